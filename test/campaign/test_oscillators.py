"""Oscillators of many points at once are those of each point, one by one."""

from __future__ import annotations

import numpy as np
import pytest

from qzs_rig.campaign import plan
from qzs_rig.campaign.oscillators import groups, oscillator_of
from qzs_rig.campaign.task import Harvest
from qzs_rig.mechanics.restoring import RESTORING
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
def test_columns_hold_the_oscillators_of_their_points(kind):
    points = points_of(RANGES[kind], {'platform.payload_trim': -1.0} if kind == 'SI' else {})
    seen = 0
    for rows, columns in points.alike(np.arange(60)):
        found = oscillator_of(columns)
        for n, row in enumerate(rows):
            wanted = oscillator_of(points.spec(int(row)))
            assert (found.law, found.dof) == (wanted.law, wanted.dof)
            pairs = list(zip(found.design, wanted.design, strict=True))
            for name in ('zeta', 'amplitude', 'load', 'omega0', 'length'):
                pairs.append((getattr(found, name), getattr(wanted, name)))
            for column, value in pairs:
                # numpy squares by a product, C by pow: the last bit
                assert np.broadcast_to(column, len(rows))[n] == pytest.approx(value, rel=1e-15)
            seen += 1
    assert seen == 60


def test_frequencies_are_made_nondimensional():
    document = {
        'campaign': {'task': 'strobe'},
        'base': {'amplitude': 0.1, 'frequency': 10.0 / np.pi},
        'vary': {'platform.k1': [2e4, 8e4], 'platform.m': [50.0, 200.0]},
    }
    points = plan.of(document).between(0, 4)
    omega = np.empty(4)
    for rows, runs in groups(points, Harvest((), 4)):
        omega[rows] = runs.omega
    assert omega == pytest.approx([1.0, 2.0, 0.5, 1.0], rel=1e-15)


def test_platforms_that_cannot_be_built_are_failed_rows():
    document = {
        'campaign': {'task': 'strobe'},
        'base': {'amplitude': 0.1, 'omega': 1.0, 'platform.L1': 0.5},
        'vary': {'platform.L20': [0.4, 0.6], 'platform.payload_trim': [-60.0, 0.0]},
    }
    harvest = Harvest((), 4)
    ((rows, runs),) = groups(plan.of(document).between(0, 4), harvest)
    part = harvest.part()
    assert rows.tolist() == [3]
    told = [part.reasons[code] for code in part.code]
    assert 'platform.L1 / L20' in told[1] and 'payload_trim' in told[2]
    assert part.code[0] and not part.code[3]
    assert np.isfinite(runs.design).all()


def test_six_degrees_of_freedom_are_not_taken_for_one():
    document = {
        'campaign': {'task': 'strobe'},
        'base': {'amplitude': 0.1, 'omega': 1.0, 'platform.law': 'geometric'},
        'vary': {'platform.coupled': [True, False]},
    }
    harvest = Harvest((), 2)
    ((rows, _),) = groups(plan.of(document).between(0, 2), harvest)
    part = harvest.part()
    assert rows.tolist() == [1]
    assert 'couples six degrees of freedom' in part.reasons[part.code[0]]
    document['base'] |= {'platform.hinge': 1.0, 'platform.coupled': False}
    del document['vary']['platform.coupled']
    document['vary']['omega'] = [0.5, 1.0]
    del document['base']['omega']
    assert not list(groups(plan.of(document).between(0, 2), harvest))
    assert any('platform.hinge' in reason for reason in harvest.part().reasons)
