"""`qzs-rig campaign`: its contract, and a kill -9 in the middle."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import qzs_rig
from qzs_rig.cli import campaign
from qzs_rig.cli.main import execute

PLAN = """\
campaign: {task: statics, chunk: 10}
vary:
  platform.A: {from: 1.0, to: 2.0, count: 40}
  platform.k3_hat: {from: 0.05, to: 0.5, count: 20}
"""
POINTS = 800


@pytest.fixture
def told(capsys):
    """Runs a command; its exit code, standard output and standard error."""

    def run(*words):
        code = execute([str(word) for word in words])
        said = capsys.readouterr()
        return code, said.out, said.err

    return run


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / 'mine.yaml'
    path.write_text(PLAN)
    return path


def start(plan, folder):
    command = (sys.executable, '-m', 'qzs_rig.cli.main', 'campaign', plan, '--out', folder)
    return subprocess.Popen(
        [*command, '--format', 'npz', '--workers', '1'],
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {'PYTHONPATH': str(Path(qzs_rig.__file__).parent.parent)},
    )


def chunks_of(folder):
    return len(list((folder / 'chunks').glob('[0-9]*.npz')))


def wait_for_chunks(folder, count):
    deadline = time.monotonic() + 20.0
    while chunks_of(folder) < count:
        assert time.monotonic() < deadline
        time.sleep(0.002)


def test_killed_in_the_middle_and_resumed_is_as_never_killed(told, plan, tmp_path):
    running = start(plan, tmp_path / 'killed')
    wait_for_chunks(tmp_path / 'killed', 3)
    running.kill()
    assert running.wait() == -signal.SIGKILL
    running.stdout.close(), running.stderr.close()
    kept = chunks_of(tmp_path / 'killed')
    assert 3 <= kept < POINTS / 10
    common = ('campaign', plan, '--format', 'npz', '--json', '--no-picture')
    code, out, _ = told(*common, '--out', tmp_path / 'killed')
    again = json.loads(out)
    assert (code, again['kept_before']) == (0, 10 * kept)
    told(*common, '--out', tmp_path / 'whole')
    names = [tmp_path / name / 'table.npz' for name in ('killed', 'whole')]
    assert names[0].read_bytes() == names[1].read_bytes()


def test_ctrl_c_says_how_to_go_on(plan, tmp_path):
    running = start(plan, tmp_path / 'stopped')
    wait_for_chunks(tmp_path / 'stopped', 2)
    running.send_signal(signal.SIGINT)
    _, err = running.communicate(timeout=20)
    assert running.returncode == 1
    kept = chunks_of(tmp_path / 'stopped')
    assert f'stopped with {10 * kept} of 800 points kept in {tmp_path / "stopped"}' in err
    assert 'the same command goes on from there' in err


def test_json_contract(told, plan, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    common = ('campaign', plan, '--json', '--set', 'platform.m=60')
    code, out, err = told(*common)
    document = json.loads(out)
    assert (code, document['schema'], document['points']) == (0, 'qzs_rig/campaign/1', POINTS)
    assert (document['failed'], document['failures'], document['kept_before']) == (0, {}, 0)
    assert document['outputs']['stiffness']['numbers'] == POINTS
    assert document['plan']['base']['platform.m'] == 60
    assert {Path(name).name for name in document['files'].values()} == {
        'table.parquet',
        'quick_look.png',
    }
    assert all(Path(name).is_file() for name in document['files'].values())
    assert 'points   800 in 80 chunks of 10' in err
    # the same command finds its folder again
    code, out, err = told(*common)
    assert 'holds all 800 points already' in err
    again = json.loads(out)
    assert (code, again['kept_before'], again['files']) == (0, POINTS, document['files'])


def test_text_tells_spread_speed_and_files(told, plan, tmp_path):
    common = ('campaign', plan, '--workers', '1', '--no-picture')
    code, out, err = told(*common, '--out', tmp_path / 'out')
    assert 'quick_look' not in out
    assert code == 0
    for words in ('800 points, 0 failed', 'stiffness', 'points/s', 'wrote    '):
        assert words in out
    for words in ('grid of 40 x 20', 'on 1 thread', 'memory ', 'vary     platform.A: 1 … 2'):
        assert words in err


def test_a_dry_run_leaves_no_trace(told, plan, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, _ = told('campaign', plan, '--dry-run')
    assert code == 0 and 'points   800 in 80 chunks' in out and 'a point on one thread' in out
    _, out, _ = told('campaign', plan, '--dry-run', '--scheduler', 'tcp://10.0.0.7:8786')
    assert 'of one core, shared by the cluster at tcp://10.0.0.7:8786' in out
    _, out, err = told('campaign', plan, '--dry-run', '--json')
    assert json.loads(out)['points'] == POINTS and 'memory' in err
    assert list(tmp_path.iterdir()) == [plan]


def test_all_points_failed_is_a_finding(told, tmp_path):
    path = tmp_path / 'bad.yaml'
    path.write_text(
        'campaign: {task: statics}\nbase: {platform.L1: 0.6}\nvary: {platform.L20: [0.5, 0.6]}\n'
    )
    common = ('campaign', path, '--format', 'npz', '--no-picture')
    code, out, _ = told(*common, '--out', tmp_path / 'out')
    assert code == 1
    assert '2 points, 2 failed' in out and 'failed   1 points: InputError: platform.L1' in out
    with np.load(tmp_path / 'out' / 'table.npz') as file:
        assert file['reason'].tolist() == [1, 2]


def test_the_list_names_plans_tasks_and_columns(told):
    code, out, _ = told('campaign', '--list')
    assert code == 0
    for words in ('peak_map', 'Peak, onset and jumps', 'single_term: ', 'output peak_T', 'option'):
        assert words in out
    document = json.loads(told('campaign', '--list', '--json')[1])
    assert document['tasks']['statics']['columns'][0]['name'] == 'dof'


def test_without_matplotlib_there_is_a_caution(told, plan, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    monkeypatch.setitem(sys.modules, 'matplotlib.figure', None)
    code, _, err = told('campaign', plan, '--out', tmp_path / 'out')
    assert code == 0 and "pip install 'qzs_rig[picture]'" in err


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        ((), 'name a plan; known: '),
        (('nope',), "unknown plan 'nope'; known"),
        (('tolerances', '--workers', '0'), '--workers 0 must be 1 or more'),
        (('tolerances', '--workers', '2', '--scheduler', 'tcp://x:1'), 'brings its own workers'),
        (('tolerances', '--set', 'platform.k1=1'), 'platform.k1 is fixed and varied'),
    ],
)
def test_refusals(told, words, said):
    code, out, err = told('campaign', *words)
    assert (code, out) == (2, '')
    assert said in err


def test_help_teaches(capsys):
    with pytest.raises(SystemExit):
        execute(['campaign', '--help'])
    out = capsys.readouterr().out
    for words in ('vary:', 'latin_hypercube', '--scheduler tcp://10.0.0.7:8786', 'kill -9'):
        assert words in out


def test_damaged_chunks_are_told(told, plan, tmp_path):
    running = start(plan, tmp_path / 'out')
    wait_for_chunks(tmp_path / 'out', 2)
    running.kill()
    running.communicate()
    next((tmp_path / 'out' / 'chunks').glob('[0-9]*.npz')).write_bytes(b'')
    common = ('campaign', plan, '--format', 'npz', '--no-picture')
    code, _, err = told(*common, '--out', tmp_path / 'out')
    assert code == 0 and 'caution: 1 damaged chunks were computed again' in err


def test_the_bar_starts_where_the_campaign_goes_on(told, plan, tmp_path, monkeypatch):
    class Bar:
        initial, n = None, 0

        def update(self, more):
            self.n += more

        def close(self):
            pass

    shown = Bar()
    monkeypatch.setattr(campaign, 'bar', lambda *_: shown)
    running = start(plan, tmp_path / 'out')
    wait_for_chunks(tmp_path / 'out', 2)
    running.kill()
    running.communicate()
    kept = chunks_of(tmp_path / 'out')
    told('campaign', plan, '--out', tmp_path / 'out', '--format', 'npz', '--no-picture')
    assert (shown.initial, shown.n) == (10 * kept, POINTS)
