"""Laws of alignment: a common grid passes bit by bit, anything else within the cubic's error."""

import itertools

import numpy as np
import pytest

from qzs_rig.errors import GapError
from qzs_rig.estimation.alignment import BRIDGE, MEMORY, Aligned, Aligner, nominal_step

STEP = 2_000_000
START = 1_700_000_000_123_456_789


def grid(count, step=STEP, start=START):
    return start + step * np.arange(count, dtype=np.int64)


def motion(stamps, frequency=7.0):
    t = (stamps - START) / 1e9
    return np.stack([np.sin(2 * np.pi * frequency * t + phase) for phase in range(4)], axis=1)


def taken(aligner, base, top, chunk=37):
    """Everything the aligner gives when both streams come in pieces, in step."""
    pieces = []
    for first in range(0, max(len(base), len(top)), chunk):
        part = slice(first, first + chunk)
        aligner.push_base(base[part], motion(base[part]))
        aligner.push_top(top[part], motion(top[part]))
        pieces.append(aligner.take())
    pieces.append(aligner.take(final=True))
    return together(pieces)


def together(pieces):
    pieces = [piece for piece in pieces if len(piece.base)]
    for piece, after in itertools.pairwise(pieces):
        assert after.start_ns == piece.start_ns + len(piece.base) * piece.step_ns
    return Aligned(
        pieces[0].start_ns,
        pieces[0].step_ns,
        np.concatenate([piece.base for piece in pieces]),
        np.concatenate([piece.top for piece in pieces]),
    )


def worst(aligned):
    exact = motion(grid(len(aligned.base), aligned.step_ns, aligned.start_ns))
    return np.nanmax(np.abs(np.stack([aligned.base, aligned.top]) - exact))


@pytest.mark.parametrize('chunk', [1, 37, 5000])
@pytest.mark.parametrize('late', [0, 5])
def test_a_common_grid_passes_bit_by_bit(chunk, late):
    base, top = grid(1000), grid(1000 - late, start=START + late * STEP)
    aligned = taken(Aligner(), base, top, chunk)
    assert (aligned.start_ns, aligned.step_ns) == (START + late * STEP, STEP)
    assert np.array_equal(aligned.base, motion(base)[late:])
    assert np.array_equal(aligned.top, motion(top))


def test_a_common_grid_does_not_wait():
    aligner = Aligner()
    stamps = grid(100)
    aligner.push_base(stamps, motion(stamps))
    aligner.push_top(stamps, motion(stamps))
    assert len(aligner.take().base) == 100


def test_jitter_phase_rate_and_drift_are_taken_out():
    rng = np.random.default_rng(2)
    base = grid(3000) + rng.integers(-300_000, 300_000, 3000)
    top = grid(6000, 1_000_300, START - 777_777) + rng.integers(-100_000, 100_000, 6000)
    aligner = Aligner()
    pieces = []
    for i in range(100):
        b, u = base[30 * i : 30 * i + 30], top[60 * i : 60 * i + 60]
        aligner.push_base(b, motion(b))
        aligner.push_top(u, motion(u))
        pieces.append(aligner.take())
    aligned = together(pieces)
    # 64 stamps with 0.3 ms of jitter tell the step to about a thousandth.
    assert aligned.step_ns == pytest.approx(STEP, rel=5e-3)
    # Cubic between steps of up to h = 2.6 ms: (2π f h)⁴ · 9/384.
    assert worst(aligned) < (2 * np.pi * 7.0 * 2.6e-3) ** 4 * 9 / 384 * 2
    assert not np.isnan(aligned.base).any()
    assert not np.isnan(aligned.top[1:]).any()
    assert len(aligned.base) > 2980
    assert {c.lost for c in aligner.counts.values()} == {0}


@pytest.mark.parametrize('shift', [0, 500_000])
@pytest.mark.parametrize('missing', [1, 3, 4, 50])
def test_a_gap_is_counted_and_bridged_or_left_open(missing, shift):
    stamps = grid(1000, start=START + shift)
    holey = np.delete(stamps, np.s_[500 : 500 + missing])
    aligner = Aligner()
    aligned = taken(aligner, grid(1000), holey)
    assert aligner.counts['top'].lost == missing
    assert aligner.counts['top'].received == 1000 - missing
    assert aligner.counts['base'].lost == 0
    open_rows = np.isnan(aligned.top).any(axis=1)
    bridged = missing + 1 <= BRIDGE
    assert open_rows.sum() == (0 if bridged else missing + (shift > 0))
    assert not np.isnan(aligned.base).any()
    # Cubic over at most BRIDGE steps, twice the error constant at one side of a gap.
    assert worst(aligned) < (2 * np.pi * 7.0 * BRIDGE * STEP / 1e9) ** 4 * 9 / 384 * 2


def test_duplicates_and_late_samples_are_dropped_and_counted():
    clean = grid(500)
    order = np.concatenate(
        [np.arange(200), [150, 199], np.arange(201, 300), [200], np.arange(300, 500)]
    )
    aligner = Aligner()
    aligned = taken(aligner, clean[order], clean, 1000)
    counts = aligner.counts['base']
    assert (counts.received, counts.duplicated, counts.reordered, counts.lost) == (502, 2, 1, 1)
    assert worst(aligned) < 1e-3
    assert np.array_equal(aligned.base[:200], motion(clean)[:200])


def test_the_values_do_not_depend_on_the_chunks():
    rng = np.random.default_rng(4)
    base = grid(600) + rng.integers(-200_000, 200_000, 600)
    top = np.delete(grid(600, start=START + 333_333), [100, 101, 300, 301, 302, 303, 304, 308, 309])
    one, other = (taken(Aligner(STEP), base, top, chunk) for chunk in (1, 200))
    assert one.start_ns == other.start_ns
    assert np.array_equal(one.top, other.top, equal_nan=True)
    assert np.array_equal(one.base, other.base, equal_nan=True)


def test_memory_is_bounded_while_one_stream_is_silent():
    aligner = Aligner()
    stamps = grid(200)
    aligner.push_base(stamps, motion(stamps))
    aligner.push_top(stamps, motion(stamps))
    aligner.take()
    longer = grid(2 * MEMORY)
    for first in range(200, len(longer), 1000):
        aligner.push_base(longer[first : first + 1000], motion(longer[first : first + 1000]))
        assert len(aligner.take().base) == 0
    assert len(aligner._base.stamps) <= MEMORY
    assert aligner.counts['base'].unmatched > 0


def test_a_set_clock_is_refused():
    aligner = Aligner()
    stamps = grid(100)
    aligner.push_base(stamps, motion(stamps))
    for jump in (10**12, -(10**12)):
        with pytest.raises(GapError, match=r'clock of base jumped by -?\d+\.\d+ s'):
            aligner.push_base(stamps + jump, motion(stamps))


def test_data_that_do_not_fit_the_stamps_are_refused():
    with pytest.raises(ValueError, match=r'top: data \(3, 4\) does not fit 2 stamps'):
        Aligner().push_top(grid(2), np.zeros((3, 4)))


def test_the_nominal_step_survives_losses():
    assert nominal_step(np.delete(grid(64), [5, 20, 21])) == STEP
