"""The rig over each transport of Fast DDS, one line each: speed, loss, starts, starts after kills.

    python benchmarks/transports.py [--runs 5] [--starts 50] [--kills 20] [--only NAME]

default run   the 120 s sweep in lockstep: the slowest and the median times real time, samples lost
starts        a run of one second, whole command: median and longest wall time, and how many did not
              end well within 30 s
kills         the platform killed (SIGKILL) amid a run in lockstep: how many of these runs the
              others did not close, with their bag, within 10 s
after kills   starts in the domain of the killed one, at once: how many did not end well
files         left in /dev/shm in the end
sockets       UDP sockets of a node that are bound to other addresses than 127.0.0.1
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from tqdm import tqdm

from qzs_rig import loopback, scenario
from qzs_rig.bag import info

SHIPPED = (scenario.config_folder() / 'fastdds.xml').read_text(encoding='utf-8')
TUNED = (
    '<transport_descriptor><transport_id>shared</transport_id><type>SHM</type>'
    '<segment_size>8388608</segment_size><port_queue_capacity>8192</port_queue_capacity>'
    '</transport_descriptor>'
)
PLAIN = SHIPPED[: SHIPPED.index('<dds')] + '<dds xmlns="http://www.eprosima.com"/>'

TRANSPORTS: dict[str, tuple[str, str]] = {
    'UDP on 127.0.0.1 (shipped)': ('SYSTEM_DEFAULT', SHIPPED),
    'the same, 208 KiB buffers': ('SYSTEM_DEFAULT', SHIPPED.replace('8388608', '212992')),
    'shared memory, tuned': (
        'SYSTEM_DEFAULT',
        SHIPPED.replace('</transport_descriptors>', f'{TUNED}</transport_descriptors>').replace(
            '<userTransports>', '<userTransports><transport_id>shared</transport_id>'
        ),
    ),
    'LOCALHOST without a profile': ('LOCALHOST', PLAIN),
}
"""Name -> discovery range and profile."""

SHORT = ('--set', 'excitation.duration=1', '--set', 'run.rate=200', '--set', 'excitation.ramp=0.2')
ENDLESS = ('--set', 'excitation.duration=3000')
PATIENCE_S = 30.0


class Rig:
    """`qzs-rig rig` with one transport, in one domain."""

    def __init__(self, folder: Path, discovery: str, profile: str, domain: int) -> None:
        self._folder = folder
        file = folder / 'profile.xml'
        file.write_text(profile, encoding='utf-8')
        self._domain = domain
        self._env = os.environ | {
            loopback.RANGE: discovery,
            loopback.DOMAIN: str(domain),
            'FASTDDS_DEFAULT_PROFILES_FILE': str(file),
        }
        self._count = 0

    def start(self, *words: str) -> subprocess.Popen[str]:
        """The command, started."""
        self._count += 1
        out = self._folder / f'run {self._count}'
        command = [sys.executable, '-m', 'qzs_rig.cli.main', 'rig', '--json', '--out', str(out)]
        return subprocess.Popen(
            [*command, *words], env=self._env, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip

    def perform(self, *words: str) -> tuple[float, dict[str, object] | None]:
        """Wall seconds of the whole command, and what it printed; None where it went wrong."""
        began = time.monotonic()
        with self.start(*words) as process:
            try:
                text, _ = process.communicate(timeout=PATIENCE_S)
            except subprocess.TimeoutExpired:
                self._kill_all(process)
                text = ''
            took = time.monotonic() - began
        return took, json.loads(text) if process.returncode == 0 and text else None

    def kill_one(self) -> tuple[bool, int]:
        """Start a run and kill its platform; whether the others closed it, and the most sockets
        that a node had elsewhere than on 127.0.0.1."""
        with self.start(*ENDLESS) as process:
            until = time.monotonic() + PATIENCE_S
            bag = self._folder / f'run {self._count}'
            while not any(f.stat().st_size > 50_000 for f in bag.glob('*.mcap')):
                time.sleep(0.01)
                if time.monotonic() > until:
                    break
            nodes = list(self._family())
            strays = max((_strays(pid) for pid in nodes), default=0)
            for pid in nodes:
                if b'qzs_rig.ros.platform' in Path(f'/proc/{pid}/cmdline').read_bytes():
                    os.kill(pid, signal.SIGKILL)
            try:
                process.communicate(timeout=10.0)
            except subprocess.TimeoutExpired:
                self._kill_all(process)
        return (bag / 'run.json').is_file() and info(bag).closed, strays

    def _kill_all(self, process: subprocess.Popen[str]) -> None:
        process.kill()
        for pid in self._family():
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)

    def _family(self) -> Iterator[int]:
        mark = f'{loopback.DOMAIN}={self._domain}\0'.encode()
        for folder in Path('/proc').iterdir():
            if folder.name.isdigit() and int(folder.name) != os.getpid():
                with contextlib.suppress(OSError):
                    if mark in (folder / 'environ').read_bytes():
                        yield int(folder.name)


def _strays(pid: int) -> int:
    try:
        inodes = {str(link.readlink()) for link in Path(f'/proc/{pid}/fd').iterdir()}
    except OSError:
        return 0
    rows = [row.split() for row in Path('/proc/net/udp').read_text().splitlines()[1:]]
    mine = [row[1] for row in rows if f'socket:[{row[9]}]' in inodes]
    return sum(not address.startswith('0100007F:') for address in mine)


def _shared() -> set[str]:
    return {path.name for path in Path('/dev/shm').iterdir() if 'fastdds' in path.name}


def measure(name: str, options: argparse.Namespace) -> str:
    """One line of the table."""
    discovery, profile = TRANSPORTS[name]
    domain = loopback.reserve_domain()
    before = _shared()
    speeds, lost, walls, bad, open_bags, bad_after, strays = [], 0, [], 0, 0, 0, 0
    try:
        with (
            tempfile.TemporaryDirectory() as scratch,
            tqdm(
                total=options.runs + options.starts + options.kills, desc=name, disable=None
            ) as bar,
        ):
            rig = Rig(Path(scratch), discovery, profile, domain.number)
            for _ in range(options.runs):
                _, run = rig.perform()
                if run:
                    speeds.append(run['rig_s'] / run['wall_s'])
                    lost += sum(topic['lost'] for topic in run['topics'].values())
                bar.update()
            for _ in range(options.starts):
                took, run = rig.perform(*SHORT)
                walls.append(took)
                bad += run is None
                bar.update()
            for _ in range(options.kills):
                closed, found = rig.kill_one()
                open_bags += not closed
                strays = max(strays, found)
                bad_after += rig.perform(*SHORT)[1] is None
                bar.update()
    finally:
        domain.close()
    speed = f'{min(speeds):.0f}, {statistics.median(speeds):.0f}' if speeds else '–'
    wall = f'{statistics.median(walls):.2f}, {max(walls):.2f}' if walls else '–'
    left = len(_shared() - before)
    return (
        f'{name:30}{speed:>8}{lost:6}{wall:>14}{bad:6} of {options.starts:<4}'
        f'{open_bags:4} of {options.kills:<3}{bad_after:6} of {options.kills:<3}{left:7}{strays:9}'
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--runs', type=int, default=5)
    parser.add_argument('--starts', type=int, default=50)
    parser.add_argument('--kills', type=int, default=20)
    parser.add_argument('--only', default='', help='transports whose name holds this text')
    options = parser.parse_args()
    print(
        f'{"transport":30}{"speed":>8}{"lost":>6}{"start s":>14}{"bad starts":>14}'
        f'{"kills":>11}{"after kills":>13}{"files":>7}{"sockets":>9}',
        flush=True,
    )
    for name in TRANSPORTS:
        if options.only in name:
            print(measure(name, options), flush=True)


if __name__ == '__main__':
    main()
