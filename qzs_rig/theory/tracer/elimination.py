"""A small dense system, factorised once and solved often, without allocation.

Plain loops over rows: numba makes vector code of them, the interpreter takes lists of lists.
"""

from __future__ import annotations

from typing import Any


def eliminate(rows: Any, order: Any) -> None:
    """Factorise the square `rows` in place, L below the diagonal; `order` says who was swapped.

    A singular matrix leaves very large numbers, which the caller's residual then shows.
    """
    n = len(rows)
    for column in range(n):
        best = column
        for row in range(column + 1, n):
            if abs(rows[row][column]) > abs(rows[best][column]):
                best = row
        order[column] = best
        pivot, other = rows[column], rows[best]
        if best != column:
            for c in range(n):
                pivot[c], other[c] = other[c], pivot[c]
        if pivot[column] == 0.0:
            pivot[column] = 1e-300
        head = pivot[column]
        for row in range(column + 1, n):
            line = rows[row]
            factor = line[column] / head
            line[column] = factor
            for c in range(column + 1, n):
                line[c] -= factor * pivot[c]


def orientation(rows: Any, order: Any) -> float:
    """Sign of the determinant of what `eliminate` factorised."""
    sign = 1.0
    for row in range(len(rows)):
        if (rows[row][row] < 0.0) != (order[row] != row):
            sign = -sign
    return sign


def substitute(rows: Any, order: Any, x: Any) -> None:
    """Turn the right-hand side `x` into the solution, with what `eliminate` left."""
    n = len(rows)
    for row in range(n):
        other = order[row]
        x[row], x[other] = x[other], x[row]
    for row in range(n):
        line, value = rows[row], x[row]
        for c in range(row):
            value -= line[c] * x[c]
        x[row] = value
    for row in range(n - 1, -1, -1):
        line, value = rows[row], x[row]
        for c in range(row + 1, n):
            value -= line[c] * x[c]
        x[row] = value / line[row]
