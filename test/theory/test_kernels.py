"""Compiled kernels: kept on disk for the next process, and apart where formulas differ."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest

from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN
from qzs_rig.theory.motion import kernels
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.kernels import schedule
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS


def test_the_next_process_finds_a_kernel_on_disk():
    program = (
        'from qzs_rig.mechanics.restoring import RESTORING\n'
        'from qzs_rig.theory.motion.kernels import advancing, grow\n'
        "period = advancing(RESTORING['closed_form'], 0)\n"
        'print(len(period.stats.cache_hits), len(grow.stats.cache_hits))'
    )
    # names in sets have another order with each seed. numba's key has the pickled formula, and that
    # of a module just compiled from source differs from that of its .pyc: without .pyc files the
    # second process may compile, too
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
    runs = Batch.of(Oscillator(RESTORING[law], DOFS[number], PAPER_DESIGN, 0.1, 0.2), 0.8, w=0.1)
    plain, moved = runs.law.along(number, math.sqrt), []
    for period in (
        kernels.advancing(runs.law, number),
        kernels.period_around(lambda _, w: plain(PAPER_DESIGN, w), runs.law.count),
    ):
        block, steps = kernels.block(runs.law.count), schedule(2)
        for column in range(64):
            kernels.begin(block, column, runs.table, runs.numbers, 0, steps)
        period(block, steps)
        moved.append(np.concatenate([block.w[0, :1], block.y[0, :1], block.cos[:1]]))
    # the fast root is good to 2e-14, sums are regrouped
    assert moved[0] == pytest.approx(moved[1], abs=1e-12)


def test_what_an_older_version_left_on_disk_is_made_anew(tmp_path):
    """A type in a signature has moved to another module since."""
    (tmp_path / 'old_home.py').write_text(
        'from typing import NamedTuple\n\nclass Pair(NamedTuple):\n    a: float\n    b: float\n'
    )
    user = (
        'from numba import float64, typeof\n'
        'from {home} import Pair\n'
        'from qzs_rig.mechanics.compiling import kept\n'
        '@kept(float64(typeof(Pair(0.0, 0.0))))\n'
        'def total(pair):\n'
        '    return pair.a + pair.b\n'
        'if __name__ != "__main__":\n'
        '    print(len(total.stats.cache_hits), total(Pair(1.0, 2.0)))\n'
    )
    source = tmp_path / 'user.py'
    environment = {'PYTHONPATH': ':'.join([str(tmp_path), *sys.path]), 'PYTHONHASHSEED': '1'}

    def run():
        words = [sys.executable, '-c', 'import user']
        found = subprocess.run(
            words, capture_output=True, text=True, check=False, env=environment, cwd=tmp_path
        )
        assert found.returncode == 0, found.stderr
        return found.stdout.split()

    source.write_text(user.format(home='old_home'))
    assert run() == ['0', '3.0']
    assert run() == ['1', '3.0']
    (tmp_path / 'old_home.py').rename(tmp_path / 'new_home.py')
    source.write_text(user.format(home='new_home'))
    assert run() == ['0', '3.0']
    assert run() == ['1', '3.0']
