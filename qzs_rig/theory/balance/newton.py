"""Newton's way to solutions of any equations with one parameter, and the tangent of their path.

Keller (1977). Lengths are relative: motions over their own size, parameters by their logarithm.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, wraps
from typing import Any, ParamSpec, Protocol, TypeVar

import numpy as np

from qzs_rig.samples import Array

In = ParamSpec('In')
Out = TypeVar('Out')


class Equations(Protocol):
    """R(x, p) = 0 in as many unknowns x (n,) as equations; p is the logarithm of a parameter."""

    def linearised(self, x: Array, p: float) -> tuple[Array, Array, Array]:
        """R (n,), its slope in x (n, n) and in p (n,)."""


@dataclass(frozen=True)
class Point:
    """A solution x (n,) at p, and the unit tangent of its path: x part (n,) over `size`, then p.

    `size` is what x is measured by around here. `side` is the sign of the determinant of the slope
    with the plane of the step below it: the same all along a path that crosses no other.
    """

    x: Array
    p: float
    tangent: Array
    size: float
    side: float = 0.0


@np.errstate(all='ignore')
def solve(
    equations: Equations, x: Array, p: float, tolerance: float = 1e-10, iterations: int = 30
) -> Array | None:
    """Newton at fixed p from x (n,); None where it does not converge."""
    x = np.array(x)
    for _ in range(iterations):
        residual, jacobian, _ = equations.linearised(x, p)
        move = _solved(jacobian, residual)
        if move is None:
            return None
        x -= move
        size = float(np.linalg.norm(x))
        if float(np.linalg.norm(move)) <= math.sqrt(tolerance) * 0.1 * size:
            return x
    return None


@np.errstate(all='ignore')
def start(equations: Equations, x: Array, p: float, direction: float) -> Point:
    """The point of a solution, its tangent heading where p grows (`direction` > 0) or falls."""
    size = float(np.linalg.norm(x)) or 1.0
    _, jacobian, slope = equations.linearised(x, p)
    # the path may run at one p: what the slopes leave out, not what p asks for
    ahead = np.linalg.svd(np.column_stack([jacobian * size, slope]))[2][-1]
    sign = ahead[-1] if abs(ahead[-1]) > 1e-9 else 1.0
    plane = math.copysign(1.0, sign * direction) * ahead
    return located(equations, x, p, size, plane)


@np.errstate(all='ignore')
def correct(
    equations: Equations, guess: Array, p: float, plane: Array, size: float, tolerance: float
) -> tuple[Point, int] | None:
    """The solution nearest `guess`, p in the hyperplane across `plane`, its tangent in the half
    space of `plane`, and the iterations it took; None where Newton does not converge."""
    x, before = np.array(guess), math.inf
    goal = 0.1 * math.sqrt(tolerance)
    for iteration in range(1, 9):
        found = _newton(equations, x, p, plane, size)
        if found is None:
            return None
        move, along, side = found
        x -= size * move[:-1]
        p -= float(move[-1])
        length = length_of(move)
        if length <= goal:
            # where Newton steps so little, the tangent before the step is that after it
            return Point(x, p, along, size, side), iteration
        if length > 2 * before or length > 2.0:
            return None
        before = length
    return None


def between(
    equations: Equations,
    here: Point,
    ahead: Point,
    share: float,
    near: tuple[float, Point] | None = None,
    tolerance: float = 1e-14,
) -> Point | None:
    """The point of the path in the plane at `share` of the chord from `here` to `ahead`, its
    tangent along the chord; None where Newton does not converge. `near`, the point at another
    share, makes it quicker."""
    step, rise = ahead.x - here.x, ahead.p - here.p
    plane = joined(step / here.size, rise)
    known, at = near or (0.0, here)
    x, p = at.x + (share - known) * step, at.p + (share - known) * rise
    found = correct(equations, x, p, plane / length_of(plane), here.size, tolerance)
    return None if found is None else found[0]


@np.errstate(all='ignore')
def located(equations: Equations, x: Array, p: float, size: float, plane: Array) -> Point:
    """The point of a solution, its tangent in the half space of `plane`."""
    found = _newton(equations, x, p, plane, size)
    return Point(x, p, plane, size) if found is None else Point(x, p, found[1], size, found[2])


def _newton(
    equations: Equations, x: Array, p: float, plane: Array, size: float
) -> tuple[Array, Array, float] | None:
    """Newton's move (x over size, p) across `plane`, the unit tangent, and the sign of the
    determinant; None where the slope is singular or not finite."""
    from scipy.linalg.lapack import dgesv

    residual, jacobian, slope = equations.linearised(x, p)
    n = len(slope)
    matrix, right = np.empty((n + 1, n + 1), order='F'), np.zeros((n + 1, 2), order='F')
    np.multiply(jacobian, size, out=matrix[:n, :n])
    matrix[:n, n], matrix[n] = slope, plane
    right[:n, 0], right[n, 1] = residual, 1.0
    factors, swaps, found, failed = dgesv(matrix, right, overwrite_a=True, overwrite_b=True)
    if failed or not math.isfinite(found.sum()):
        return None
    odd = np.count_nonzero(swaps != np.arange(n + 1)) + np.count_nonzero(factors.diagonal() < 0)
    along = found[:, 1]
    return found[:, 0], along / length_of(along), -1.0 if odd % 2 else 1.0


def _solved(matrix: Array, right: Array) -> Array | None:
    if not (np.isfinite(matrix).all() and np.isfinite(right).all()):
        return None
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        return None


def joined(x: Array, p: float) -> Array:
    """(n + 1,): a part in x and one in p."""
    whole = np.empty(len(x) + 1)
    whole[:-1], whole[-1] = x, p
    return whole


def length_of(vector: Array) -> float:
    return math.sqrt(vector @ vector)


def one_thread(function: Callable[In, Out]) -> Callable[In, Out]:
    """`function` with BLAS held to one thread while it runs.

    On matrices of a few dozen rows its threads cost several times what they give, ten times on a
    busy machine, and with their number the order of sums would change, and the last bits.
    """

    @wraps(function)
    def alone(*arguments: In.args, **named: In.kwargs) -> Out:
        with _pools().limit(limits=1, user_api='blas'):
            return function(*arguments, **named)

    return alone


@cache
def _pools() -> Any:
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
