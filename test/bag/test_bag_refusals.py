"""Every refusal is one line that names the thing, the value and the way out."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from bag_samples import IMU, STRING, expected, imus, record, stamps, string

from qzs_rig.bag import BagReader, BagWriter, TopicSpec, info, recover
from qzs_rig.errors import BagError

ROOT = Path(__file__).parents[2]
SPEC = (TopicSpec('base/imu', IMU),)


def message_of(error: pytest.ExceptionInfo[BagError]) -> str:
    text = str(error.value)
    assert '\n' not in text
    return text


def test_a_folder_in_use_is_never_overwritten(bag: Path) -> None:
    before = {x: x.read_bytes() for x in bag.iterdir()}
    with pytest.raises(BagError) as error:
        BagWriter(bag, SPEC)
    assert str(bag) in message_of(error)
    assert 'choose a new one' in message_of(error)
    assert {x: x.read_bytes() for x in bag.iterdir()} == before


def test_a_file_in_the_way_is_named(tmp_path: Path) -> None:
    (tmp_path / 'bag').write_text('notes')
    with pytest.raises(BagError, match='cannot be made'):
        BagWriter(tmp_path / 'bag', SPEC)


@pytest.mark.parametrize(
    ('make', 'reason'),
    [
        (lambda: BagWriter(Path('x'), [TopicSpec('a', 'no/msg/No')]), "'no/msg/No'.*package/msg"),
        (lambda: BagWriter(Path('x'), [TopicSpec('a', IMU), TopicSpec('/a', IMU)]), '2 times'),
    ],
)
def test_wrong_topics_are_refused_before_anything_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, make, reason: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BagError, match=reason) as error:
        make()
    message_of(error)
    assert not list(tmp_path.iterdir())


def test_wrong_input_to_the_writer(tmp_path: Path) -> None:
    rows = np.zeros((2, 8), dtype=np.uint8)
    with BagWriter(tmp_path / 'bag', SPEC) as bag:
        with pytest.raises(
            BagError, match=r"topic 'x' is not recorded here; take one of /base/imu"
        ):
            bag.write('x', [1], [bytes(8)])
        with pytest.raises(BagError, match='stamp -1 ns is negative'):
            bag.write('base/imu', [-1, 2], rows)
        with pytest.raises(BagError, match='stamp -5 ns is negative'):
            bag.write('base/imu', [-5], [bytes(8)])
        with pytest.raises(BagError, match='message of 3 bytes on /base/imu is not CDR'):
            bag.write('base/imu', [1], [bytes(3)])
        with pytest.raises(BagError, match='message of 0 bytes'):
            bag.write('base/imu', [1, 2], [bytes(8), b''])
        with pytest.raises(ValueError, match='do not fit 2 messages'):
            bag.write('base/imu', [1], rows)
        with pytest.raises(ValueError, match='are not'):
            bag.write('base/imu', [1, 2], rows.astype(float))
        bag.write('base/imu', [1, 2], rows)
        bag.write('base/imu', np.empty(0, int), rows[:0])
    for late in (
        lambda: bag.write('base/imu', [1], [bytes(8)]),
        lambda: bag.write('/base/imu', [1, 2], rows),
    ):
        with pytest.raises(BagError, match='is closed; record to a new folder'):
            late()
    bag.close()
    bag.flush()
    bag.tick()
    with BagReader(tmp_path / 'bag') as reader:
        assert len(reader.rows('base/imu')) == 2


def test_an_exception_loses_nothing(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt), BagWriter(tmp_path / 'bag', SPEC) as bag:
        bag.write('base/imu', stamps(10), imus(10, 'x'))
        bag.write('base/imu', stamps(11)[10:], imus(11, 'x')[10:])
        raise KeyboardInterrupt
    with BagReader(tmp_path / 'bag') as reader:
        assert reader.rows('base/imu').messages() == list(imus(11, 'x'))


def test_the_wall_clock_cuts_when_stamps_stand_still(tmp_path: Path) -> None:
    now = [0.0]
    bag = BagWriter(tmp_path / 'bag', SPEC, clock=lambda: now[0])
    try:
        bag.write('base/imu', [1], [bytes(8)])
        size = bag.path.stat().st_size
        now[0] = 0.24
        bag.tick()
        assert (bag.path.stat().st_size, bag.wall_cuts) == (size, 0)
        now[0] = 0.26
        bag.tick()
        assert bag.path.stat().st_size > size
        assert bag.wall_cuts == 1
        bag.write('base/imu', [2], [bytes(8)])
        size = bag.path.stat().st_size
        now[0] = 0.6
        bag.write('base/imu', [3], [bytes(8)])
        assert bag.path.stat().st_size > size
    finally:
        bag.close()


@pytest.mark.parametrize(
    ('make', 'reason'),
    [
        (lambda p: p / 'none', 'does not exist'),
        (lambda p: p, 'holds no bag'),
        (lambda p: _touch(p / 'notes.txt'), 'is not a bag'),
        (lambda p: _touch(p / 'x.mcap'), 'is empty; nothing was recorded'),
        (lambda p: _touch(p / 'x.mcap', b'no magic in here'), 'is not an MCAP file'),
        (
            lambda p: _touch(_touch(p / 'a.mcap').parent / 'b.mcap').parent,
            'holds 2 bags .a.mcap, b',
        ),
        (lambda p: _touch(p / 'x.mcap', b'\x89MCAP0\r\n'), 'not closed.*qzs-rig bag recover /'),
    ],
)
def test_what_is_no_bag_is_named(tmp_path: Path, make, reason: str) -> None:
    with pytest.raises(BagError, match=reason) as error:
        BagReader(make(tmp_path))
    assert str(tmp_path) in message_of(error)


def _touch(path: Path, content: bytes = b'') -> Path:
    path.write_bytes(content)
    return path


def test_wrong_questions_to_a_bag(bag: Path, tmp_path: Path) -> None:
    with BagReader(bag) as reader:
        with pytest.raises(BagError, match=r'/joint is not in it; take one of /base/imu, /base/mo'):
            reader.rows('joint')
        with pytest.raises(BagError, match=f'/rig/run is {STRING}, not {IMU}'):
            reader.rows('rig/run', IMU)
        with pytest.raises(BagError, match='topic /imu is one of /base/imu, /top/imu; take one'):
            reader.rows('imu')
    with BagWriter(tmp_path / 'b', [TopicSpec('rig/run', STRING)]) as writer:
        writer.write('rig/run', [1, 2], [string('{"a": 1}'), string('[1, 2]')])
    with BagReader(tmp_path / 'b') as reader:
        with pytest.raises(BagError, match='no JSON object'):
            reader.run_sheets()
        with pytest.raises(BagError, match=r'have \d+ to \d+ bytes'):
            _ = reader.rows('rig/run').rows
    with BagWriter(tmp_path / 'c', [TopicSpec('rig/run', STRING)]) as writer:
        writer.write('rig/run', [1], [string('{"a": ')])
    with BagReader(tmp_path / 'c') as reader, pytest.raises(BagError, match='is no JSON'):
        reader.run_sheets()


def test_a_damaged_chunk_is_named_with_the_way_out(bag: Path, tmp_path: Path) -> None:
    data = bytearray((bag / 'bag_0.mcap').read_bytes())
    data[len(data) // 2] ^= 1
    path = _touch(tmp_path / 'x.mcap', bytes(data))
    with BagReader(path) as reader, pytest.raises(BagError) as error:
        list(reader.messages())
    assert f'qzs-rig bag recover {path}' in message_of(error)


def test_a_damaged_summary_is_named(bag: Path, tmp_path: Path) -> None:
    data = bytearray((bag / 'bag_0.mcap').read_bytes())
    data[-100] ^= 1
    with pytest.raises(BagError, match='CRC of the summary does not match'):
        BagReader(_touch(tmp_path / 'x.mcap', bytes(data)))


LIMITED = """
import resource, signal, sys
from pathlib import Path
import numpy as np
from qzs_rig.bag import BagWriter, TopicSpec
from qzs_rig.errors import BagError
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), int(sys.argv[2])))
rows = np.random.default_rng(0).integers(0, 255, (100, 332), dtype=np.uint8)
bag = BagWriter(Path(sys.argv[1]), [TopicSpec('imu', 'sensor_msgs/msg/Imu')])
try:
    for k in range(1000):
        bag.write('imu', (k * 100 + np.arange(100)) * 1_000_000, rows)
