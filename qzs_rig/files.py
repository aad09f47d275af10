"""Files of results: whole or not at all, new and never over another; numbers as JSON has them."""

from __future__ import annotations

import json
import math
import os
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from qzs_rig.errors import InputError


def write_new(path: Path, content: bytes | str) -> Path:
    """Create `path`, and its folder, with `content`; readers see it complete or not at all.

    Raises InputError where the file exists or its folder cannot take it.
    """
    refuse_existing(path)
    with _drafted(path, uuid.uuid4().hex[:8]) as draft:
        draft.write_bytes(_encoded(content))
        _sync(draft)
        _claim(draft, path)
    return path


def write_new_json(path: Path, document: dict[str, Any]) -> Path:
    """`write_new` for JSON; numbers that are not finite are a bug and raise ValueError."""
    return write_new(path, json.dumps(document, allow_nan=False, indent=1) + '\n')


@contextmanager
def rewriting(path: Path) -> Iterator[Path]:
    """Where to write a new version of `path`, a file that is the caller's own; it takes the place
    of the older one, if there is one, when the block ends well. Raises InputError as `write_new`.
    """
    with _drafted(path, 'partial') as draft:
        yield draft
        _sync(draft)
        draft.replace(path)


def rewrite(path: Path, content: bytes | str) -> None:
    """A new version of `path`, a file that is the caller's own; complete or not at all."""
    with rewriting(path) as draft:
        draft.write_bytes(_encoded(content))


def refuse_existing(path: Path) -> None:
    """Raises InputError where `path` is taken."""
    if os.path.lexists(path):
        raise InputError(f'{path} is already there; nothing is overwritten: give another --out')


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


@contextmanager
def _drafted(path: Path, mark: str) -> Iterator[Path]:
    """A name beside `path` for what is not whole yet; gone when the block ends."""
    draft = path.with_name(f'.{path.name}.{mark}')
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield draft
    except OSError as error:
        raise InputError(f'cannot write {path}: {error.strerror}; give another --out') from error
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def _sync(draft: Path) -> None:
    with draft.open('rb') as file:
        os.fsync(file.fileno())


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
