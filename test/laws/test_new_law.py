"""A law with a parameter of its own is one line in RESTORING: everything else follows."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from qzs_rig import scenario
from qzs_rig.campaign import plan
from qzs_rig.campaign.oscillators import oscillator_of
from qzs_rig.cli.main import execute
from qzs_rig.mechanics.integrator import Integrator
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import RestoringLaw
from qzs_rig.parameters import positive
from qzs_rig.theory.motion.batch import Batch, batch_along
from qzs_rig.theory.motion.stroboscope import strobe
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS

STOP = 'platform.stop'
FIRM = ('--set', f'{STOP}=3.0')


def force(rsqrt):
    """k3 w and a spring that gets harder with w: stop w (1 - 1/sqrt(1 + w²))."""

    def formula(design, w):
        _, k3, _, _, _, _, stop = design
        return k3 * w + stop * w * (1.0 - rsqrt(1.0 + w * w))

    return formula


def slope(design, w):
    _, k3, _, _, _, _, stop = design
    return k3 + stop * (1.0 - (1.0 + w * w) ** -1.5)


LAW = RestoringLaw(
    'stop',
    'nowhere',
    lambda design: ((design.k3, 0.0, 0.5 * design.own[0]),) * 4,
    (force,) * 4,
    (slope,) * 4,
    weighted=False,
    odd=DOFS,
    parameters=(positive(STOP, 1.5, '', 'law stop: how hard it gets'),),
)


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    monkeypatch.setitem(RESTORING, LAW.name, LAW)


@pytest.fixture
def told(capsys):
    def run(*words):
        code = execute([*words, '--json'])
        out, err = capsys.readouterr()
        assert code == 0, err
        return json.loads(out)

    return run


def spec(**given):
    words = {'law': 'stop', 'zeta': 0.1} | given
    return scenario.of({f'platform.{name}': value for name, value in words.items()})


def test_its_parameter_is_listed_with_its_unit_and_text(told):
    rows = {row['name']: row for row in told('scenarios', '--parameters')['parameters']}
    assert rows[STOP]['default'] == 1.5
    assert rows[STOP]['range'] == '> 0'
    assert 'stop' in rows['platform.law']['range']


def test_the_numbers_of_the_law_follow_those_of_the_platform():
    assert Platform.from_spec(spec(stop=3.0)).design.own == (3.0,)
    assert Platform.from_spec(spec(law='corrected')).design.own == ()


def test_statics(told, tmp_path):
    words = ('statics', '--law', 'stop', '--dof', 'horizontal', *FIRM)
    found = told(*words, '--at', '0.5')
    k3, root = 0.1, math.sqrt(1.25)
    assert found['force'] == pytest.approx([k3 * 0.5 + 1.5 * (1 - 1 / root)], rel=1e-12)
    assert found['stiffness'] == pytest.approx([k3 + 3 * (1 - root**-3)], rel=1e-12)
    # the figures compare the laws of the paper at the same design
    assert len(told(*words, '--out', str(tmp_path / 'page'))['files']) == 10


def test_a_run_in_process(told, tmp_path):
    words = ('run', '--no-bag', '--out', str(tmp_path / 'run'), '--set', 'platform.law=stop')
    short = ('--set', 'excitation.duration=10', *FIRM)
    assert told(*words, *short)['topics']['top/imu']['received'] == 8001


@pytest.mark.parametrize('kernel', ['numba', 'python'])
def test_interpreter_and_numba_move_it_alike(kernel):
    t = np.arange(400) / 500.0
    wave = 0.1 * np.stack([np.sin(9 * t)] * 4 + [9 * np.cos(9 * t)] * 4, axis=1)
    platform = Platform.from_spec(spec(stop=3.0))
    got, want = (Integrator(platform, 0.002, 1, k).push(wave) for k in (kernel, 'auto'))
    assert got.tobytes() == want.tobytes()


def test_frequency_response(told):
    words = ('frf', '--law', 'stop', '--zeta', '0.1', '--amplitude', '0.2', '--omega', '0.2:1.5')
    soft, firm = told(*words), told(*words, *FIRM)
    # a spring that gets harder leans the peak upward
    assert firm['peak']['omega'] > soft['peak']['omega'] + 0.02


def test_time_integration_varies_it_run_by_run():
    own = Oscillator.of(spec(), 'vertical', 0.3)
    stops = np.array([0.5, 1.5, 4.0])
    seen = strobe(batch_along(spec(), own, 0.8, STOP, stops), steps=32, periods=200, keep=0)
    for k, stop in enumerate(stops.tolist()):
        one = Oscillator.of(spec(stop=stop), 'vertical', 0.3)
        alone = strobe(Batch.of(one, 0.8), steps=32, periods=200, keep=0)
        # the same sums, regrouped by the compiler
        assert seen.end[k] == pytest.approx(alone.end[0], abs=1e-10)


def test_a_campaign_varies_it_from_point_to_point():
    asked = {
        'campaign': {'task': 'single_term', 'sample': 'latin_hypercube', 'samples': 5},
        'base': {'platform.law': 'stop', 'amplitude': 0.1},
        'vary': {STOP: {'from': 1.0, 'to': 5.0}},
    }
    points = plan.of(asked).between(0, 5)
    found = oscillator_of(points.columns(np.arange(5)))
    wanted = [Oscillator.of(points.spec(row), 'vertical', 0.1).design.own for row in range(5)]
    assert [tuple(own) for own in np.transpose(found.design.own)] == wanted
