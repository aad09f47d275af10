"""The rig at its promises, by the clock: `make soak`. Prints one line a run.

lockstep   the 120 s default sweep, two Imu topics at 500 Hz, recorded: wall time and lost samples
real time  60 s at 1 kHz: lost samples and CPU of all three nodes over one core
long       1000 s at 500 Hz in lockstep, for the memory of the nodes and the size of the bag
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

RUNS = {
    'lockstep': (),
    'lockstep again': (),
    'lockstep, four dofs': (
        *('--set', 'excitation.amplitude.horizontal=0.5', '--set', 'platform.L0_hat=0.08'),
        *('--set', 'excitation.amplitude.vertical_rotation=0.1'),
        *('--set', 'excitation.amplitude.horizontal_rotation=0.1'),
    ),
    'real time, 1 kHz': (
        '--real-time', '--set', 'run.rate=1000', '--set', 'excitation.duration=54',
    ),
    'long': ('--set', 'excitation.duration=994',),
}  # fmt: skip


def main() -> int:
    """Perform all runs; the exit code is that of the worst."""
    worst = 0
    print(f'{"run":22}{"rig s":>8}{"wall s":>8}{"speed":>7}{"lost":>6}{"CPU %":>7}{"bag MB":>8}')
    with tempfile.TemporaryDirectory() as scratch:
        for name, extra in RUNS.items():
            folder = Path(scratch) / name.replace(' ', '_')
            command = [sys.executable, '-m', 'qzs_rig.cli.main', 'rig', '--json', *extra]
            done = subprocess.run(
                [*command, '--out', str(folder)], capture_output=True, text=True, check=False
            )
            worst = max(worst, done.returncode)
            if done.returncode not in (0, 3):
                print(f'{name}: exit {done.returncode}: {done.stderr.strip()}')
                continue
            run = json.loads(done.stdout)
            lost = sum(topic['lost'] for topic in run['topics'].values())
            size = sum(file.stat().st_size for file in folder.glob('*.mcap')) / 1e6
            print(
                f'{name:22}{run["rig_s"]:8.1f}{run["wall_s"]:8.2f}'
                f'{run["rig_s"] / run["wall_s"]:7.1f}{lost:6}'
                f'{100 * run["cpu_s"] / max(run["wall_s"], 1e-9):7.0f}{size:8.2f}',
                flush=True,
            )
    return worst


if __name__ == '__main__':
    sys.exit(main())
