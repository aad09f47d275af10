"""Compiled kernels: kept on disk for the next process, and apart where formulas differ."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest

from qzs_rig.mechanics.design import PAPER_DESIGN
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.theory.motion import kernels
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.kernels import schedule
from qzs_rig.theory.oscillator import oscillator
from qzs_rig.units import DOFS


def test_the_next_process_finds_a_kernel_on_disk():
    program = (
        'from qzs_rig.mechanics.restoring import RESTORING\n'
        'from qzs_rig.theory.motion.kernels import advancing, grow\n'
        "period = advancing(RESTORING['closed_form'], 0)\n"
        'print(len(period.stats.cache_hits), len(grow.stats.cache_hits))'
    )
    # names in sets have another order with each seed; of a fresh install the first two processes
    # may both compile, the third never
    for seed in ('1', '2', '3'):
        run = subprocess.run(
            [sys.executable, '-c', program],
            capture_output=True,
            text=True,
            check=True,
            env={'PYTHONHASHSEED': seed, 'PYTHONPATH': ':'.join(sys.path)},
        )
    assert run.stdout.split() == ['1', '1']


@pytest.mark.parametrize('law', RESTORING)
@pytest.mark.parametrize('number', range(4), ids=DOFS)
def test_every_law_has_a_period_of_its_own(law, number):
    """A kernel taken from the disk for another law would kick by another force."""
    runs = Batch.of(oscillator(law, DOFS[number], PAPER_DESIGN, 0.1, 0.2), 0.8, w=0.1)
    moved = []
    for period in (
        kernels.advancing(runs.law, number),
        kernels.period_around(lambda _, w: runs.law.bind(math.sqrt)[number](PAPER_DESIGN, w)),
    ):
        block, steps = kernels.block(), schedule(2)
        for column in range(64):
            kernels.begin(block, column, runs.table, runs.numbers, 0, steps)
        period(block, steps)
        moved.append(np.concatenate([block.w[0, :1], block.y[0, :1], block.cos[:1]]))
    # the fast root is good to 2e-14, sums are regrouped
    assert moved[0] == pytest.approx(moved[1], abs=1e-12)
