"""Theory of the scenario that a run performs: where figures come from, what is refused or said."""

from __future__ import annotations

import json

import pytest

from qzs_rig import scenario
from qzs_rig.cli.main import execute
from qzs_rig.mechanics.platform import Platform
from qzs_rig.prediction.predict import predict, range_hz

DWELL = ('--set', 'excitation.kind=sine', '--set', 'excitation.frequency=2.2')


@pytest.fixture
def told(capsys):
    """Runs a command; its exit code, document (None where there is none) and standard error."""

    def run(*words):
        code = execute((*words, '--json'))
        said = capsys.readouterr()
        return code, json.loads(said.out) if said.out else None, said.err

    return run


def test_the_response_is_the_one_that_the_run_predicts(told):
    code, document, err = told('frf', 'vertical_sweep', '--no-isolas')
    assert (code, err) == (0, '')
    spec = scenario.load('vertical_sweep')
    (prediction,) = predict(spec)
    hertz = Platform.from_spec(spec).omega0[0] / (2.0 * 3.141592653589793)
    folds = sorted(fold['omega'] * hertz for fold in document['folds'])
    assert folds == pytest.approx([fold.frequency_hz for fold in prediction.folds], rel=1e-12)
    low, high = range_hz(spec)
    ends = [b['omega'][k] * hertz for b in document['branches'] for k in (0, -1)]
    assert (min(ends), max(ends)) == pytest.approx((low, high), rel=1e-9)
    # 4 m/s² over omega0² L20
    assert document['amplitude'] == pytest.approx(4.0 / 400.0 / 0.6, rel=1e-14)


def test_set_alone_speaks_of_the_excitation_too(told):
    words = ('--set', 'excitation.amplitude.horizontal=0.5', '--no-isolas')
    document = told('frf', *words)[1]
    assert document['dof'] == 'horizontal'
    assert document['amplitude'] == pytest.approx(0.5 / 400.0 / 0.6, rel=1e-14)


def test_options_override_the_scenario(told):
    words = ('--law', 'symmetric', '--zeta', '0.1', '--amplitude', '0.02', '--omega', '0.5:1')
    document = told('frf', 'vertical_sweep', *words)[1]
    assert (document['law'], document['amplitude']) == ('symmetric', 0.02)
    assert document['zeta'] == pytest.approx(0.1, rel=1e-15)
    assert min(b['omega'][0] for b in document['branches']) >= 0.5
    held = told('frf', 'vertical_sweep', '--held', 'displacement', '--omega', '0.5:1')[1]
    assert held['amplitude'] == pytest.approx(4.0 / 400.0 / 0.6, rel=1e-14)


def test_a_coupled_scenario_is_solved_in_six_degrees_of_freedom(told):
    code, document, err = told('frf', 'coupled_sweep', '--omega', '0.9:1.1')
    assert (code, err) == (0, '')
    assert (document['degrees_of_freedom'], document['dof']) == (6, 'horizontal')


@pytest.mark.parametrize('command', ['bifurcation', 'poincare', 'lyapunov', 'basin'])
def test_runs_of_one_degree_of_freedom_refuse_what_only_six_have(told, command):
    code, _, err = told(command, 'coupled_sweep', '--omega', '0.8')
    assert code == 2
    assert 'platform.cm_height = 0.05 has no meaning for single degrees of freedom' in err


def test_one_term_and_a_varied_word_refuse_it_too(told):
    code, _, err = told('frf', 'coupled_sweep', '--single-term')
    assert code == 2
    assert 'platform.cm_height = 0.05 has no meaning for single degrees of freedom' in err
    words = ('--law', 'geometric', '--dof', 'horizontal', '--vary', 'platform.hinge')
    code, _, err = told('bifurcation', *words, '--range', '1:2')
    assert code == 2
    assert 'platform.hinge has no meaning for single degrees of freedom' in err


def test_a_projection_is_called_one(told):
    words = ('vertical_sweep', '--law', 'geometric', '--omega', '0.8', '--periods', '40')
    code, document, err = told('poincare', *words)
    assert code == 0
    assert [run['dof'] for run in document['runs']] == ['vertical']
    assert 'caution: law geometric couples six degrees of freedom' in err


def test_a_sweep_has_no_single_frequency(told):
    code, _, err = told('lyapunov', 'vertical_sweep')
    assert code == 2
    assert 'a sweep has many frequencies; give one by --omega' in err


@pytest.mark.parametrize(
    ('command', 'words'),
    [
        ('poincare', ('--periods', '40')),
        ('lyapunov', ('--starts', '2', '--periods', '64', '--before', '10')),
        ('basin', ('--grid', '4')),
        ('bifurcation', ('--points', '2', '--periods', '60', '--keep', '20')),
    ],
)
def test_a_dwell_gives_frequency_and_amplitude(told, command, words):
    code, document, _ = told(command, 'vertical_sweep', *DWELL, *words)
    assert code == 0
    one = document.get('runs', document.get('diagrams', [document]))[0]
    assert one['dof'] == 'vertical'
    omega = 2.0 * 3.141592653589793 * 2.2 / 20.0
    assert one['omega'] == pytest.approx([omega] * 2 if command == 'bifurcation' else omega)
    if command != 'bifurcation':
        assert one['amplitude'] == pytest.approx(4.0 / 400.0 / 0.6)


def test_the_band_of_the_scenario_is_swept(told):
    words = ('--vary', 'omega', '--points', '3', '--periods', '40', '--keep', '20')
    (diagram,) = told('bifurcation', 'vertical_sweep', *words)[1]['diagrams']
    hertz = 20.0 / (2.0 * 3.141592653589793)
    low, high = range_hz(scenario.load('vertical_sweep'))
    assert diagram['values'] == pytest.approx([low / hertz, (low + high) / 2 / hertz, high / hertz])


def test_two_motions_are_taken_one_at_a_time(told):
    code, _, err = told('frf', 'rotations')
    assert code == 2
    assert 'drives vertical_rotation and horizontal_rotation; take one of them by --dof' in err
    document = told('frf', 'rotations', '--dof', 'vertical_rotation', '--no-isolas')[1]
    assert document['dof'] == 'vertical_rotation'
    code, _, err = told('frf', 'rotations', '--dof', 'vertical')
    assert code == 2
    assert 'excitation.amplitude.vertical is 0: say how the base moves' in err


def test_statics_of_a_scenario(told):
    code, document, err = told('statics', 'rotations')
    assert (code, err) == (0, '')
    assert document == told('statics', '--set', 'platform.L0_hat=0.08')[1]
    code, _, err = told('statics', '--set', 'platform.payload_trim=0.5')
    assert code == 0
    assert 'caution: payload_trim moves the rest position' in err


@pytest.mark.parametrize(
    'command', ['frf', 'statics', 'bifurcation', 'poincare', 'lyapunov', 'basin', 'modes']
)
def test_an_unknown_scenario_is_refused(told, command):
    code, _, err = told(command, 'sideways')
    assert code == 2
    assert "unknown scenario 'sideways'; known: " in err
