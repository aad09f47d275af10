"""The node that leads a run: waits for its peers, arms them, feeds them by credit, ends the run.

Handshake on `rig/run` (sheet) and `<peer>/status`: sheet waiting -> peers ready (with their part of
the RunSpec) -> theory on `theory/branches` -> sheet armed (start, whole RunSpec) -> peers armed ->
samples -> peers at the last sample -> sheet finished -> peers done. Anything else is sheet aborted,
with a reason.
"""

from __future__ import annotations

import time
import uuid
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from rclpy.context import Context
from std_srvs.srv import Trigger

from qzs_rig import scenario, wire
from qzs_rig.errors import InputError, PeerError, RigError
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.prediction.curve import Prediction, to_document
from qzs_rig.prediction.predict import predict
from qzs_rig.ros.endpoints import Message
from qzs_rig.ros.node import REPEAT_S, RigNode
from qzs_rig.ros.states import FollowerState, FollowerStatus, LeadState, from_wire, stepped
from qzs_rig.run.sheet import RunSheet, SheetState
from qzs_rig.wire import Status, Topic

PEER_STATUS: dict[str, Topic] = {
    'platform': wire.PLATFORM_STATUS,
    'analyzer': wire.ANALYZER_STATUS,
}
IN_FLIGHT = 120
"""Samples under way in lockstep. Two Imu messages each, which fit into the socket buffer that Linux
allows by default (208 KiB); a shared-memory port (512 places) stalls beyond 400 messages."""
DRAIN_S = 2.0
"""How long the peers may take for the last samples of a real-time run before they count as lost."""
STALL_S = 5.0
"""How long a peer that lives may keep a lockstep run from going on."""
SEE_OFF_S = 3.0
"""How long the lead stays for its peers to close their files."""

LEAD_PARAMETERS = (
    Parameter('peers', str, 'platform,analyzer', '', 'nodes that take part, comma separated'),
    Parameter('scenario', str, 'unnamed', '', 'name of the run in its sheet and folder'),
    Parameter('run_id', str, '', '', 'identity of the run; empty: a new one'),
)


@dataclass
class Running:
    """One run from `begin` to its end; times are of the monotonic clock, in s."""

    sheet: RunSheet
    sent: int = 0
    predictions: tuple[Prediction, ...] = ()
    waits_for: str = ''
    abort_reason: str = ''
    start_at: float = 0.0
    announced_at: float = 0.0
    drain_until: float = 0.0
    leave_at: float = 0.0
    progress: tuple[LeadState, int, int] | None = None
    progress_at: float = 0.0


