"""Synthetic runs: a sweep up and a sweep down along the branches of a known theory."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from qzs_rig.estimation.estimate import Curve, Estimate, Event
from qzs_rig.mechanics.restoring.law import Design
from qzs_rig.mechanics.restoring.polynomials import SYMMETRIC
from qzs_rig.prediction.predict import by_single_term
from qzs_rig.theory.oscillator import Oscillator

DESIGN = Design.of(A=1.25, k3=0.4, L1=math.sqrt(3.0) / 2.0, L0=0.1)
"""Hardening: c1 = 0.15, c3 = 4.2."""
OWN = Oscillator(
    SYMMETRIC, 'vertical', DESIGN, zeta=0.05, amplitude=0.025 / 0.6, omega0=20.0, length=0.6
)
RESOLUTION = 0.02


def swept(theory, n=240):
    """What ideal slow sweeps from 0.5 to 8 Hz read along `theory`, with their events."""
    f = np.geomspace(0.5, 8.0, n)
    up, down = (fold.frequency_hz for fold in theory.folds)
    branches = {branch.name: branch for branch in theory.branches}
    lower, high = branches['lower'], branches['upper']
    curves, events = [], []
    for direction, leap, kind in (('forward', down, 'jump_down'), ('reverse', up, 'jump_up')):
        upper = f < leap

        def along(name, upper=upper):
            values = [np.interp(f, b.frequency_hz, getattr(b, name)) for b in (high, lower)]
            return np.where(upper, *values)

        T, phase = along('transmissibility'), along('phase_deg')
        thd = 0.02 + 0.2 * np.exp(-((np.log(f / 1.5) / 0.4) ** 2)) * (upper | (f < up))
        turn = slice(None) if direction == 'forward' else slice(None, None, -1)
        curves.append(
            Curve(
                theory.dof,
                direction,
                'tracked_sine',
                'fundamental',
                f[turn],
                T[turn],
                phase[turn],
                thd[turn],
                0.01 * T[turn],
            )
        )
        crossing = int(np.flatnonzero(T < 1)[0])
        top = int(np.argmax(T))
        for what, at in (('onset', crossing), ('peak', top)):
            events.append(
                Event(theory.dof, direction, what, float(f[at]), float(T[at]), RESOLUTION)
            )
        events.append(
            Event(theory.dof, direction, kind, float(leap), float(T[f < leap][-1]), RESOLUTION)
        )
    return Estimate(tuple(curves), tuple(events), {'samples': 60000, 'lost': 0})


@pytest.fixture(scope='session')
def theory():
    return by_single_term(OWN, 0.4, 10.0)


@pytest.fixture(scope='session')
def run(theory):
    return swept(theory)


@pytest.fixture(scope='session')
def stiffer_run():
    """The same rig under a slightly larger base motion."""
    return swept(by_single_term(replace(OWN, amplitude=0.027 / 0.6), 0.4, 10.0))
