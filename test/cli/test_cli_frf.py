"""`qzs-rig frf`: the JSON contract, files, refusals."""

from __future__ import annotations

import csv
import json
import sys

import numpy as np
import pytest

from qzs_rig.cli.main import execute

CONTRACT = {'omega', 'T', 'amplitude', 'phase_deg', 'stable'}
QUICK = ('--omega', '0.5:2', '--no-isolas')


@pytest.fixture
def told(capsys):
    """Runs `frf`; its exit code, standard output and standard error."""

    def run(*words):
        code = execute(('frf', *words))
        said = capsys.readouterr()
        return code, said.out, said.err

    return run


def test_json_contract(told):
    words = ('--law', 'taylor', '--zeta', '0.07', '--amplitude', '0.6', '--omega', '0.1:0.6')
    code, out, _ = told(*words, '--json')
    document = json.loads(out)
    assert code == 0
    for branch in document['branches']:
        assert set(branch) >= CONTRACT
        assert len({len(branch[name]) for name in CONTRACT}) == 1
        assert set(map(type, branch['stable'])) == {bool}
        omega = np.array(branch['omega'])
        assert omega.min() >= 0.1
        assert omega.max() <= 0.6
    folds = sorted(fold['omega'] for fold in document['folds'])
    assert folds == pytest.approx([0.2071890982, 0.4724070372], abs=1e-8)
    assert {fold['kind'] for fold in document['folds']} == {'fold'}
    assert isinstance(document['onset_omega'], list)
    assert (document['zeta'], document['amplitude'], document['dof']) == (0.07, 0.6, 'vertical')


def test_single_term_has_the_check_values_of_the_model(told):
    words = ('--law', 'symmetric', '--zeta', '0.07', '--amplitude', str(1 / 12), '--single-term')
    _, out, _ = told(*words, '--omega', '0.2:0.5', '--json')
    branches = json.loads(out)['branches']
    ends = sorted((b['T'][-1], b['stable'][-1]) for b in branches if b['omega'][-1] == 0.5)
    # MODEL section 5 prints six decimals
    assert [T for T, _ in ends] == pytest.approx([0.314178, 2.739556, 3.830048], abs=1e-6)
    assert [stable for _, stable in ends] == [True, False, True]
    starts = [b['T'][0] for b in branches if b['omega'][0] == 0.2]
    assert starts == pytest.approx([1.840268], abs=1e-6)
    (fold,) = json.loads(out)['folds']
    assert 0.2 < fold['omega'] < 0.5


def test_the_platform_is_where_everything_comes_from(told):
    _, out, _ = told(*QUICK, '--set', 'platform.A=1.5', '--set', 'platform.zeta=0.2', '--json')
    document = json.loads(out)
    assert document['design']['A'] == 1.5
    assert document['zeta'] == pytest.approx(0.2)
    assert document['law'] == 'corrected'
    # Table 1: H = 0.1 m, L20 = 0.6 m
    assert document['amplitude'] == pytest.approx(1 / 6)
    _, out, _ = told(*QUICK, '--dof', 'vertical_rotation', '--json')
    assert json.loads(out)['amplitude'] == pytest.approx(np.radians(5.0))


def test_held_acceleration(told):
    _, out, _ = told('--law', 'linear', '--held', 'acceleration', *QUICK, '--json')
    assert json.loads(out)['falloff'] == 2


def test_people_get_tables(told):
    code, out, _ = told('--law', 'taylor', '--zeta', '0.07', '--amplitude', '0.6')
    assert code == 0
    assert '0.4724070372' in out
    assert 'harmonics, at most' in out
    assert 'closed' in out


def test_a_resonance_without_end_is_said(told):
    *_, err = told('--law', 'taylor', '--zeta', '0.02', '--amplitude', '0.6', *QUICK)
    assert 'has not come down' in err


def test_too_few_harmonics_are_said(told):
    words = ('--zeta', '0.02', '--amplitude', '0.6', '--omega', '1.2:2', '--no-isolas')
    *_, err = told(*words, '--harmonics', '7')
    assert 'artefact of too few harmonics' in err


