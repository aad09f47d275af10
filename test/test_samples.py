"""Samples: stamps, rows and channels that belong together; indices recovered from stamps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from qzs_rig.errors import GapError
from qzs_rig.samples import Channel, Samples, index_of

CHANNELS = (Channel('x', 'm'), Channel('v', 'm/s'))
START = 1_700_000_000_000_000_001


def some(n=10):
    return Samples(START + 3_333_333 * np.arange(n), np.arange(2.0 * n).reshape(n, 2), CHANNELS)


@given(st.lists(st.integers(0, 20), min_size=1, max_size=6))
def test_pieces_make_up_the_whole(cuts):
    whole, ends = some(sum(cuts)), np.cumsum(cuts)
    pieces = [whole[end - cut : end] for cut, end in zip(cuts, ends, strict=True)]
    assert list(map(len, pieces)) == cuts
    assert np.array_equal(np.concatenate([piece.data for piece in pieces]), whole.data)
    stamps = np.concatenate([piece.stamps_ns for piece in pieces])
    assert np.array_equal(stamps, whole.stamps_ns)
    assert all(piece.channels == CHANNELS for piece in pieces)


@pytest.mark.parametrize('shape', [(3,), (3, 1), (3, 3), (3, 2, 1), (2, 2)])
def test_data_must_fit_stamps_and_channels(shape):
    with pytest.raises(ValueError, match='does not fit 3 stamps and 2 channels'):
        Samples(np.arange(3), np.zeros(shape), CHANNELS)


@given(st.integers(-(10**6), 10**6), st.integers(2, 10**9), st.data())
def test_an_index_is_recovered_from_its_stamp(index, step, data):
    assert index_of(START + index * step, START, step) == index
    off = data.draw(st.integers(1, step - 1))
    with pytest.raises(
        GapError, match=rf'lies {off} ns off the {step} ns sample grid .* run\.rate'
    ):
        index_of(START + index * step + off, START, step)
