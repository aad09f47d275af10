"""Synthetic runs: a sweep up and a sweep down along the branches of a known theory."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from qzs_rig.compare.theory_overlay import TheoryCase, theory_curve
from qzs_rig.estimation.estimate import Curve, Estimate, Event

CASE = TheoryCase(
    dof='vertical', c1=0.15, c3=4.2, zeta=0.05, omega0=20.0, length=0.6, amplitude=0.025
)
RESOLUTION = 0.02


def swept(case, n=240):
    """What ideal slow sweeps from 0.5 to 8 Hz read along `case`, with their events."""
    f = np.geomspace(0.5, 8.0, n)
    theory = theory_curve(case, 0.4, 10.0)
    up, down = case.folds_hz()
    curves, events = [], []
    for direction, leap, kind in (('forward', down, 'jump_down'), ('reverse', up, 'jump_up')):
        upper = f < leap
        column = np.where(upper & (f > up), 2, 0)

        def along(values, column=column):
            branches = np.stack(
                [
                    np.interp(f, theory.frequency_hz[on], values[on, k])
                    for k, on in enumerate(np.isfinite(values).T)
                ],
                axis=1,
            )
            lone = np.where(f <= up, 2, 0)
            chosen = np.where((f > up) & (f < down), column, lone)
            return np.take_along_axis(branches, chosen[:, None], axis=1)[:, 0]

        T, phase = along(theory.magnitude), along(theory.phase_deg)
        thd = 0.02 + 0.2 * np.exp(-((np.log(f / 1.5) / 0.4) ** 2)) * (upper | (f < up))
        turn = slice(None) if direction == 'forward' else slice(None, None, -1)
        curves.append(
            Curve(
                case.dof,
                direction,
                'tracked_sine',
                'fundamental',
                f[turn],
                T[turn],
                phase[turn],
                thd[turn],
            )
        )
        crossing = int(np.flatnonzero(T < 1)[0])
        top = int(np.argmax(T))
        for what, at in (('onset', crossing), ('peak', top)):
            events.append(Event(case.dof, direction, what, float(f[at]), float(T[at]), RESOLUTION))
        events.append(
            Event(case.dof, direction, kind, float(leap), float(T[f < leap][-1]), RESOLUTION)
        )
    return Estimate(tuple(curves), tuple(events), {'samples': 60000, 'lost': 0})


@pytest.fixture(scope='session')
def case():
    return CASE


@pytest.fixture(scope='session')
def run():
    return swept(CASE)


@pytest.fixture(scope='session')
def stiffer_run():
    """The same rig under a slightly larger base motion."""
    return swept(replace(CASE, amplitude=0.027))
