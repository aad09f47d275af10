"""The process of a node: start, spin, end with the right exit code, however long that takes."""

from __future__ import annotations

import ctypes
import faulthandler
import gc
import os
import signal
import sys
import time
from collections.abc import Callable

# numpy must see these before it loads
os.environ.setdefault('OMP_NUM_THREADS', '1')
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

import rclpy
from rclpy.executors import Executor, ExternalShutdownException
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from qzs_rig import loopback
from qzs_rig.errors import RigError
from qzs_rig.ros.node import RigNode

LEAVE_S = {True: 15, False: 3}
"""Longest time from the end of the work to the end of the process, after a finished run or not."""
FLUSH_S = {True: 5.0, False: 0.2}
"""How long a node that ends, after a finished run or not, waits for its messages to arrive: a
listener slower than a run in lockstep would miss the end of it."""
PART_S = 0.3
"""How long a node that ends early waits for its peers to hear why, lest they take it for dead."""
SLICE_S = 0.1
"""How often Python looks at its signals while the executor sleeps in C++."""
CLOCK_MONOTONIC = 1
SIGEV_THREAD = 2


def run(build: Callable[[], RigNode], args: list[str] | None = None) -> int:
    """Build the node, run it until it is done or told to stop; returns the exit code."""
    stops: list[int] = []
    # SIGINT, too, where a shell that starts jobs in the background has it ignored
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda signum, _frame: stops.append(signum))
    node = executor = None
    code = 1
    try:
        loopback.settle(os.environ)
        # rclpy's own handlers would end the context before the peers can be told
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        node, executor = build(), _executor()
        code = _spin(node, executor, stops)
    except RigError as error:
        print(f'qzs_rig: {error}', file=sys.stderr, flush=True)
        code = error.exit_code
    except ExternalShutdownException:
        code = 0
    finally:
        if node is not None:
            finished = code == 0 and not node.stopped
            leave_within(LEAVE_S[finished], code)
            if executor is not None and node.exit_code is not None:
                _part(node, executor)
            node.close()
            if rclpy.ok():
                node.flush(FLUSH_S[finished])
            node.destroy_node()
        # the lifecycle machine keeps the node alive past destroy_node; unless it is collected
        # before the process ends, its peers see a ghost of this node for 20 s
        node = None
        gc.collect()
        rclpy.try_shutdown()
    return code


def _spin(node: RigNode, executor: Executor, stops: list[int]) -> int:
    """Work until the node is done or a signal came; the exit code."""
    executor.add_node(node)
    node.start()
    never: Future[None] = Future()
    node.wake = lambda: never.set_result(None)
    while node.exit_code is None:
        executor.spin_until_future_complete(never, timeout_sec=SLICE_S)
        if stops:
            node.operator_stop(signal.Signals(stops[0]).name)
            break
    return node.exit_code or 0


def _part(node: RigNode, executor: Executor) -> None:
    """Stay until peers and callers have heard how it ended, for some time at most."""
    until = time.monotonic() + PART_S
    while not node.answered() or (not node.parted() and time.monotonic() < until):
        executor.spin_until_future_complete(Future(), timeout_sec=0.01)


def _executor() -> Executor:
    """EventsExecutor where this rclpy has one (five times the messages a second), else the default.

    MultiThreadedExecutor is no choice: it loses messages at rates a tenth of these.
    """
    try:
        from rclpy.experimental import EventsExecutor

        return EventsExecutor()
    except ImportError:
        from rclpy.executors import SingleThreadedExecutor

        return SingleThreadedExecutor()


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
