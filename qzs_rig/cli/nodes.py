"""The node processes of a run, started and ended by the CLI itself: no ros2cli is needed."""

from __future__ import annotations

import importlib.util
import json
import os
import queue
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from qzs_rig import loopback
from qzs_rig.errors import InputError, PeerError
from qzs_rig.parameters import RunSpec

PATIENCE_S = 2.0
"""How long nodes may take to close before they are killed."""
LEADS = ('exciter', 'player')


@contextmanager
def environment() -> Iterator[dict[str, str]]:
    """The environment of the nodes: this machine only, and a domain of their own for the block,
    unless the caller's environment says otherwise."""
    env = {loopback.RANGE: 'LOCALHOST', **os.environ, 'PYTHONUNBUFFERED': '1'}
    if loopback.DOMAIN in env:
        yield env
        return
    domain = loopback.reserve_domain()
    try:
        yield env | {loopback.DOMAIN: str(domain.number)}
    finally:
        domain.close()


def need_ros() -> None:
    """Raises InputError where rclpy is not installed."""
    if importlib.util.find_spec('rclpy') is None:
        raise InputError(
            "rclpy is not installed, so there are no nodes to run; pip install 'qzs_rig[ros]', or "
            'source a ROS 2 setup, or use `qzs-rig run`, which needs no ROS'
        )


class Nodes:
    """Node processes of one run, their logs, and the analyzer's progress lines."""

    def __init__(self, spec: RunSpec, env: Mapping[str, str]) -> None:
        self._scratch = tempfile.TemporaryDirectory(prefix='qzs_rig_')
        self._folder = Path(self._scratch.name)
        self._parameters = self._folder / 'parameters.yaml'
        self._parameters.write_text(spec.to_yaml(), encoding='utf-8')
        self._env = dict(env)
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def start(self, role: str, **parameters: Any) -> None:
        """Start node `role` with parameters on top of the scenario."""
        words = [f'-p{name}:={_word(value)}' for name, value in parameters.items()]
        arguments = [word for text in words for word in (text[:2], text[2:])]
        with self._log(role).open('wb') as log, undisturbed():
            self._processes[role] = process = subprocess.Popen(
                [
                    *(sys.executable, '-m', f'qzs_rig.ros.{role}', '--ros-args'),
                    *('--params-file', str(self._parameters), *arguments),
                ],
                stdout=subprocess.PIPE,
                stderr=log,
                stdin=subprocess.DEVNULL,
                env=self._env,
                start_new_session=True,  # Ctrl-C reaches the nodes through `stop`, in order
            )
        threading.Thread(target=self._read, args=(process,), daemon=True).start()

    def progress(self, timeout: float) -> dict[str, Any] | None:
        """The newest progress line, waiting at most `timeout` s for one."""
        newest = None
        try:
            newest = self._lines.get(timeout=timeout)
            while True:
                newest = self._lines.get_nowait()
        except queue.Empty:
            pass
        try:
            document = json.loads(newest) if newest else None
        except json.JSONDecodeError:
            return None
        return document if isinstance(document, dict) else None

    def running(self) -> list[str]:
        """Roles whose process has not ended."""
        return [role for role, process in self._processes.items() if process.poll() is None]

    def codes(self) -> dict[str, int | None]:
        """Exit codes so far."""
        return {role: process.poll() for role, process in self._processes.items()}

    def stop(self, patience_s: float = PATIENCE_S) -> None:
        """SIGINT to the lead, which tells the others; then to all, then SIGKILL."""
        for role in self.running():
            if role in LEADS:
                self._processes[role].send_signal(signal.SIGINT)
                self.wait(0.3 * patience_s)
        for role in self.running():
            self._processes[role].send_signal(signal.SIGINT)
        self.wait(0.6 * patience_s)
        for role in self.running():
            self._processes[role].kill()
        self.wait(patience_s)

    def wait(self, patience_s: float) -> bool:
        """Wait for all to end; false where some still run after `patience_s`."""
        until = time.monotonic() + patience_s
        while self.running() and time.monotonic() < until:
            time.sleep(0.01)
        return not self.running()

    def cpu_s(self) -> float:
        """CPU seconds of all nodes that have ended."""
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    def errors(self) -> list[str]:
        """What the nodes complained about, one line each, the oldest first."""
        lines = []
        for role in self._processes:
            text = self._log(role).read_text(encoding='utf-8', errors='replace')
            for line in text.splitlines():
                if line.startswith(('[ERROR]', '[FATAL]', 'qzs_rig:')):
                    lines.append(f'{role}: {line.rsplit("]: ", 1)[-1]}')
        return lines

    def cautions(self) -> list[str]:
        """Warnings of the nodes."""
        text = [self._log(role).read_text(errors='replace') for role in self._processes]
        lines = [line for log in text for line in log.splitlines() if line.startswith('[WARN]')]
        return [line.rsplit(']: ', 1)[-1] for line in lines]

    def keep_logs(self, folder: Path) -> None:
        """Copy the nodes' logs and the parameter file into the run's folder."""
        logs = folder / 'log'
        logs.mkdir(exist_ok=True)
        for source in (self._parameters, *(self._log(role) for role in self._processes)):
            (logs / source.name).write_bytes(source.read_bytes())

    def close(self) -> None:
        """End what still runs and remove the scratch files."""
        with undisturbed():
            self.stop()
            self._scratch.cleanup()

    def died(self, folder: Path) -> PeerError:
        """Why the run gave no estimate, and what can be done with a bag in `folder`."""
        said = self.errors()
        codes = ', '.join(f'{role} exit {code}' for role, code in self.codes().items())
        rescue = f'; get the bag back with: qzs-rig bag recover {folder}' if folder.is_dir() else ''
        return PeerError(
            f'the nodes ended without an estimate ({codes}): {"; ".join(said) or "no word"}{rescue}'
        )

    def _log(self, role: str) -> Path:
        return self._folder / f'{role}.log'

    def _read(self, process: subprocess.Popen[bytes]) -> None:
        assert process.stdout is not None
        for line in process.stdout:
            self._lines.put(line)


@contextmanager
def undisturbed() -> Iterator[None]:
    """SIGINT and SIGTERM wait for the end of the block: an exception between the birth of a process
    and its entry in the books would orphan it."""
    came: list[int] = []
    handlers = {
        number: signal.signal(number, lambda number, _frame: came.append(number))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
    if came:
        raise KeyboardInterrupt


def _word(value: Any) -> str:
    """A value as rcl's command line reads it: text in quotes, so that 1e5 stays a name."""
    return str(value).lower() if isinstance(value, bool) else json.dumps(value)
