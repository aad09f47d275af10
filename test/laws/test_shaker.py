"""The shaker refuses what it cannot do, with every reason at once, and can be told not to."""

from __future__ import annotations

import math

import pytest

from qzs_rig import scenario
from qzs_rig.errors import InputError, LimitError
from qzs_rig.excitation.drive import Drive
from qzs_rig.excitation.shaker import refuse_beyond_limits
from qzs_rig.run.stages import ExciterStage


def check(**given):
    words = {
        'excitation.kind': 'sine',
        'excitation.quantity': 'acceleration',
        'excitation.duration': 2.0,
        'excitation.frequency': 5.0,
        'excitation.ramp': 1.0,
        'excitation.amplitude.vertical': 10.0,
        'run.rate': 1000.0,
    }
    spec = scenario.of(words | {name.replace('__', '.'): v for name, v in given.items()})
    refuse_beyond_limits(Drive.from_spec(spec, scenario.step_ns_of(spec)), spec)


def test_the_papers_test_is_refused_for_both_reasons():
    spec = scenario.load('paper_test')
    with pytest.raises(LimitError) as caught:
        ExciterStage(spec, 1_000_000)
    text = str(caught.value)
    assert '0.5 Hz is below its 1 Hz' in text
    # 0.1 m (2 pi 20 Hz)² = 1579 m/s²; the nearest crest is a quarter cycle off the turn, 0.05 %
    # lower, and the samples may miss it by half a step
    crest = 0.1 * (2 * math.pi * 20) ** 2
    reached = float(text.split('acceleration reaches ')[1].split(maxsplit=1)[0])
    assert crest * (math.cos(math.pi * 20 / 1000) - 5e-4) - 1 <= reached <= crest + 1
    assert 'beyond 1000 m/s²' in text
    assert '--set shaker.limits=false' in text
    assert isinstance(caught.value, InputError)


def test_the_papers_test_runs_with_the_limits_lifted():
    spec = scenario.load('paper_test', ['shaker.limits=false'])
    assert ExciterStage(spec, 1_000_000).samples == 126_001


def test_a_run_inside_the_limits_passes():
    check()


@pytest.mark.parametrize(
    ('given', 'reason'),
    [
        ({'excitation__frequency': 0.9}, '0.9 Hz is below its 1 Hz'),
        ({'shaker__frequency_high': 4.0}, '5 Hz is above its 4 Hz'),
        ({'shaker__acceleration': 9.0}, 'vertical acceleration reaches 10 m/s², beyond 9 m/s²'),
        ({'shaker__force': 400.0}, 'vertical force reaches 500 N, beyond 400 N'),
        ({'shaker__velocity': 0.3}, r'vertical velocity reaches 0\.3183 m/s, beyond 0\.3 m/s'),
        ({'shaker__displacement': 0.01}, r'displacement reaches 0\.01013 m, beyond 0\.01 m'),
        (
            {'excitation__amplitude__horizontal': 1200.0},
            'horizontal acceleration reaches 1200 m/s², beyond 1000',
        ),
    ],
)
def test_each_limit(given, reason):
    """10 m/s² at 5 Hz: 0.3183 m/s (over 2 pi f), 10.13 mm, 500 N on 50 kg; a hundredth of the
    last digit is lost between samples, none at a whole number of samples a quarter cycle."""
    with pytest.raises(LimitError, match=reason):
        check(**given)


def test_limits_meet_the_band_exactly():
    check(excitation__frequency=1.0)
    check(shaker__frequency_high=5.0, shaker__acceleration=10.0 * (1 + 1e-9))


def test_rotations_have_no_limit():
    # Table 4 gives no torque
    check(excitation__amplitude__vertical=0.0, excitation__amplitude__vertical_rotation=1e4)
