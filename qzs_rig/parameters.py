"""Parameters: declared once with unit, bounds and text; read from ROS YAML, refused if unknown."""

from __future__ import annotations

import contextlib
import difflib
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from qzs_rig.errors import InputError

Value = bool | int | float | str


@dataclass(frozen=True)
class Parameter:
    """One parameter of a run. Without a `default` it is optional: unset until somebody sets it.

    `kind` is the type that values are converted to; integers are accepted for floats. `replaces`
    names the parameters that say the same in other words, which may not be given beside it.
    """

    name: str
    kind: type
    default: Value | None
    unit: str
    text: str
    minimum: float = -math.inf
    maximum: float = math.inf
    above: bool = False  # True: `minimum` itself is out of range
    choices: tuple[str, ...] = ()
    replaces: tuple[str, ...] = ()

    @property
    def section(self) -> str:
        """First word of the name: run, excitation, shaker, platform, sensor or analyzer."""
        return self.name.split('.', 1)[0]

    @property
    def range_text(self) -> str:
        """The allowed values in words, for help and errors."""
        if self.choices:
            return 'one of ' + ', '.join(self.choices)
        low = '' if self.minimum == -math.inf else f'{">" if self.above else ">="} {self.minimum:g}'
        high = '' if self.maximum == math.inf else f'<= {self.maximum:g}'
        return ' and '.join(part for part in (low, high) if part) or f'any {self.kind.__name__}'

    def convert(self, value: Any) -> Value:
        """`value` as this parameter's type; raises InputError naming value, range and way out."""
        converted = self._typed(value)
        if isinstance(converted, float) and not math.isfinite(converted):
            raise InputError(f'{self.name} = {value!r} is not finite; give {self._wanted()}')
        if self.choices and converted not in self.choices:
            hint = closest(str(value), self.choices)
            raise InputError(f'{self.name} = {value!r} is unknown{hint}; give {self.range_text}')
        if isinstance(converted, int | float) and not isinstance(converted, bool):
            too_low = converted < self.minimum or (self.above and converted == self.minimum)
            if too_low or converted > self.maximum:
                raise InputError(f'{self.name} = {value!r} is out of range; give {self._wanted()}')
        return converted

    def _typed(self, value: Any) -> Value:
        if self.kind is str and isinstance(value, str):
            return value
        if self.kind is bool and isinstance(value, bool):
            return value
        if (
            self.kind is float
            and isinstance(value, int | float | str)
            and not isinstance(value, bool)
        ):
            # YAML 1.1 reads 1e-3 as text, and users write integers for reals
            with contextlib.suppress(ValueError, OverflowError):
                return float(value)
        whole = isinstance(value, int) or (isinstance(value, float) and value.is_integer())
        if self.kind is int and whole and not isinstance(value, bool):
            return int(value)
        raise InputError(f'{self.name} = {value!r} has the wrong type; give {self._wanted()}')

    def _wanted(self) -> str:
        unit = f' in {self.unit}' if self.unit else ''
        return f'a {self.kind.__name__}{unit}, {self.range_text}'


def positive(
    name: str,
    default: float | None,
    unit: str,
    text: str,
    maximum: float = math.inf,
    replaces: tuple[str, ...] = (),
) -> Parameter:
    """A real number above 0."""
    return Parameter(name, float, default, unit, text, 0.0, maximum, above=True, replaces=replaces)


@dataclass(frozen=True)
class RunSpec(Mapping[str, Value]):
    """Every parameter of a run, complete and checked; `spec['platform.k1']` reads one.

    A run is reproducible from its RunSpec. Optional parameters that nobody set are absent.
    """

    declared: tuple[Parameter, ...]
    given: Mapping[str, Value]

    @classmethod
    def of(cls, declared: Iterable[Parameter], given: Mapping[str, Any] = {}) -> RunSpec:
        """A spec of the declared defaults with `given` values on top."""
        return cls(tuple(declared), MappingProxyType({})).override(given)

    def override(self, values: Mapping[str, Any]) -> RunSpec:
        """A spec with `values` on top: a later word for the same thing silences the earlier one."""
        table = {parameter.name: parameter for parameter in self.declared}
        for name in values:
            if name not in table:
                raise InputError(unknown_parameter(name, table))
        given = dict(self.given)
        for name in values:
            for other in _synonyms(name, self.declared):
                if other in values:
                    raise InputError(
                        f'{name} and {other} say the same thing twice; keep one of them'
                    )
                given.pop(other, None)
        given.update({name: table[name].convert(value) for name, value in values.items()})
        return RunSpec(self.declared, MappingProxyType(given))

    def columns(self, values: Mapping[str, Any]) -> RunSpec:
        """A spec of n runs at once, whose `number` of these names is their column (n,) of floats.

        It serves formulas that take arrays. Raises InputError as `override`, also for the lowest
        and the highest value of a column.
        """
        lowest = self.override({name: float(column.min()) for name, column in values.items()})
        highest = lowest.override({name: float(column.max()) for name, column in values.items()})
        return RunSpec(self.declared, MappingProxyType({**highest.given, **values}))

    def __getitem__(self, name: str) -> Value:
        if name in self.given:
            return self.given[name]
        for parameter in self.declared:
            if parameter.name == name and parameter.default is not None:
                return parameter.default
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        for parameter in self.declared:
            if parameter.default is not None or parameter.name in self.given:
                yield parameter.name

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def number(self, name: str) -> float:
        """A float parameter, or a column (n,) of it."""
        value: Any = self[name]
        assert not isinstance(value, int | str), name
        return value  # type: ignore[no-any-return]

    def optional(self, name: str) -> float | None:
        """A float parameter, or None where nobody set it."""
        return self.number(name) if name in self else None

    def count(self, name: str) -> int:
        """An integer parameter."""
        value = self[name]
        assert isinstance(value, int), name
        return value

    def text(self, name: str) -> str:
        """A text parameter."""
        value = self[name]
        assert isinstance(value, str), name
        return value

    def flag(self, name: str) -> bool:
        """A yes/no parameter."""
        value = self[name]
        assert isinstance(value, bool), name
        return value

    def sections(self, *names: str) -> dict[str, Value]:
        """All set values of the named sections, flat, JSON-ready."""
        return {name: value for name, value in self.items() if name.split('.', 1)[0] in names}

    def to_yaml(self) -> str:
        """The given values as a ROS parameter file that `ros2 launch` and the CLI read."""
        import yaml

        tree: dict[str, Any] = {}
        for name, value in self.given.items():
            *path, leaf = name.split('.')
            branch = tree
            for step in path:
                branch = branch.setdefault(step, {})
            branch[leaf] = value
        # rcl takes no empty parameter map
        body = tree or {'run': {'rate': self['run.rate']}}
        return yaml.safe_dump({'/**': {'ros__parameters': body}}, sort_keys=False)


