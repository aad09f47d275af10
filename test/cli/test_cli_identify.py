"""`qzs-rig identify`: the JSON contract, files, refusals."""

from __future__ import annotations

import json

import numpy as np
import pytest

from qzs_rig import scenario
from qzs_rig.cli.main import execute
from qzs_rig.identification.point_response import followed, motion_of
from qzs_rig.theory.oscillator import Oscillator

TRUE = {'platform.zeta': 0.08, 'platform.A': 1.09}
FIT = ','.join(TRUE)
MEASURED = ('--scenario', 'vertical_sweep', '--fit', FIT)


@pytest.fixture
def said(capsys):
    """Runs a command; its exit code, standard output and standard error."""

    def run(*words):
        code = execute(words)
        told = capsys.readouterr()
        return code, told.out, told.err

    return run


@pytest.fixture(scope='module')
def curve(tmp_path_factory):
    """The upper part of a calculated curve as CSV, without noise."""
    there = Oscillator.driven(scenario.load('vertical_sweep').override(TRUE), 'vertical')
    hz = np.geomspace(4.0, 1.5, 12)
    far = np.full(12, 0.05 - 0.02j)
    steady = followed(there, hz, motion_of(there, there.omega(hz), far, 7))
    assert steady.good.all()
    path = tmp_path_factory.mktemp('csv') / 'curve.csv'
    rows = zip(hz, np.abs(steady.ratio), np.degrees(np.angle(steady.ratio)), strict=True)
    lines = [
        f'vertical,reverse,{f!r},{T!r},{phase!r}' for f, T, phase in np.array([*rows]).tolist()
    ]
    path.write_text('\n'.join(['dof,direction,frequency_hz,transmissibility,phase_deg', *lines]))
    return path


def test_json_contract_and_files(said, curve, tmp_path):
    out = tmp_path / 'fit'
    code, told, err = said('identify', str(curve), *MEASURED, '--out', str(out), '--json')
    document = json.loads(told)
    assert code == 0 and err == ''
    for item in document['parameters']:
        assert item['estimate'] == pytest.approx(TRUE[item['name']], rel=1e-4)
        assert item['low'] < item['estimate'] < item['high'] and item['determined']
    assert document['advice'] is None
    assert document['points'][0]['branch'] == ['lower'] * 12
    assert {path.name for path in out.iterdir()} == {
        'fitted.yaml',
        'identification.json',
        'fit.svg',
        'fit.png',
    }
    fitted = scenario.load(str(out / 'fitted.yaml'))
    assert fitted.number('platform.zeta') == document['parameters'][0]['estimate']
    code, _, err = said('identify', str(curve), *MEASURED, '--out', str(out))
    assert code == 2 and 'occupied' in err


def test_the_table_names_everything(said, curve):
    code, told, _ = said('identify', str(curve), *MEASURED[:2], '--fit', 'platform.payload_trim',
                         '--set', 'platform.zeta=0.08', '--set', 'platform.A=1.09')  # fmt: skip
    assert code == 0
    assert 'platform.payload_trim' in told and '95 %' in told
    assert 'payload: leave the payload' in told


@pytest.mark.parametrize(
    ('words', 'wanted'),
    [
        ((), 'nothing to identify'),
        (('nowhere.csv',), 'cannot be read as CSV'),
        (('nowhere',), 'nowhere'),
        (('runs/A', '--scenario', 'vertical_sweep'), '--scenario is for a CSV'),
        (('x.csv', '--paper'), '--paper takes no measurement'),
    ],
)
def test_refusals(said, words, wanted):
    code, _, err = said('identify', *words)
    assert code == 2 and wanted in err


def test_a_csv_needs_its_excitation(said, curve):
    code, _, err = said('identify', str(curve))
    assert code == 2 and 'excitation.amplitude.vertical is 0' in err
    code, _, err = said('identify', str(curve), *MEASURED, '--dof', 'horizontal')
    assert code == 2 and "no measured points of 'horizontal'" in err


def test_the_papers_frequencies(said):
    code, told, _ = said('identify', '--paper', '--fit', 'platform.k1,platform.zeta', '--json')
    document = json.loads(told)
    assert code == 0
    assert len(document['jumps']) == 4 and len(document['combinations']) == 2
    code, told, _ = said('identify', '--paper', '--fit', 'platform.k1')
    assert code == 0 and 'they fix' in told
