"""The rig in process: the same bits however it is cut, from its bag, and the right physics."""

from __future__ import annotations

import math

import numpy as np
import pytest

from qzs_rig import scenario, wire
from qzs_rig.bag import BagReader
from qzs_rig.errors import DivergenceError, InputError
from qzs_rig.mechanics.platform import Platform
from qzs_rig.run import in_process, offline
from qzs_rig.run.runfolder import Recording
from qzs_rig.run.sheet import RunSheet
from qzs_rig.run.stages import AnalyzerStage, ExciterStage, PlatformStage
from qzs_rig.samples import Samples
from qzs_rig.theory.single_term import single_term
from qzs_rig.units import DOFS

START = 1_700_000_000_000_000_000
SWEEP = {
    'run.rate': 200.0,
    'run.seed': 11,
    'excitation.frequency_low': 1.5,
    'excitation.frequency_high': 4.0,
    'excitation.duration': 30.0,
    'excitation.ramp': 1.0,
    'excitation.amplitude.vertical': 3.0,
    'excitation.amplitude.horizontal': 1.0,
    'excitation.amplitude.vertical_rotation': 0.3,
    'excitation.amplitude.horizontal_rotation': 0.3,
    'platform.L0_hat': 0.08,
    'sensor.kind': 'noisy',
}


def join(pieces):
    """One signal of its pieces, which follow one another without a gap."""
    stamps = np.concatenate([piece.stamps_ns for piece in pieces])
    assert np.array_equal(stamps, START + 5_000_000 * np.arange(len(stamps)))
    data = np.concatenate([piece.data for piece in pieces])
    return Samples(stamps, data, pieces[0].channels)


class Kept:
    """A tap that keeps all chunks."""

    def __init__(self):
        self.base, self.out = [], []

    def __call__(self, base, out):
        self.base.append(base)
        self.out.append(out)

    def signals(self):
        tops = [[getattr(o, name) for o in self.out] for name in ('base_imu', 'top_imu', 'top')]
        return [join(pieces) for pieces in (self.base, *tops)]


def perform(given, chunk):
    kept = Kept()
    result = in_process.run(scenario.of(given), START, kept, chunk=chunk)
    return result, kept.signals()


@pytest.fixture(scope='module')
def whole():
    return perform(SWEEP, 10**6)


@pytest.mark.parametrize('chunk', [7, 50, 1000])
def test_chunks_do_not_change_a_bit(whole, chunk):
    result, signals = perform(SWEEP, chunk)
    assert result.estimate.to_json() == whole[0].estimate.to_json()
    for cut, uncut in zip(signals, whole[1], strict=True):
        assert cut.stamps_ns[0] == uncut.stamps_ns[0] == START
        assert cut.data.tobytes() == uncut.data.tobytes()


def test_single_samples_do_not_change_a_bit():
    short = SWEEP | {'excitation.kind': 'sine', 'excitation.duration': 4.0}
    result, signals = perform(short, 10**6)
    again, cut = perform(short, 1)
    assert result.estimate.to_json() == again.estimate.to_json()
    assert [s.data.tobytes() for s in signals] == [s.data.tobytes() for s in cut]


def test_a_degree_of_freedom_at_rest_has_the_same_zeros_in_any_chunk():
    # -0.0 and 0.0 are equal numbers and different bytes in a bag
    alone = {k: v for k, v in SWEEP.items() if 'amplitude' not in k and 'sensor' not in k}
    alone |= {'excitation.amplitude.vertical': 2.0, 'excitation.duration': 3.0}
    _, signals = perform(alone, 10**6)
    for chunk in (1, 7):
        _, cut = perform(alone, chunk)
        assert [s.data.tobytes() for s in signals] == [s.data.tobytes() for s in cut]


def test_the_estimate_holds_every_driven_degree_of_freedom(whole):
    estimate = whole[0].estimate
    assert {curve.dof for curve in estimate.curves} == set(DOFS)
    assert {curve.direction for curve in estimate.curves} == {'forward', 'reverse'}
    assert estimate.quality['streams']['top']['received'] == whole[0].samples


def test_progress_and_counts(whole):
    seen = []
    short = SWEEP | {'excitation.duration': 2.0}
    result = in_process.run(scenario.of(short), progress=lambda *at: seen.append(at), chunk=300)
    assert seen == [(300, 801), (600, 801), (801, 801)]
    assert (result.samples, result.rig_s) == (801, 4.0)
    assert result.cautions == ()
    assert result.wall_s > 0