def read_yaml(path: Path) -> dict[str, Any]:
    """The flat parameters of a ROS parameter file; raises InputError for anything else."""
    document = yaml_document(path, 'scenario')
    flat: dict[str, Any] = {}
    for node, body in _nodes(document, path):
        if not isinstance(body, dict) or set(body) != {'ros__parameters'}:
            raise InputError(
                f'scenario {path}: node {node!r} must hold ros__parameters and nothing else'
            )
        for name, value in _flatten(body['ros__parameters'] or {}, path):
            if name in flat and flat[name] != value:
                raise InputError(f'scenario {path}: {name} is given twice with different values')
            flat[name] = value
    return flat


def yaml_document(path: Path, what: str) -> Any:
    """The one document of a YAML file; InputError, which calls it `what`, for anything else and
    for a key given twice."""
    import yaml

    try:
        loader = yaml.SafeLoader(path.read_text(encoding='utf-8'))
        root = loader.get_single_node()
        document = loader.construct_document(root) if root else None
    except OSError as error:
        raise InputError(f'{what} {path} cannot be read: {error.strerror}') from error
    except (yaml.YAMLError, ValueError) as error:  # ValueError: no UTF-8, or a date like 2001-99-99
        first_line = str(error).splitlines()[0]
        raise InputError(f'{what} {path} is not YAML: {first_line}') from error
    for key, line in _repeated_keys(root) if root else ():
        raise InputError(f'{what} {path}, line {line}: {key!r} is given twice; keep one')
    return document


def parse_assignment(text: str) -> tuple[str, Any]:
    """`platform.k1=20000` as name and value, the value read as YAML."""
    import yaml

    name, equals, value = text.partition('=')
    if not equals or not name.strip():
        raise InputError(f'--set {text!r} is not an assignment; write --set platform.k1=20000')
    try:
        return name.strip(), yaml.safe_load(value)
    except (yaml.YAMLError, ValueError) as error:
        raise InputError(f'--set {text!r}: the value is not YAML') from error


def unknown_parameter(name: str, known: Iterable[str]) -> str:
    """The refusal of an unknown key, with the nearest known ones."""
    known = sorted(known)
    section = name.split('.', 1)[0]
    family = [item for item in known if item.startswith(section + '.')] or sorted(
        {item.split('.', 1)[0] + '.*' if '.' in item else item for item in known}
    )
    return f'unknown parameter {name!r}{closest(name, known)}; known: {", ".join(family)}'


def closest(word: str, known: Iterable[str]) -> str:
    """' (did you mean ...?)' for the end of a refusal, or nothing where none is near."""
    close = difflib.get_close_matches(word, list(known), n=1)
    return f' (did you mean {close[0]!r}?)' if close else ''


def _synonyms(name: str, declared: Iterable[Parameter]) -> set[str]:
    same: set[str] = set()
    for parameter in declared:
        if parameter.name == name:
            same.update(parameter.replaces)
        if name in parameter.replaces:
            same.add(parameter.name)
    return same


def _repeated_keys(node: Any) -> Iterator[tuple[str, int]]:
    """Keys that a map of a YAML document repeats, with their line: YAML would take the last."""
    seen: set[str] = set()
    for key, value in node.value if node.id == 'mapping' else ():
        if str(key.value) in seen:
            yield str(key.value), key.start_mark.line + 1
        seen.add(str(key.value))
        yield from _repeated_keys(value)


def _nodes(document: Any, path: Path) -> list[tuple[str, Any]]:
    if not isinstance(document, dict) or not document:
        raise InputError(
            f'scenario {path} is no ROS parameter file; it starts with /**: and ros__parameters:'
        )
    return [(str(node), body) for node, body in document.items()]


def _flatten(tree: Any, path: Path, prefix: str = '') -> Iterator[tuple[str, Any]]:
    if not isinstance(tree, dict):
        raise InputError(f'scenario {path}: ros__parameters must map names to values')
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from _flatten(value, path, f'{prefix}{key}.')
        else:
            yield f'{prefix}{key}', value
