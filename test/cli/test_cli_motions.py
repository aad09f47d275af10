"""`qzs-rig bifurcation`, `poincare`, `lyapunov`, `basin`: the JSON contract, files, refusals."""

from __future__ import annotations

import csv
import json
import sys

import numpy as np
import pytest

from qzs_rig.cli.main import execute

FIGURE_13 = ('bifurcation', '--dof', 'vertical', '--law', 'closed_form', '--points', '12')


@pytest.fixture
def told(capsys):
    """Runs a command; its exit code, standard output and standard error."""

    def run(*words):
        code = execute(words)
        said = capsys.readouterr()
        return code, said.out, said.err

    return run


def test_figure_13(told):
    code, out, err = told(*FIGURE_13, '--json')
    document = json.loads(out)
    assert (code, err) == (0, '')
    assert (document['parameter'], document['periods'], document['keep']) == ('zeta', 500, 400)
    (diagram,) = document['diagrams']
    assert (diagram['dof'], diagram['from']) == ('vertical', 'from rest')
    assert (diagram['values'][0], diagram['values'][-1]) == (0.0158, 0.158)
    # 6.28 rad/s over 20
    assert diagram['omega'] == pytest.approx([0.314] * 12)
    assert set(diagram['period']) == {1}
    assert all(error <= 1e-6 for error in diagram['error'])
    assert [len(points) for points in diagram['w']] == [1] * 12


def test_figure_13_with_the_frequency_taken_for_a_ratio_is_a_transient(told):
    words = (*FIGURE_13, '--omega', '6.28')
    document = json.loads(told(*words, '--json')[1])
    (diagram,) = document['diagrams']
    zeta, kind = np.array(diagram['values']), np.array(diagram['kind'])
    assert (kind[zeta < 0.05] == 'transient').all()
    assert (kind[zeta > 0.07] == 'periodic').all()
    late = [value for value in diagram['exponent'] if value is not None]
    assert len(late) == np.count_nonzero(kind == 'transient')
    assert max(late) < 0.0
    text = told(*words)[1]
    assert 'transient, not chaos, at' in text
    assert 'the largest Lyapunov exponent there is -0.01' in text


def test_sweeps_up_and_down_with_the_steps_of_the_paper(told):
    words = ('--vary', 'omega', '--range', '1:1.5', '--from', 'previous', '--steps', '1000')
    short = ('--periods', '40', '--keep', '20', '--points', '3', '--whole')
    code, out, _ = told(*FIGURE_13, *words, *short, '--json')
    up, down = json.loads(out)['diagrams']
    assert code == 0
    assert (up['from'], down['from']) == ('up', 'down')
    assert up['values'] == down['values'][::-1] == [1.0, 1.25, 1.5]
    assert set(up['steps']) == {1000}
    assert up['error'] == [None] * 3


def test_files_of_a_diagram(told, tmp_path):
    folder = tmp_path / 'one'
    code, out, _ = told(*FIGURE_13, '--out', str(folder), '--json')
    assert code == 0
    assert {p.name for p in folder.iterdir()} == {
        f'bifurcation.{kind}' for kind in ('png', 'svg', 'csv', 'npz')
    }
    assert len(json.loads(out)['files']) == 4
    with (folder / 'bifurcation.csv').open(newline='') as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 12
    arrays = np.load(folder / 'bifurcation.npz')
    assert arrays['vertical_from_rest_w'].shape == (12, 400)
    assert [float(row['w']) for row in rows] == arrays['vertical_from_rest_w'][:, -1].tolist()
    code, _, err = told(*FIGURE_13, '--out', str(folder))
    assert code == 2
    assert 'nothing is overwritten' in err


def test_figures_15_to_18(told, tmp_path):
    words = ('poincare', '--zeta', '0.07', '--periods', '120')
    code, out, _ = told(*words, '--out', str(tmp_path / 'p'), '--json')
    runs = json.loads(out)['runs']
    assert code == 0
    assert [run['dof'] for run in runs] == [
        'vertical',
        'horizontal',
        'vertical_rotation',
        'horizontal_rotation',
    ]
    for run in runs:
        assert run['period'] == 1
        assert run['transient_visible_periods'] <= run['settled'] <= 120
        assert len(run['w']) == len(run['velocity']) == 120
        # the visible transient ends where the points come within a thousandth of the last
        k = run['transient_visible_periods']
        assert np.abs(np.array(run['w'][k:]) - run['w'][-1]).max() <= 1e-3
    assert {p.suffix for p in (tmp_path / 'p').iterdir()} == {'.png', '.svg', '.csv', '.npz'}
    text = told(*words, '--dof', 'vertical')[1]
    assert 'vertical: settles into period 1' in text


def test_a_run_that_has_not_settled_says_why(told):
    words = ('--dof', 'vertical', '--zeta', '0.0158', '--omega', '6.28', '--periods', '200')
    text = told('poincare', *words)[1]
    assert 'vertical: has not settled; Lyapunov exponent -0.01' in text
    assert 'a transient, not chaos' in text


def test_lyapunov(told, tmp_path):
    words = ('lyapunov', '--zeta', '0.07', '--starts', '8', '--periods', '400', '--before', '100')
    code, out, _ = told(*words, '--out', str(tmp_path), '--json')
    document = json.loads(out)
    assert code == 0
    assert document['verdict'] == '8 of 8 runs settle'
    assert document['sum_of_exponents'] == -0.14
    # on a cycle the exponents are both -zeta, or lie to either side of it
    assert -0.0705 < document['mean'] < 0.0
    assert len(document['exponent']) == len(document['standard_error']) == 8
    assert 'sum of both, -2 zeta' in told(*words)[1]


