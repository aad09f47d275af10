"""The error family of the rig: each message names the thing, the value and the way out."""

from __future__ import annotations


class RigError(Exception):
    """Any failure the rig foresees; the CLI prints it on one line and exits with `exit_code`."""

    exit_code = 1


class InputError(RigError):
    """Something the user gave is wrong: a parameter, a scenario, a file, a topic."""

    exit_code = 2


class BagError(InputError):
    """A bag cannot be read, or a folder cannot take one."""


class LimitError(InputError):
    """The excitation asks more than the shaker can give."""


class GapError(RigError):
    """Samples are missing where a contiguous time history was promised."""

    exit_code = 3


class DivergenceError(RigError):
    """The integration left the finite numbers; carries the last good sample index."""

    def __init__(self, message: str, last_good_sample: int) -> None:
        super().__init__(message)
        self.last_good_sample = last_good_sample


class RunAbortedError(RigError):
    """A run ended before its last sample; the message says why and what was kept."""


class PeerError(RigError):
    """A node of the rig died, stalled or disagrees."""
