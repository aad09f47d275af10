"""The commanded base motion: a frequency plan with an amplitude, ramped in and out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.excitation import EXCITATIONS
from qzs_rig.excitation.segments import Cycles, Dwell, Segment
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import NS, Array
from qzs_rig.units import DOFS, QUANTITIES

Wave = tuple[Array, Array, Array]
"""A function of time with its first and second derivative, each (n,) or (n, c)."""


def fade_in(t: Array, ramp: float) -> Wave:
    """(1 - cos(pi t / ramp)) / 2 from 0 at t <= 0 to 1 at t >= ramp."""
    w = math.pi / ramp
    inside = (t > 0.0) & (t < ramp)
    sin, cos = np.sin(w * t), np.cos(w * t)
    level = np.where(inside, 0.5 * (1.0 - cos), (t >= ramp).astype(np.float64))
    return level, np.where(inside, 0.5 * w * sin, 0.0), np.where(inside, 0.5 * w * w * cos, 0.0)


def fade_out(t: Array, ramp: float) -> Wave:
    """The mirror of fade_in: 1 at t <= 0, 0 at t >= ramp."""
    level, slope, bend = fade_in(t, ramp)
    return 1.0 - level, -slope, -bend


def shaped(envelope: Wave, wave: Wave) -> Wave:
    """`envelope` times `wave` by the product rule."""
    e, de, dde = envelope
    x, dx, ddx = wave
    return e * x, de * x + e * dx, dde * x + 2.0 * de * dx + e * ddx


@dataclass(frozen=True)
class Drive:
    """Base motion of a whole run: ramp in at the first frequency, plan, ramp out at the last.

    `order` is the time derivative whose amplitude (4,) is held: 0 displacement, 1 velocity,
    2 acceleration. The displacement amplitude at f is amplitude / (2 pi f)^order.
    """

    segments: tuple[Segment, ...]
    amplitude: tuple[float, ...]
    order: int
    ramp: float
    step_ns: int

    @classmethod
    def from_spec(cls, spec: RunSpec, step_ns: int) -> Drive:
        """The drive that a run asks for; raises InputError where it asks for nothing or aliases."""
        plan = EXCITATIONS[spec.text('excitation.kind')](spec)
        amplitude = tuple(spec.number(f'excitation.amplitude.{dof}') for dof in DOFS)
        if not any(amplitude):
            raise InputError(
                'every excitation.amplitude is 0, so nothing would move; '
                'set excitation.amplitude.vertical (or another degree of freedom)'
            )
        ramp = spec.number('excitation.ramp')
        first, last = _edge_hz(plan[0], 0.0), _edge_hz(plan[-1], plan[-1].duration)
        drive = cls(
            (Dwell(first, ramp), *plan, Dwell(last, ramp)),
            amplitude,
            QUANTITIES.index(spec.text('excitation.quantity')),
            ramp,
            step_ns,
        )
        top_hz = max(_edge_hz(s, t) for s in plan for t in (0.0, s.duration))
        if top_hz > 0.1 * NS / step_ns:
            raise InputError(
                f'{top_hz:g} Hz needs a sample rate of at least ten times that; '
                f'raise run.rate above {10 * top_hz:g} Hz or lower the frequency'
            )
        return drive

    @property
    def duration(self) -> float:
        """Length in s, both ramps included."""
        return sum(segment.duration for segment in self.segments)

    @property
    def samples(self) -> int:
        """Samples of the whole run, the last at rest; sample k is at k * step_ns from the start."""
        return math.ceil(self.duration * NS / self.step_ns) + 1

    def motion(self, first: int, last: int) -> Array:
        """Base motion at samples `first` to `last` (excluded) -> (n, 12): position, velocity and
        acceleration of the four degrees of freedom, SI, z up. Exact derivatives of one formula.
        """
        if last <= first:
            return np.empty((0, 3 * len(DOFS)))
        t = np.arange(first, last) * self.step_ns / NS
        motion = np.zeros((len(t), 3 * len(DOFS)))
        for order, part in enumerate(self._unit_wave(t)):
            for dof, amplitude in enumerate(self.amplitude):
                if amplitude:
                    motion[:, order * len(DOFS) + dof] = amplitude * part
        return motion

    def _unit_wave(self, t: Array) -> tuple[Array, Array, Array]:
        cycles = self._cycles(t)
        wave = _held_sine(cycles, self.order)
        end = self.duration - self.ramp
        if t[0] < self.ramp:
            wave = shaped(fade_in(t, self.ramp), wave)
        if t[-1] > end:
            wave = shaped(fade_out(t - end, self.ramp), wave)
        return wave

    def frequency_hz(self, t: float) -> float:
        """Commanded frequency at time t in s."""
        return float(self.frequencies_hz(np.array([t]))[0])

    def frequencies_hz(self, t: Array) -> Array:
        """Commanded frequency at times t (n,) in s, rising."""
        return self._cycles(t).frequency

    def _cycles(self, t: Array) -> Cycles:
        out = Cycles(*(np.empty_like(t) for _ in range(4)))
        begin, turns = 0.0, 0.0
        for number, segment in enumerate(self.segments):
            end = begin + segment.duration
            final = number == len(self.segments) - 1
            here = (t >= begin) & ((t < end) | final)
            if here.any():
                piece = segment.cycles(t[here] - begin)
                out.phase[here] = piece.phase + turns
                for whole, part in zip(out[1:], piece[1:], strict=True):
                    whole[here] = part
            # whole turns are dropped, so the phase keeps its digits however long the run
            turns = (turns + _turns(segment)) % 1.0
            begin = end
        return out


def _held_sine(cycles: Cycles, order: int) -> tuple[Array, Array, Array]:
    """Displacement X sin(phi) with X = phi'^-order, and its exact first two derivatives."""
    phi, w, dw, ddw = (2.0 * math.pi * part for part in (cycles.phase % 1.0, *cycles[1:]))
    sin, cos = np.sin(phi), np.cos(phi)
    p, slowness = float(order), 1.0 / w
    X = slowness**order
    dX = -p * X * slowness * dw
    ddX = -X * slowness * p * (ddw - (p + 1.0) * slowness * dw * dw)
    position = X * sin
    velocity = dX * sin + X * w * cos
    acceleration = (ddX - X * w**2) * sin + (2.0 * dX * w + X * dw) * cos
    return position, velocity, acceleration


def _turns(segment: Segment) -> float:
    return float(segment.cycles(np.array([segment.duration])).phase[0])


def _edge_hz(segment: Segment, t: float) -> float:
    return float(segment.cycles(np.array([t])).frequency[0])
