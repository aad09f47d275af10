"""The result survives its JSON bit by bit, and a damaged one is refused by name."""

import dataclasses
import json

import numpy as np
import pytest

from qzs_rig.errors import InputError
from qzs_rig.estimation.estimate import Curve, Estimate, Event, from_json


def some_estimate():
    rng = np.random.default_rng(11)
    columns = rng.standard_normal((4, 50)) * 10.0 ** rng.integers(-300, 300, (4, 50))
    columns[3, ::7] = np.nan
    return Estimate(
        (Curve('vertical', 'forward', 'tracked_sine', 'fundamental', *columns),),
        (Event('vertical', 'forward', 'peak', 1.0 / 3.0, 2.0 / 3.0, 0.1),),
        {'samples': 5, 'dofs': {'vertical': {'points': 50, 'base_residual': None}}},
    )


def test_json_round_trip_is_bitwise():
    estimate = some_estimate()
    again = from_json(estimate.to_json())
    for name in ('frequency_hz', 'magnitude', 'phase_deg', 'thd'):
        sent, got = (getattr(each.curves[0], name) for each in (estimate, again))
        assert np.array_equal(sent, got, equal_nan=True)
    assert again.events == estimate.events
    assert again.quality == estimate.quality
    assert again.to_json() == estimate.to_json()


def test_what_is_no_estimate_is_refused():
    with pytest.raises(InputError, match='not an estimate: schema is None'):
        from_json('{}')
    with pytest.raises(InputError, match="not an estimate: schema is 'list'"):
        from_json('[]')
    with pytest.raises(InputError, match='not an estimate: Expecting'):
        from_json('{')
    document = json.loads(some_estimate().to_json())
    del document['curves'][0]['thd']
    with pytest.raises(InputError, match="damaged estimate: KeyError\\('thd'\\)"):
        from_json(json.dumps(document))


def test_a_result_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        some_estimate().events = ()
