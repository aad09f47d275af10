"""Recovery saves every whole message, invents none, and never touches the original."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from bag_samples import IMU, TOPICS, as_rows, expected, imus, record, stamps
from hypothesis import example, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader

from qzs_rig.bag import BagReader, BagWriter, TopicSpec, recover
from qzs_rig.errors import BagError


def messages(path: Path) -> list[tuple[str, int, bytes]]:
    with BagReader(path) as bag:
        return list(bag.messages())


def chunk_ends(bag: Path) -> list[tuple[int, int, int]]:
    """(first byte, end of chunk, end of its indexes) of each chunk."""
    with (bag / 'bag_0.mcap').open('rb') as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    return [
        (
            x.chunk_start_offset,
            x.chunk_start_offset + x.chunk_length,
            x.chunk_start_offset + x.chunk_length + x.message_index_length,
        )
        for x in chunks
    ]


def test_an_intact_bag_is_copied_whole(bag: Path, tmp_path: Path) -> None:
    before = (bag / 'bag_0.mcap').read_bytes()
    report = recover(bag, tmp_path / 'out')
    assert messages(tmp_path / 'out') == expected()
    assert (report.was_closed, report.bytes_dropped, report.findings) == (True, 0, ())
    assert report.messages['/base/imu'] == 1000
    assert sum(report.messages.values()) == len(expected())
    assert (report.start_ns, report.end_ns) == (stamps(1000)[0], stamps(1000)[-1])
    assert (bag / 'bag_0.mcap').read_bytes() == before
    assert json.loads(json.dumps(report.to_document()))['was_closed'] is True
    assert '2026 messages over 1.998 s saved' in report.text


def test_recovery_repeats_itself(bag: Path, tmp_path: Path) -> None:
    recover(bag, tmp_path / 'a' / 'bag')
    recover(tmp_path / 'a' / 'bag', tmp_path / 'b' / 'bag')
    first, second = (tmp_path / x / 'bag' / 'bag_0.mcap' for x in 'ab')
    assert first.read_bytes() == second.read_bytes()


def test_a_recovered_bag_satisfies_mcap(unfinished: Path, tmp_path: Path) -> None:
    report = recover(unfinished, tmp_path / 'out')
    assert not report.was_closed
    assert messages(tmp_path / 'out') == expected()
    with (tmp_path / 'out' / 'out_0.mcap').open('rb') as file:
        found = list(make_reader(file, validate_crcs=True).iter_messages())
    assert len(found) == len(expected())


def offsets(bag: Path) -> list[int]:
    """Every class of place to cut: in magic, header, declarations, chunk head, compressed data,
    index, between records, in the metadata, the summary, the footer and the closing magic."""
    size = (bag / 'bag_0.mcap').stat().st_size
    chunks = chunk_ends(bag)
    places = {8, 9, 16, 17, 40, 200, 5000, size - 1, size - 8, size - 9, size - 20, size - 37}
    for first, end, after in (chunks[0], chunks[3], chunks[-1]):
        places |= {first - 1, first, first + 1, first + 8, first + 20, first + 44, first + 60}
        places |= {(first + end) // 2, end - 1, end, end + 5, after - 1, after, after + 3}
    places |= set(np.linspace(8, size - 1, 25, dtype=int).tolist())
    return sorted(places)


def test_a_cut_anywhere_keeps_all_whole_chunks_and_invents_nothing(
    bag: Path, tmp_path: Path
) -> None:
    data = (bag / 'bag_0.mcap').read_bytes()
    whole = set(expected())
    places = offsets(bag)
    assert len(places) >= 55
    last = 0
    for place in places:
        cut = tmp_path / f'cut_{place}.mcap'
        cut.write_bytes(data[:place])
        report = recover(cut, tmp_path / f'out{place}')
        found = messages(tmp_path / f'out{place}')
        assert set(found) <= whole
        assert len(found) == len(set(found)) == sum(report.messages.values())
        assert set(in_whole_chunks(bag, place)) <= set(found)
        assert len(found) >= last
        last = len(found)
        assert cut.read_bytes() == data[:place]


def in_whole_chunks(bag: Path, place: int) -> list[tuple[str, int, bytes]]:
    """The messages of the chunks that end before byte `place`, by mcap's own reader."""
    with (bag / 'bag_0.mcap').open('rb') as file:
        reader = make_reader(file)
        count = sum(
            (x.message_index_length - 15 * len(x.message_index_offsets)) // 16
            for x in reader.get_summary().chunk_indexes
            if x.chunk_start_offset + x.chunk_length <= place
        )
        found = reader.iter_messages(log_time_order=False)
        return [
            (c.topic, m.log_time, m.data) for _, (_, c, m) in zip(range(count), found, strict=False)
        ]


