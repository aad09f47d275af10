"""Somebody else's sensors: the analyzer node on a driver that knows nothing of the rig."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

import numpy as np
import pytest
from ros_support import document, given, kept, wait_until
from std_srvs.srv import Trigger

HERTZ, MAGNITUDE, PHASE = 12.0, 0.35, -130.0
SENSORS = {
    'analyzer.base.topic': '/left/imu',
    'analyzer.top.topic': '/right/data',
    'analyzer.base.axis.vertical': '-linear_acceleration.x',
    'analyzer.base.scale.vertical': 9.80665,
    'analyzer.top.axis.vertical': 'linear_acceleration.y',
    'analyzer.dofs': 'vertical',
}
NODE = SENSORS | {'analyzer.source': 'driver', 'analyzer.qos': 'sensor_data'}


@pytest.mark.parametrize('how', ['SIGINT', 'save', 'silence'])
def test_driver(lab, how):
    out = lab.folder / 'out'
    ears = lab.ears(services=(('analyzer/save', Trigger),))
    silence = {'analyzer.silence': 0.5} if how == 'silence' else {}
    analyzer = lab.node('analyzer', NODE | silence, folder=str(out))
    script = Path(__file__).parent / 'driver.py'
    words = [str(x) for x in (HERTZ, MAGNITUDE, PHASE, 2.5)]
    driver = lab.run('driver', [sys.executable, str(script), *words])
    analyzer.says('analyzing /left/imu and /right/data')
    if how != 'silence':
        # what is on the disk grows in pieces; two seconds are well over 100 kB
        wait_until(
            lambda: sum(f.stat().st_size for f in out.glob('*.mcap')) > 30_000, 'a bag that grows'
        )
    if how == 'SIGINT':
        analyzer.signal(signal.SIGINT)
    elif how == 'save':
        answer = ears.call('analyzer/save')
        assert answer.success and str(out) in answer.message
    assert analyzer.code() == 0, analyzer.log
    driver.signal(signal.SIGTERM)
    assert driver.code() == 0, driver.log

    run, estimate = kept(out)
    assert run['state'] == 'finished' and run['scenario'] == 'driver'
    assert set(run['topics']) == {'/left/imu', '/right/data'}
    curve = next(c for c in estimate['curves'] if c['dof'] == 'vertical')
    assert len(curve['magnitude']) >= 1
    assert np.allclose(curve['frequency_hz'], HERTZ, rtol=1e-3)
    assert np.allclose(curve['magnitude'], MAGNITUDE, rtol=0.01)
    assert np.allclose(curve['phase_deg'], PHASE, atol=1.0)

    # the bag knows how it was analyzed; the same words on top change nothing
    plain = lab.cli('analyze', str(out), '--out', str(lab.folder / 'plain'))
    told = lab.cli('analyze', str(out), *given(SENSORS), '--out', str(lab.folder / 'told'))
    for command in (plain, told):
        assert command.code() == 0, command.log
    assert document(lab.folder / 'plain' / 'estimate.json') == estimate
    assert document(lab.folder / 'told' / 'estimate.json') == estimate


def test_nothing_to_save(lab):
    ears = lab.ears(services=(('analyzer/save', Trigger),))
    analyzer = lab.node('analyzer', NODE)
    answer = ears.call('analyzer/save')
    assert (answer.success, answer.message) == (False, 'nothing to save')
    analyzer.signal(signal.SIGINT)
    assert analyzer.code() == 0
