"""Refusing what a plan must not say."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from qzs_rig.errors import InputError
from qzs_rig.parameters import closest


def refuse_unknown(given: Mapping[str, Any], known: Iterable[str], where: str) -> None:
    """InputError for a key that is not `known`, with those that are."""
    known = list(known)
    for key in given:
        if key not in known:
            raise InputError(
                f'{where}: unknown key {key!r}{closest(str(key), known)}; known: '
                + (', '.join(known) or 'none')
            )


def mapping(given: Any, where: str) -> dict[str, Any]:
    """`given` as a map of names, an absent one empty; InputError for anything else."""
    if given is None:
        return {}
    if not isinstance(given, dict) or not all(isinstance(key, str) for key in given):
        raise InputError(f'{where} must map names to values, as in "name: value"')
    return given
