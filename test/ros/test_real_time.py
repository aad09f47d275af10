"""Real time: by the clock, on the grid, nothing lost; in a namespace, with late joiners."""

from __future__ import annotations

import time

import numpy as np
from ros_support import SHORT, kept, read, without_ros

from qzs_rig import wire

SPEC = SHORT | {'run.rate': 500.0, 'run.mode': 'real_time', 'excitation.duration': 2.0}
SAMPLES = 2001
AWAY = wire.Topic('/lab/rig/run', wire.RUN.type, 10, latched=True)
STATES = wire.Topic('/lab/joint_states', wire.JOINT_STATES.type, 10)
HEALTH = wire.DIAGNOSTICS


def test_real_time_in_a_namespace(lab):
    remap = ('-r', '__ns:=/lab')
    ears = lab.ears(STATES, HEALTH, wire.CLOCK, wire.RUN)
    nodes = [
        lab.node('exciter', SPEC, remap),
        lab.node('platform', SPEC, remap),
        lab.node('analyzer', SPEC, remap, folder=str(lab.folder / 'out')),
    ]
    nodes[0].says('all matched')
    began = time.monotonic()
    late = lab.ears(AWAY)
    late.wait(AWAY.name)  # latched: the sheet is there for who comes later
    assert [node.code() for node in nodes] == [0, 0, 0]
    # a quarter of a second to the start, and up to two seconds for the peers' last samples
    assert 3.9 < time.monotonic() - began < 4.0 + 5.0

    run, estimate = kept(lab.folder / 'out')
    counts = {'published': SAMPLES, 'received': SAMPLES, 'lost': 0, 'duplicated': 0}
    assert run['topics'] == {'base/imu': counts, 'top/imu': counts}
    assert run['mode'] == 'real_time' and run['rig_s'] == 4.0
    # from the first to the last batch; batches are 20 ms and start together
    assert 3.5 < run['wall_s'] < 6.0
    assert estimate == without_ros(SPEC)[0]
    sheets, _, imus = read(lab.folder / 'out')
    grid = sheets[-1].start_ns + np.arange(SAMPLES) * 2_000_000
    assert all((imu.stamps_ns == grid).all() for imu in imus)

    assert ears.got['/clock'] == [], '/clock belongs to lockstep'
    assert ears.got['rig/run'] == [], 'nothing leaves the namespace'
    # 60 Hz, over the 4 s of the run and the burst after a stall
    assert 20 < len(ears.got[STATES.name]) <= 4.3 * 60
    names = {s.name for m in ears.messages(HEALTH.name) for s in m.status}
    assert names == {'exciter', 'platform', 'analyzer'}
