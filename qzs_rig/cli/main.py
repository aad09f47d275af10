"""`qzs-rig`: every verb of the rig on the command line."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from collections.abc import Sequence
from typing import Any

from qzs_rig import __version__
from qzs_rig.cli import (
    analyze,
    bag,
    basin,
    bifurcation,
    campaign,
    claims,
    compare,
    design,
    figures,
    frf,
    identify,
    lyapunov,
    modes,
    poincare,
    replay,
    rig,
    run,
    scenarios,
    springs,
    statics,
)
from qzs_rig.cli.options import joined
from qzs_rig.errors import RigError

COMMANDS = (
    *(rig, run, analyze, replay, compare, bag),
    *(frf, bifurcation, poincare, lyapunov, basin, identify, campaign),
    *(statics, modes, springs, design, claims, figures, scenarios),
)

EPILOG = """\
start here:
  qzs-rig rig                         the paper's platform swept through its jump, real ROS 2 nodes
  qzs-rig run --set platform.zeta=0.1 the same in this process, with more damping
  qzs-rig compare runs/A runs/B       two runs over theory, in one page
  qzs-rig frf --amplitude 0.1         every branch of the response, where it jumps, what is stable
  qzs-rig identify runs/A             damping, stiffness and payload back from a measured curve
  qzs-rig scenarios --parameters      everything that --set knows

exit codes: 0 ok, 1 aborted or a finding, 2 bad input, 3 samples were lost
"""


def parser() -> argparse.ArgumentParser:
    """The whole command line; each command file adds its own part."""
    top = argparse.ArgumentParser(
        prog='qzs-rig',
        description='Virtual test rig for a quasi-zero-stiffness vibration isolation platform.',
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument('--version', action='version', version=f'qzs_rig {__version__}')
    verbs = top.add_subparsers(title='commands', metavar='COMMAND', required=True)
    for command in COMMANDS:
        command.add_to(verbs)
    return top


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command and end with its exit code; SIGTERM closes things as Ctrl-C does."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _interrupt)
    sys.exit(execute(arguments))


def execute(arguments: Sequence[str] | None = None) -> int:
    """Exit code of one command; foreseen failures become one line on stderr."""
    options = parser().parse_args(joined(sys.argv[1:] if arguments is None else arguments))
    try:
        return int(options.execute(options))
    except RigError as error:
        print(f'qzs-rig: {error}', file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print('qzs-rig: stopped', file=sys.stderr)
        return 1
    except BrokenPipeError:
        # the reader of our output went away (| head); nothing is left to say
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _interrupt(number: int, frame: Any) -> None:
    raise KeyboardInterrupt


if __name__ == '__main__':
    main()
