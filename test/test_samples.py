"""Time histories: stamps on an exact grid, joints without gaps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from qzs_rig.errors import GapError
from qzs_rig.samples import Channel, TimeHistory, index_of, join

CHANNELS = (Channel('x', 'm'), Channel('v', 'm/s'))
START = 1_700_000_000_000_000_001


def history(n=10, start=START, step=3_333_333, channels=CHANNELS):
    data = np.arange(n * len(channels), dtype=float).reshape(n, len(channels))
    return TimeHistory(start, step, channels, data)


def test_stamps_are_exact_integers():
    piece = history(1000)
    assert piece.stamps_ns().tolist() == [START + k * 3_333_333 for k in range(1000)]
    assert piece.end_ns == START + 1000 * 3_333_333
    assert len(piece) == 1000


@given(st.lists(st.integers(0, 20), min_size=1, max_size=6))
def test_pieces_join_to_the_whole(cuts):
    whole, first, pieces = history(sum(cuts)), 0, []
    for cut in cuts:
        pieces.append(whole.slice(first, first + cut))
        first += cut
    joined = join(pieces)
    assert np.array_equal(joined.data, whole.data)
    assert (joined.start_ns, joined.end_ns) == (whole.start_ns, whole.end_ns)


def test_a_gap_names_its_size_and_place():
    whole = history(50, step=2_000_000)
    with pytest.raises(GapError, match=r'jumped by 20\.000 ms after sample 9; raise the QoS depth'):
        join([whole.slice(0, 10), whole.slice(20, 30)])
    with pytest.raises(GapError, match=r'jumped by -2\.000 ms after sample 9'):
        join([whole.slice(0, 10), whole.slice(9, 20)])


@pytest.mark.parametrize('other', [{'step': 5}, {'channels': (Channel('x', 'mm'), CHANNELS[1])}])
def test_pieces_of_different_histories_do_not_join(other):
    with pytest.raises(ValueError, match='share the step and the channels'):
        join([history(), history(start=history().end_ns, **other)])


@pytest.mark.parametrize('shape', [(3,), (3, 1), (3, 3), (3, 2, 1)])
def test_data_must_fit_the_channels(shape):
    with pytest.raises(ValueError, match='does not fit 2 channels'):
        TimeHistory(0, 1, CHANNELS, np.zeros(shape))


@given(st.integers(-(10**6), 10**6), st.integers(2, 10**9), st.data())
def test_an_index_is_recovered_from_its_stamp(index, step, data):
    assert index_of(START + index * step, START, step) == index
    off = data.draw(st.integers(1, step - 1))
    with pytest.raises(
        GapError, match=rf'lies {off} ns off the {step} ns sample grid .* run\.rate'
    ):
        index_of(START + index * step + off, START, step)
