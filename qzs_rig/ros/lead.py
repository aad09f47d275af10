"""The node that leads a run: waits for its peers, arms them, feeds them by credit, ends the run.

Handshake on `rig/run` (sheet) and `<peer>/status`: sheet waiting -> peers ready (with their part of
the RunSpec) -> theory on `theory/branches` -> sheet armed (start, whole RunSpec) -> peers armed ->
samples -> peers at the last sample -> sheet finished -> peers done. Anything else is sheet aborted,
with a reason.
"""

from __future__ import annotations

import json
import time
import uuid
from abc import abstractmethod
from collections.abc import Callable
from functools import partial
from typing import Any

from std_srvs.srv import Trigger

from qzs_rig import scenario, wire
from qzs_rig.errors import InputError, PeerError, RigError
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.prediction.curve import Prediction, to_document
from qzs_rig.prediction.predict import predict
from qzs_rig.ros import parameters, qos
from qzs_rig.ros.node import REPEAT_S, RigNode
from qzs_rig.run.sheet import RunSheet
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


class Lead(RigNode):
    """Drives `samples` through the peers. Subclasses give `feed(n)` and publish what it yields."""

    own: tuple[Parameter, ...] = LEAD_PARAMETERS

    def open(self) -> None:
        self.peers = tuple(p for p in self.spec.text('peers').split(',') if p)
        unknown = [p for p in self.peers if p not in PEER_STATUS]
        if unknown:
            raise PeerError(f'peers names {unknown[0]!r}; known: {", ".join(PEER_STATUS)}')
        self.statuses: dict[str, Status] = {}
        self.state = 'configured'
        self.sent = 0
        self._waits_for = ''
        self._announced_at = 0.0
        self._progress: tuple[str, int, int] = ('', 0, 0)
        self._progress_at = 0.0
        self.predictions: tuple[Prediction, ...] = ()

    def introduce(self) -> None:
        self._run = self.publisher(wire.RUN, qos.latest(wire.RUN))
        self._theory = self.publisher(wire.THEORY)
        for peer in self.peers:
            self.subscribe(
                PEER_STATUS[peer],
                partial(self._heard, peer),
                qos.watched(PEER_STATUS[peer]),
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

    def begin(self) -> None:
        self.spec = parameters.current(self, self.spec)
        run_id = self.spec.text('run_id') or uuid.uuid4().hex[:8]
        self.sheet = self.prepare().of(
            run_id=run_id, scenario=self.spec.text('scenario'), peers=self.peers, state='waiting'
        )
        self.sent = 0
        self.gone.clear()
        self._abort_reason = ''
        self.busy = True
        self._announce('waiting')

    def halt(self) -> None:
        if self.state == 'running':
            self._ramp_down('deactivated by the operator')
        elif self.state in ('waiting', 'armed'):
            self._end('aborted', 'deactivated by the operator')

    def tick(self) -> None:
        if self.gone and self.busy:
            self._end('aborted', f'{" and ".join(self.gone)} died')
        step: Callable[[], None] | None = {
            'waiting': self._wait,
            'armed': self._wait_armed,
            'running': self._pump,
            'draining': self._drain,
            'ended': self._see_off,
        }.get(self.state)
        if step:
            step()
        waits = self.state in ('waiting', 'armed', 'ended')
        if waits and time.monotonic() - self._announced_at > REPEAT_S:
            self._publish_sheet()
        self._watch_progress()

    def _watch_progress(self) -> None:
        """A peer may live and yet do nothing; in lockstep everybody would wait for it for ever."""
        progress = (self.state, self._done(), self.sent)
        if progress != self._progress:
            self._progress, self._progress_at = progress, time.monotonic()
        waits = self.state == 'armed' or (
            self.state in ('running', 'draining') and self.sheet.mode == 'lockstep'
        )
        if waits and time.monotonic() - self._progress_at > STALL_S:
            index = self._done()
            slow = [p for p in self.peers if self._index(p) == index]
            text = f'{" and ".join(slow)} stayed at sample {index} for {STALL_S:g} s'
            self._end('aborted', text)

    def _wait(self) -> None:
        self._waits_for = ', '.join(self._missing())
        if self._waits_for:
            self.remind(f'waiting for {self._waits_for}')
            return
        self.remind('all matched')
        for peer in self.peers:
            part = json.loads(self.statuses[peer].values.get('spec', '{}'))
            self.sheet = self.sheet.of(spec={**self.sheet.spec, **part})
        self._foretell()  # before the clock starts: it may take a while
        lead_s = 0.25 if self.sheet.mode == 'real_time' else 0.0
        self._start_clock = time.monotonic() + lead_s  # before `arm`, which may take a while
        start_ns = self.arm(time.time_ns() + int(lead_s * 1e9))
        self.sheet = self.sheet.of(start_ns=start_ns)
        self._announce('armed')

    def _foretell(self) -> None:
        try:
            self.predictions = predict(self._physics())
        except InputError as error:  # a recorded sheet may be of another version
            self.get_logger().warning(f'no theory of this run: {error}')
            self.predictions = ()
        theory = to_document(self.sheet.run_id, self.predictions)
        self._theory.publish(wire.encode_json(theory))

    def _physics(self) -> RunSpec:
        """The run as the sheet tells it; where it does not know a section, as this node does."""
        told = {name.split('.', 1)[0] for name in self.sheet.spec}
        known = {p.name for p in scenario.PARAMETERS if p.section not in told}
        mine = {name: value for name, value in self.spec.items() if name in known}
        return scenario.complete({**mine, **self.sheet.spec})

    def _missing(self) -> list[str]:
        missing = []
        for peer in self.peers:
            status = self.statuses.get(peer)
            if status is None:
                missing.append(f'node {peer}')
            elif status.values.get('state') != 'ready' or not self._ours(status):
                missing.append(f'{peer} ({status.message or status.values.get("state")})')
        return missing + self.unmatched(self.endpoints())

    def _wait_armed(self) -> None:
        states = [self.statuses[p].values.get('state') for p in self.peers if p in self.statuses]
        if len(states) == len(self.peers) and all(s in ('armed', 'running') for s in states):
            self._announce('running')
            self._pump()

    def _pump(self) -> None:
        if self.sheet.mode == 'lockstep':
            chunk = min(self.sheet.chunk, IN_FLIGHT)
            while self._room() >= chunk and self.sent < self.sheet.samples:
                self.sent += self.feed(chunk)
        else:
            elapsed_s = time.monotonic() - self._start_clock
            owed = min(int(elapsed_s * self.sheet.pace * 1e9) // self.sheet.step_ns + 1, 2**62)
            # what is owed after a stall goes out in pieces that the queues can hold
            while self.sent < min(owed, self.sheet.samples):
                self.sent += self.feed(min(owed - self.sent, 500))
        if self.sent >= self.sheet.samples:
            self.state = 'draining'
            self._drain_until = time.monotonic() + DRAIN_S
            self._drain()

    def _drain(self) -> None:
        late = self.sheet.mode == 'real_time' and time.monotonic() > self._drain_until
        if self._done() >= self.sheet.samples or late or not self.peers:
            self._end('aborted' if self._abort_reason else 'finished', self._abort_reason)

    def _room(self) -> int:
        return self._done() + IN_FLIGHT - self.sent

    def _done(self) -> int:
        return min((self._index(peer) for peer in self.peers), default=self.sent)

    def _index(self, peer: str) -> int:
        status = self.statuses.get(peer)
        return int(status.values.get('index', '0')) if status else 0

    def parted(self) -> bool:
        """Every peer that takes part has closed its files."""
        sheet = getattr(self, 'sheet', None)
        values = [status.values for status in self.statuses.values()] if sheet else []
        mine = [each for each in values if sheet and each.get('run_id') == sheet.run_id]
        return all(each.get('state') in ('done', 'failed') for each in mine)

    def _see_off(self) -> None:
        if not self.parted() and time.monotonic() < self._end_until:
            return
        if self.spec.flag('exit_when_done'):
            self.finish(0 if self.sheet.state == 'finished' else 1)
        else:
            self.state = 'idle'

    # --- peers and operators

    def _heard(self, peer: str, raw: bytes) -> None:
        status = wire.decode_status(raw)
        self.statuses[peer] = status
        if not self._ours(status):
            return
        if status.level == wire.LEVEL['error'] and self.busy:
            self._end('aborted', f'{peer}: {status.message.removeprefix("aborted: ")}')
        elif self.state in ('waiting', 'armed', 'draining', 'ended') or (
            self.state == 'running' and self.sheet.mode == 'lockstep'
        ):
            self.tick()

    def _ours(self, status: Status) -> bool:
        return status.values.get('run_id') == self.sheet.run_id if self.busy else False

    def _lost(self, peer: str) -> None:
        gone = self.statuses.pop(peer, None)
        if self.state in ('armed', 'running', 'draining') and gone is not None:
            self.get_logger().error(f'{peer} died or was cut off; the run ends')
            self.gone.append(peer)  # `tick` acts on it: a second one may be news of the same moment

    def _ramp_down(self, why: str) -> None:
        self._abort_reason = why
        self.sheet = self.sheet.of(samples=self.soft_stop())
        self.get_logger().warning(f'{why}: ramping down')

    def _abort_service(self, request: Any, response: Any) -> Any:
        response.success = self.state == 'running'
        response.message = 'ramping down' if response.success else f'no run is on ({self.state})'
        if response.success:
            self._ramp_down('aborted by the operator')
        return self.answer(response)

    def fail(self, error: RigError) -> None:
        if self.busy:
            self._end('aborted', str(error))
        super().fail(error)

    def operator_stop(self, why: str) -> None:
        if self.busy:
            self._end('aborted', f'stopped by {why}')
        super().operator_stop(why)

    def _end(self, state: str, reason: str) -> None:
        if self.state in ('ended', 'idle'):
            return
        self.busy = False
        self.sheet = self.sheet.of(reason=reason)
        self._announce(state)
        self.state = 'ended'
        self._end_until = time.monotonic() + SEE_OFF_S
        # two calls: rclpy refuses one call that changes its severity
        if state == 'finished':
            self.get_logger().info(f'run {self.sheet.run_id} finished')
        else:
            self.get_logger().error(f'run {self.sheet.run_id} aborted: {reason}')

    def _announce(self, state: str) -> None:
        self.state = state
        self.sheet = self.sheet.of(state=state)
        self._publish_sheet()

    def _publish_sheet(self) -> None:
        self._announced_at = time.monotonic()
        self._run.publish(wire.encode_json(self.sheet.to_document()))

    def status(self) -> Status:
        state = getattr(self, 'state', 'unconfigured')
        sheet = getattr(self, 'sheet', None)
        values = {'state': state}
        if sheet is not None:
            values |= {'run_id': sheet.run_id, 'sent': str(self.sent), 'of': str(sheet.samples)}
        aborted = sheet is not None and sheet.state == 'aborted'
        level = wire.LEVEL['error' if aborted else 'warn' if state == 'waiting' else 'ok']
        return Status(self.role, level, sheet.reason if aborted and sheet else self._text(), values)

    def _text(self) -> str:
        awaited = getattr(self, '_waits_for', '')
        return f'waiting for {awaited}' if awaited else getattr(self, 'state', 'unconfigured')
