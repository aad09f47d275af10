"""What a campaign of a million points costs: the engine alone, and runs of 500 periods.

The engine alone makes points and oscillators, hands out chunks, keeps them, and writes and sums
up the table; its task gives nine columns back at once. The runs are those of Figure 13 over
damping and amplitude. `python benchmarks/campaign.py 100000` takes fewer points.
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from qzs_rig.campaign import plan
from qzs_rig.campaign.finished import summary
from qzs_rig.campaign.oscillators import groups
from qzs_rig.campaign.perform import Performed, perform
from qzs_rig.campaign.plan import Plan
from qzs_rig.campaign.runners import Threads
from qzs_rig.campaign.task import Harvest, Points
from qzs_rig.parameters import RunSpec


def wanted(points: int, early: bool, sample: str = 'grid') -> Plan:
    """Damping of Figure 13 times amplitudes around its own, at 6.28 rad/s."""
    zeta: dict[str, Any] = {'from': 0.0158, 'to': 0.158, 'scale': 'log'}
    amplitude: dict[str, Any] = {'from': 0.5, 'to': 0.7}
    head: dict[str, Any] = {'task': 'strobe', 'sample': sample}
    if sample == 'grid':
        side = round(points**0.5)
        zeta['count'] = amplitude['count'] = side
    else:
        head['samples'] = points
    return plan.of(
        {
            'campaign': head,
            'base': {'platform.law': 'closed_form', 'omega': 0.314},
            'vary': {'platform.zeta': zeta, 'amplitude': amplitude},
            'options': {'early': early},
        }
    )


def idle(points: Points, options: RunSpec, harvest: Harvest) -> None:
    """All that the stroboscope's task does, but for running."""
    for rows, runs in groups(points, harvest):
        harvest.put(rows, dict.fromkeys(plan.TASKS['strobe'].columns, runs.omega))


def measured(what: Plan, kind: str) -> tuple[Performed, float, float]:
    """The campaign done, and with the summary its wall time and the core seconds used."""
    with tempfile.TemporaryDirectory() as folder:
        began, used = time.perf_counter(), time.process_time()
        workers = os.cpu_count() or 1
        done = perform(what, Path(folder) / 'out', Threads(workers), kind, lambda points: None)
        summary(done.table)
        return done, time.perf_counter() - began, time.process_time() - used


def line(name: str, what: Plan, kind: str) -> None:
    """Measure and print."""
    done, wall, used = measured(what, kind)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    rate = what.points / wall
    print(
        f'{name:38} | {wall:7.2f} s | {used:7.2f} s | '
        f'{1e6 * wall / what.points:7.3f} µs | {rate:9.0f} | '
        f'{done.first_s or 0.0:5.2f} s | {memory:6.0f} MB',
        flush=True,
    )


def main() -> None:
    points = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    cores = os.cpu_count() or 1
    print(f'{points} points, {cores} cores')
    print('work | wall | core seconds | a point | points/s | first chunk | peak memory so far')
    for sample in ('grid', 'latin_hypercube'):
        for kind in ('npz', 'parquet'):
            grid = wanted(points, True, sample)
            engine = replace(grid, task=replace(grid.task, compute=idle))
            line(f'engine alone, {sample}, {kind}', engine, kind)
    line('500 periods, done once they repeat', wanted(points, True), 'npz')
    line('500 periods, all of them', wanted(points, False), 'npz')


if __name__ == '__main__':
    main()
