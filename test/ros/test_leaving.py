"""A run that has finished well ends with exit 0 even if the middleware hangs on leaving."""

from __future__ import annotations

import sys

import pytest
from ros_support import SHORT, kept

HANGS = """
import ctypes
import sys

from qzs_rig.ros import analyzer, process

def hang(self):
    # as rclpy does in C++: with the interpreter locked
    ctypes.PyDLL(None).sleep(1000)

analyzer.Analyzer.destroy_node = hang
process.LEAVE_S = {True: 3, False: 2}
analyzer.main()
"""


DIVERGES = {
    'platform.law': 'closed_form',
    'excitation.amplitude.vertical': 0.0,
    'excitation.amplitude.horizontal_rotation': 60.0,
    'shaker.limits': False,
}


@pytest.mark.parametrize(('more', 'code'), [({}, 0), (DIVERGES, 1)], ids=['finished', 'aborted'])
def test_a_hang_on_leaving_does_not_change_the_end(lab, more, code):
    """The exit code is that of the run, finished or aborted, and the log says where it hung."""
    words = ['-p', f'folder:={lab.folder / "out"}']
    analyzer = lab.run('analyzer', [sys.executable, '-c', HANGS, '--ros-args', *words])
    others = [lab.node('platform', SHORT | more), lab.node('exciter', SHORT | more)]
    assert [node.code() for node in others] == [code, code]
    assert analyzer.code() == code
    assert 'in hang' in analyzer.log
    assert kept(lab.folder / 'out')[0]['state'] == ('finished' if code == 0 else 'aborted')
