"""A campaign on a dask cluster of two processes gives the bytes that threads give."""

from __future__ import annotations

import builtins
import os
import signal
import time
from types import SimpleNamespace

import pytest
from campaign_plans import statics

from qzs_rig.campaign import runners
from qzs_rig.campaign.perform import perform
from qzs_rig.campaign.runners import Cluster, Threads, refuse_unequal
from qzs_rig.errors import InputError, PeerError


@pytest.fixture(scope='module')
def workers():
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        host='127.0.0.1',
        dashboard_address=None,
        silence_logs=50,
    ) as made:
        yield made


def table_of(plan, folder, runner, progress=lambda points: None):
    return perform(plan, folder, runner, 'npz', progress).table.path.read_bytes()


def test_the_bytes_are_those_of_threads_with_two_workers_one_and_a_dead_one(workers, tmp_path):
    wanted = statics(chunk=4)
    here = table_of(wanted, tmp_path / 'here', Threads(2))
    there = Cluster(workers.scheduler_address)
    assert table_of(wanted, tmp_path / 'two', there) == here
    victim = next(iter(workers.workers.values())).pid
    deaths = []

    def kill_one(points):
        if points and not deaths:
            deaths.append(os.kill(victim, signal.SIGKILL))

    assert table_of(wanted, tmp_path / 'dead', there, kill_one) == here
    assert deaths
    workers.scale(1)
    deadline = time.monotonic() + 10.0
    while len(workers.scheduler_info['workers']) != 1:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    assert table_of(wanted, tmp_path / 'one', there) == here


def test_no_scheduler_is_said(monkeypatch):
    monkeypatch.setattr(runners, 'WAIT', 0.2)
    with pytest.raises(InputError, match=r'no scheduler answers at tcp://127.0.0.1:1 '):
        runners.connected('tcp://127.0.0.1:1')
    with pytest.raises(InputError, match=r'no scheduler answers at nonsense://x'):
        runners.connected('nonsense://x')


def test_dask_missing_is_said(monkeypatch):
    plain = builtins.__import__

    def without(name, *more):
        if name == 'distributed':
            raise ImportError(name)
        return plain(name, *more)

    monkeypatch.setattr(builtins, '__import__', without)
    with pytest.raises(InputError, match=r"needs dask.distributed: pip install 'qzs_rig\[camp"):
        runners.connected('tcp://127.0.0.1:1')


class Client:
    """Stands for a cluster whose workers answer `run` with this."""

    def __init__(self, answer):
        self.answer = answer

    def run(self, function):
        if isinstance(self.answer, Exception):
            raise self.answer
        return {'tcp://w:1': function() | self.answer}


def test_workers_with_other_versions_are_refused():
    refuse_unequal(Client({}))
    with pytest.raises(InputError, match=r'worker tcp://w:1 has numpy 1.0, here is .*same on both'):
        refuse_unequal(Client({'numpy': '1.0'}))
    with pytest.raises(InputError, match=r'the workers have no qzs_rig'):
        refuse_unequal(Client(ImportError('qzs_rig')))


def test_a_scheduler_without_workers_is_said(monkeypatch):
    import distributed

    class Empty:
        def __init__(self, address, **_):
            pass

        def nthreads(self):
            return {}

        def close(self):
            pass

    monkeypatch.setattr(distributed, 'Client', Empty)
    with pytest.raises(InputError, match=r'has no workers; start some with: dask worker tcp://s'):
        runners.connected('tcp://s')


def test_a_chunk_that_kills_its_workers_is_said(monkeypatch):
    from distributed import KilledWorker

    class Killing(Client):
        def nthreads(self):
            raise KilledWorker('chunk', SimpleNamespace(address='tcp://w'), 3)

        def close(self):
            pass

    monkeypatch.setattr(runners, 'connected', lambda address: Killing({}))
    with pytest.raises(PeerError, match=r'killed its worker .* campaign: chunk a smaller number'):
        list(Cluster('tcp://s').results(statics(), [0]))


def test_a_word_that_is_no_address_is_refused_at_once():
    with pytest.raises(InputError, match=r"'bogus' is no address; write tcp://HOST:8786"):
        runners.connected('bogus')
