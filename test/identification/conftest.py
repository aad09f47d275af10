from __future__ import annotations

import numpy as np
import pytest
from measured_platform import stepped

from qzs_rig import scenario
from qzs_rig.identification.points import Points

ZETA = np.array([0.08, 0.09, 0.08])
A = np.array([1.10, 1.09, 1.11])
TRIM = np.array([0.3, -0.4, 0.0])
UP = np.geomspace(1.0, 4.0, 10)
HZ = np.concatenate([UP, UP[::-1]])


class Bench:
    """Three platforms, stepped up and down once; noise is added as asked."""

    truth = np.stack([ZETA, A, TRIM], axis=1)

    def __init__(self):
        # 8 s let the slowest disturbance die to exp(-0.08 · 20 · 8) = 3e-6
        self.ratio = stepped(HZ, ZETA, A, TRIM, settle_s=8.0)
        self.spec = scenario.load('vertical_sweep')

    def points(self, lane=0, noise=0.0, seed=0, *, phase=True, std=False):
        """The curve of a platform; each point has its own noise, half to twice `noise`."""
        rng, n, ratio = np.random.default_rng(seed), len(HZ), self.ratio[:, lane]
        sigma, T = noise * rng.uniform(0.5, 2.0, n), np.abs(ratio)
        turned = np.angle(ratio) + sigma * rng.standard_normal(n)
        return Points(
            'vertical',
            np.where(np.arange(n) < len(UP), 'forward', 'reverse'),
            HZ,
            T * (1.0 + sigma * rng.standard_normal(n)),
            turned if phase else np.full(n, np.nan),
            sigma * T if std else np.full(n, np.nan),
            np.zeros(n),
        )


@pytest.fixture(scope='session')
def bench():
    return Bench()
