"""Who computes the chunks of a plan: threads of this process, or a dask cluster."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, as_completed, wait
from dataclasses import dataclass
from functools import lru_cache
from importlib import metadata
from itertools import islice
from typing import Any, Protocol

from qzs_rig import __version__
from qzs_rig.campaign import plan as plans
from qzs_rig.campaign.plan import Plan
from qzs_rig.campaign.task import Part
from qzs_rig.errors import InputError, PeerError
from qzs_rig.theory.balance.newton import one_thread

WAIT = 10.0
"""Seconds after which a scheduler or worker that does not answer is missing."""


class Runner(Protocol):
    """Threads or Cluster."""

    @property
    def text(self) -> str:
        """Who computes, as the plan of a campaign is announced."""

    @property
    def ahead(self) -> int:
        """Chunks under way at once, whose figures are held in memory here."""

    def results(self, plan: Plan, numbers: Sequence[int]) -> Iterator[tuple[int, Part]]:
        """(chunk, figures) of the chunks `numbers`, in the order in which they get done."""


def evaluate(plan: Plan, number: int) -> Part:
    """The figures of chunk `number`, reduced to the task's outputs."""
    return plan.task.evaluate(plan.between(*plan.part(number)), plan.options)


@dataclass(frozen=True)
class Threads:
    """`workers` threads of this process; compiled kernels release the interpreter.

    On KeyboardInterrupt the chunks under way are still given, the rest is dropped.
    """

    workers: int

    @property
    def text(self) -> str:
        """As in `2 threads`."""
        return f'{self.workers} thread{"s" if self.workers > 1 else ""}'

    @property
    def ahead(self) -> int:
        """For each thread one chunk under way, and one waiting."""
        return 2 * self.workers

    def results(self, plan: Plan, numbers: Sequence[int]) -> Iterator[tuple[int, Part]]:
        """(chunk, figures), see Runner."""
        waiting = iter(numbers)
        pending: dict[Future[Part], int] = {}
        with ThreadPoolExecutor(self.workers) as pool:

            def submit(count: int) -> None:
                for number in islice(waiting, count):
                    pending[pool.submit(evaluate, plan, number)] = number

            try:
                submit(self.ahead)
                while pending:
                    done, _ = wait(pending, return_when=FIRST_COMPLETED)
                    submit(len(done))
                    for future in done:
                        yield pending.pop(future), future.result()
            except KeyboardInterrupt:
                left = {f: number for f, number in pending.items() if not f.cancel()}
                for future in as_completed(left):
                    yield left[future], future.result()
                raise
            finally:
                pool.shutdown(wait=False, cancel_futures=True)


@dataclass(frozen=True)
class Cluster:
    """The workers of the dask scheduler at `address`, for instance tcp://10.0.0.7:8786.

    Workers are sent the plan as text and a chunk's number; they generate the points, reduce them
    to the outputs, and send these back. A chunk whose worker dies is computed by another one.
    """

    address: str
    ahead: int = 4
    """A thread of the cluster: enough that none waits for the way there and back."""

    @property
    def text(self) -> str:
        """As in `the cluster at tcp://10.0.0.7:8786`."""
        return f'the cluster at {self.address}'

    def results(self, plan: Plan, numbers: Sequence[int]) -> Iterator[tuple[int, Part]]:
        """(chunk, figures), see Runner."""
        from distributed import KilledWorker, as_completed

        client = connected(self.address)
        try:
            refuse_unequal(client)
            text, waiting = plan.text, iter(numbers)

            def submit(number: int) -> Any:
                key = f'qzs_rig-{plan.fingerprint}-{number}'
                return client.submit(_evaluate_text, text, number, key=key)

            window = self.ahead * max(1, sum(client.nthreads().values()))
            numbered = {submit(n): n for n in islice(waiting, window)}
            done = as_completed(numbered, loop=client.loop, with_results=True)
            for future, part in done:
                yield numbered.pop(future), part
                for number in islice(waiting, 1):
                    following = submit(number)
                    numbered[following] = number
                    done.add(following)
        except KilledWorker as error:
            raise PeerError(
                f'chunk after chunk killed its worker ({error}); give the workers more memory, or '
                'campaign: chunk a smaller number'
            ) from error
        finally:
            # futures under way are released with their client
            client.close()


def connected(address: str) -> Any:
    """A client of the scheduler; InputError where there is none, or it has no workers."""
    try:
        from distributed import Client
    except ImportError as error:
        raise InputError(
            "--scheduler needs dask.distributed: pip install 'qzs_rig[campaign]'"
        ) from error
    if not re.fullmatch(r'\w+://\S+', address):
        raise InputError(f'--scheduler {address!r} is no address; write tcp://HOST:8786')
    try:
        client = Client(address, timeout=WAIT, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(
            f'no scheduler answers at {address} ({error}); start one with: dask scheduler'
        ) from error
    if not client.nthreads():
        client.close()
        raise InputError(
            f'the scheduler at {address} has no workers; start some with: dask worker {address}'
        )
    return client


def refuse_unequal(client: Any) -> None:
    """InputError where a worker cannot compute what this process would: another version of the
    rig, of the packages that it computes with, or none at all."""
    mine = versions()
    try:
        theirs = client.run(versions)
    except ImportError as error:
        raise InputError(
            f'the workers have no qzs_rig ({error}); install version {__version__} there'
        ) from error
    for worker, found in theirs.items():
        for name, version in mine.items():
            if found[name] != version:
                raise InputError(
                    f'worker {worker} has {name} {found[name]}, here is {version}: figures would '
                    'differ by where they were computed; install the same on both'
                )


def versions() -> dict[str, str]:
    """Versions, here, of what decides the last bits of a figure."""
    packages = {name: metadata.version(name) for name in ('numpy', 'scipy', 'numba')}
    return {'qzs_rig': __version__, **packages}


@one_thread
def _evaluate_text(text: str, number: int) -> Part:
    """`evaluate` of the plan whose `text` a worker of a cluster is sent."""
    return evaluate(_read(text), number)


@lru_cache(maxsize=2)
def _read(text: str) -> Plan:
    return plans.of(json.loads(text))
