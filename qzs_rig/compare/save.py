"""Writing a result file: whole or not at all, and never over another."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from qzs_rig.errors import InputError


def refuse_existing(path: Path) -> None:
    """Raises InputError when `path` is taken."""
    if os.path.lexists(path):
        raise InputError(
            f'{path} exists and is never overwritten; choose another folder with --out'
        )


def write_new(path: Path, content: bytes) -> None:
    """Create `path` with `content`; readers see it complete or not at all.

    Raises InputError when the file exists or its folder cannot take it.
    """
    refuse_existing(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f'.{path.name}.', dir=path.parent)
    except OSError as error:
        raise InputError(f'cannot write {path}: {error.strerror}; choose another --out') from error
    draft = Path(name)
    try:
        with os.fdopen(handle, 'wb') as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        draft.chmod(0o644)
        _claim(draft, path)
    except OSError as error:
        raise InputError(f'cannot write {path}: {error.strerror}; choose another --out') from error
    finally:
        draft.unlink(missing_ok=True)


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
