"""Signals that hold, jump, go straight or oscillate: steps, sines, a sweep of frequencies, pulses."""

import casadi as ca
import numpy as np

from workbench.blocks.signals.signal import AbstractSignal, Motion, clock
from workbench.core import block, option, parameter
from workbench.core.block import Number, Scalar, Vector


@block
class Constant(AbstractSignal):
    """A signal with the same value at all times.

    Parameters
    ----------
    position
        The value. The signal need not be a position: it may be a voltage or a speed.

    Examples
    --------
    >>> wb.Constant("q", "rad", [0.5, 0.0]).at(3.0).q
    SX([0.5, 0])
    """

    signal: str
    unit: str
    position: Vector = parameter(unit="{unit}", shape=("n",), symbol="q^*")

    def motion(self, t: Number) -> Motion:
        zero = ca.SX.zeros(self.dof)
        return ca.SX(self.position), zero, zero


@block
class Step(AbstractSignal):
    """A step from the value `start` to the value `level` at the instant `time`:

        x_i(t) = start_i for t < time_i,     x_i(t) = level_i for t >= time_i.

    Both derivatives are taken to be zero at all times.

    Parameters
    ----------
    level
        The value from `time` on.
    time
        The instant of the step.
    start
        The value of the signal before the instant `time`.

    Examples
    --------
    >>> wb.Step("omega", "rad/s", level=1.0, time=0.1).at(0.2).omega
    SX(1)
    """

    signal: str
    unit: str
    level: Vector = parameter(unit="{unit}", shape=("n",), symbol="x_1")
    time: Vector = parameter(default=0.0, unit="s", low=0, shape=("n",), symbol="t_s")
    start: Vector = parameter(default=0.0, unit="{unit}", shape=("n",), symbol="x_0")

    def motion(self, t: Number) -> Motion:
        zero = ca.SX.zeros(self.dof)
        return ca.if_else(clock(t) >= self.time, ca.SX(self.level), ca.SX(self.start)), zero, zero


@block
class Ramp(AbstractSignal):
    """A ramp that begins at the value `start` at the instant `time`:

        x_i(t) = start_i for t < time_i,     x_i(t) = start_i + slope_i (t - time_i) for t >= time_i.

    Parameters
    ----------
    slope
        The rate of change from `time` on.
    time
        The instant at which the ramp begins.
    start
        The value of the signal up to the instant `time`.

    Examples
    --------
    >>> wb.Ramp("h", "m", slope=0.01, time=5.0, start=0.1).at(10.0).h
    SX(0.15)
    """

    signal: str
    unit: str
    slope: Vector = parameter(unit="{unit_of_rate}", shape=("n",), symbol="v")
    time: Vector = parameter(default=0.0, unit="s", low=0, shape=("n",), symbol="t_s")
    start: Vector = parameter(default=0.0, unit="{unit}", shape=("n",), symbol="x_0")

    def motion(self, t: Number) -> Motion:
        rate = ca.if_else(clock(t) >= self.time, ca.SX(self.slope), 0)
        return self.start + self.slope * ca.fmax(t - self.time, 0), rate, ca.SX.zeros(self.dof)


@block
class Sines(AbstractSignal):
    """A sine for each component:  x_i(t) = amplitude_i sin(frequency_i t + phase_i).

    Parameters
    ----------
    amplitude
        The peak value of each sine.
    frequency
        The angular frequency of each sine, in rad/s and not in Hz.
    phase
        The phase of each sine at t = 0.

    Examples
    --------
    >>> wb.Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]).at(0.0).qd
    SX([2, 1.5])
    """

    signal: str
    unit: str
    amplitude: Vector = parameter(unit="{unit}", shape=("n",), symbol="a")
    frequency: Vector = parameter(unit="rad/s", shape=("n",), symbol="omega")
    phase: Vector = parameter(default=0.0, unit="rad", shape=("n",), symbol="theta")

    def motion(self, t: Number) -> Motion:
        a, w = self.amplitude, self.frequency
        angle = w * t + self.phase
        return a * ca.sin(angle), a * w * ca.cos(angle), -a * w**2 * ca.sin(angle)


