"""The run sheet survives its JSON, and what is none is refused."""

from __future__ import annotations

import json

import pytest

from qzs_rig import scenario
from qzs_rig.errors import InputError
from qzs_rig.run.sheet import RunSheet, SheetState, from_document
from qzs_rig.scenario import complete

SHEET = RunSheet(
    step_ns=2_000_000,
    samples=60_001,
    mode='lockstep',
    chunk=40,
    spec=dict(scenario.load('rotations')),
    run_id='abc',
    scenario='rotations',
    peers=('platform', 'analyzer'),
    start_ns=1_700_000_000_000_000_001,
    pace=1.5,
)


@pytest.mark.parametrize('state', list(SheetState))
def test_a_sheet_survives_its_json(state):
    sheet = SHEET.replace(state=state, reason='why')
    assert from_document(json.loads(json.dumps(sheet.to_document()))) == sheet


def test_a_change_leaves_the_rest():
    changed = SHEET.replace(state='aborted', reason='stop')
    assert (SHEET.state, changed.state, changed.run_id) == ('waiting', 'aborted', 'abc')


@pytest.mark.parametrize('words', [{}, {'platform.A': 1.2, 'platform.zeta': 0.05}])
def test_a_spec_comes_back_from_its_sheet(words):
    spec = scenario.load('rotations').override(words)
    document = json.loads(json.dumps(SHEET.replace(spec=dict(spec)).to_document()))
    assert dict(complete(from_document(document).spec)) == dict(spec)


@pytest.mark.parametrize('schema', [None, 'qzs_rig/sheet/2', 'qzs_rig/estimate/1', 1])
def test_another_schema_is_refused(schema):
    with pytest.raises(InputError, match=r"rig/run holds schema .*, expected 'qzs_rig/sheet/1'"):
        from_document(SHEET.to_document() | {'schema': schema})
    document = SHEET.to_document()
    del document['schema']
    with pytest.raises(InputError, match='holds schema None'):
        from_document(document)


@pytest.mark.parametrize(
    'damage',
    [{'peers': None}, {'peers': 3}, {'surplus': 1}, {'state': 'asleep'}],
    ids=lambda d: next(iter(d)),
)
def test_a_damaged_sheet_is_refused(damage):
    with pytest.raises(InputError, match='rig/run holds a damaged run sheet'):
        from_document(SHEET.to_document() | damage)


@pytest.mark.parametrize('field', ['step_ns', 'samples', 'mode', 'chunk', 'peers'])
def test_a_sheet_that_lacks_a_field_is_refused(field):
    document = SHEET.to_document()
    del document[field]
    with pytest.raises(InputError, match='rig/run holds a damaged run sheet'):
        from_document(document)
