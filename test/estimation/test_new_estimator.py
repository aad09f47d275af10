"""A new estimator is one file and one line: a copy of the package is given one, and runs it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import qzs_rig

TOY = '''
from qzs_rig.estimation.estimate import Estimate


class Counting:
    """Counts the samples of each degree of freedom."""

    name = 'counting'

    def __init__(self, settings, step_ns, dofs):
        self._dofs, self._samples = dofs, 0

    def push(self, base, top):
        self._samples += len(base)

    def latest(self, dof):
        return None

    def result(self):
        return Estimate(quality={'estimator': self.name, 'samples': self._samples})
'''

RUN = """
from qzs_rig import scenario
from qzs_rig.run import in_process

given = {
    'analyzer.estimator': 'counting',
    'run.rate': 200.0,
    'excitation.kind': 'sine',
    'excitation.duration': 4.0,
    'excitation.ramp': 1.0,
    'excitation.amplitude.vertical': 1.0,
}
quality = in_process.run(scenario.of(given), 0).estimate.quality
print(quality['estimator'], quality['samples'])
"""


def test_one_file_and_one_line_make_an_estimator(tmp_path):
    copy = tmp_path / 'qzs_rig'
    shutil.copytree(
        Path(qzs_rig.__file__).parent, copy, ignore=shutil.ignore_patterns('__pycache__')
    )
    (copy / 'estimation' / 'counting.py').write_text(TOY)
    table = copy / 'estimation' / '__init__.py'
    imported, listed = (
        'from qzs_rig.estimation import channels',
        "    'stepped_sine': SteppedSine,\n",
    )
    text = table.read_text()
    assert text.count(imported) == text.count(listed) == 1
    text = text.replace(imported, f'from qzs_rig.estimation.counting import Counting\n{imported}')
    table.write_text(text.replace(listed, listed + "    'counting': Counting,\n"))
    run = subprocess.run(
        [sys.executable, '-c', RUN],
        check=False,
        capture_output=True,
        text=True,
        env=os.environ | {'PYTHONPATH': str(tmp_path)},
        cwd=tmp_path,
        timeout=120,
    )
    # 4 s between two ramps of 1 s, at 200 Hz
    assert run.stdout.split()[0:1] == ['counting'], run.stderr
    assert int(run.stdout.split()[1]) >= 6 * 200