def test_basin(told, tmp_path):
    words = ('basin', '--zeta', '0.02', '--omega', '0.305', '--grid', '12')
    code, out, _ = told(*words, '--w=-1:1', '--out', str(tmp_path), '--json')
    document = json.loads(out)
    assert code == 0
    assert np.array(document['which']).shape == (12, 12)
    # between the folds 0.2964 and 0.3177 of issue 4
    assert len(document['attractors']) > 2
    shares = [each['share'] for each in document['attractors']]
    rest = document['lost_share'] + document['unsettled_share']
    assert sum(shares) + rest == pytest.approx(1.0)
    assert 'Motions of vertical at Omega 0.305' in told(*words)[1]


def test_margin(told, tmp_path):
    law = ('--law', 'symmetric', '--zeta', '0.05', '--amplitude', '0.05')
    words = ('basin', *law, '--held', 'acceleration', '--margin', '0.7:0.8', '--points', '2')
    code, out, _ = told(*words, '--kick', '1', '--out', str(tmp_path), '--json')
    document = json.loads(out)
    assert code == 0
    assert all(kick > 0.0 for kick in document['kick'])
    assert all(rise > 1.0 for rise in document['rise'])
    assert (tmp_path / 'margin.csv').is_file()
    assert 'Smallest kick' in told(*words)[1]


def test_without_matplotlib_the_numbers_are_written(told, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    code, _, err = told(*FIGURE_13, '--out', str(tmp_path))
    assert code == 0
    assert 'caution: figures as SVG and PNG need matplotlib' in err
    assert {p.name for p in tmp_path.iterdir()} == {'bifurcation.csv', 'bifurcation.npz'}


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (('--vary', 'mass'), '--vary mass needs --range LO:HI'),
        (('--vary', 'mass', '--range', '1:2'), "unknown parameter 'mass'"),
        (('--range', '2:1'), '--range'),
        (('--range', 'wide'), "--range 'wide': write LO:HI"),
        (('--points', '1'), '--points 1: give 2 or more'),
        (('--omega', '0'), 'frequency 0; give a number above 0'),
        (('--omega', '1', '--frequency', '2'), '--omega and --frequency say the same thing twice'),
        (('--law', 'cubic'), "unknown law 'cubic'"),
        (('--keep', '501'), '501 of 500 periods kept'),
        (('--error', '0'), 'error 0; give what w may be off'),
    ],
)
def test_what_is_refused(told, words, message):
    code, out, err = told('bifurcation', '--dof', 'vertical', '--points', '3', *words)
    assert (code, out) == (2, '')
    assert message in err


def test_an_unknown_motion_is_refused(told):
    for command in ('bifurcation', 'poincare', 'lyapunov', 'basin'):
        code, _, err = told(command, '--dof', 'sideways')
        assert code == 2
        assert "unknown degree of freedom 'sideways'" in err


def test_a_run_too_short_for_its_damping_is_not_called_chaotic(told):
    """Nearly linear at Omega 1e6: the disturbance has no time to die in 2000 periods."""
    code, out, _ = told('lyapunov', '--omega', '1e6', '--starts', '2', '--json')
    assert code == 0
    assert json.loads(out)['verdict'].startswith('the runs are too short to tell')


def test_the_finest_error_gives_no_false_periods(told):
    words = ('--dof', 'vertical', '--law', 'closed_form', '--points', '3', '--error', '1e-12')
    (diagram,) = json.loads(told('bifurcation', *words, '--json')[1])['diagrams']
    assert diagram['period'] == [1, 1, 1]


def test_a_base_at_rest_has_no_transmissibility(told):
    code, out, err = told('basin', '--amplitude', '0', '--grid', '4', '--omega', '0.3', '--json')
    assert (code, err) == (0, '')
    assert {each['T'] for each in json.loads(out)['attractors']} == {None}


def test_a_margin_that_is_none_says_so(told):
    words = ('basin', '--zeta', '0.2', '--amplitude', '0.05', '--margin', '1.5:1.6')
    code, out, _ = told(*words, '--points', '2', '--json')
    document = json.loads(out)
    assert code == 0
    assert document['kick'] == [None, None]
    assert all('T differs by more than 5 %' in reason for reason in document['reason'])


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (('basin', '--margin', '0.2:0.4', '--kick', '-1'), '--kick -1: give a number above 0'),
        (('basin', '--margin', '0.2:0.4', '--rise', '1'), '--rise 1: give a number above 1'),
        (('basin', '--margin', '0.2:0.4', '--omega', '0.3'), 'leave out --omega'),
        (('lyapunov', '--seed', '-1'), '--seed -1: give 0 or more'),
        (('lyapunov', '--steps', '0'), '--steps 0: give 1 or more'),
        (('bifurcation', '--error', '1e-15'), 'error 1e-15; give what w may be off'),
        (('bifurcation', '--zeta', '0.1'), '--vary zeta and --zeta both name it'),
        (('frf', '--harmonics', '100000'), '--harmonics 100000: give 1 to 512'),
        (('frf', '--omega', '-1:2'), 'the range must rise from above 0'),
        (('frf', '--single-term', '--harmonics', '5'), '--single-term has one harmonic'),
    ],
)
def test_what_else_is_refused(told, words, message):
    code, out, err = told(*words)
    assert (code, out) == (2, '')
    assert message in err
