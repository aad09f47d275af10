"""Payload trim: every law rests where it carries the weight, and a run starts there."""

from __future__ import annotations

import numpy as np
import pytest

from qzs_rig import scenario
from qzs_rig.errors import InputError
from qzs_rig.gravity import GRAVITY
from qzs_rig.mechanics.integrator import Integrator
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring import RESTORING

every_law = pytest.mark.parametrize('law', RESTORING)


def platform(law, balanced) -> Platform:
    return Platform.from_spec(
        scenario.of({'platform.law': law, 'platform.balanced_mass': balanced})
    )


@every_law
@pytest.mark.parametrize('balanced', [35.0, 49.9, 51.0, 80.0])
def test_the_law_carries_the_excess_at_rest(law, balanced):
    rig = platform(law, balanced)
    weight = (50.0 - balanced) * GRAVITY
    w = np.array([rig.rest[0], 0.0, 0.0, 0.0])
    carried = rig.stiffness[0] * abs(rig.length[0]) * rig.law.force(rig.design, w)[0]
    # bisection ends between neighbouring numbers: slope of at most 2 k1 L20 over their distance
    assert carried == pytest.approx(weight, abs=1e-10)
    assert np.sign(rig.rest[0]) == np.sign(weight)  # heavy is down, which the paper counts positive


@every_law
def test_a_balanced_payload_rests_at_the_working_point(law):
    assert platform(law, 50.0).rest == (0.0,) * 4
    assert Platform.from_spec(scenario.of({'platform.law': law})).rest == (0.0,) * 4


@every_law
@pytest.mark.parametrize('kernel', ['python', 'numba'])
def test_a_trimmed_platform_stays_where_it_rests(law, kernel):
    rig = platform(law, 45.0)
    base = np.zeros((400, 12))
    base[:, 0] = 0.01
    top = Integrator(rig, 2e-3, 1, kernel).push(base)
    assert np.allclose(top[:, 0], 0.01 + rig.rest[0] * rig.length[0], rtol=0, atol=1e-12)
    assert top[0, 0] < 0.01  # too heavy: it sags


def test_a_payload_beyond_the_springs_is_refused():
    with pytest.raises(
        InputError, match=r'law linear cannot hold .* bring platform\.balanced_mass'
    ):
        _ = platform('linear', 50_000.0).rest
