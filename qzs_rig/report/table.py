"""A table with a caption: the same rows for the terminal and for the report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

MISSING = '–'


@dataclass(frozen=True)
class Table:
    """Cells are text as shown. The leading `labels` columns name the row, the rest are numbers."""

    caption: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    labels: int = 2

    def trimmed(self) -> Table:
        """Without the columns that are blank in every row."""
        keep = [k for k in range(len(self.header)) if any(row[k] for row in self.rows)]
        return replace(
            self,
            header=tuple(self.header[k] for k in keep),
            rows=tuple(tuple(row[k] for k in keep) for row in self.rows),
            labels=sum(k < self.labels for k in keep),
        )

    def to_text(self) -> str:
        """Aligned columns under the caption, names left and numbers right."""
        lines = [self.header, *self.rows]
        widths = [max(len(line[k]) for line in lines) for k in range(len(self.header))]
        body = [self._line(line, widths) for line in lines]
        return '\n'.join([self.caption, body[0], '-' * len(body[0]), *body[1:]])

    def _line(self, cells: Sequence[str], widths: Sequence[int]) -> str:
        padded = [
            cell.ljust(width) if k < self.labels else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(cells, widths, strict=True))
        ]
        return '  '.join(padded).rstrip()


def number(value: float | None, pattern: str = '.3f') -> str:
    """`value` by format `pattern`, or a dash where there is none."""
    return MISSING if value is None or math.isnan(value) else format(value, pattern)
