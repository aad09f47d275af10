"""Scenarios: every parameter of the rig in one table, and the YAML files that set them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from qzs_rig import estimation, excitation, sensing
from qzs_rig.errors import InputError
from qzs_rig.excitation import shaker
from qzs_rig.mechanics import platform
from qzs_rig.parameters import Parameter, RunSpec, parse_assignment, positive, read_yaml
from qzs_rig.samples import NS
from qzs_rig.units import DOFS, displacement_unit

RUN_PARAMETERS = (
    Parameter(
        'run.rate', float, 500.0, 'Hz', 'samples a second; the step is rounded to whole ns', 1, 1e5
    ),
    Parameter(
        'run.mode',
        str,
        'lockstep',
        '',
        'real_time, or lockstep: as fast as the chain goes, nothing lost',
        choices=('lockstep', 'real_time'),
    ),
    Parameter('run.seed', int, 0, '', 'seed of all sensor noise', 0, 2**31 - 1),
    Parameter('run.chunk', int, 40, 'samples', 'base motion a message in lockstep', 1, 1000),
    Parameter(
        'run.predictive_abort',
        bool,
        False,
        '',
        'ramp down before theory foresees a stroke beyond run.stroke_limit',
    ),
    Parameter(
        'run.lead_time', float, 5.0, 's', 'how long before that; at least excitation.ramp', 0.0
    ),
    *(
        positive(
            f'run.stroke_limit.{dof}',
            None,
            displacement_unit(dof),
            f'largest {dof.replace("_", " ")} stroke of the top against the base; unset: any',
        )
        for dof in DOFS
    ),
)


def parameters() -> tuple[Parameter, ...]:
    """The whole declaration: YAML, ROS parameters, CLI help and docs read it."""
    return (
        *RUN_PARAMETERS,
        *excitation.PARAMETERS,
        *shaker.PARAMETERS,
        *platform.parameters(),
        *sensing.PARAMETERS,
        *estimation.PARAMETERS,
    )


DEFAULT = 'vertical_sweep'


def step_ns_of(spec: RunSpec) -> int:
    """Sample step in ns; the grid of a run is exact in this step."""
    return round(NS / spec.number('run.rate'))


def load(scenario: str, assignments: Iterable[str] = ()) -> RunSpec:
    """The RunSpec of a scenario, by name in `config/` or by path, with `--set` words on top."""
    spec = RunSpec.of(parameters(), read_yaml(find(scenario)))
    return spec.override(assigned(assignments))


def of(given: Mapping[str, Any]) -> RunSpec:
    """A RunSpec of the defaults with `given` values on top."""
    return RunSpec.of(parameters(), given)


def complete(values: Mapping[str, Any]) -> RunSpec:
    """The RunSpec of all values on a run sheet, including those that synonyms silence."""
    defaults = of({})
    return defaults.override({k: v for k, v in values.items() if defaults.get(k) != v})


def find(name: str, what: str = 'scenario', folder: str = '') -> Path:
    """Path of a YAML file, by path or by its name in `folder` of `config/`; InputError, which calls
    it `what`, lists the known ones."""
    path = Path(name)
    if path.is_file():
        return path
    known = ', '.join(names(folder))
    if path.suffix in {'.yaml', '.yml'}:
        raise InputError(f'{what} {name} is not there; known by name: {known}')
    shipped = config_folder() / folder / f'{name}.yaml'
    if shipped.is_file():
        return shipped
    raise InputError(f'unknown {what} {name!r}; known: {known}, or the path of a YAML file')


def names(folder: str = '') -> list[str]:
    """Names of the scenarios that ship with the package, or of what is in a `folder` of them."""
    return sorted(path.stem for path in (config_folder() / folder).glob('*.yaml'))


def headlines(folder: str = '') -> dict[str, str]:
    """What each of `names` is for: the first sentence of its file."""

    def sentence(name: str) -> str:
        text = (config_folder() / folder / f'{name}.yaml').read_text(encoding='utf-8')
        comment = text.removeprefix('# ').replace('\n# ', ' ')
        return comment.split('. ')[0].split('\n')[0].rstrip('.')

    return {name: sentence(name) for name in names(folder)}


def config_folder() -> Path:
    """`config/` of the source tree, of the ament share folder or of the wheel's data."""
    source = Path(__file__).resolve().parent.parent
    shares = [
        *(
            Path(p) / 'share'
            for p in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
            if p
        ),
        # an ament or wheel install: <prefix>/lib/pythonX.Y/site-packages/qzs_rig
        *(parent / 'share' for parent in source.parents[:4]),
    ]
    for folder in (source / 'config', *(share / 'qzs_rig' / 'config' for share in shares)):
        if (folder / f'{DEFAULT}.yaml').is_file():
            return folder
    raise InputError(
        f'no config folder with {DEFAULT}.yaml near {source}; source the install or reinstall'
    )


def assigned(assignments: Iterable[str]) -> dict[str, Any]:
    """`--set` words as parameter values; raises InputError for a word given twice."""
    values: dict[str, Any] = {}
    for text in assignments:
        name, value = parse_assignment(text)
        if name in values:
            raise InputError(f'--set {name} is given twice; keep one')
        values[name] = value
    return values
