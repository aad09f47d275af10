"""Chunks on threads of this process; compiled kernels release the interpreter."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, as_completed, wait
from dataclasses import dataclass
from itertools import islice

from qzs_rig.campaign import work
from qzs_rig.campaign.part import Part
from qzs_rig.campaign.plan import Plan

AHEAD = 2
"""Chunks handed out a thread: one under way, one waiting. It bounds the memory."""


@dataclass(frozen=True)
class Threads:
    """Runs on `workers` threads."""

    workers: int

    @property
    def text(self) -> str:
        """In words."""
        return f'{self.workers} thread{"s" if self.workers > 1 else ""}'

    def results(self, plan: Plan, numbers: Sequence[int]) -> Iterator[tuple[int, Part]]:
        """(chunk, figures) of the chunks `numbers`, in the order in which they get done.

        On KeyboardInterrupt those under way are still given, the rest is dropped.
        """
        waiting = iter(numbers)
        pending: dict[Future[Part], int] = {}
        with ThreadPoolExecutor(self.workers) as pool:

            def submit(count: int) -> None:
                for number in islice(waiting, count):
                    pending[pool.submit(work.evaluate, plan, number)] = number

            try:
                submit(AHEAD * self.workers)
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
