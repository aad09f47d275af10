"""The run sheet: what a run is, said on `rig/run`, kept in its bag."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from enum import Enum
from typing import Any

from qzs_rig.errors import InputError
from qzs_rig.parameters import Value

SCHEMA = 'qzs_rig/sheet/1'


class SheetState(str, Enum):
    """How far a run is; `value` is its word in the JSON."""

    WAITING = 'waiting'
    ARMED = 'armed'
    RUNNING = 'running'
    FINISHED = 'finished'
    ABORTED = 'aborted'

    __str__ = str.__str__


@dataclass(frozen=True)
class RunSheet:
    """Identity, time grid, full RunSpec and state of a run.

    Sample k of every topic is stamped start_ns + k * step_ns, k from 0 to samples - 1. `pace` is
    rig seconds a wall second in real time. `reason` says why a run was aborted.
    """

    step_ns: int
    samples: int
    mode: str
    chunk: int
    spec: Mapping[str, Value] = field(default_factory=dict)
    run_id: str = ''
    scenario: str = ''
    peers: tuple[str, ...] = ()
    start_ns: int = 0
    pace: float = 1.0
    state: SheetState = SheetState.WAITING
    reason: str = ''

    def __post_init__(self) -> None:
        object.__setattr__(self, 'state', SheetState(self.state))

    def replace(self, **changes: Any) -> RunSheet:
        """The same sheet but for `changes` of its fields."""
        return replace(self, **changes)

    def to_document(self) -> dict[str, Any]:
        """JSON-ready."""
        plain = {'spec': dict(self.spec), 'peers': list(self.peers), 'state': self.state.value}
        return {'schema': SCHEMA, **asdict(self), **plain}


def from_document(document: Mapping[str, Any]) -> RunSheet:
    """The sheet in a JSON document; raises InputError where it is none."""
    fields = dict(document)
    schema = fields.pop('schema', None)
    if schema != SCHEMA:
        raise InputError(f'rig/run holds schema {schema!r}, expected {SCHEMA!r}')
    try:
        return RunSheet(**fields | {'peers': tuple(fields['peers'])})
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f'rig/run holds a damaged run sheet: {error}') from error
