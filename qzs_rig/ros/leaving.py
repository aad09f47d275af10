"""The end of a process, however long the middleware takes over it."""

from __future__ import annotations

import ctypes
import faulthandler
import os
import sys

CLOCK_MONOTONIC = 1
SIGEV_THREAD = 2


class _Event(ctypes.Structure):
    """`struct sigevent` of glibc: 64 bytes, the function behind value, signal and kind."""

    _fields_ = (
        ('value', ctypes.c_void_p),
        ('signal', ctypes.c_int),
        ('kind', ctypes.c_int),
        ('function', ctypes.c_void_p),
        ('attributes', ctypes.c_void_p),
        ('padding', ctypes.c_char * 32),
    )


class _Period(ctypes.Structure):
    """`struct itimerspec`: once, after some time."""

    _fields_ = tuple(
        (name, ctypes.c_long) for name in ('again_s', 'again_ns', 'after_s', 'after_ns')
    )


def leave(code: int) -> None:
    """End the process now: the middleware's threads need no interpreter to wait for them."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def leave_within(seconds: int, code: int) -> None:
    """End the process with `code` after `seconds`, unless it has ended by then.

    rclpy takes leave of the middleware in C++ and keeps the interpreter locked meanwhile. Should it
    hang there, no thread or signal handler of Python's would run, and faulthandler's own watchdog
    knows no exit code but 1; so a timer of the C library calls `_exit`. Half a second before, the
    stack is printed. Where there is no such timer to be had, faulthandler ends the process.
    """
    library = ctypes.CDLL(None)
    # the timer's thread passes the event's value where `_exit` takes its argument from
    end = ctypes.cast(library._exit, ctypes.c_void_p).value
    event = _Event(value=code, kind=SIGEV_THREAD, function=end)
    after, timer = _Period(after_s=seconds), ctypes.c_void_p()
    timed = (
        hasattr(library, 'timer_create')
        and not library.timer_create(CLOCK_MONOTONIC, ctypes.byref(event), ctypes.byref(timer))
        and not library.timer_settime(timer, 0, ctypes.byref(after), None)
    )
    faulthandler.dump_traceback_later(seconds - 0.5 if timed else seconds, exit=not timed)