def test_cautions_reach_the_result():
    tipping = SWEEP | {'excitation.duration': 1.0, 'platform.L0_hat': 0.1}
    (caution,) = in_process.run(scenario.of(tipping)).cautions
    assert caution.startswith('horizontal_rotation has negative stiffness')


# --- the bag ---


def record(folder, given, chunk=40, per_message=25):
    """A run written as the nodes write it; returns its result and signals."""
    spec = scenario.of(given)
    names = [spec.text(f'analyzer.{plate}.topic') for plate in ('base', 'top')]
    recording = Recording(folder, *names)
    step_ns = scenario.step_ns_of(spec)
    samples = ExciterStage(spec, step_ns).samples
    sheet = RunSheet(step_ns, samples, 'in_process', chunk, dict(spec), 'id', start_ns=START)
    recording.sheet(START, sheet.replace(state='running'))
    kept = Kept()

    def keep(base, out):
        kept(base, out)
        for first in range(0, len(base), per_message):
            piece = base[first : first + per_message]
            recording.motion(piece.stamps_ns[:1], [wire.encode_motion(piece)])
        recording.base(base.stamps_ns, wire.encode_imu(out.base_imu, 'base_imu_link'))
        top = wire.encode_imu(out.top_imu, 'top_imu_link')
        recording.top(base.stamps_ns, [row.tobytes() for row in top])
        recording.tick()

    result = in_process.run(spec, START, keep, chunk=chunk)
    recording.sheet(START + samples * step_ns, sheet.replace(state='finished'))
    recording.close()
    return result, kept.signals()


@pytest.fixture(scope='module')
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp('chain') / 'run'
    return folder, *record(folder, SWEEP)


def test_the_bag_gives_the_same_estimate(recorded):
    folder, result, _ = recorded
    analysis = offline.analyze(folder)
    assert analysis.estimate.to_json() == result.estimate.to_json()
    assert analysis.sheet.state == 'finished'
    assert dict(analysis.spec) == dict(scenario.of(SWEEP))
    assert dict(offline.recorded_spec(folder)) == dict(scenario.of(SWEEP))


def test_words_change_the_analysis_of_a_bag(recorded):
    folder, result, _ = recorded
    analysis = offline.analyze(folder, ['analyzer.hop_periods=2'])
    assert analysis.spec['analyzer.hop_periods'] == 2.0
    half = len(result.estimate.curves[0].frequency_hz) / 2
    # every second window, give or take those at the ends
    assert abs(len(analysis.estimate.curves[0].frequency_hz) - half) <= 2


def test_the_recorded_motion_gives_the_same_readings(recorded):
    folder, _, (base, base_imu, top_imu, top) = recorded
    reader = BagReader(folder)
    try:
        chunks = [wire.decode_motion(raw) for _, _, raw in reader.messages(['base/motion'])]
        imu = wire.decode_imu([raw for _, _, raw in reader.messages(['top/imu'])])
    finally:
        reader.close()
    motion = join(chunks)
    assert motion.data.tobytes() == base.data.tobytes()
    out = PlatformStage(scenario.of(SWEEP), 5_000_000).push(motion)
    assert out.top.data.tobytes() == top.data.tobytes()
    assert out.base_imu.data.tobytes() == base_imu.data.tobytes()
    assert out.top_imu.data.tobytes() == top_imu.data.tobytes() == imu.data.tobytes()
    assert np.array_equal(imu.stamps_ns, base.stamps_ns)


def test_an_estimate_is_found_beside_its_bag_in_it_or_alone(recorded, tmp_path):
    folder, result, _ = recorded
    text = result.estimate.to_json()
    assert offline.recorded(folder).estimate.to_json() == text
    (folder / 'estimate.json').write_text(text, encoding='utf-8')
    for path in (folder, folder / 'estimate.json'):
        analysis = offline.recorded(path)
        assert analysis.estimate.to_json() == text
        assert analysis.sheet.run_id == 'id'
    moved = tmp_path / 'moved.json'
    moved.write_text(text, encoding='utf-8')
    alone = offline.recorded(moved)
    assert (alone.sheet, alone.estimate.to_json()) == (None, text)
    with pytest.raises(
        InputError, match=r'nowhere\.json is not there; give a bag, a run folder or'
    ):
        offline.recorded(tmp_path / 'nowhere.json')


# --- the stages ---


def test_a_platform_that_runs_away_gives_no_reading():
    wild = SWEEP | {'excitation.amplitude.horizontal_rotation': 800.0}
    with pytest.raises(DivergenceError, match='horizontal_rotation left the domain'):
        in_process.run(scenario.of(wild))


