"""An oscillator's force and stiffness at samples of w, for kernels that know no law.

Compiled, it is a function pointer: one kernel serves every law, and only this loop is compiled
for each of them.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from qzs_rig.mechanics.restoring.law import Formula, RestoringLaw
from qzs_rig.mechanics.restoring.polynomial import cubic_force, cubic_stiffness
from qzs_rig.mechanics.restoring.roots import rsqrt, teach_numba
from qzs_rig.mechanics.specialise import Function, compiled, interpreted
from qzs_rig.theory.oscillator import Oscillator

Numbers = tuple[float, ...]


force: Formula = cubic_force
stiffness: Formula = cubic_stiffness
"""A cubic law's, unless `interpreted` or `compiled` puts in others."""


def sample(numbers: Any, load: float, count: int, w: Any, f: Any, k: Any) -> None:
    """Fill force f and stiffness k at the first `count` of w."""
    for j in range(count):
        f[j] = force(numbers, w[j]) - load
        k[j] = stiffness(numbers, w[j])


def numbers(oscillator: Oscillator) -> Numbers:
    """The six numbers that the formulas take: the design, or a cubic law's coefficients."""
    if oscillator.law.cubic_only:
        return (*oscillator.law.taylor(oscillator.design)[oscillator.number], 0.0, 0.0, 0.0)
    return tuple(oscillator.design)


@cache
def in_interpreter(law: RestoringLaw, dof: int) -> Function:
    """`sample` of a law for lists."""
    return interpreted(sample, _formulas(law, dof))


@cache
def in_numba(law: RestoringLaw, dof: int) -> Function:
    """`sample` of a law for arrays, an argument of compiled code; ImportError without numba."""
    from numba import void

    teach_numba()
    return compiled(sample, _formulas(law, dof), signature=void(*arguments()))


@cache
def pointer() -> Any:
    """numba's type of what `in_numba` gives."""
    from numba import types, void

    return types.FunctionType(void(*arguments()))


def arguments() -> tuple[Any, ...]:
    """numba's types of the arguments of `sample`."""
    from numba import float64, int64, types

    # numba's own types carry no annotations
    pack: Any = types.UniTuple
    line = float64[::1]
    return pack(float64, 6), float64, int64, line, line, line


def _formulas(law: RestoringLaw, dof: int) -> dict[str, Formula]:
    if law.cubic_only:
        return {'force': cubic_force, 'stiffness': cubic_stiffness}
    return {'force': law.around(rsqrt)[dof], 'stiffness': law.stiffnesses[dof]}
