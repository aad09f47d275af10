"""A kernel per restoring law: one source with the law's formulas put in by name."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from types import CodeType, FunctionType
from typing import Any

Function = Callable[..., Any]


def interpreted(template: Any, formulas: Mapping[str, Function]) -> Function:
    """`template`, a function of a module, with its global names `formulas` bound to these.

    A formula sees those named before it, so a template may be cut into parts.
    """
    inner: dict[str, Function] = {}
    for name, formula in formulas.items():
        inner[name] = _bound(formula, inner, name) if hasattr(formula, '__code__') else formula
    return _bound(template, inner, template.__name__)


def compiled(
    template: Any,
    formulas: Mapping[str, Function],
    *,
    fastmath: bool | set[str] = False,
    signature: Any = None,
) -> Function:
    """What `interpreted` gives, compiled by numba with the formulas inlined, and kept on disk.

    The file that keeps it is named after what the formulas compute, so an edited formula is
    compiled anew. A formula may be compiled already. With a `signature` it is compiled at once and
    may itself be an argument of compiled code. Raises ImportError where numba is missing.
    """
    from numba import njit

    how: dict[str, Any] = {'nogil': True, 'error_model': 'numpy', 'fastmath': fastmath}
    # only compiled code calls the formulas: leave out the doors for others, half of the work
    closed = {**how, 'no_cpython_wrapper': True, 'no_cfunc_wrapper': True}
    inner: dict[str, Function] = {}
    for name, formula in formulas.items():
        plain = isinstance(formula, FunctionType)
        inner[name] = njit(**closed)(_bound(formula, inner, name)) if plain else formula
    told = fingerprint(template) + ''.join(
        name + fingerprint(formula) for name, formula in formulas.items()
    )
    # a set of words has another order in every process
    manner = sorted(fastmath) if isinstance(fastmath, set) else fastmath
    stamp = hashlib.sha256(f'{told}{manner}'.encode()).hexdigest()[:16]
    named = _bound(template, inner, f'{template.__name__}_{stamp}')
    kernel: Function = njit(signature, cache=True, **how)(named)
    return kernel


def fingerprint(function: Any) -> str:
    """A text that differs where two functions compute differently: code, constants, closure.

    What `compiled` made is known by its name, which says what went into it.
    """
    if hasattr(function, 'py_func'):
        return f'{function.__name__}{fingerprint(function.py_func)}'
    if not hasattr(function, '__code__'):
        return repr(function)
    cells = function.__closure__ or ()
    numbers = [function.__globals__.get(name) for name in function.__code__.co_names]
    # what a module calls LANES or STAGES is a constant in compiled code
    known = repr([number for number in numbers if isinstance(number, int | float)])
    return (
        known
        + _code(function.__code__)
        + ''.join(fingerprint(cell.cell_contents) for cell in cells)
    )


def _code(code: CodeType) -> str:
    constants = [_code(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts]
    return f'{code.co_code.hex()}{code.co_names}{constants}'


def _bound(template: Any, formulas: Mapping[str, Function], name: str) -> Function:
    scope = {**template.__globals__, **formulas}
    bound = FunctionType(
        template.__code__, scope, name, template.__defaults__, template.__closure__
    )
    bound.__qualname__ = name
    bound.__module__ = template.__module__
    return bound
