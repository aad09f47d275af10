"""The paper's figures of transmissibility, drawn by the rig. A new one is one function and one line
here."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from qzs_rig.paper_figures import computed, measured, write

FIGURES: dict[str, Callable[[Path], list[Path]]] = {
    '19': lambda folder: write.computed(folder, computed.damping()),
    '20': lambda folder: write.computed(folder, computed.length()),
    '22': lambda folder: write.measured(folder, measured.against_linear()),
    '23': lambda folder: write.measured(folder, measured.directions()),
}
"""Each writes its files into a folder and names them."""