class Lead(RigNode):
    """Drives `samples` through the peers. Subclasses give `feed(n)` and publish what it yields."""

    own: tuple[Parameter, ...] = LEAD_PARAMETERS

    def __init__(self, context: Context | None = None) -> None:
        super().__init__(context)
        self.state = LeadState.UNCONFIGURED
        self.peers: tuple[str, ...] = ()
        self.statuses: dict[str, FollowerStatus] = {}
        self._run: Running | None = None

    def open(self) -> None:
        self.peers = tuple(p for p in self.spec.text('peers').split(',') if p)
        unknown = [p for p in self.peers if p not in PEER_STATUS]
        if unknown:
            raise PeerError(f'peers names {unknown[0]!r}; known: {", ".join(PEER_STATUS)}')
        self.statuses.clear()
        self._run = None
        self._enter(LeadState.CONFIGURED)

    def introduce(self) -> None:
        # who comes late gets what holds now, not how it came about
        self.publisher(wire.RUN._replace(depth=1))
        self.publisher(wire.THEORY)
        for peer in self.peers:
            self.subscribe(
                PEER_STATUS[peer],
                partial(self._heard, peer),
                lost=partial(self._lost, peer),
            )
        self.create_service(Trigger, '~/abort', self._abort_service)

    # --- what a subclass gives

    @abstractmethod
    def prepare(self) -> RunSheet:
        """A sheet for the run to come: mode, step, samples, own sections of the RunSpec."""

    @abstractmethod
    def endpoints(self) -> list[str]:
        """Labels of the data publishers that must be matched before the start."""

    @abstractmethod
    def feed(self, n: int) -> int:
        """Publish up to `n` further samples; returns how many."""

    @abstractmethod
    def arm(self, start_ns: int) -> int:
        """The run starts at about `start_ns`; returns the stamp of sample 0."""

    @abstractmethod
    def soft_stop(self) -> int:
        """Ramp down; returns the number of samples that the run has now."""

    # --- the run

    @property
    def run(self) -> Running:
        """The run that is on, or the last one."""
        assert self._run is not None
        return self._run

    def _enter(self, state: LeadState) -> None:
        self.state = stepped(self.state, state)

    def begin(self) -> None:
        self.reread()
        run_id = self.spec.text('run_id') or uuid.uuid4().hex[:8]
        sheet = self.prepare().replace(
            run_id=run_id, scenario=self.spec.text('scenario'), peers=self.peers
        )
        self._run = Running(sheet)
        self.gone.clear()
        self.busy = True
        self._announce(LeadState.WAITING, SheetState.WAITING)

    def halt(self) -> None:
        if self.state is LeadState.RUNNING:
            self._ramp_down('deactivated by the operator')
        elif self.state in (LeadState.WAITING, LeadState.ARMED):
            self._abort('deactivated by the operator')

    def tick(self) -> None:
        if self.gone and self.busy:
            self._abort(f'{" and ".join(self.gone)} died')
        work: Callable[[], None] | None = {
            LeadState.WAITING: self._wait,
            LeadState.ARMED: self._wait_armed,
            LeadState.RUNNING: self._pump,
            LeadState.DRAINING: self._drain,
            LeadState.ENDED: self._see_off,
        }.get(self.state)
        if work is None:
            return
        work()
        waits = self.state in (LeadState.WAITING, LeadState.ARMED, LeadState.ENDED)
        if waits and time.monotonic() - self.run.announced_at > REPEAT_S:
            self._publish_sheet()
        self._watch_progress()

    def _watch_progress(self) -> None:
        """A peer may live and yet do nothing; in lockstep everybody would wait for it for ever."""
        run, index = self.run, self._done()
        progress = (self.state, index, run.sent)
        if progress != run.progress:
            run.progress, run.progress_at = progress, time.monotonic()
        waits = self.state is LeadState.ARMED or (
            self.state in (LeadState.RUNNING, LeadState.DRAINING) and run.sheet.mode == 'lockstep'
        )
        if waits and time.monotonic() - run.progress_at > STALL_S:
            slow = [p for p in self.peers if self._index(p) == index]
            self._abort(f'{" and ".join(slow)} stayed at sample {index} for {STALL_S:g} s')

    def _wait(self) -> None:
        run = self.run
        run.waits_for = ', '.join(self._missing())
        if run.waits_for:
            self.remind(f'waiting for {run.waits_for}')
            return
        self.remind('all matched')
        for peer in self.peers:
            part = self.statuses[peer].spec or {}
            run.sheet = run.sheet.replace(spec={**run.sheet.spec, **part})
        self._foretell()  # before the clock starts: it may take a while
        lead_s = 0.25 if run.sheet.mode == 'real_time' else 0.0
        run.start_at = time.monotonic() + lead_s  # before `arm`, which may take a while
        start_ns = self.arm(time.time_ns() + int(lead_s * 1e9))
        run.sheet = run.sheet.replace(start_ns=start_ns)
        self._announce(LeadState.ARMED, SheetState.ARMED)

    def _foretell(self) -> None:
        try:
            self.run.predictions = predict(self._physics())
        except InputError as error:  # a recorded sheet may be of another version
            self.get_logger().warning(f'no theory of this run: {error}')
        theory = to_document(self.run.sheet.run_id, self.run.predictions)
        self.publish(wire.THEORY, wire.encode_json(theory))

    def _physics(self) -> RunSpec:
        """The run as the sheet tells it; where it does not know a section, as this node does."""
        recorded = self.run.sheet.spec
        told = {name.split('.', 1)[0] for name in recorded}
        known = {p.name for p in scenario.parameters() if p.section not in told}
        mine = {name: value for name, value in self.spec.items() if name in known}
        return scenario.complete({**mine, **recorded})

    def _missing(self) -> list[str]:
        missing = []
        for peer in self.peers:
            status = self.statuses.get(peer)
            if status is None:
                missing.append(f'node {peer}')
            elif status.state is not FollowerState.READY or not self._ours(status):
                missing.append(f'{peer} ({status.message or status.state})')
        return missing + self.unmatched(self.endpoints())

    def _wait_armed(self) -> None:
        states = [self.statuses[p].state for p in self.peers if p in self.statuses]
        begun = (FollowerState.ARMED, FollowerState.RUNNING)
        if len(states) == len(self.peers) and all(state in begun for state in states):
            self._announce(LeadState.RUNNING, SheetState.RUNNING)
            self._pump()

    def _pump(self) -> None:
        run = self.run
        if run.sheet.mode == 'lockstep':
            chunk = min(run.sheet.chunk, IN_FLIGHT)
            while self._room() >= chunk and run.sent < run.sheet.samples:
                run.sent += self.feed(chunk)
        else:
            elapsed_s = time.monotonic() - run.start_at
            owed = min(int(elapsed_s * run.sheet.pace * 1e9) // run.sheet.step_ns + 1, 2**62)
            # what is owed after a stall goes out in pieces that the queues can hold
            while run.sent < min(owed, run.sheet.samples):
                run.sent += self.feed(min(owed - run.sent, 500))
        if run.sent >= run.sheet.samples:
            self._enter(LeadState.DRAINING)
            run.drain_until = time.monotonic() + DRAIN_S
            self._drain()

    def _drain(self) -> None:
        sheet = self.run.sheet
        late = sheet.mode == 'real_time' and time.monotonic() > self.run.drain_until
        if self._done() >= sheet.samples or late or not self.peers:
            if self.run.abort_reason:
                self._abort(self.run.abort_reason)
            else:
                self._end(SheetState.FINISHED)

    def _room(self) -> int:
        return self._done() + IN_FLIGHT - self.run.sent

    def _done(self) -> int:
        return min((self._index(peer) for peer in self.peers), default=self.run.sent)

    def _index(self, peer: str) -> int:
        status = self.statuses.get(peer)
        return status.index if status else 0

    def parted(self) -> bool:
        """Every peer that takes part has closed its files."""
        over = (FollowerState.DONE, FollowerState.FAILED)
        return self._run is None or all(
            status.state in over
            for status in self.statuses.values()
            if status.run_id == self._run.sheet.run_id
        )

    def _see_off(self) -> None:
        if not self.parted() and time.monotonic() < self.run.leave_at:
            return
        if self.spec.flag('exit_when_done'):
            self.finish(0 if self.run.sheet.state is SheetState.FINISHED else 1)
        else:
            self._enter(LeadState.IDLE)

    # --- peers and operators

    def _heard(self, peer: str, raw: bytes) -> None:
        try:
            status = from_wire(wire.decode_status(raw))
        except InputError as error:  # a stranger, who stops no run
            self.get_logger().warning(f'{PEER_STATUS[peer].name}: {error}')
            return
        self.statuses[peer] = status
        if not self._ours(status):
            return
        if status.level == wire.LEVEL['error'] and self.busy:
            self._abort(f'{peer}: {status.message.removeprefix("aborted: ")}')
        elif self.state is not LeadState.RUNNING or self.run.sheet.mode == 'lockstep':
            self.tick()

    def _ours(self, status: FollowerStatus) -> bool:
        return self.busy and status.run_id == self.run.sheet.run_id

    def _lost(self, peer: str) -> None:
        gone = self.statuses.pop(peer, None)
        begun = (LeadState.ARMED, LeadState.RUNNING, LeadState.DRAINING)
        if self.state in begun and gone is not None:
            self.get_logger().error(f'{peer} died or was cut off; the run ends')
            self.gone.append(peer)  # `tick` acts on it: a second one may be news of the same moment

    def _ramp_down(self, why: str) -> None:
        self.run.abort_reason = why
        self.run.sheet = self.run.sheet.replace(samples=self.soft_stop())
        self.get_logger().warning(f'{why}: ramping down')

    def _abort_service(self, request: Message, response: Message) -> Message:
        response.success = self.state is LeadState.RUNNING
        response.message = 'ramping down' if response.success else f'no run is on ({self.state})'
        if response.success:
            self._ramp_down('aborted by the operator')
        return self.answer(response)

    def fail(self, error: RigError) -> None:
        if self.busy:
            self._abort(str(error))
        super().fail(error)

    def operator_stop(self, why: str) -> None:
        if self.busy:
            self._abort(f'stopped by {why}')
        super().operator_stop(why)

    def _abort(self, reason: str) -> None:
        self._end(SheetState.ABORTED, reason)

    def _end(self, state: SheetState, reason: str = '') -> None:
        if self.state in (LeadState.ENDED, LeadState.IDLE):
            return
        self.busy = False
        self.run.sheet = self.run.sheet.replace(reason=reason)
        self.run.leave_at = time.monotonic() + SEE_OFF_S
        self._announce(LeadState.ENDED, state)
        # two calls: rclpy refuses one call that changes its severity
        if state is SheetState.FINISHED:
            self.get_logger().info(f'run {self.run.sheet.run_id} finished')
        else:
            self.get_logger().error(f'run {self.run.sheet.run_id} aborted: {reason}')

    def _announce(self, state: LeadState, word: SheetState) -> None:
        self._enter(state)
        self.run.sheet = self.run.sheet.replace(state=word)
        self._publish_sheet()

    def _publish_sheet(self) -> None:
        self.run.announced_at = time.monotonic()
        self.publish(wire.RUN, wire.encode_json(self.run.sheet.to_document()))

    def status(self) -> Status:
        values = {'state': self.state.value}
        if self._run is None:
            return Status(self.role, wire.LEVEL['ok'], self.state.value, values)
        run, sheet = self._run, self._run.sheet
        values |= {'run_id': sheet.run_id, 'sent': str(run.sent), 'of': str(sheet.samples)}
        if sheet.state is SheetState.ABORTED:
            return Status(self.role, wire.LEVEL['error'], sheet.reason, values)
        text = f'waiting for {run.waits_for}' if run.waits_for else self.state.value
        level = wire.LEVEL['warn' if self.state is LeadState.WAITING else 'ok']
        return Status(self.role, level, text, values)
