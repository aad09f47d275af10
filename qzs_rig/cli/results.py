"""Figures, CSV and NPZ of a theory command into its --out folder. Nothing is overwritten."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from qzs_rig.files import write_new


def pictures(folder: Path, name: str, draw: Callable[[str], bytes]) -> list[Path]:
    """`name`.png and `name`.svg; a word on stderr where matplotlib is missing."""
    paths = []
    try:
        for kind in ('png', 'svg'):
            content = draw(kind)
            paths.append(folder / f'{name}.{kind}')
            write_new(paths[-1], content)
    except ImportError:
        print("caution: figures need matplotlib; pip install 'qzs_rig[picture]'", file=sys.stderr)
    return paths


def csv(folder: Path, name: str, header: Sequence[str], columns: Sequence[ArrayLike]) -> Path:
    """`name`.csv; numbers read back as the same numbers."""
    rows = zip(*(np.asarray(column).tolist() for column in columns), strict=True)
    lines = [','.join(header), *(','.join(_cell(value) for value in row) for row in rows)]
    path = folder / f'{name}.csv'
    write_new(path, ('\n'.join(lines) + '\n').encode())
    return path


def npz(folder: Path, name: str, arrays: Mapping[str, ArrayLike]) -> Path:
    """`name`.npz."""
    page = io.BytesIO()
    np.savez_compressed(page, **arrays)  # type: ignore[arg-type]
    path = folder / f'{name}.npz'
    write_new(path, page.getvalue())
    return path


def _cell(value: object) -> str:
    return value if isinstance(value, str) else repr(value)
