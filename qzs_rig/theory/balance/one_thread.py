"""Linear algebra of small matrices by one thread."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

In = ParamSpec('In')
Out = TypeVar('Out')


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
