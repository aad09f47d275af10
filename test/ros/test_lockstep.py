"""Lockstep over three processes: nobody starts alone, nothing is lost, the bits stay."""

from __future__ import annotations

import json
import time

import numpy as np
import pytest
from ros_support import ROLES, SAMPLES, SHORT, kept, read, same_bits, without_ros

from qzs_rig.run import offline

NOISY = SHORT | {'sensor.kind': 'noisy', 'run.seed': 5}


@pytest.mark.parametrize(
    ('order', 'pauses'),
    [
        (('exciter', 'platform', 'analyzer'), (0.0, 0.0)),
        (('analyzer', 'exciter', 'platform'), (0.6, 0.6)),
        (('platform', 'analyzer', 'exciter'), (0.0, 1.0)),
    ],
)
def test_any_order_waits_and_loses_nothing(lab, order, pauses):
    nodes = {}
    for role, pause in zip(order, (*pauses, 0.0), strict=True):
        own = {'folder': str(lab.folder / 'out')} if role == 'analyzer' else {}
        nodes[role] = lab.node(role, NOISY, **own)
        time.sleep(pause)
    assert [nodes[role].code() for role in ROLES] == [0, 0, 0]

    run, estimate = kept(lab.folder / 'out')
    counts = {'published': SAMPLES, 'received': SAMPLES, 'lost': 0, 'duplicated': 0}
    assert run['topics'] == {'base/imu': counts, 'top/imu': counts}
    assert (run['schema'], run['mode'], run['state']) == ('qzs_rig/run/1', 'lockstep', 'finished')
    assert run['rig_s'] == 10.0
    reference, columns = without_ros(NOISY)
    assert estimate == reference
    assert offline.analyze(lab.folder / 'out').estimate.to_json() == json.dumps(estimate)

    sheets, chunks, imus = read(lab.folder / 'out')
    sheet = sheets[-1]
    grid = sheet.start_ns + np.arange(SAMPLES) * sheet.step_ns
    assert [s.state for s in sheets] == ['armed', 'finished']
    assert same_bits(np.concatenate([c.data for c in chunks]), columns[0])
    for imu, column in zip(imus, columns[1:], strict=True):
        assert (imu.stamps_ns == grid).all()
        assert same_bits(imu.data, column)


def test_each_says_whom_it_waits_for(lab):
    exciter = lab.node('exciter')
    exciter.says('waiting for node platform, node analyzer')
    platform = lab.node('platform')
    platform.says('waiting for a subscriber of base/imu, a subscriber of top/imu')
    exciter.says('node analyzer')
    assert exciter.running and platform.running
    analyzer = lab.node('analyzer', folder=str(lab.folder / 'out'))
    exciter.says('all matched')
    assert [node.code() for node in (exciter, platform, analyzer)] == [0, 0, 0]
