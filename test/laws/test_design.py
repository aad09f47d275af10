"""Proposed platforms: (16), (19), load, a simulated sweep, warnings and refusals."""

from __future__ import annotations

import math
import re
import time
from dataclasses import replace
from functools import lru_cache

import pytest

from qzs_rig import scenario
from qzs_rig.design.check import WARNINGS, Case, warnings
from qzs_rig.design.proposal import REACH, Wish, propose, trial, trial_text
from qzs_rig.errors import InputError
from qzs_rig.mechanics.platform import Platform
from qzs_rig.parameters import read_yaml
from qzs_rig.run import in_process
from qzs_rig.units import GRAVITY

PLAIN = Wish(mass=50.0, onset=2.0, stroke=0.1, level=1.0)
WISHES = {
    'plain': PLAIN,
    'damped': replace(PLAIN, zeta=0.2, onset=1.0),
    'small': Wish(mass=10.0, onset=3.0, stroke=0.02, level=1.0),
    'hard': replace(PLAIN, level=4.0),
    'displacement': Wish(50.0, 1.0, 0.06, 0.02, 'displacement', 0.03),
}
proposed = lru_cache(propose)
every_wish = pytest.mark.parametrize('wish', WISHES.values(), ids=WISHES)


@every_wish
def test_proposal_is_quasi_zero_stands_and_carries(wish):
    p = proposed(wish)
    A, k3, a, L0 = p.k2 / p.k1, p.k3 / p.k1, math.sqrt(1.0 - (p.L1 / p.L20) ** 2), p.L0 / p.L20
    assert 1.0 + A - A / a + k3 == pytest.approx(0.0, abs=1e-12)
    assert k3 > A * L0
    assert p.k3 * p.L1 == pytest.approx(wish.mass * GRAVITY, rel=1e-12)
    assert wish.stroke <= REACH * p.L20 * (1.0 + 1e-12)
    said = warnings(Case.proposed(p))
    assert set(said) <= {'spring stress'}


@every_wish
def test_response_keeps_the_wish(wish):
    response = proposed(wish).motion.response()
    assert response.onset <= wish.onset * (1.0 + 1e-9)
    assert response.relative <= wish.stroke * (1.0 + 1e-9)


@pytest.mark.parametrize('name', ['plain', 'damped', 'displacement'])
def test_simulated_onset_is_the_promised_one(name):
    p = proposed(WISHES[name])
    promised = p.motion.response().onset
    measured = [
        e.frequency_hz for e in in_process.run(trial(p)).estimate.events if e.kind == 'onset'
    ]
    assert len(measured) == 2
    # cubic against exact law within REACH, and the even term: a tenth
    assert max(measured) == pytest.approx(promised, rel=0.1)


def test_a_lower_onset_takes_longer_springs():
    # a stroke so tight that the onset rules the length
    wishes = [Wish(50.0, f, 0.032 * (2.0 / f) ** 2, 4.0) for f in (1.0, 1.5, 2.0)]
    lengths = [proposed(w).L20 for w in wishes]
    assert lengths[0] > lengths[1] > lengths[2]


def test_a_heavier_payload_scales_the_springs_only():
    light, heavy = proposed(PLAIN), propose(replace(PLAIN, mass=100.0))
    assert [heavy.k1, heavy.k2, heavy.k3] == pytest.approx(
        [2.0 * light.k1, 2.0 * light.k2, 2.0 * light.k3], rel=1e-14
    )
    assert heavy.L20 == light.L20


def test_a_stronger_level_takes_stiffer_springs():
    assert propose(replace(PLAIN, level=2.0)).k1 > proposed(PLAIN).k1


def test_same_wish_same_bits_within_two_seconds():
    began = time.process_time()
    first = propose(PLAIN)
    Case.proposed(first).response  # noqa: B018
    assert time.process_time() - began < 2.0
    assert proposed(PLAIN) == first


def test_scenario_file_holds_the_proposal(tmp_path):
    p = proposed(PLAIN)
    path = tmp_path / 'proposal.yaml'
    path.write_text(trial_text(p), encoding='utf-8')
    spec = scenario.of(read_yaml(path))
    assert dict(spec) == dict(trial(p))
    platform = Platform.from_spec(spec)
    assert platform.design == pytest.approx(p.design, rel=1e-14)
    assert platform.zeta[0] == pytest.approx(PLAIN.zeta, rel=1e-14)


def case(scenario_name='vertical_sweep', stroke=None, **given):
    words = [f'{name.replace("__", ".")}={value}' for name, value in given.items()]
    return Case.of_spec(scenario.load(scenario_name, words), stroke)


TRIGGERS = {
    'negative stiffness': ({'platform__A': 1.2}, 'snaps aside; .* not 1.2'),
    'not quasi-zero': ({'platform__A': 0.9}, 'not quasi-zero'),
    'tipping': ({}, 'L0 up to 0.05455 m stands'),
    'load': ({'platform__m': 150.0}, 'insufficient load capacity: .* carry 106.0 kg'),
    'critical amplitude': (
        {'excitation__quantity': 'displacement', 'excitation__amplitude__vertical': 0.02},
        'critical amplitude 0.01498',
    ),
    'spring stress': ({'platform__k1': 2e6, 'platform__A': 1.1}, 'no standard wire'),
    'stroke': ({'stroke': 0.6}, 'beyond the geometry'),
}


def test_every_warning_has_its_trigger():
    assert set(TRIGGERS) == set(WARNINGS)


@pytest.mark.parametrize('name', TRIGGERS)
def test_warning(name):
    given, words = TRIGGERS[name]
    said = warnings(case(**given))
    assert name in said
    assert re.search(words, said[name])


def test_swing_beyond_stroke_and_reach():
    assert 'beyond the stroke of 0.1 m' in warnings(case(stroke=0.1))['stroke']
    assert 'no longer cubic' in warnings(case())['stroke']
    assert 'payload too light' in warnings(case())['load']


REFUSALS = {
    'mass': (lambda: replace(PLAIN, mass=0.0), '--mass 0 must be a number above 0'),
    'nan': (lambda: replace(PLAIN, onset=math.nan), '--onset nan'),
    'zeta': (lambda: replace(PLAIN, zeta=1.5), '--zeta 1.5 is beyond critical damping'),
    'held': (lambda: replace(PLAIN, held='jerk'), "held is 'jerk'; known: displacement"),
    'still': (
        lambda: Wish(50.0, 2.0, 0.01, 0.02, 'displacement'),
        'no more than --displacement 0.02 m',
    ),
    'stroke': (
        lambda: propose(Wish(50.0, 2.0, 0.005, 4.0)),
        'is too short: .* swings .* allow more --stroke',
    ),
    'room': (lambda: propose(replace(PLAIN, stroke=1.5)), 'springs 7.5 m long, beyond 5 m'),
    'small': (
        lambda: propose(Wish(50.0, 0.05, 0.02, 1e-5)),
        '--onset 0.05 Hz is too low for so small a platform',
    ),
}


@pytest.mark.parametrize('name', REFUSALS)
def test_refusal(name):
    wish, words = REFUSALS[name]
    with pytest.raises(InputError, match=words):
        wish()


@pytest.mark.parametrize('name', ['k2', 'k3'])
def test_a_spring_of_no_rate_is_not_ordered(name):
    ordered = {order.spring for order in case(**{f'platform__{name}': 0.0}).orders}
    assert ordered == {'central', 'suspension', 'leaf'} - {{'k2': 'suspension', 'k3': 'leaf'}[name]}
