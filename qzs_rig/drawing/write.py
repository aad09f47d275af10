"""Sheets as picture files. Nothing is overwritten."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from qzs_rig.drawing.sheet import Sheet
from qzs_rig.drawing.still import still
from qzs_rig.files import write_new


def pictures(folder: Path, sheets: Sequence[Sheet]) -> list[Path]:
    """Each sheet as SVG and PNG; raises ImportError where matplotlib is not installed."""
    paths = []
    for sheet in sheets:
        for kind in ('svg', 'png'):
            paths.append(folder / f'{sheet.name}.{kind}')
            write_new(paths[-1], still(sheet, kind))
    return paths
