"""The files of a result: page, pictures, CSV and NPZ. Nothing is overwritten."""

from __future__ import annotations

import io
import sys
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from qzs_rig.files import refuse_existing, write_new
from qzs_rig.report.page import Part, page
from qzs_rig.report.sheet import Sheet
from qzs_rig.report.still import still

KINDS = ('svg', 'png')


def write_page(path: Path, title: str, parts: Sequence[Part]) -> Path:
    """`path`, a page that needs nothing but itself; `parts` as of `report.page`."""
    refuse_existing(path)
    return write_new(path, page(title, parts))


def drawable() -> bool:
    """Can pictures be drawn? If matplotlib is not installed, stderr says so."""
    if find_spec('matplotlib') is not None:
        return True
    text = "caution: figures as SVG and PNG need matplotlib; pip install 'qzs_rig[picture]'"
    print(text, file=sys.stderr)
    return False


def pictures(folder: Path, sheets: Sequence[Sheet]) -> list[Path]:
    """Each sheet as SVG and PNG in `folder`; none, and a word on stderr, where matplotlib is not
    installed."""
    if not drawable():
        return []
    return [
        write_new(folder / f'{sheet.name}.{kind}', still(sheet, kind))
        for sheet in sheets
        for kind in KINDS
    ]


def csv(folder: Path, name: str, header: Sequence[str], columns: Sequence[ArrayLike]) -> Path:
    """`name`.csv; numbers read back as the same numbers."""
    rows = zip(*(np.asarray(column).tolist() for column in columns), strict=True)
    lines = [','.join(header), *(','.join(_cell(value) for value in row) for row in rows)]
    return write_new(folder / f'{name}.csv', '\n'.join(lines) + '\n')


def npz(folder: Path, name: str, arrays: Mapping[str, ArrayLike]) -> Path:
    """`name`.npz."""
    page = io.BytesIO()
    np.savez_compressed(page, **arrays)  # type: ignore[arg-type]
    return write_new(folder / f'{name}.npz', page.getvalue())


def _cell(value: object) -> str:
    return value if isinstance(value, str) else repr(value)
