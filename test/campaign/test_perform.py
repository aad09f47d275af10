"""A campaign gives the same table however it was computed, and keeps what it has."""

from __future__ import annotations

import _thread
import json
import signal
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from campaign_plans import statics

from qzs_rig import __version__
from qzs_rig.campaign import ledger as ledgers
from qzs_rig.campaign import plan, table_file
from qzs_rig.campaign.finished import quick_look, summary, summary_text
from qzs_rig.campaign.perform import perform
from qzs_rig.campaign.runners import Threads, evaluate
from qzs_rig.errors import InputError
from qzs_rig.mechanics.platform import platform_design
from qzs_rig.report.still import still

FORMATS = table_file.FORMATS


class Stopping:
    """Threads whose operator presses Ctrl-C after `chunks` chunks."""

    text = 'threads, for a while'

    def __init__(self, chunks):
        self.chunks = chunks

    def results(self, plan, numbers):
        for count, result in enumerate(Threads(1).results(plan, numbers)):
            if count == self.chunks:
                raise KeyboardInterrupt
            yield result


def done(plan, folder, runner=None, kind='npz'):
    return perform(plan, folder, runner or Threads(2), kind, lambda points: None)


@pytest.mark.parametrize('kind', FORMATS)
def test_the_table_is_the_same_to_the_last_byte(tmp_path, kind):
    whole = done(statics(), tmp_path / 'one', Threads(1), kind).table.path.read_bytes()
    assert done(statics(), tmp_path / 'four', Threads(4), kind).table.path.read_bytes() == whole
    for chunks in (1, 3):
        with pytest.raises(KeyboardInterrupt):
            done(statics(), tmp_path / 'stopped', Stopping(chunks), kind)
    again = done(statics(), tmp_path / 'stopped', Threads(2), kind)
    assert again.kept == 40  # four chunks of ten
    assert again.table.path.read_bytes() == whole
    assert sorted(path.name for path in (tmp_path / 'stopped').iterdir()) == [
        '.lock',
        'campaign.json',
        again.table.path.name,
    ]


@pytest.mark.parametrize('kind', FORMATS)
def test_the_table_holds_points_figures_reasons_and_the_plan(tmp_path, kind):
    wanted = statics(seed=11)
    finished = done(wanted, tmp_path, kind=kind).table
    points, part = wanted.between(0, 62), evaluate(statics(chunk=62, seed=11), 0)
    for name, column in {**points.varied, **part.columns}.items():
        np.testing.assert_array_equal(finished.column(name), column)
    bad = points.varied['platform.L20'] <= 0.6 * np.sqrt(3) / 2
    assert np.isnan(finished.column('stiffness')[bad]).all() and bad.any()
    assert np.isfinite(finished.column('stiffness')[~bad]).all()
    assert sum(finished.failures().values()) == bad.sum()
    assert all('springs would not incline' in reason for reason in finished.failures())
    told = finished.about
    assert plan.of(told['plan']) == wanted
    assert (told['version'], told['plan']['campaign']['seed']) == (__version__, 11)
    assert told['varied']['platform.L20']['unit'] == 'm'
    assert told['outputs']['stiffness']['text'].startswith('stiffness at the working point')


def test_figures_are_those_of_the_point(tmp_path):
    wanted = statics()
    finished = done(wanted, tmp_path).table
    spec = wanted.between(40, 41).spec(0)
    A, k3, *_, a, _ = platform_design(spec)
    assert finished.column('qzs_residual')[40] == pytest.approx(1 + A - A / a + k3, abs=1e-15)


def test_parquet_carries_units(tmp_path):
    from pyarrow import parquet

    path = done(statics(), tmp_path, kind='parquet').table.path
    schema = parquet.read_schema(path)
    assert schema.field('platform.L20').metadata[b'unit'] == b'm'
    reasons = parquet.read_table(path).column('reason').to_pylist()
    assert len(reasons) == 62 and reasons[-1] == ''


def test_a_finished_campaign_is_told_and_not_computed(tmp_path):
    first = done(statics(), tmp_path)
    stamp = first.table.path.stat().st_mtime_ns
    again = done(statics(), tmp_path, Stopping(0), None)
    assert (again.kept, again.first_s) == (62, None)
    assert first.table.path.stat().st_mtime_ns == stamp
    with pytest.raises(InputError, match=r'table.npz is complete; .* leave out --format'):
        done(statics(), tmp_path, kind='parquet')


def test_a_changed_plan_is_refused_with_the_difference(tmp_path):
    done(statics(), tmp_path)
    with pytest.raises(InputError, match=r'another campaign: campaign seed is 1 here, 0 there'):
        done(statics(seed=1), tmp_path)
    other = statics(vary={'platform.L20': {'from': 0.5, 'to': 0.7, 'count': 3}})
    with pytest.raises(InputError, match=r'count is 3 here, 31 there; vary dof is unset here'):
        done(other, tmp_path)


def test_another_version_is_another_campaign(tmp_path):
    done(statics(), tmp_path)
    path = tmp_path / 'campaign.json'
    path.write_text(json.dumps(json.loads(path.read_text()) | {'version': '0.0.9'}))
    with pytest.raises(InputError, match=r'version is ".*" here, "0.0.9" there'):
        done(statics(), tmp_path)
    path.write_text('{')
    with pytest.raises(InputError, match=r'campaign.json is damaged'):
        done(statics(), tmp_path)


