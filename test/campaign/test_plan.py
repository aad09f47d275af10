"""Plans: what they take, what they refuse, and that they survive being told."""

from __future__ import annotations

import json

import pytest
from campaign_plans import statics

from qzs_rig.campaign import plan
from qzs_rig.errors import InputError

ZETA = {'platform.zeta': [0.1, 0.2]}


def of(task='statics', base=None, vary=ZETA, **head):
    document = {'campaign': {'task': task, **head}, 'base': base or {}, 'vary': vary}
    return plan.of(document)


@pytest.mark.parametrize('name', plan.shipped())
def test_every_shipped_plan_loads_and_survives_being_told(name):
    loaded = plan.load(plan.find(name))
    again = plan.of(json.loads(loaded.text))
    assert (again, again.fingerprint) == (loaded, loaded.fingerprint)
    assert plan.shipped()[name]


def test_chunks_cover_all_points_once():
    parts = [statics(chunk=10).part(k) for k in range(statics(chunk=10).chunks)]
    assert parts == [*((10 * k, 10 * k + 10) for k in range(6)), (60, 62)]


def test_the_fingerprint_tells_plans_apart():
    prints = {of().fingerprint, of(seed=1).fingerprint, of(vary={'platform.zeta': [1]}).fingerprint}
    assert len(prints) == 3


def test_a_scenario_lies_under_base_and_vary():
    found = of('run', {'scenario': 'rotations', 'platform.L0': 0.05}, {'run.rate': [250, 500]})
    spec = found.between(1, 2).spec(0)
    assert (spec['platform.L0'], spec['run.rate'], spec['run.seed']) == (0.05, 500.0, 3)
    assert 'platform.L0_hat' not in spec  # the scenario's synonym is silenced


def test_words_on_top_of_a_file(tmp_path):
    path = tmp_path / 'mine.yaml'
    path.write_text('campaign: {task: statics}\nvary: {platform.zeta: [0.1]}\n')
    assert plan.load(path, {'platform.k1': 1e4}).fixed['platform.k1'] == 1e4


@pytest.mark.parametrize(
    ('document', 'words'),
    [
        ([1], 'a plan must map names to values'),
        (
            {'campain': {}},
            "unknown key 'campain' .did you mean 'campaign'..; known: campaign, base",
        ),
        (
            {'campaign': {'task': 'statics', 'sede': 1}},
            "campaign: unknown parameter 'sede' .did you mean 'seed'",
        ),
        ({'campaign': {}}, 'task is missing; give one of statics'),
        ({'campaign': {'task': 'static'}}, "'static' is unknown .did you mean 'statics'"),
        ({'campaign': {'task': 'statics'}}, 'vary is empty'),
    ],
)
def test_refused_documents(document, words):
    with pytest.raises(InputError, match=words):
        plan.of(document)


@pytest.mark.parametrize(
    ('given', 'words'),
    [
        ({'seed': -1}, 'campaign: seed = -1 is out of range'),
        ({'seed': True}, 'campaign: seed = True has the wrong type'),
        ({'chunk': 0}, 'chunk = 0 is out of range; give a int in points, >= 1'),
        ({'sample': 'sobol'}, "sample = 'sobol' is unknown; give one of grid, latin_hypercube"),
        ({'samples': 9}, 'samples is for sample: latin_hypercube'),
        ({'sample': 'latin_hypercube'}, 'samples is missing; say how many'),
        ({'place': 'corner'}, "place = 'corner' is unknown; give one of centre, random, maximin"),
        ({'method': 'leaps'}, "method = 'leaps' is unknown; give one of scipy.stats.qmc"),
        ({'vary': {'platform.zeat': [1]}}, "'platform.zeat' .did you mean 'platform.zeta'"),
        ({'vary': {'omeag': [1]}}, "unknown parameter 'omeag'.*dof"),
        ({'base': {'platform.zeta': 0.1}}, 'platform.zeta is fixed and varied'),
        ({'base': {'platform.C.vertical': 1.0}}, 'say the same thing twice'),
        ({'base': {'platform': {'zeta': 1}}}, "unknown parameter 'platform'"),
        ({'task': 'single_term'}, 'needs amplitude or displacement; put it under base or vary'),
        ({'vary': {'run.rate': {'from': 1, 'to': 2, 'count': 10_000_000}, 'platform.zeta':
          {'from': 1, 'to': 2, 'count': 1000}}}, 'the grid has 1e.10 points'),
    ],
)  # fmt: skip
def test_refused_plans(given, words):
    with pytest.raises(InputError, match=words):
        of(**given)


def test_unknown_options_are_refused():
    document = {'campaign': {'task': 'statics'}, 'vary': ZETA, 'options': {'tolerence': 1}}
    with pytest.raises(InputError, match=r"options of statics: .*did you mean 'tolerance'"):
        plan.of(document)


def test_a_file_that_is_no_plan(tmp_path):
    path = tmp_path / 'mine.yaml'
    path.write_text('campaign: {task: statics}\ncampaign: {}\n')
    with pytest.raises(InputError, match=r"plan .*mine.yaml, line 2: 'campaign' is given twice"):
        plan.load(path)


def test_unknown_names_list_the_known():
    with pytest.raises(InputError, match=r"unknown plan 'nope'; known: .*peak_map"):
        plan.find('nope')
    with pytest.raises(InputError, match=r'nope.yaml is not there; known by name'):
        plan.find('nope.yaml')