def test_backbone_and_jump_map(told, tmp_path):
    words = ('--law', 'taylor', '--zeta', '0.1', '--amplitude', '0.05', '--omega', '0.2:1')
    _, out, _ = told(
        *(*words, '--backbone', '--jump-map', 'zeta', '--out', str(tmp_path / 'new'), '--json')
    )
    document = json.loads(out)
    assert document['backbone'][0]['omega']
    assert document['phase_resonance'][0]['drive_hat']
    assert document['jump_map']['parameter'] == 'zeta'
    assert all(len(c['value']) == len(c['omega']) for c in document['jump_map']['curves'])
    names = {path.name for path in (tmp_path / 'new').iterdir()}
    assert names >= {'response.html', 'response.csv', 'response.svg', 'response.png'}
    assert 'backbone.svg' in names


def test_motions_over_another_parameter(told, tmp_path):
    words = ('--law', 'taylor', '--zeta', '0.1', '--amplitude', '0.05', '--omega', '0.2:1')
    _, out, _ = told(
        *words, '--vary', 'zeta=0.05:0.3', '--at', '0.5', '--out', str(tmp_path / 'new'), '--json'
    )
    document = json.loads(out)
    varied = document['variation']
    assert (varied['parameter'], varied['omega']) == ('zeta', 0.5)
    value, T = (varied['branches'][0][name] for name in ('value', 'T'))
    assert sorted({value[0], value[-1]}) == [0.05, 0.3]
    # both cross at the values of the other: lines between points of either
    at = np.interp(0.1, *zip(*sorted(zip(value, T, strict=True)), strict=True))
    branch = document['branches'][0]
    beside = np.interp(
        0.5, *zip(*sorted(zip(branch['omega'], branch['T'], strict=True)), strict=True)
    )
    assert at == pytest.approx(beside, rel=1e-2)
    assert 'variation.svg' in {path.name for path in (tmp_path / 'new').iterdir()}


def test_files(told, tmp_path):
    code, out, _ = told('--zeta', '0.1', *QUICK, '--out', str(tmp_path), '--json')
    document = json.loads(out)
    assert code == 0
    with (tmp_path / 'response.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(branch['omega']) for branch in document['branches'])
    assert [float(row['T']) for row in rows if row['branch'] == '0'] == document['branches'][0]['T']
    page = (tmp_path / 'response.html').read_text()
    assert 'Frequency response: law corrected, vertical' in page
    assert '"name":"LogScale"' in page
    code, _, err = told('--zeta', '0.1', *QUICK, '--out', str(tmp_path))
    assert code == 2
    assert 'nothing is overwritten' in err


def test_without_matplotlib_the_page_stays(told, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    monkeypatch.setitem(sys.modules, 'matplotlib.figure', None)
    code, _, err = told('--zeta', '0.1', *QUICK, '--out', str(tmp_path))
    assert code == 0
    assert 'need matplotlib' in err
    assert {path.name for path in tmp_path.iterdir()} == {'response.html', 'response.csv'}


def test_the_coupled_platform(told):
    words = ('--law', 'geometric', '--zeta', '0.1', '--amplitude', '0.02', '--omega', '2:2.4')
    _, out, _ = told(*words, '--dof', 'horizontal', '--json')
    six = json.loads(out)
    assert six['degrees_of_freedom'] == 6
    _, out, _ = told(*words, '--dof', 'vertical', '--set', 'platform.coupled=false', '--json')
    assert json.loads(out)['degrees_of_freedom'] == 1


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (('--law', 'cubic'), "unknown law 'cubic'; known: corrected"),
        (('--dof', 'z'), "unknown degree of freedom 'z'; known: vertical"),
        (('--omega', '1'), 'write LO:HI'),
        (('--omega', '2:1'), 'the first must be below the second'),
        (('--amplitude', '0'), 'needs a base that moves'),
        (('--zeta', '-1'), 'platform.zeta'),
        (('--harmonics', '0'), '--harmonics 0: give 1 to 512'),
        (('--single-term', '--set', 'platform.payload_trim=1'), 'knows no load'),
        (('--jump-map', 'zeta', '--zeta', '0', '--single-term'), 'give a value above 0'),
        (('--single-term', '--vary', 'zeta=0.1:0.2'), 'give one frequency above 0 with --at'),
        (('--single-term', '--vary', 'mass=1:2', '--at', '1'), "unknown parameter 'mass'"),
        (('--single-term', '--vary', 'zeta=1', '--at', '1'), "--vary zeta '1': write LO:HI"),
    ],
)
def test_refusals(told, words, message):
    code, out, err = told(*words)
    assert (code, out) == (2, '')
    assert message in err
