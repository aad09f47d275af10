"""The folder of a run: its name, and the document of what was performed."""

from __future__ import annotations

import json
from pathlib import Path

from qzs_rig.estimation.estimate import Estimate, from_json
from qzs_rig.run.runfolder import keep_results, new_folder
from qzs_rig.run.sheet import RunSheet


def test_a_folder_is_named_after_time_scenario_and_id(tmp_path):
    folder = new_folder('some/where/rotations.yaml', 'abc', str(tmp_path))
    assert folder.parent == tmp_path
    assert folder.name.endswith('_rotations_abc')
    assert not folder.exists()


def test_the_results_of_a_run_are_json(tmp_path):
    sheet = RunSheet(1, 2, 'lockstep', 3, run_id='id', scenario='s', state='aborted', reason='x')
    counts = {'top/imu': {'lost': 0}}
    document = keep_results(
        tmp_path, sheet, Estimate(), (), rig_s=1.5, wall_s=0.1, topics=counts, bag=tmp_path
    )
    read = json.loads((tmp_path / 'run.json').read_text(encoding='utf-8'))
    assert read == document
    assert (Path(read['bag']), read['report'], read['state']) == (tmp_path, None, 'aborted')
    assert from_json(Path(read['estimate']).read_text(encoding='utf-8')) == Estimate()
    assert not (tmp_path / 'theory.json').exists()
