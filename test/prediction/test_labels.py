"""Points whose branch and distance are known, and the documents that carry them."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from qzs_rig.errors import InputError
from qzs_rig.estimation.estimate import Curve, Estimate
from qzs_rig.mechanics.restoring.law import Design
from qzs_rig.mechanics.restoring.polynomials import SYMMETRIC
from qzs_rig.prediction import curve, labels
from qzs_rig.prediction.predict import by_single_term
from qzs_rig.run import runfolder
from qzs_rig.theory.oscillator import Oscillator

DESIGN = Design.of(A=1.25, k3=0.4, L1=math.sqrt(3.0) / 2.0, L0=0.1)
"""Hardening: c1 = 0.15, c3 = 4.2."""
OWN = Oscillator(SYMMETRIC, 'vertical', DESIGN, zeta=0.05, amplitude=0.04, omega0=20.0, length=0.6)
THEORY = by_single_term(OWN, 0.5, 9.0)
UP, DOWN = (fold.frequency_hz for fold in THEORY.folds)
INSIDE = np.linspace(UP * 1.05, DOWN * 0.95, 50)


def on(name, f):
    (branch,) = (branch for branch in THEORY.branches if branch.name == name)
    return np.interp(f, branch.frequency_hz, branch.transmissibility)


def measured(f, T, relative=0.01):
    nothing = np.full(len(f), math.nan)
    return Curve('vertical', 'forward', 'sine', 'fundamental', f, T, 0 * f, nothing, relative * T)


@pytest.mark.parametrize('name', ['lower', 'upper'])
@pytest.mark.parametrize('sigmas', [-3.0, 0.0, 1.5])
def test_a_point_on_a_branch_has_its_name_and_distance(name, sigmas):
    T = on(name, INSIDE)
    shifted = replace(measured(INSIDE, T), magnitude=T * (1 + 0.01 * sigmas))
    found = labels.label(shifted, THEORY)
    assert set(found.branch) == {name}
    # linear here, logarithmic there, between points 1 % apart: 1e-4 of T is 0.01 σ
    np.testing.assert_allclose(found.z, sigmas, atol=0.05)
    within = 50 if abs(sigmas) <= 2 else 0
    assert found.counts == {name: (within, 50)}
    assert found.sentence == f'{within} of 50 points within 2σ of the {name} branch'


def test_no_stable_branch_no_label():
    f = np.array([0.1, 2.0, 20.0])
    found = labels.label(measured(f, np.ones(3)), THEORY)
    assert (found.branch[0], found.branch[2]) == ('none', 'none')
    assert np.isnan(found.z[[0, 2]]).all() and np.isfinite(found.z[1])
    assert found.sentence.endswith(', 2 on no branch')


def test_a_point_in_a_jump_is_on_no_branch():
    lower = on('lower', INSIDE)
    above = [labels.label(measured(INSIDE[:5], k * lower[:5]), THEORY) for k in (1.9, 0.45)]
    assert [set(found.branch) for found in above] == [{'lower'}, {'none'}]
    assert np.isnan(above[1].z).all() and np.isnan(above[1].transmissibility).all()


def test_the_unstable_branch_attracts_nothing():
    assert 'middle' not in labels.label(measured(INSIDE, on('middle', INSIDE)), THEORY).branch


def test_points_that_are_no_numbers_or_have_no_uncertainty():
    f = INSIDE[:4]
    T = on('lower', f)
    broken = measured(f, np.where(np.arange(4) < 2, math.nan, T))
    assert labels.label(broken, THEORY).branch == ('none', 'none', 'lower', 'lower')
    bare = labels.label(measured(f, T, math.nan), THEORY)
    assert np.isnan(bare.z).all()
    assert bare.sentence == '4 points on the lower branch'
    nothing = measured(np.empty(0), np.empty(0))
    assert labels.label(nothing, THEORY).sentence == ''


def test_a_phase_across_180_degrees_is_interpolated_the_short_way():
    (upper,) = (branch for branch in THEORY.branches if branch.name == 'upper')
    wrapping = replace(upper, phase_deg=np.where(np.arange(len(upper.stable)) % 2, 179.0, -179.0))
    f = upper.frequency_hz[100:110] * 1.0001
    found = labels.label(
        measured(f, upper.transmissibility[100:110]), replace(THEORY, branches=(wrapping,))
    )
    assert (np.abs(found.phase_deg) >= 179.0).all()
    assert (found.phase_deg > -180.0).all() and (found.phase_deg <= 180.0).all()


def test_documents_survive_the_round_trip(tmp_path):
    told = json.loads(json.dumps(curve.to_document('id', [THEORY]), allow_nan=False))
    assert (told['schema'], told['run_id']) == ('qzs_rig/theory/1', 'id')
    assert told['predictions'][0]['stroke_unit'] == 'm'
    (again,) = curve.from_document(told)
    assert again.folds == THEORY.folds and again.onset_hz == THEORY.onset_hz
    for mine, theirs in zip(THEORY.branches, again.branches, strict=True):
        for name, value in vars(mine).items():
            assert np.array_equal(value, getattr(theirs, name)), name


def test_a_fold_that_leads_nowhere_known_survives_too():
    lost = replace(THEORY.folds[0], lands='', stroke=(1.0, math.nan))
    (again,) = curve.from_document(
        json.loads(json.dumps(curve.to_document('', [replace(THEORY, folds=(lost,))])))
    )
    assert math.isnan(again.folds[0].stroke[1]) and again.folds[0].lands == ''


@pytest.mark.parametrize(
    ('told', 'message'),
    [
        ([], "not a theory: schema is 'list'"),
        ({'schema': 'other'}, "schema is 'other', expected 'qzs_rig/theory/1'"),
        ({'schema': curve.SCHEMA}, 'damaged theory: KeyError'),
        ({'schema': curve.SCHEMA, 'predictions': [{'dof': 'x'}]}, 'damaged theory'),
        ({'schema': curve.SCHEMA, 'predictions': 3}, 'damaged theory'),
    ],
)
def test_refuses_what_is_no_theory(told, message):
    with pytest.raises(InputError, match=message):
        curve.from_document(told)


def test_a_run_keeps_its_theory_and_where_its_points_lie(tmp_path):
    curve = measured(INSIDE, on('lower', INSIDE))
    estimate = Estimate((curve, replace(curve, dof='horizontal')))
    runfolder.keep_theory(tmp_path, 'id', [THEORY], estimate)
    (again,) = runfolder.theory_in(tmp_path)
    assert again.folds == THEORY.folds
    match = json.loads((tmp_path / 'match.json').read_text())
    assert (match['schema'], match['run_id']) == ('qzs_rig/match/1', 'id')
    (row,) = match['curves']  # nothing is predicted of the horizontal
    assert row['branch'] == ['lower'] * 50 and len(row['z']) == len(row['phase_deg']) == 50
    assert row['summary'] == '50 of 50 points within 2σ of the lower branch'
    assert runfolder.theory_in(tmp_path / 'elsewhere') is None
