"""The paper's dynamic figures, drawn by the rig. A new one is one function and one line here."""

from __future__ import annotations

from collections.abc import Callable

from qzs_rig.paper_figures import measured
from qzs_rig.paper_figures.measured import Measured

FIGURES: dict[str, Callable[[], Measured]] = {
    '22': measured.against_linear,
    '23': measured.directions,
}
