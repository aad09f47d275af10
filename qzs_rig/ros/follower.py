"""A node that follows a run: gets ready for the lead's sheet, works, says how far it is."""

from __future__ import annotations

import time
from abc import abstractmethod
from functools import partial

from rclpy.context import Context

from qzs_rig import wire
from qzs_rig.errors import PeerError, RigError
from qzs_rig.ros.lead import PEER_STATUS
from qzs_rig.ros.node import REPEAT_S, RigNode
from qzs_rig.ros.states import FollowerState, FollowerStatus, stepped
from qzs_rig.run.sheet import RunSheet, SheetState, from_document
from qzs_rig.wire import Status

STATUS_S = 0.2
"""Longest silence of a status between chunks of a real-time run."""


UNREADY = (FollowerState.IDLE, FollowerState.WAITING)
BEFORE_RUN = (*UNREADY, FollowerState.READY)


class Follower(RigNode):
    """Subclasses give `endpoints`, `armed`, `conclude` and keep `index`, the samples done."""

    def __init__(self, context: Context | None = None) -> None:
        super().__init__(context)
        self.state = FollowerState.UNCONFIGURED
        self.sheet: RunSheet | None = None
        self.index = 0
        self.message = ''
        self._said_at = 0.0
        self._told = ('', '')  # run and message, as the peers know them
        self._alone = False  # ended the run before the lead did
        self._heard: set[str] = set()  # peers that have said their status

    def open(self) -> None:
        self._enter(FollowerState.IDLE, 'waiting for rig/run (the exciter or a player)')
        self.sheet, self.index = None, 0
        self._told, self._alone = ('', ''), False
        self._heard.clear()

    def _enter(self, state: FollowerState, message: str) -> None:
        self.state, self.message = stepped(self.state, state), message

    def introduce(self) -> None:
        self.publisher(PEER_STATUS[self.role])
        self.subscribe(wire.RUN, self._read_sheet, lost=partial(self.peer_lost, 'lead'))
        for peer, topic in PEER_STATUS.items():
            if peer != self.role:
                self.subscribe(topic, partial(self._hear, peer), lost=partial(self.peer_lost, peer))

    # --- what a subclass gives

    @abstractmethod
    def endpoints(self, sheet: RunSheet) -> list[str]:
        """Labels of the endpoints that must be matched before this node is ready."""

    def prepare(self, sheet: RunSheet) -> None:
        """What takes long, while the nodes still find each other; `sheet` waits for its start."""

    @abstractmethod
    def armed(self, sheet: RunSheet) -> None:
        """Build everything for the run on `sheet`, which now has its start and its whole spec."""

    @abstractmethod
    def conclude(self, sheet: RunSheet) -> None:
        """The run on `sheet` is over, finished or aborted: keep what there is."""

    def details(self) -> dict[str, str]:
        """Counters for the status."""
        return {}

    # --- the run

    def begin(self) -> None:
        self.say()

    def halt(self) -> None:
        if self.busy:
            self.message = f'{self.role} was deactivated by the operator'
            self._alone = True
            self._end(self._aborted(self.message))  # its status ends the run for the others
        elif self.state is FollowerState.READY:
            self._get_ready()

    def tick(self) -> None:
        silence_s = time.monotonic() - self._said_at
        if self.gone and self.busy:
            self._alone = True
            self._end(self._aborted(f'{" and ".join(self.gone)} died'))
        elif self.state in BEFORE_RUN:
            if self.state is FollowerState.WAITING:
                self._get_ready()
            if silence_s > REPEAT_S:
                self.say()
            self.remind(self.message)
        elif self.state is FollowerState.RUNNING and silence_s > STATUS_S:
            self.say()

    def _hear(self, peer: str, raw: bytes) -> None:
        self._heard.add(peer)

    def _read_sheet(self, raw: bytes) -> None:
        sheet = from_document(wire.decode_json(raw))
        if self.role not in sheet.peers:
            return
        if sheet.state is SheetState.WAITING and self.state in BEFORE_RUN:
            known, self.sheet = self.sheet, sheet
            self._enter(FollowerState.WAITING, self.message)
            self.reread()
            if known is None or known.run_id != sheet.run_id:
                self.prepare(sheet)
            self._get_ready()
        elif self.sheet is None or sheet.run_id != self.sheet.run_id:
            return  # a run that began without this node
        elif sheet.state is SheetState.ARMED and self.state is FollowerState.READY:
            self.sheet, self.index = sheet, 0
            self.gone.clear()
            self.armed(sheet)
            self.busy = True
            self._enter(FollowerState.ARMED, 'armed')
            self.say()
            self._enter(FollowerState.RUNNING, 'running')
        elif sheet.state in (SheetState.FINISHED, SheetState.ABORTED):
            self._alone = False
            self._end(sheet)

    def _get_ready(self) -> None:
        assert self.sheet is not None
        unheard = [peer for peer in self.sheet.peers if peer not in {self.role, *self._heard}]
        missing = [
            *([] if self.active else ['its activation']),
            *self.unmatched(self.endpoints(self.sheet)),
            *(f'node {peer}' for peer in unheard),
        ]
        if missing:
            self._enter(FollowerState.WAITING, f'waiting for {", ".join(missing)}')
        else:
            self._enter(FollowerState.READY, 'ready for the start')
        self.remind(self.message)
        told = (self.sheet.run_id, self.message)
        if told != self._told:
            self._told = told
            self.say()

    def _end(self, sheet: RunSheet) -> None:
        if self.state in (FollowerState.DONE, FollowerState.IDLE):
            return
        started = self.busy
        self.busy = False
        self.sheet = sheet
        if started:
            self.conclude(sheet)
        aborted = sheet.state is SheetState.ABORTED
        self._enter(FollowerState.DONE, f'aborted: {sheet.reason}' if aborted else 'finished')
        # two calls: rclpy refuses one call that changes its severity
        if aborted:
            self.get_logger().error(f'run {self.message}')
        else:
            self.get_logger().info(f'run {self.message}')
        self.say(wire.LEVEL['error'] if aborted else None)
        if self.spec.flag('exit_when_done'):
            self.finish(1 if aborted else 0)
        else:
            self._enter(FollowerState.IDLE, 'waiting for rig/run')

    def peer_lost(self, peer: str) -> None:
        """The middleware reports that `peer` no longer lives."""
        self._heard.discard(peer)
        if self.sheet is None or not self.busy or (peer != 'lead' and peer not in self.sheet.peers):
            if peer == 'lead' and self.state in (FollowerState.WAITING, FollowerState.READY):
                self._enter(FollowerState.IDLE, 'waiting for rig/run')
                self.sheet = None
            elif self.state is FollowerState.READY and self.sheet and peer in self.sheet.peers:
                self._get_ready()  # not any more
            return
        name = 'the exciter (or player)' if peer == 'lead' else peer
        self.get_logger().error(f'{name} died or was cut off; the run ends')
        self.gone.append(name)  # `tick` acts on it: a second one may be news of the same moment

    def fail(self, error: RigError) -> None:
        """Close what is open, tell the lead through the status, then end."""
        if self.busy:
            self.busy, self._alone = False, True
            self.conclude(self._aborted(str(error)))
        self._enter(FollowerState.FAILED, str(error))
        self.say(wire.LEVEL['error'])
        super().fail(error)

    def operator_stop(self, why: str) -> None:
        if self.busy:
            self.fail(PeerError(f'{self.role} was stopped by {why}'))
            self.exit_code = 0
        super().operator_stop(why)

    def parted(self) -> bool:
        """The lead has ended the run, too."""
        return not self._alone

    def _aborted(self, reason: str) -> RunSheet:
        assert self.sheet is not None
        return self.sheet.replace(state=SheetState.ABORTED, reason=reason)

    def say(self, level: int | None = None) -> None:
        """Publish the status; the lead's credit in lockstep."""
        self._said_at = time.monotonic()
        if self.opened(PEER_STATUS[self.role]):  # configuring may fail before
            self.publish(PEER_STATUS[self.role], wire.encode_status(self.status(level)))

    def status(self, level: int | None = None) -> Status:
        if level is None:
            unset = self.state is FollowerState.UNCONFIGURED
            level = wire.LEVEL['stale' if unset else 'warn' if self.state in UNREADY else 'ok']
        return FollowerStatus(
            self.role,
            self.state,
            level,
            self.message,
            run_id=self.sheet.run_id if self.sheet else None,
            index=self.index,
            spec=self.spec.sections(*self.sections) if self.state is FollowerState.READY else None,
            details=self.details(),
        ).to_wire()
