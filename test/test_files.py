"""Files of results: never over another, never half written; and what JSON cannot say."""

from __future__ import annotations

import json
import math
import os
import threading

import pytest

from qzs_rig import files
from qzs_rig.errors import InputError
from qzs_rig.files import refuse_occupied, rewrite, rewriting, write_new, write_new_json


def test_an_occupied_folder_is_refused(tmp_path):
    refuse_occupied(tmp_path)
    refuse_occupied(tmp_path / 'new')
    file = write_new(tmp_path / 'a' / 'note.txt', 'text')
    for path in (tmp_path, file):
        with pytest.raises(InputError, match=r'is occupied; nothing is overwritten: give another'):
            refuse_occupied(path)


def test_a_file_is_kept_once(tmp_path):
    path = write_new(tmp_path / 'a' / 'estimate.json', 'first')
    with pytest.raises(InputError, match=r'estimate\.json is already there; nothing is overwrit'):
        write_new(path, 'second')
    assert path.read_text(encoding='utf-8') == 'first'
    assert [item.name for item in path.parent.iterdir()] == ['estimate.json']


def test_of_two_writers_one_is_told(tmp_path):
    """Many at once: one content, whole, and an error for everybody else."""
    path, told = tmp_path / 'estimate.json', []

    def write(number):
        try:
            write_new(path, f'{number}' * 100_000)
        except InputError as error:
            told.append(str(error))

    threads = [threading.Thread(target=write, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(told) == 7 and all('already there' in text for text in told)
    assert len(set(path.read_text())) == 1 and path.stat().st_size == 100_000
    assert [item.name for item in tmp_path.iterdir()] == ['estimate.json']


def test_without_hard_links(tmp_path, monkeypatch):
    """FAT and some network shares have none."""

    def refuse(draft, path):
        raise OSError('no links here')

    monkeypatch.setattr(files.os, 'link', refuse)
    path = write_new(tmp_path / 'a.txt', 'text')
    with pytest.raises(InputError, match='already there'):
        write_new(path, 'other')
    assert path.read_text() == 'text'
    assert [item.name for item in tmp_path.iterdir()] == ['a.txt']


def test_a_folder_that_takes_no_file(tmp_path):
    (tmp_path / 'file').write_text('')
    with pytest.raises(InputError, match=r'cannot write .*report\.html: .*; give another --out'):
        write_new(tmp_path / 'file' / 'report.html', 'text')


def test_a_new_version_takes_the_place_of_the_older_one_or_does_not(tmp_path):
    path = tmp_path / 'run.json'
    rewrite(path, 'first')
    rewrite(path, 'second')
    with pytest.raises(KeyboardInterrupt), rewriting(path) as draft:
        draft.write_text('half')
        raise KeyboardInterrupt
    assert path.read_text() == 'second'
    assert [item.name for item in tmp_path.iterdir()] == ['run.json']


@pytest.mark.parametrize(('mask', 'mode'), [(0o077, 0o600), (0o002, 0o664)])
def test_the_umask_is_the_users(tmp_path, mask, mode):
    before = os.umask(mask)
    try:
        write_new(tmp_path / 'new', 'text')
        rewrite(tmp_path / 'own', 'text')
    finally:
        os.umask(before)
    assert {item.stat().st_mode & 0o777 for item in tmp_path.iterdir()} == {mode}


def test_numbers_as_json_has_them(tmp_path):
    assert files.finite_or_none([1.0, math.nan, -math.inf]) == [1.0, None, None]
    with pytest.raises(ValueError, match='not JSON compliant'):
        write_new_json(tmp_path / 'nan.json', {'value': float('nan')})
    path = write_new_json(tmp_path / 'document.json', {'value': 1.5})
    assert json.loads(path.read_text()) == {'value': 1.5}