def test_a_torn_chunk_yields_its_beginning(tmp_path: Path) -> None:
    """zstd blocks hold 128 KiB: half of a 1 MB chunk gives nearly half of its messages."""
    rows = np.random.default_rng(0).integers(0, 255, (3000, 332), dtype=np.uint8)
    at = np.arange(3000) * 10_000
    with BagWriter(tmp_path / 'bag', [TopicSpec('imu', IMU)], chunk_bytes=1 << 21) as bag:
        bag.write('imu', at, rows)
    ((first, end, _),) = chunk_ends(tmp_path / 'bag')
    data = (tmp_path / 'bag' / 'bag_0.mcap').read_bytes()
    cut = tmp_path / 'cut.mcap'
    cut.write_bytes(data[: (first + end) // 2])
    report = recover(cut, tmp_path / 'out')
    with BagReader(tmp_path / 'out') as reader:
        found = reader.rows('imu')
    assert 1000 < len(found) < 1500
    np.testing.assert_array_equal(found.rows, rows[: len(found)])
    assert f'last chunk is torn, {len(found)} messages of it saved' in report.findings[0]
    assert report.bytes_dropped == (first + end) // 2 - first


@pytest.mark.parametrize('where', ['data', 'length', 'opcode', 'index', 'index length'])
def test_damage_in_the_middle_costs_one_chunk(bag: Path, tmp_path: Path, where: str) -> None:
    data = bytearray((bag / 'bag_0.mcap').read_bytes())
    first, end, after = chunk_ends(bag)[4]
    place = {
        'data': (first + end) // 2,
        'length': first + 2,
        'opcode': first,
        'index': after - 3,
        'index length': end + 2,
    }[where]
    data[place] ^= 0x55
    broken = tmp_path / 'broken.mcap'
    broken.write_bytes(data)
    report = recover(broken, tmp_path / 'out')
    found = messages(tmp_path / 'out')
    lost = [x for x in expected() if x not in found]
    assert set(found) <= set(expected())
    if where.startswith('index'):
        assert not lost
        return
    with (bag / 'bag_0.mcap').open('rb') as file:
        chunk = make_reader(file).get_summary().chunk_indexes[4]
    assert 0 < len(lost) < 300
    assert all(chunk.message_start_time <= x[1] <= chunk.message_end_time for x in lost)
    assert report.findings
    assert report.bytes_dropped >= end - first


def test_a_lost_beginning_is_replaced_by_the_summary(bag: Path, tmp_path: Path) -> None:
    data = bytearray((bag / 'bag_0.mcap').read_bytes())
    first = chunk_ends(bag)[0][0]
    data[8:first] = bytes(first - 8)
    broken = tmp_path / 'broken.mcap'
    broken.write_bytes(data)
    assert recover(broken, tmp_path / 'out').bytes_dropped == first - 8
    assert messages(tmp_path / 'out') == expected()


def test_messages_of_undeclared_channels_are_dropped_and_counted(
    unfinished: Path, bag: Path, tmp_path: Path
) -> None:
    data = bytearray(unfinished.read_bytes())
    first = chunk_ends(bag)[0][0]
    data[8:first] = bytes(first - 8)
    broken = tmp_path / 'broken.mcap'
    broken.write_bytes(data)
    report = recover(broken, tmp_path / 'out')
    assert messages(tmp_path / 'out') == []
    assert any('belong to channels nobody declares' in x for x in report.findings)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.floats(0, 1), st.integers(1, 255)), min_size=1, max_size=4))
@example([(0.0, 4), (0.5, 1)])  # the header becomes a message
@example([(0.0, 4)])
def test_flipped_bytes_never_crash_nor_change_a_message(
    tmp_path_factory: pytest.TempPathFactory, flips: list[tuple[float, int]]
) -> None:
    folder = tmp_path_factory.mktemp('flip')
    data = bytearray(_small(tmp_path_factory))
    for place, mask in flips:
        data[8 + int(place * (len(data) - 9))] ^= mask
    (folder / 'x.mcap').write_bytes(data)
    known = {message for _, _, message in expected(120)}
    try:
        with BagReader(folder / 'x.mcap') as bag:
            assert {message for _, _, message in bag.messages()} <= known
    except BagError:
        pass
    recover(folder / 'x.mcap', folder / 'out')
    assert {message for _, _, message in messages(folder / 'out')} <= known


SMALL: list[bytes] = []


def _small(factory: pytest.TempPathFactory) -> bytes:
    if not SMALL:
        folder = record(factory.mktemp('small') / 'bag', count=120, chunk_bytes=20_000)
        SMALL.append((folder / 'bag_0.mcap').read_bytes())
    return SMALL[0]


def test_recovery_wants_a_new_folder(bag: Path) -> None:
    with pytest.raises(BagError, match='is not empty; choose a new one'):
        recover(bag, bag)


@pytest.mark.parametrize('content', [b'', b'\x89MC', b'no bag at all'])
def test_a_file_without_beginning_is_lost(tmp_path: Path, content: bytes) -> None:
    (tmp_path / 'x.mcap').write_bytes(content)
    with pytest.raises(BagError, match='does not begin like an MCAP file'):
        recover(tmp_path / 'x.mcap', tmp_path / 'out')
    assert not (tmp_path / 'out').exists()


def test_recovered_rows_keep_type_and_quality_of_service(
    unfinished: Path, bag: Path, tmp_path: Path
) -> None:
    recover(unfinished, tmp_path / 'out')
    with BagReader(bag) as before, BagReader(tmp_path / 'out') as after:
        assert before.channels == after.channels
        np.testing.assert_array_equal(
            after.rows('top/imu', IMU).rows, as_rows(imus(1000, 'top_imu_link'))
        )
    assert len(TOPICS) == 4
    with (tmp_path / 'out' / 'out_0.mcap').open('rb') as file:
        assert list(StreamReader(file, validate_crcs=True).records)
