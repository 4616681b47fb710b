"""Signals of many frequencies: a sweep through them, and noise."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.core import block, option, parameter
from workbench.core.block import Number, Scalar, Vector
from workbench.signals.signal import AbstractSignal, Motion, count
from workbench.validation import refusals

MOST_SINES = 1000


@block
class Chirp(AbstractSignal):
    """A sine whose frequency goes from `first` to `last` in the time `duration` T, and stays there:

        x(t) = amplitude sin(2 pi integral f + phase),     f = first + (last - first) t / T,
                                                      or   f = first (last / first)^(t / T).

    Raises
    ------
    ValueError
        If a logarithmic sweep begins or ends at 0 Hz, or where it begins.

    Examples
    --------
    >>> chirp = wb.Chirp("omega", "rad/s", amplitude=1.0, first=0.1, last=10.0, duration=20.0)
    >>> chirp.says.names, chirp.says["omegad"].unit
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
        {"linear": "the frequency grows in proportion to time", "logarithmic": "each octave takes as long"},
        default="linear",
    )

    def __post_init__(self) -> None:
        if self.sweep == "logarithmic" and (min(self.first, self.last) == 0 or self.first == self.last):
            raise ValueError(
                "`Chirp(first=..., last=...)` of a logarithmic sweep must be two positive frequencies that differ, as "
                f"it passes octaves; got {self.first:g} and {self.last:g} Hz."
            )

    @property
    def dof(self) -> int:
        """How many numbers it has, n."""
        return count(self.amplitude)

    def motion(self, t: Number) -> Motion:
        """The sine and its derivatives."""
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
class ColouredNoise(AbstractSignal):
    """Noise of a first-order spectrum by seed: a sum of N sines at multiples of one frequency, phases by chance,

        x(t) = sigma sum a_k sin(w_k t + theta_k),   w_k = 2 pi k / period,   a_k^2 ~ 2 / (1 + (w_k time_constant)^2).

    The a_k^2 / 2 add up to 1, so that over a period its mean is 0 and its variance sigma^2 exactly. It repeats after
    `period`; it has no power above N / period Hz, which is to lie well above 1 / (2 pi time_constant). As an expression
    in time it is the same in every method and at every step. The numbers of a signal are independent of one another.

    Parameters
    ----------
    sigma
        (n,), standard deviations.
    time_constant
        Of the correlation exp(-|s| / time_constant), which it has but for the ends of the spectrum.
    seed
        Of the phases, which are evenly spread.
    period
        In s, at least the length of the run.

    References
    ----------
    Shinozuka and Deodatis (1991), Simulation of stochastic processes by spectral representation, Applied Mechanics
    Reviews 44(4).
    """

    signal: str
    unit: str
    sigma: Vector = parameter(unit="{unit}", low=0, shape=("n",), symbol="sigma")
    time_constant: Scalar = parameter(unit="s", low=0, strict=True, symbol="T")
    period: Scalar = parameter(unit="s", low=0, strict=True, symbol="P")
    seed: int = 0
    sines: int = 64

    def __post_init__(self) -> None:
        refusals.seed("ColouredNoise(seed=...)", self.seed)
        refusals.whole("ColouredNoise(sines=...)", self.sines, most=MOST_SINES)

    @property
    def dof(self) -> int:
        """How many numbers it has, n."""
        return count(self.sigma)

    def motion(self, t: Number) -> Motion:
        """The sum and its derivatives."""
        phase = np.random.default_rng(self.seed).uniform(0.0, 2 * np.pi, (self.sines, self.dof))
        w = ca.SX(2 * np.pi * np.arange(1, self.sines + 1)) / self.period
        power = 1 / (1 + (w * self.time_constant) ** 2)
        a = ca.sqrt(2 * power / ca.sum1(power))
        angle = ca.repmat(w * t, 1, self.dof) + phase
        sine, cosine = ca.sin(angle).T, ca.cos(angle).T
        return self.sigma * (sine @ a), self.sigma * (cosine @ (a * w)), -self.sigma * (sine @ (a * w**2))
