"""Functions compiled by numba and kept on disk, beside the file that they stand in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def kept(signature: Any, **options: Any) -> Callable[[Any], Any]:
    """A decorator: compiled for `signature`, a type of numba, by numba's `options`, without the
    interpreter's lock, once for all processes. Raises ImportError where numba is missing.

    What an older version of the package has left may name modules and types that are gone: numba
    cannot read it, so it is compiled anew.
    """
    import numba

    def compiled(function: Any) -> Any:
        own = numba.njit(cache=True, nogil=True, **options)(function)
        try:
            own.compile(signature)
        except (ModuleNotFoundError, AttributeError):
            own._cache.flush()
            own.compile(signature)
        own.disable_compile()
        return own

    return compiled
