"""`qzs-rig design` and `qzs-rig claims`: documents, files, refusals."""

from __future__ import annotations

import json

import pytest

from qzs_rig import scenario
from qzs_rig.cli.main import execute

WISH = ('design', '--mass', '50', '--onset', '2', '--stroke', '0.1', '--level', '1')


@pytest.fixture
def told(capsys):
    """Runs a command; its exit code, standard output and standard error."""

    def run(*words):
        code = execute(words)
        said = capsys.readouterr()
        return code, said.out, said.err

    return run


def test_proposal_as_text_and_document(told):
    code, out, err = told(*WISH)
    assert (code, err) == (0, '')
    assert '(16), no vertical stiffness' in out and 'no warnings' in out
    document = json.loads(told(*WISH, '--json')[1])
    assert document['static']['carries_kg'] == pytest.approx(50.0, rel=1e-12)
    assert document['margins']['onset'] > 0.0 and document['warnings'] == {}
    assert set(document['proposal']) == set(document['why'])


def test_scenario_is_written_once(told, tmp_path):
    path = tmp_path / 'advice.yaml'
    assert told(*WISH, '--yaml', str(path))[0] == 0
    assert scenario.load(str(path)).number('platform.m') == 50.0
    code, out, err = told(*WISH, '--yaml', str(path))
    assert (code, out) == (2, '') and 'nothing is overwritten' in err


def test_check_warns_of_table_1(told):
    code, out, _ = told('design', '--check', '--json')
    assert code == 0
    assert {'tipping', 'load'} <= set(json.loads(out)['warnings'])
    still = json.loads(told('design', '--check', 'rotations', '--json')[1])
    assert still['dynamic'] is None and 'tipping' not in still['warnings']


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (('design', '--mass', '50'), 'needs --onset and --stroke and --level'),
        ((*WISH, '--set', 'platform.A=1'), '--set changes an existing design; add --check'),
        ((*WISH, '--check'), 'leave out --mass'),
        (('design', '--check', '--stroke', '-1'), '--stroke -1 must be'),
        (('design', '--check', 'nowhere'), 'unknown scenario'),
        ((*WISH, '--zeta', '0'), '--zeta 0 must be a number above 0'),
    ],
)
def test_refusals(told, words, message):
    code, out, err = told(*words)
    assert (code, out) == (2, '')
    assert message in err and err.count('\n') == 1


def test_claims(told):
    code, out, err = told('claims', 'C5', 'C6', '--json')
    items = json.loads(out)
    assert (code, err) == (0, '')
    assert [item['id'] for item in items] == ['C5', 'C6']
    assert {'id', 'verdict', 'figures', 'how'} <= set(items[0])
    assert 'C6  not reproduced' in told('claims', 'C6')[1]
    code, _, err = told('claims', 'C99')
    assert code == 2
    assert "claim 'C99' is unknown; known: C1, C2" in err
