"""Chunks on an existing dask.distributed cluster."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

from qzs_rig import __version__
from qzs_rig.campaign import work
from qzs_rig.campaign.part import Part
from qzs_rig.campaign.plan import Plan
from qzs_rig.errors import InputError, PeerError

AHEAD = 4
"""Chunks handed out a thread of the cluster: enough that none waits for the way there and back."""
WAIT = 10.0
"""Seconds after which a scheduler or worker that does not answer is missing."""
FIGURES = ('numpy', 'numba')
"""Packages whose version may change the last bits of a figure."""


@dataclass(frozen=True)
class Cluster:
    """Runs on the workers of the scheduler at `address`, for instance tcp://10.0.0.7:8786.

    Workers are sent the plan as text and a chunk's number; they generate the points, reduce them
    to the outputs, and send these back. A chunk whose worker dies is computed by another one.
    """

    address: str

    @property
    def text(self) -> str:
        """In words."""
        return f'the cluster at {self.address}'

    def results(self, plan: Plan, numbers: Sequence[int]) -> Iterator[tuple[int, Part]]:
        """(chunk, figures) of the chunks `numbers`, in the order in which they get done."""
        from distributed import KilledWorker, as_completed

        client = connected(self.address)
        try:
            refuse_unequal(client)
            text, waiting = plan.text, iter(numbers)

            def submit(number: int) -> Any:
                key = f'qzs_rig-{plan.fingerprint}-{number}'
                return client.submit(work.evaluate_text, text, number, key=key)

            window = AHEAD * max(1, sum(client.nthreads().values()))
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
    rig, of the task's packages, or none at all."""
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
    """Versions, here, of what decides a figure."""
    from importlib import metadata

    found = {'qzs_rig': __version__}
    for name in FIGURES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = 'not installed'
    return found