def test_clipped_readings_are_counted():
    spec = scenario.of(SWEEP | {'sensor.acceleration_range': 5.0, 'sensor.acceleration_noise': 0})
    stage = PlatformStage(spec, 5_000_000)
    stage.push(ExciterStage(spec, 5_000_000).take(10))
    assert stage.clipped == 20  # gravity, on both plates


def test_an_analyzer_without_samples_estimates_nothing():
    stage = AnalyzerStage(scenario.of({}), 2_000_000)
    assert stage.latest('vertical') is None
    assert stage.preview().curves == stage.result().curves == ()


def test_the_latest_point_follows_the_tone():
    spec = scenario.of(
        SWEEP
        | {'excitation.kind': 'sine', 'excitation.duration': 8.0}
        | {'excitation.frequency': 3.0, 'sensor.kind': 'ideal'}
    )
    stage, exciter = AnalyzerStage(spec, 5_000_000), ExciterStage(spec, 5_000_000)
    out = PlatformStage(spec, 5_000_000).push(exciter.take(1700))
    stage.push_base(out.base_imu)
    assert stage.latest('vertical') is None  # both sensors are needed
    stage.push_top(out.top_imu)
    hz, _ = stage.latest('vertical')
    assert hz == pytest.approx(3.0, rel=1e-6)  # a pure tone: the fit converges to rounding


# --- the physics ---

STEPS = {
    'run.rate': 200.0,
    'excitation.kind': 'stepped_sine',
    'excitation.direction': 'forward',
    'excitation.quantity': 'acceleration',
    'excitation.steps': 4,
    'excitation.dwell': 16.0,
    'excitation.glide': 0.5,
    'excitation.ramp': 1.0,
    'analyzer.estimator': 'stepped_sine',
}


def steps(**given):
    words = {name.replace('__', '.'): value for name, value in given.items()}
    spec = scenario.of(STEPS | words)
    return Platform.from_spec(spec), in_process.run(spec).estimate.curves


def assert_close(curve, theory):
    """1 % and 1 degree: what a laboratory would ask of a sine measurement."""
    turned = (curve.phase_deg - np.degrees(np.angle(theory)) + 180) % 360 - 180
    assert np.allclose(curve.magnitude, np.abs(theory), rtol=0.01)
    assert np.abs(turned).max() < 1.0


@pytest.mark.parametrize('dof', DOFS)
def test_a_linear_platform_has_the_textbook_transmissibility(dof):
    zeta_hat = 0.2
    platform, curves = steps(
        platform__law='linear',
        platform__zeta=zeta_hat,
        excitation__frequency_low=1.2,
        excitation__frequency_high=3.0,
        **{f'excitation__amplitude__{dof}': 1.0},
    )
    # a tilting accelerometer also reads g sin(tilt) sideways
    (curve,) = (curve for curve in curves if curve.dof == dof)
    number = DOFS.index(dof)
    c1, _ = platform.law.cubic(platform.design)[number]
    natural = platform.omega0[number] * math.sqrt(c1)
    r, zeta = 2 * math.pi * curve.frequency_hz / natural, zeta_hat / math.sqrt(c1)
    assert curve.frequency_hz == pytest.approx(np.linspace(1.2, 3.0, 4), rel=1e-4)
    assert_close(curve, (1 + 2j * zeta * r) / (1 - r**2 + 2j * zeta * r))


@pytest.mark.parametrize(
    ('dof', 'amplitude', 'low', 'high'),
    [
        ('vertical', 0.5, 1.6, 3.0),
        ('horizontal', 0.5, 1.4, 3.0),
        ('vertical_rotation', 1.0, 3.0, 5.0),
    ],
)
def test_a_cubic_platform_has_the_transmissibility_of_harmonic_balance(dof, amplitude, low, high):
    platform, (curve,) = steps(
        platform__law='symmetric',
        platform__zeta=0.07,
        excitation__frequency_low=low,
        excitation__frequency_high=high,
        **{f'excitation__amplitude__{dof}': amplitude},
    )
    number = DOFS.index(dof)
    omega = 2 * math.pi * curve.frequency_hz
    displacement = amplitude / omega**2 / abs(platform.length[number])
    theory = single_term(
        *platform.law.cubic(platform.design)[number],
        platform.zeta[number],
        displacement,
        omega / platform.omega0[number],
    )
    # one branch only, and so little distortion that one term tells it within a percent
    assert (theory.stable.sum(axis=1) == 1).all()
    assert len(curve.frequency_hz) == 4
    assert np.nanmax(curve.thd) < 0.05
    value = theory.T * np.exp(1j * np.radians(theory.phase_deg))
    assert_close(curve, value[theory.stable])
