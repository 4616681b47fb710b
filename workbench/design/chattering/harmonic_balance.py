"""Harmonic balance: the oscillation of a loop of a switch and a linear part, by its first harmonic alone."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, finite, positive, require
from workbench.core.validation.signatures import check_arguments
from workbench.design.chattering.linear_part import ROUNDING, LinearPart
from workbench.design.control_system import System

LEAST = 1e-100  # an amplitude
POINTS, DECADES = 6000, 4  # of the grid of frequencies, beyond the slowest and the fastest pole
TURN = np.sinh(np.linspace(-12, 12, 401))  # times its distance from the axis, about the frequency of a corner
BALANCE_TOLERANCE = 1e-8  # a sign change across a pole leaves a residual near one


class AbstractSwitch(ABC):
    """An odd switching function f(s) with its describing function N(a), the gain for s = a sin(w t)."""

    K: float

    @abstractmethod
    def amplitude(self, g: float) -> float | None:
        """The amplitude a with N(a) = g, or None if there is none."""

    @abstractmethod
    def gain(self, a: float) -> float:
        """The describing function N(a)."""

    @abstractmethod
    def slope(self, a: float) -> float:
        """The derivative dN/da."""

    @abstractmethod
    def third(self, a: float) -> float:
        """The amplitude of the third harmonic of f."""


@dataclass(frozen=True)
@check_arguments
class Relay(AbstractSwitch):
    """f(s) = K sign(s), K > 0, N(a) = 4 K / (pi a) (Gelb and Vander Velde 1968, appendix B)."""

    K: float

    def __post_init__(self) -> None:
        positive("Relay(K=...)", self.K)

    @check_arguments
    def amplitude(self, g: float) -> float | None:
        """The amplitude a with N(a) = g: 4 K / (pi g)."""
        return 4 * self.K / (math.pi * g) if g > 0 else None

    @check_arguments
    def gain(self, a: float) -> float:
        """The describing function N(a) = 4 K / (pi a)."""
        a = _amplitude("gain", a)
        return 4 * self.K / (math.pi * a)

    @check_arguments
    def slope(self, a: float) -> float:
        """The derivative dN/da = -4 K / (pi a^2)."""
        a = _amplitude("slope", a)
        return -4 * self.K / (math.pi * a**2)

    @check_arguments
    def third(self, a: float) -> float:
        """The amplitude of the third harmonic, 4 K / (3 pi)."""
        return 4 * self.K / (3 * math.pi)


@dataclass(frozen=True)
@check_arguments
class BoundaryLayer(AbstractSwitch):
    """f(s) = K sat(s / phi), clipped; with r = phi / a, N(a) = 2 K (asin r + r sqrt(1 - r^2)) / (pi phi) for r < 1.

    K and phi are positive. Gelb and Vander Velde (1968), Multiple-Input Describing Functions, appendix B.
    """

    K: float
    phi: float

    def __post_init__(self) -> None:
        positive("BoundaryLayer(K=...)", self.K)
        positive("BoundaryLayer(phi=...)", self.phi)

    @check_arguments
    def amplitude(self, g: float) -> float | None:
        """The amplitude a with N(a) = g; None if g is above the largest gain of the layer, K / phi."""
        if not 0 < g < self.K / self.phi:
            return None
        relay = 4 * self.K / (math.pi * g)  # a saturation does less than the relay, so its amplitude is smaller
        return float(brentq(lambda a: self.gain(a) - g, self.phi, relay, xtol=1e-15 * relay, rtol=1e-14))

    @check_arguments
    def gain(self, a: float) -> float:
        """The describing function N(a), which is K / phi within the layer."""
        r = min(self.phi / _amplitude("gain", a), 1.0)
        return 2 * self.K / (math.pi * self.phi) * (math.asin(r) + r * math.sqrt(1 - r**2))

    @check_arguments
    def slope(self, a: float) -> float:
        """The derivative dN/da, which is zero within the layer."""
        a = _amplitude("slope", a)
        r = min(self.phi / a, 1.0)
        return -4 * self.K / (math.pi * a**2) * math.sqrt(1 - r**2)

    @check_arguments
    def third(self, a: float) -> float:
        """The amplitude of the third harmonic: zero within the layer, and near that of a relay far beyond it."""
        a = _amplitude("third", a)
        c = math.asin(min(self.phi / a, 1.0))
        rising = a / self.phi * (math.sin(2 * c) / 4 - math.sin(4 * c) / 8)
        return abs(4 * self.K / math.pi * (rising + math.cos(3 * c) / 3))


def _amplitude(call: str, a: float) -> float:
    """An amplitude whose square is a float."""
    return finite(f"{call}(a=...)", a, " beyond zero", low=LEAST, high=1 / LEAST)


@dataclass(frozen=True)
@show
class Oscillation:
    """An oscillation s = a sin(w t) that satisfies the balance 1 + N(a, j w) W(j w) = 0, w in rad/s.

    `amplitude` is a, in the unit of s, and `frequency` is w. A small deviation of the amplitude grows at the rate
    `growth` in 1/s, which is negative if the oscillation attracts (Loeb). `third` is the third harmonic of s over the
    first; the balance neglects it, and so it must be small. `residual` is |1 + N W|.
    """

    amplitude: float
    frequency: float
    growth: float
    third: float
    residual: float

    @property
    def stable(self) -> bool:
        """True if nearby motions approach the oscillation."""
        return self.growth < 0


@dataclass(frozen=True)
@show
class Balance:
    """All oscillations that harmonic balance predicts, slowest first, with a verdict in a sentence.

    The last oscillation ends at a boundary layer of `least_phi`, in the unit of s. `rest` is the rate of decay of the
    linear loop within the layer, in 1/s. It is None without a layer, and zero but for rounding if a part drifts that
    the switch cannot move.
    """

    oscillations: tuple[Oscillation, ...]
    verdict: str
    least_phi: float = 0.0
    rest: float | None = None


@check_arguments
def harmonic_balance(system: System, switch: AbstractSwitch) -> Balance:
    """The solutions (a, w) of 1 + N(a, j w) W(j w) = 0 for u = -f(s), s = W u, with Loeb's criterion for each.

    `system` is W, a `LinearPart` or a python-control system from u to s. W is exact: that of a loop in a computer
    includes hold and period, up to w = pi / period. The balance neglects the harmonics of s, and whatever moves s
    besides u.

    Raises
    ------
    ValueError
        If `system` cannot be a `LinearPart`, or `switch` is not an `AbstractSwitch`.

    References
    ----------
    Gelb and Vander Velde (1968), Multiple-Input Describing Functions, chapter 3 (limit cycles and their stability).
    Utkin, Guldner and Shi (2009), Sliding Mode Control in Electro-Mechanical Systems, chapter 8 (chattering).

    Examples
    --------
    >>> import control
    >>> from workbench.design.chattering import BoundaryLayer, harmonic_balance
    >>> balance = harmonic_balance(control.tf([81.0], [1.0, 18.0, 81.0, 0.0]), BoundaryLayer(8.0, 0.3))
    >>> [(round(one.amplitude, 6), round(one.frequency, 6)) for one in balance.oscillations]
    [(0.534593, 9.0)]
    """
    W = LinearPart.of(system)
    require("harmonic_balance(switch=...)", switch, AbstractSwitch)
    crossings = _crossings(W)
    found = [(w, a) for w in crossings if (a := switch.amplitude(-(1 / complex(W.response(w)[0][0])).real)) is not None]
    held = tuple(o for w, a in found if (o := _oscillation(W, switch, w, a)).residual < BALANCE_TOLERANCE)
    least = switch.K * max((abs(complex(W.response(w)[0][0])) for w in crossings), default=0.0)
    rest = W.decay_rate(switch.K / switch.phi) if isinstance(switch, BoundaryLayer) else None
    return Balance(held, _verdict(held, least, rest), least, rest)


def _crossings(W: LinearPart) -> list[float]:
    """All frequencies in rad/s at which W is real and negative, slowest first."""
    w = _grid(W)
    inverse = 1 / W.response(w)[0]
    phase = np.array([G.imag / abs(G) for G in inverse])

    def at(x: float) -> float:
        G = complex(1 / W.response(x)[0][0])
        return G.imag / abs(G)

    places = np.flatnonzero(phase[:-1] * phase[1:] < 0)
    roots = [float(brentq(at, w[i], w[i + 1], xtol=1e-14 * w[i], rtol=1e-14)) for i in places]
    roots += w[phase == 0].tolist()  # two equal lags, say, balance just at their corner, which the grid holds
    if W.period:
        roots.append(np.pi / W.period)  # where every sampled W is real
    return sorted(x for x in roots if W.response(x)[0][0].real < 0)


def _oscillation(W: LinearPart, switch: AbstractSwitch, w: float, a: float) -> Oscillation:
    value, slope = (complex(part[0]) for part in W.response(w))
    gain = switch.gain(a)
    growth = -a * (switch.slope(a) * value / (gain * slope)).real
    third = abs(complex(W.response(3 * w)[0][0])) * switch.third(a) / a
    return Oscillation(a, w, growth, third, abs(1 + gain * value))


def _grid(W: LinearPart) -> Array:
    """Frequencies in rad/s, as close together about each pole and zero as the phase turns there."""
    corners = W.corners
    sizes = np.abs(corners)
    near = sizes > 1e-9 * sizes.max(initial=0.0)
    corners, sizes = corners[near], sizes[near]
    low, high = min([*sizes, 1.0]) * 10.0**-DECADES, max([*sizes, 1.0]) * 10.0**DECADES
    turns = [size + abs(corner.real) * TURN for corner, size in zip(corners, sizes, strict=True)]
    w: Array = np.unique(np.concatenate([np.geomspace(low, high, POINTS), *turns]))
    w = w[(w >= low) & (w <= high)]
    return w[w < np.pi / W.period * (1 - 1e-6)] if W.period else w


def _verdict(oscillations: tuple[Oscillation, ...], least: float, rest: float | None) -> str:
    stable = [o for o in oscillations if o.stable]
    if stable:
        return "; ".join(
            f"an oscillation of amplitude {o.amplitude:.4g} at {o.frequency / (2 * np.pi):.4g} Hz, its third harmonic "
            f"{o.third:.1%}"
            for o in stable
        )
    if rest is not None and rest < -ROUNDING:
        return "the rest within the layer is unstable, and no oscillation about it was found to attract"
    if rest is not None and least:
        return (
            f"no oscillation: the layer is wider than {least:.4g}, which is K |W| where W has a phase of -180 degrees"
        )
    if oscillations:
        return "no oscillation that attracts: those of the balance repel"
    return "no oscillation: the phases of W and of the switch meet at no finite frequency"
