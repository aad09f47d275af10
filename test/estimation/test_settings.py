"""Settings refuse what cannot work and say what would."""

from dataclasses import fields

import pytest

from qzs_rig.errors import InputError
from qzs_rig.estimation import ESTIMATORS, TrackedSineSettings

BOUNDS = {item.name: item.metadata['bounds'] for item in fields(TrackedSineSettings)}


@pytest.mark.parametrize('name', sorted(BOUNDS))
@pytest.mark.parametrize('side', [0, 1])
def test_each_setting_is_held_to_its_bounds(name, side):
    beyond = BOUNDS[name][side] + (2 * side - 1)
    with pytest.raises(InputError, match=f'estimation {name} = .* is outside'):
        TrackedSineSettings(**{name: beyond})


def test_an_empty_band_is_refused():
    with pytest.raises(InputError, match=r'frequency_min = 5\.0 Hz is not below'):
        TrackedSineSettings(frequency_min=5.0, frequency_max=4.0)


def test_estimators_carry_the_name_they_are_listed_under():
    assert {name: estimator.name for name, estimator in ESTIMATORS.items()} == {
        name: name for name in ESTIMATORS
    }