@block
class Chirp(AbstractSignal):
    """A sine whose frequency f(t) goes from `first` to `last` within the time `duration` T, and then stays at `last`:

        x(t) = amplitude sin(2 pi integral f dt + phase)

        f(t) = first + (last - first) t / T      with `sweep="linear"`
        f(t) = first (last / first)^(t / T)      with `sweep="logarithmic"`

    Parameters
    ----------
    amplitude
        The peak value of the sine.
    first
        The frequency at t = 0, in Hz.
    last
        The frequency from t = `duration` on, in Hz. A logarithmic sweep needs two different positive frequencies.
    duration
        The time T of the sweep.
    phase
        The phase of the sine at t = 0.
    sweep
        The law by which the frequency changes.

    Examples
    --------
    >>> chirp = wb.Chirp("omega", "rad/s", amplitude=1.0, first=0.1, last=10.0, duration=20.0)
    >>> chirp.gives.names, chirp.gives["omegad"].unit
    (('omega', 'omegad', 'omegadd'), 'rad/s^2')
    """

    signal: str
    unit: str
    amplitude: Vector = parameter(unit="{unit}", shape=("n",), symbol="a")
    first: Scalar = parameter(unit="Hz", low=0, symbol="f_0")
    last: Scalar = parameter(unit="Hz", low=0, symbol="f_1")
    duration: Scalar = parameter(unit="s", low=0, strict=True, symbol="T")
    phase: Vector = parameter(default=0.0, unit="rad", shape=("n",), symbol="theta")
    sweep: str = option(
        {"linear": "the frequency changes at a constant rate", "logarithmic": "each octave takes the same time"},
        default="linear",
    )

    def __post_init__(self) -> None:
        if self.sweep == "logarithmic" and (min(self.first, self.last) == 0 or self.first == self.last):
            raise ValueError(
                "`Chirp(first=..., last=...)` of a logarithmic sweep must be two positive frequencies that differ, as "
                f"it passes octaves; got {self.first:g} and {self.last:g} Hz."
            )

    def motion(self, t: Number) -> Motion:
        T, s = self.duration, ca.fmin(t, self.duration)
        if self.sweep == "linear":
            growth = (self.last - self.first) / T
            f, turns = self.first + growth * s, self.first * s + growth * s**2 / 2
        else:
            octaves = ca.log(self.last / self.first) / T
            f = self.first * ca.exp(octaves * s)
            growth, turns = octaves * f, (f - self.first) / octaves
        angle = 2 * np.pi * (turns + self.last * ca.fmax(t - T, 0)) + self.phase
        w, wd = 2 * np.pi * f, 2 * np.pi * growth * (t < T)
        sine, cosine = self.amplitude * ca.sin(angle), self.amplitude * ca.cos(angle)
        return sine, w * cosine, wd * cosine - w**2 * sine


@block
class SquareWave(AbstractSignal):
    """A square wave between `amplitude` and 0:  x_i(t) = amplitude_i (square(pi f t) + 1) / 2.

    square(x) has the sign of sin(x) and is 1 at x = 0. So x is at `amplitude` for 1/f seconds and at 0 for the next 1/f
    seconds, and repeats after 2/f seconds. The derivatives are taken to be zero at all times: the jumps have none.

    Parameters
    ----------
    amplitude
        The value in the first half of each period.
    frequency
        The number f of half periods per second.

    Examples
    --------
    >>> wave = wb.SquareWave("q", "rad", [1.0], 0.25)
    >>> wave.signal, wave.frequency
    ('q', 0.25)
    """

    signal: str
    unit: str
    amplitude: Vector = parameter(unit="{unit}", shape=("n",), symbol="a")
    frequency: Scalar = parameter(unit="Hz", low=0, strict=True, symbol="f")

    def motion(self, t: Number) -> Motion:
        down = ca.fmod(ca.floor(self.frequency * t), 2)
        zero = ca.SX.zeros(self.dof)
        return self.amplitude * (1 - down), zero, zero


@block
class PulseTrain(AbstractSignal):
    """A train of pulses: `level` during the first `width` seconds of each `period` from `time` on, and else `base`.

    The derivatives are taken to be zero at all times: the jumps have none.

    Parameters
    ----------
    level
        The value during a pulse.
    period
        The time from the start of one pulse to the start of the next.
    width
        The length of a pulse, less than `period`.
    time
        The instant at which the first pulse starts.
    base
        The value before the first pulse and between pulses.

    Examples
    --------
    >>> wb.PulseTrain("v", "V", level=12.0, period=1.0, width=0.2).at(0.1).v
    SX(12)
    """

    signal: str
    unit: str
    level: Vector = parameter(unit="{unit}", shape=("n",), symbol="x_1")
    period: Scalar = parameter(unit="s", low=0, strict=True, symbol="P")
    width: Scalar = parameter(unit="s", low=0, strict=True, symbol="w")
    time: Scalar = parameter(default=0.0, unit="s", low=0, symbol="t_s")
    base: Vector = parameter(default=0.0, unit="{unit}", shape=("n",), symbol="x_0")

    def __post_init__(self) -> None:
        if self.width >= self.period:
            raise ValueError(
                f"`PulseTrain(width=...)` must be less than the period of {self.period:g} s, or pulses are one; got "
                f"{self.width:g} s."
            )

    def motion(self, t: Number) -> Motion:
        before = (self.width - self.period) / 2  # amid a gap, where the time waits for the first begin
        s, zero = ca.fmax(clock(t) - self.time, before), ca.SX.zeros(self.dof)
        up = s - self.period * ca.floor(s / self.period) < self.width
        return ca.if_else(up, ca.SX(self.level), ca.SX(self.base)), zero, zero
