"""A campaign's folder: the plan, and each chunk as soon as it is done. Survives kill -9.

campaign.json        plan and version
chunks/000017.npz    figures of chunk 17, whole or absent
table.npz            all of it, once the last chunk is there; the chunks are gone then
"""

from __future__ import annotations

import fcntl
import io
import json
import shutil
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from qzs_rig import __version__
from qzs_rig.campaign.finished import SCHEMA
from qzs_rig.campaign.plan import Plan
from qzs_rig.campaign.task import Part
from qzs_rig.errors import InputError
from qzs_rig.files import rewrite

TABLES = ('table.npz', 'table.parquet')


@dataclass(frozen=True)
class Ledger:
    """Keeps the chunks of `plan` in `folder`. Use inside `opened`."""

    folder: Path
    plan: Plan

    @property
    def table(self) -> Path | None:
        """The finished table, None while chunks are missing."""
        return next((p for p in map(self.folder.joinpath, TABLES) if p.is_file()), None)

    def kept(self) -> list[int]:
        """Chunks that are done, ascending."""
        return sorted(int(path.stem) for path in self._chunks.glob('[0-9]*.npz'))

    def keep(self, number: int, part: Part) -> None:
        """Write one chunk; after a crash it is there whole or not at all."""
        page = io.BytesIO()
        words = np.array(part.reasons, dtype=np.str_)
        np.savez(page, code=part.code, reasons=words, **part.columns)  # type: ignore[arg-type]
        rewrite(self._path(number), page.getvalue())

    def column(self, number: int, name: str) -> Any:
        """One column of a kept chunk; also `code` and `reasons`."""
        with np.load(self._path(number)) as file:
            return file[name]

    def sound(self, number: int) -> bool:
        """Can the kept chunk be read, and has it all its rows?"""
        first, stop = self.plan.part(number)
        try:
            with np.load(self._path(number)) as file:
                return set(file.files) == {*self.plan.task.columns, 'code', 'reasons'} and (
                    file['code'].shape == (stop - first,)
                )
        except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile):
            return False

    def forget(self, number: int) -> None:
        """Take a damaged chunk away: it is computed again."""
        self._path(number).unlink()

    def clear(self) -> None:
        """Remove the chunks; the table holds them."""
        shutil.rmtree(self._chunks)

    @property
    def _chunks(self) -> Path:
        return self.folder / 'chunks'

    def _path(self, number: int) -> Path:
        return self._chunks / f'{number:06d}.npz'


@contextmanager
def opened(folder: Path, plan: Plan) -> Iterator[Ledger]:
    """The ledger of `plan` in `folder`, made or found; alone in it until the end.

    Raises InputError where the folder belongs to another plan, to something else, or to a
    campaign at work.
    """
    try:
        _refuse_foreign(folder)
        (folder / 'chunks').mkdir(parents=True, exist_ok=True)
        lock = (folder / '.lock').open('w')
    except OSError as error:
        raise InputError(f'{folder} cannot be written: {error.strerror}; give --out') from error
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise InputError(
                f'another campaign is at work in {folder}; wait for it, or give another --out'
            ) from None
        _sign(folder, plan)
        yield Ledger(folder, plan)


def differences(mine: Any, theirs: Any, name: str = '') -> list[str]:
    """Where two plans differ, leaf by leaf, in words."""
    if isinstance(mine, dict) and isinstance(theirs, dict):
        names = [*mine, *(key for key in theirs if key not in mine)]
        pairs = ((key, mine.get(key), theirs.get(key)) for key in names)
        return [line for key, a, b in pairs for line in differences(a, b, f'{name} {key}'.strip())]
    return [] if mine == theirs else [f'{name} is {_shown(mine)} here, {_shown(theirs)} there']


def _sign(folder: Path, plan: Plan) -> None:
    path = folder / 'campaign.json'
    mine = json.loads(json.dumps({'schema': SCHEMA, 'version': __version__, **plan.document}))
    if not path.exists():
        rewrite(path, json.dumps(mine, indent=1) + '\n')
        return
    try:
        theirs = json.loads(path.read_text(encoding='utf-8'))
    except ValueError as error:
        raise InputError(f'{path} is damaged: {error}; give another --out') from error
    different = differences(mine, theirs)
    if different:
        raise InputError(
            f'{folder} holds another campaign: {"; ".join(different[:5])}. Nothing is '
            'overwritten: give another --out'
        )


def _refuse_foreign(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise InputError(f'{folder} is a file; give another --out')
    # a crash before the plan was written leaves no more than these
    ours = {'.lock', 'chunks', '.campaign.json.partial'}
    if folder.is_dir() and not (folder / 'campaign.json').exists():
        strange = sorted(path.name for path in folder.iterdir() if path.name not in ours)
        if strange:
            raise InputError(
                f'{folder} is no campaign, it holds {strange[0]}; nothing is overwritten: give '
                'another --out'
            )


def _shown(value: Any) -> str:
    return 'unset' if value is None else json.dumps(value)
