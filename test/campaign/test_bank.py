"""The columns of a bank are the platforms of its points, one by one."""

from __future__ import annotations

import numpy as np
import pytest

from qzs_rig.campaign import plan
from qzs_rig.campaign.bank import banks
from qzs_rig.campaign.task import Harvest
from qzs_rig.campaign.tasks.single_term import amplitude_hat
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS

RANGES = {
    'SI': {
        'platform.k1': {'from': 1e4, 'to': 3e4},
        'platform.k3': {'from': 0, 'to': 4e3},
        'platform.C.vertical': {'from': 0, 'to': 90},
        'platform.L1': {'from': 0.4, 'to': 0.6},
        'platform.m': {'from': 5, 'to': 90},
        'displacement': {'from': 0.01, 'to': 0.1},
    },
    'ratios': {
        'platform.A': {'from': 0.5, 'to': 2},
        'platform.k3_hat': {'from': 0, 'to': 1},
        'platform.L1_hat': {'from': 0.5, 'to': 1},
        'platform.L0_hat': {'from': 0.05, 'to': 0.2},
        'platform.zeta': {'from': 0.01, 'to': 0.2},
        'platform.I_vm': {'from': 0.01, 'to': 0.2},
        'amplitude': {'from': 0.01, 'to': 0.7},
    },
}


def points_of(ranges, base=None, law=tuple(RESTORING)):
    return plan.of(
        {
            'campaign': {'task': 'single_term', 'sample': 'latin_hypercube', 'samples': 60},
            'base': base or {},
            'vary': {**ranges, 'platform.law': list(law), 'dof': list(DOFS)},
        }
    ).between(0, 60)


@pytest.mark.parametrize('kind', RANGES)
def test_a_bank_holds_the_platforms_of_its_points(kind):
    points = points_of(RANGES[kind], {'platform.payload_trim': -1.0} if kind == 'SI' else {})
    seen = 0
    for bank in banks(points, Harvest((), 60)):
        for n, row in enumerate(bank.rows):
            spec = points.spec(int(row))
            wanted = Oscillator.of(spec, spec.text('dof'), amplitude_hat(spec))
            found = bank.oscillator(n)
            assert (found.law, found.dof) == (wanted.law, wanted.dof)
            for name in ('design', 'zeta', 'amplitude', 'load'):
                # rounding: the same products, some of them in another order
                assert getattr(found, name) == pytest.approx(getattr(wanted, name), rel=1e-15)
            omega0 = Platform.from_spec(spec).omega0[found.number]
            assert bank.omega0[n] == pytest.approx(omega0, rel=1e-15)
            seen += 1
    assert seen == 60


def test_frequencies_are_made_nondimensional():
    document = {
        'campaign': {'task': 'single_term'},
        'base': {'amplitude': 0.1},
        'vary': {'platform.k1': [2e4, 8e4], 'platform.m': [50.0, 200.0]},
    }
    points = plan.of(document).between(0, 4)
    (bank,) = banks(points, Harvest((), 4))
    assert bank.omega0 == pytest.approx([20.0, 10.0, 40.0, 20.0], rel=1e-15)


def test_platforms_that_cannot_be_built_are_failed_rows():
    document = {
        'campaign': {'task': 'single_term'},
        'base': {'amplitude': 0.1, 'platform.L1': 0.5},
        'vary': {'platform.L20': [0.4, 0.6], 'platform.payload_trim': [-60.0, 0.0]},
    }
    harvest = Harvest((), 4)
    (bank,) = banks(plan.of(document).between(0, 4), harvest)
    part = harvest.part()
    assert bank.rows.tolist() == [3]
    told = [part.reasons[code] for code in part.code]
    assert 'platform.L1 / L20' in told[1] and 'payload_trim' in told[2]
    assert part.code[0] and not part.code[3]
    assert np.isfinite(bank.ratios).all()
