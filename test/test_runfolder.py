"""The folder of a run: nothing in it is ever overwritten, and no half-written file appears."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from qzs_rig.errors import InputError
from qzs_rig.runfolder import keep, keep_document, new_folder, refuse_occupied, run_document


def test_a_folder_is_named_after_time_scenario_and_id(tmp_path):
    folder = new_folder('some/where/rotations.yaml', 'abc', str(tmp_path))
    assert folder.parent == tmp_path
    assert folder.name.endswith('_rotations_abc')
    assert not folder.exists()


def test_an_occupied_folder_is_refused(tmp_path):
    refuse_occupied(tmp_path)
    refuse_occupied(tmp_path / 'new')
    file = keep(tmp_path / 'a' / 'note.txt', 'text')
    for path in (tmp_path, file):
        with pytest.raises(InputError, match=r'is occupied; nothing is overwritten: give another'):
            refuse_occupied(path)


def test_a_file_is_kept_once(tmp_path):
    path = keep(tmp_path / 'a' / 'estimate.json', 'first')
    with pytest.raises(InputError, match=r'estimate\.json is already there; nothing is overwrit'):
        keep(path, 'second')
    assert path.read_text(encoding='utf-8') == 'first'
    assert [item.name for item in path.parent.iterdir()] == ['estimate.json']


def test_the_document_of_a_run_is_json(tmp_path):
    files = {'bag': tmp_path, 'report': None}
    document = run_document('id', 'lockstep', 1.5, 0.1, {'top/imu': {'lost': 0}}, files, state='x')
    path = keep_document(tmp_path / 'run.json', document)
    read = json.loads(path.read_text(encoding='utf-8'))
    assert read == document
    assert (Path(read['bag']), read['report'], read['state']) == (tmp_path, None, 'x')
    with pytest.raises(ValueError, match='not JSON compliant'):
        keep_document(tmp_path / 'nan.json', {'value': float('nan')})