except BagError as error:
    print(error)
finally:
    bag.close()
"""


def test_a_file_that_may_not_grow_stays_readable(tmp_path: Path) -> None:
    """The system refuses beyond 1 MB; what was written before is a closed bag."""
    command = [sys.executable, '-c', LIMITED, str(tmp_path / 'bag'), '1000000']
    environment = {**os.environ, 'PYTHONPATH': str(ROOT)}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    assert 'File too large after ' in done.stdout
    assert 'the bag is closed and readable up to there' in done.stdout
    with BagReader(tmp_path / 'bag') as bag:
        found = bag.rows('imu').stamps_ns
    assert f'after {len(found)} messages' in done.stdout
    assert found.tolist() == [k * 1_000_000 for k in range(len(found))]
    assert len(found) * 332 > 850_000


class FullDisk:
    """A file that takes `room` bytes, then fails as a full disk does, half-way through a write."""

    def __init__(self, raw, room: int) -> None:
        self._raw, self._room = raw, room

    def write(self, data) -> int:
        fits = self._room - self._raw.tell()
        if fits <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return self._raw.write(data[:fits])

    def __getattr__(self, name: str):
        return getattr(self._raw, name)


def test_a_full_disk_at_every_place_keeps_what_was_there(bag: Path, tmp_path: Path) -> None:
    """Closed where the summary still fits, else recovered; never an exception but BagError."""
    size = (bag / 'bag_0.mcap').stat().st_size
    outcomes = set()
    rooms = [*np.linspace(12_000, size - 1, 12, dtype=int).tolist()]
    for room in rooms:
        folder = tmp_path / str(room) / 'bag'
        with pytest.raises(BagError, match='No space left on device after') as error:
            _record_on_full_disk(folder, room)
        text = message_of(error)
        if 'is closed and readable' in text:
            outcomes.add('closed')
            with BagReader(folder) as reader:
                found = list(reader.messages())
        else:
            assert f'qzs-rig bag recover {folder}' in text
            outcomes.add('recovered')
            recover(folder, tmp_path / str(room) / 'out')
            with BagReader(tmp_path / str(room) / 'out') as reader:
                found = list(reader.messages())
        assert set(found) <= set(expected())
        assert f'after {len(found)} messages' in text
    assert outcomes == {'closed', 'recovered'}


def _record_on_full_disk(folder: Path, room: int) -> None:
    from qzs_rig.bag.mcap_file import McapFile

    begin = McapFile.begin

    def begin_on_full_disk(self, channels) -> None:
        self._raw = FullDisk(self._raw, room)
        begin(self, channels)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(McapFile, 'begin', begin_on_full_disk)
        record(folder)


def test_a_disk_full_from_the_start_names_the_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, 'No space left on device')

    monkeypatch.setattr('qzs_rig.bag.mcap_file.McapFile.__init__', refuse)
    with pytest.raises(BagError, match=r'cannot be written .No space.*choose another folder'):
        BagWriter(tmp_path / 'bag', SPEC)


def test_recovery_to_a_full_disk_names_it(
    bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, 'No space left on device')

    monkeypatch.setattr('qzs_rig.bag.mcap_file.McapFile.finish', refuse)
    with pytest.raises(BagError, match='No space left on device; recover to another disk'):
        recover(bag, tmp_path / 'out')


def test_info_of_a_killed_bag_says_so(unfinished: Path) -> None:
    assert 'was not closed' in info(unfinished).text
