"""The folder of a run: its name, and the document of what was performed."""

from __future__ import annotations

import json
from pathlib import Path

from qzs_rig.files import write_new_json
from qzs_rig.run.runfolder import new_folder, run_document


def test_a_folder_is_named_after_time_scenario_and_id(tmp_path):
    folder = new_folder('some/where/rotations.yaml', 'abc', str(tmp_path))
    assert folder.parent == tmp_path
    assert folder.name.endswith('_rotations_abc')
    assert not folder.exists()


def test_the_document_of_a_run_is_json(tmp_path):
    files = {'bag': tmp_path, 'report': None}
    document = run_document('id', 'lockstep', 1.5, 0.1, {'top/imu': {'lost': 0}}, files, state='x')
    path = write_new_json(tmp_path / 'run.json', document)
    read = json.loads(path.read_text(encoding='utf-8'))
    assert read == document
    assert (Path(read['bag']), read['report'], read['state']) == (tmp_path, None, 'x')