def test_foreign_folders_are_left_alone(tmp_path):
    (tmp_path / 'thesis.tex').write_text('years of work')
    with pytest.raises(InputError, match=r'is no campaign, it holds thesis.tex'):
        done(statics(), tmp_path)
    with pytest.raises(InputError, match=r'thesis.tex is a file'):
        done(statics(), tmp_path / 'thesis.tex')
    with pytest.raises(InputError, match=r'cannot be written: .*; give --out'):
        done(statics(), tmp_path / ('x' * 300))


def test_one_campaign_at_a_time(tmp_path):
    with (
        ledgers.opened(tmp_path, statics()),
        pytest.raises(InputError, match='another campaign is at work in'),
    ):
        done(statics(), tmp_path)


def test_damaged_chunks_are_computed_again(tmp_path):
    whole = done(statics(), tmp_path / 'whole').table.path.read_bytes()
    with pytest.raises(KeyboardInterrupt):
        done(statics(), tmp_path / 'part', Stopping(4))
    chunks = sorted((tmp_path / 'part' / 'chunks').glob('*.npz'))
    chunks[0].write_bytes(chunks[0].read_bytes()[:-40])
    chunks[1].write_bytes(b'')
    (tmp_path / 'part' / 'chunks' / '.000003.npz.partial').write_bytes(b'half')
    again = done(statics(), tmp_path / 'part')
    assert (again.damaged, again.kept) == (2, 20)
    assert again.table.path.read_bytes() == whole


@pytest.fixture
def ctrl_c():
    """Ctrl-C as in a terminal: a shell that starts jobs in the background has it ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield _thread.interrupt_main
    signal.signal(signal.SIGINT, before)


def waits_for_results(thread):
    """Whether this thread has handed out its chunks and sleeps until one is done."""
    frame = sys._current_frames().get(thread.ident)
    names = []
    while frame:
        names.append((Path(frame.f_code.co_filename).name, frame.f_code.co_name))
        frame = frame.f_back
    return ('_base.py', 'wait') in names and ('runners.py', 'results') in names


def test_ctrl_c_keeps_what_is_under_way(ctrl_c):
    started, go = threading.Event(), threading.Event()

    class Slow:
        def evaluate(self, points, options):
            started.set()
            assert go.wait(10)
            return points.first

    class Plan:
        task, options = Slow(), None

        def part(self, number):
            return number, number + 1

        def between(self, first, stop):
            return type('Points', (), {'first': first})

    results = Threads(1).results(Plan(), range(5))
    found = []

    def press():
        started.wait(10)
        until = time.monotonic() + 10
        while not waits_for_results(threading.main_thread()) and time.monotonic() < until:
            time.sleep(0.001)
        ctrl_c()
        go.set()

    threading.Thread(target=press).start()
    with pytest.raises(KeyboardInterrupt):
        found.extend(results)
    assert (0, 0) in found
    assert len(found) < 5


def test_the_summary_counts_and_spreads(tmp_path):
    finished = done(statics(), tmp_path).table
    found = summary(finished)
    values = finished.column('stiffness')
    good = values[np.isfinite(values)]
    assert found['outputs']['stiffness'] == {
        'unit': '',
        'numbers': good.size,
        'min': good.min(),
        'median': np.median(good),
        'max': good.max(),
    }
    assert found['failed'] == 62 - good.size
    text = summary_text(found)
    assert f'62 points, {found["failed"]} failed' in text
    assert 'more reasons' not in text
    assert all(reason in text for reason in found['failures'])
    json.dumps(found, allow_nan=False)


@pytest.mark.parametrize(
    'vary',
    [
        {'platform.A': {'from': 1.0, 'to': 2.0, 'count': 30}},
        {'platform.A': {'from': 1.0, 'to': 2.0, 'count': 5}, 'platform.k3_hat': [0.1, 0.5]},
        {'dof': ['vertical', 'horizontal'], 'platform.A': [1.0, 1.1]},
        {'platform.A': [1.0, 1.1], 'platform.k3_hat': [0.1, 0.5], 'platform.L1_hat': [0.8, 0.9]},
        {'platform.L1_hat': [2.0e-9]},
    ],
    ids=['line', 'map', 'words', 'dots', 'one point'],
)
def test_the_quick_look_is_drawn(tmp_path, vary):
    wanted = statics(vary=vary)
    drawn = still(quick_look(wanted, done(wanted, tmp_path).table, 'look'), 'png')
    assert drawn.startswith(b'\x89PNG')


def test_the_quick_look_of_a_hypercube_over_two_axes_is_drawn(tmp_path):
    vary = {'platform.A': {'from': 1.0, 'to': 2.0}, 'platform.k3_hat': {'from': 0.1, 'to': 1.0}}
    wanted = statics(vary=vary, sample='latin_hypercube', samples=30)
    drawn = still(quick_look(wanted, done(wanted, tmp_path).table, 'look'), 'png')
    assert drawn.startswith(b'\x89PNG')


def test_parquet_without_pyarrow_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(table_file, 'find_spec', lambda name: None)
    assert table_file.format_of(None) == 'npz'
    with pytest.raises(InputError, match=r"pip install 'qzs_rig\[campaign\]', or --format npz"):
        done(statics(), tmp_path, kind='parquet')
