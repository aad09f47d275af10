"""States of leader and followers, the steps between them, and a follower's status on the wire."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import TypeVar

from qzs_rig import wire
from qzs_rig.errors import InputError
from qzs_rig.parameters import Value


class LeadState(Enum):
    """What a leader is doing."""

    UNCONFIGURED = 'unconfigured'
    CONFIGURED = 'configured'
    WAITING = 'waiting'
    ARMED = 'armed'
    RUNNING = 'running'
    DRAINING = 'draining'
    """All samples are out; the followers still work on them."""
    ENDED = 'ended'
    """The run is over; the followers close their files."""
    IDLE = 'idle'

    def __str__(self) -> str:
        return str(self.value)


class FollowerState(Enum):
    """What a follower is doing; `value` is its word on `<role>/status`."""

    UNCONFIGURED = 'unconfigured'
    IDLE = 'idle'
    WAITING = 'waiting'
    READY = 'ready'
    ARMED = 'armed'
    RUNNING = 'running'
    DONE = 'done'
    FAILED = 'failed'

    def __str__(self) -> str:
        return str(self.value)


_L, _F = LeadState, FollowerState
State = TypeVar('State', LeadState, FollowerState)
NEXT: Mapping[Enum, frozenset[Enum]] = {
    _L.UNCONFIGURED: frozenset({_L.CONFIGURED}),
    _L.CONFIGURED: frozenset({_L.CONFIGURED, _L.WAITING}),
    _L.WAITING: frozenset({_L.ARMED, _L.ENDED}),
    _L.ARMED: frozenset({_L.RUNNING, _L.ENDED}),
    _L.RUNNING: frozenset({_L.DRAINING, _L.ENDED}),
    _L.DRAINING: frozenset({_L.ENDED}),
    _L.ENDED: frozenset({_L.IDLE, _L.WAITING, _L.CONFIGURED}),
    _L.IDLE: frozenset({_L.WAITING, _L.CONFIGURED}),
    _F.UNCONFIGURED: frozenset({_F.IDLE, _F.FAILED}),
    # a driver's session needs no handshake: it runs as soon as there are samples
    _F.IDLE: frozenset({_F.IDLE, _F.WAITING, _F.RUNNING, _F.FAILED}),
    _F.WAITING: frozenset({_F.IDLE, _F.WAITING, _F.READY, _F.RUNNING, _F.DONE, _F.FAILED}),
    _F.READY: frozenset({_F.IDLE, _F.WAITING, _F.READY, _F.ARMED, _F.RUNNING, _F.DONE, _F.FAILED}),
    _F.ARMED: frozenset({_F.RUNNING, _F.DONE, _F.FAILED}),
    _F.RUNNING: frozenset({_F.DONE, _F.FAILED}),
    _F.DONE: frozenset({_F.IDLE, _F.FAILED}),
    _F.FAILED: frozenset({_F.IDLE, _F.DONE, _F.FAILED}),
}
"""The states that may follow each state. Configuring leads to CONFIGURED or IDLE from any state
without a run."""


def stepped(now: State, then: State) -> State:
    """`then`, if it may follow `now`; anything else is a fault of the node and raises."""
    if then not in NEXT[now]:
        raise RuntimeError(f'{type(now).__name__}: {then} cannot follow {now}')
    return then


@dataclass(frozen=True)
class FollowerStatus:
    """What a follower says of itself: the samples it has done, of which run, and in what state.

    `spec` holds its part of the RunSpec while it is ready, `details` its counters, `level` is one
    of wire.LEVEL.
    """

    role: str
    state: FollowerState
    level: int = wire.LEVEL['ok']
    message: str = ''
    run_id: str | None = None
    index: int = 0
    spec: Mapping[str, Value] | None = None
    details: Mapping[str, str] = field(default_factory=dict)

    def to_wire(self) -> wire.Status:
        """As a DiagnosticStatus."""
        if self.state is FollowerState.UNCONFIGURED:
            return wire.Status(self.role, self.level, self.state.value, {})
        values = {'state': self.state.value, 'index': str(self.index)}
        if self.run_id is not None:
            values['run_id'] = self.run_id
        if self.spec is not None:
            values['spec'] = json.dumps(self.spec)
        return wire.Status(self.role, self.level, self.message, {**values, **self.details})


def from_wire(status: wire.Status) -> FollowerStatus:
    """The follower's status in a DiagnosticStatus; raises InputError where it is none."""
    values = status.values
    try:
        spec = json.loads(values['spec']) if 'spec' in values else None
        return FollowerStatus(
            status.name,
            FollowerState(values.get('state', 'unconfigured')),
            status.level,
            status.message,
            values.get('run_id'),
            int(values.get('index', '0')),
            spec,
        )
    except (ValueError, RecursionError) as error:
        raise InputError(f'{status.name}/status is none of a follower: {error}') from error
