"""Lost, doubled and stray samples are counted exactly."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from bag_samples import IMU, SHEET, START_NS, STEP_NS, STRING, expected, imus, string

from qzs_rig.bag import BagWriter, TopicSpec, info

SPECS = (
    TopicSpec('base/imu', IMU),
    TopicSpec('top/imu', IMU),
    TopicSpec('rig/run', STRING),
)


def write(folder: Path, base: list[int], top: list[int], sheet: dict | None) -> Path:
    rows = np.zeros((len(base) + len(top), 12), dtype=np.uint8)
    with BagWriter(folder, SPECS) as bag:
        if sheet is not None:
            bag.write('rig/run', [START_NS], [string(json.dumps(sheet))])
        bag.write('base/imu', START_NS + STEP_NS * np.array(base, int), rows[: len(base)])
        bag.write('top/imu', START_NS + STEP_NS * np.array(top, int), rows[: len(top)])
    return folder


def test_a_whole_bag_is_described(bag: Path) -> None:
    found = info(bag.parent)
    assert found.closed
    assert found.lossless
    assert found.messages == len(expected())
    assert found.duration == 999 * STEP_NS / 1e9
    assert found.run == SHEET
    assert found.size_bytes == (bag / 'bag_0.mcap').stat().st_size
    topics = {topic.name: topic for topic in found.topics}
    assert topics['/base/imu'].count == 1000
    assert topics['/base/imu'].rate_hz == pytest.approx(500.0, rel=1e-12)
    assert topics['/base/imu'].grid is not None
    assert topics['/base/imu'].grid.source == 'run sheet'
    assert topics['/base/motion'].grid is None
    document = json.loads(json.dumps(found.to_document()))
    assert document['lossless'] is True
    assert document['topics'][0]['name'] == '/base/imu'
    assert '/top/imu' in found.text


@pytest.mark.parametrize('sheet', [SHEET, {'spec': {'start_ns': START_NS, 'step_ns': STEP_NS}}])
def test_loss_at_both_ends_shows_against_the_run_sheet(tmp_path: Path, sheet: dict) -> None:
    """The other sensor shows how far the run went, the sheet where it began."""
    base = [k for k in range(3, 95) if k not in {40, 41}]
    found = info(write(tmp_path / 'b', [*base, 50, 50], list(range(100)), sheet))
    base_grid, top_grid = (found.topics[k].grid for k in (0, 2))
    assert (base_grid.received, base_grid.lost, base_grid.duplicated) == (92, 10, 2)
    assert (top_grid.received, top_grid.lost, top_grid.duplicated) == (100, 0, 0)
    assert not found.lossless


def test_without_a_sheet_the_median_step_is_the_grid(tmp_path: Path) -> None:
    base = [k for k in range(100) if k not in {40, 41}]
    found = info(write(tmp_path / 'b', [*base, 7], [], None))
    grid = found.topics[0].grid
    assert grid is not None
    assert grid.step_ns == STEP_NS
    assert grid.source == 'median step'
    assert (grid.received, grid.lost, grid.duplicated, grid.off_grid) == (99, 2, 1, 0)
    assert found.topics[2].grid is None


def test_stamps_off_the_grid_and_before_the_start_are_counted(tmp_path: Path) -> None:
    sheet = {**SHEET, 'start_ns': START_NS + 5 * STEP_NS - 0}
    found = info(write(tmp_path / 'b', list(range(10)), [], sheet))
    assert found.topics[0].grid.off_grid == 5
    sheet = {**SHEET, 'start_ns': START_NS - 1}
    found = info(write(tmp_path / 'c', list(range(10)), [], sheet))
    assert found.topics[0].grid.off_grid == 10


def test_a_killed_bag_is_described_as_far_as_it_goes(unfinished: Path) -> None:
    found = info(unfinished)
    assert not found.closed
    assert not found.lossless
    assert found.damage == ('was not closed',)
    assert found.messages == len(expected())
    assert 'was not closed' in found.text


def test_damage_and_a_sheet_that_is_no_json_are_listed(bag: Path, tmp_path: Path) -> None:
    data = bytearray((bag / 'bag_0.mcap').read_bytes())
    data[len(data) // 2] ^= 1
    (tmp_path / 'x.mcap').write_bytes(data)
    found = info(tmp_path / 'x.mcap')
    assert any('CRC' in x or 'zstd' in x for x in found.damage)
    assert 900 < found.messages < len(expected())
    with BagWriter(tmp_path / 'b', SPECS) as bag_writer:
        bag_writer.write('rig/run', [START_NS], [string('hello')])
        bag_writer.write('base/imu', [START_NS], imus(1, 'x'))
    found = info(tmp_path / 'b')
    assert found.run is None
    assert any('no JSON' in x for x in found.damage)
