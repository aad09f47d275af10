"""Files of results: whole or not at all, new and never over another; numbers as JSON has them."""

from __future__ import annotations

import json
import math
import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from qzs_rig.errors import InputError


def write_new(path: Path, content: bytes | str) -> Path:
    """Create `path`, and its folder, with `content`; readers see it complete or not at all.

    Raises InputError where the file exists or its folder cannot take it.
    """
    refuse_existing(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        draft = _draft(path, content)
        try:
            _claim(draft, path)
        finally:
            draft.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f'cannot write {path}: {error.strerror}; give another place') from error
    return path


def write_new_json(path: Path, document: dict[str, Any]) -> Path:
    """`write_new` for JSON; numbers that are not finite are a bug and raise ValueError."""
    return write_new(path, json.dumps(document, allow_nan=False, indent=1) + '\n')


@contextmanager
def rewriting(path: Path) -> Iterator[Path]:
    """Where to write a new version of `path`, a file that is the caller's own; it takes the place
    of the older one, if there is one, when the block ends well."""
    draft = path.with_name(f'.{path.name}.partial')
    yield draft
    with draft.open('rb') as file:
        os.fsync(file.fileno())
    draft.replace(path)


def rewrite(path: Path, content: bytes | str) -> None:
    """A new version of `path`, a file that is the caller's own; complete or not at all."""
    with rewriting(path) as draft:
        draft.write_bytes(_encoded(content))


def refuse_existing(path: Path) -> None:
    """Raises InputError where `path` is taken."""
    if os.path.lexists(path):
        raise InputError(f'{path} is already there; nothing is overwritten: give another name')


def refuse_occupied(folder: Path) -> None:
    """Raises InputError where `folder` is a file or holds anything."""
    if folder.is_file() or (folder.is_dir() and any(folder.iterdir())):
        raise InputError(f'{folder} is occupied; nothing is overwritten: give another --out')


def finite_or_none(values: Iterable[float]) -> list[float | None]:
    """`values` for JSON, which knows no NaN: None for what is not finite."""
    return [number_or_none(value) for value in values]


def number_or_none(value: float) -> float | None:
    """`value` for JSON: None where it is not finite."""
    return float(value) if math.isfinite(value) else None


def _draft(path: Path, content: bytes | str) -> Path:
    """`content` on the disk, under a name beside `path` that nobody else has."""
    handle, name = tempfile.mkstemp(prefix=f'.{path.name}.', dir=path.parent)
    draft = Path(name)
    try:
        with os.fdopen(handle, 'wb') as file:
            file.write(_encoded(content))
            file.flush()
            os.fsync(file.fileno())
        draft.chmod(0o644)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise
    return draft


def _encoded(content: bytes | str) -> bytes:
    return content if isinstance(content, bytes) else content.encode()


def _claim(draft: Path, path: Path) -> None:
    """Give `draft` its name: a link fails where a second writer was faster, a rename would not."""
    try:
        os.link(draft, path)
    except FileExistsError:
        refuse_existing(path)
    except OSError:
        # No hard links on this file system (FAT, some network shares).
        refuse_existing(path)
        draft.replace(path)
