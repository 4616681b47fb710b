"""Harmonic balance: the oscillation that a switch and a linear part keep up, if both see only its first harmonic."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from workbench.design.chattering.linear_part import ROUNDING, LinearPart
from workbench.design.chattering.switch import AbstractSwitch, BoundaryLayer, SuperTwist
from workbench.validation.refusals import Array, require
from workbench.validation.signatures import door
from workbench.validation.views import show

POINTS, DECADES = 6000, 4  # of the grid of frequencies, beyond the slowest and the fastest pole
TURN = np.sinh(np.linspace(-12, 12, 401))  # times its distance from the axis, about the frequency of a corner
BALANCED = 1e-8  # a sign change across a pole leaves a residual near one


@dataclass(frozen=True)
@show
class Oscillation:
    """s = a sin(w t), as the balance 1 + N(a, j w) W(j w) = 0 has it.

    Attributes
    ----------
    amplitude, frequency
        a in the unit of s, w in rad/s.
    growth
        How a small departure of the amplitude grows, in 1/s; negative where the oscillation attracts (Loeb).
    third
        The third harmonic of s over the first: the balance neglects it, so it is to be small.
    residual
        |1 + N W|.
    """

    amplitude: float
    frequency: float
    growth: float
    third: float
    residual: float

    @property
    def stable(self) -> bool:
        """Whether it attracts."""
        return self.growth < 0


@dataclass(frozen=True)
@show
class Balance:
    """All oscillations that harmonic balance predicts, slowest first, and what it says in a sentence.

    Attributes
    ----------
    least_phi
        The boundary layer at which the last oscillation ends, in the unit of s; None for a super-twist.
    rest
        How fast the linear loop within a boundary layer comes to rest, in 1/s, from its exact poles: negative where
        it does not, zero to rounding where a part of the loop drifts that the switch cannot move; None without a
        layer or with a dead time.
    """

    oscillations: tuple[Oscillation, ...]
    verdict: str
    least_phi: float | None = None
    rest: float | None = None


@door
def harmonic_balance(system: Any, switch: AbstractSwitch) -> Balance:
    """The solutions (a, w) of 1 + N(a, j w) W(j w) = 0 for u = -f(s), s = W u, with Loeb's criterion for each.

    W is exact: a hold and a period in a computer are its own (up to w = pi / period, which is one switch
    at every instant). What is neglected are the harmonics of s, and whatever moves s besides u.

    Parameters
    ----------
    system
        W: a `LinearPart`, or a python-control system from u to s.

    Raises
    ------
    ValueError
        If the system cannot be a `LinearPart`, or the switch is none.

    References
    ----------
    Gelb and Vander Velde (1968), Multiple-Input Describing Functions, chapter 3 (limit cycles and their stability).
    Boiko (2009), Discontinuous Control Systems.
    Utkin, Guldner and Shi (2009), Sliding Mode Control in Electro-Mechanical Systems, chapter 8 (chattering).
    """
    W = LinearPart.of(system)
    require("harmonic_balance(switch=...)", switch, AbstractSwitch)
    crossings = frequencies(W, switch)
    found = [(w, a) for w in crossings if (a := _amplitude(W, switch, w)) is not None]
    held = tuple(o for w, a in found if (o := _oscillation(W, switch, w, a)).residual < BALANCED)
    layer = isinstance(switch, BoundaryLayer)
    K = getattr(switch, "K", None)
    reach = [abs(complex(W.response(w)[0][0])) for w in crossings]
    least = K * max(reach, default=0.0) if K is not None else None
    rest = W.closed(switch.K / switch.phi) if isinstance(switch, BoundaryLayer) and not W.delay else None
    return Balance(held, _verdict(held, layer, least, rest), least, rest)


def frequencies(W: LinearPart, switch: AbstractSwitch) -> list[float]:
    """All frequencies in rad/s at which the phases of W and of the switch can meet, slowest first."""
    w = _grid(W)
    mismatch = np.array([_mismatch(G, switch, W, wi) for wi, G in zip(w, 1 / W.response(w)[0], strict=True)])

    def at(x: float) -> float:
        return _mismatch(complex(1 / W.response(x)[0][0]), switch, W, x)

    places = np.flatnonzero(mismatch[:-1] * mismatch[1:] < 0)
    roots = [float(brentq(at, w[i], w[i + 1], xtol=1e-14 * w[i], rtol=1e-14)) for i in places]
    roots += w[mismatch == 0].tolist()  # two equal lags, say, balance just at their corner, which the grid holds
    if W.period and not isinstance(switch, SuperTwist):
        roots.append(np.pi / W.period)  # where every sampled W is real
    return sorted(x for x in roots if isinstance(switch, SuperTwist) or W.response(x)[0][0].real < 0)


def _mismatch(G: complex, switch: AbstractSwitch, W: LinearPart, w: float) -> float:
    """The part of G + N that `amplitude` leaves, over |G|; NaN where no amplitude is possible."""
    if not isinstance(switch, SuperTwist):
        return G.imag / abs(G)
    I, _ = W.integrator(w)
    a = switch.amplitude(G, I)
    if a is None:
        return float("nan")
    N, J = switch.gain(a)
    return (G + N + J * I).real / abs(G)


def _amplitude(W: LinearPart, switch: AbstractSwitch, w: float) -> float | None:
    G = complex(1 / W.response(w)[0][0])
    return switch.amplitude(G, W.integrator(w)[0])


def _oscillation(W: LinearPart, switch: AbstractSwitch, w: float, a: float) -> Oscillation:
    value, slope = (complex(part[0]) for part in W.response(w))
    I, dI = W.integrator(w)
    (N, J), (dN, dJ) = switch.gain(a), switch.slope(a)
    gain = N + J * I
    by_amplitude, by_s = (dN + dJ * I) * value, J * dI * value + gain * slope
    third = abs(complex(W.response(3 * w)[0][0])) * switch.third(a, W.integrator(3 * w)[0]) / a
    return Oscillation(a, w, -a * (by_amplitude / by_s).real, third, abs(1 + gain * value))


def _grid(W: LinearPart) -> Array:
    """Frequencies in rad/s, as close together about each pole and zero as the phase turns there."""
    corners = W.corners
    sizes = np.abs(corners)
    near = sizes > 1e-9 * sizes.max(initial=0.0)
    corners, sizes = corners[near], sizes[near]
    scale = 1 / W.delay if W.delay else 1.0
    low = min([*sizes, scale]) * 10.0**-DECADES
    high = max([*sizes, scale]) * 10.0**DECADES
    if W.delay:
        high = min(high, np.pi / W.delay)  # beyond, the switch would act more than once within the dead time
    turns = [size + abs(corner.real) * TURN for corner, size in zip(corners, sizes, strict=True)]
    w: Array = np.unique(np.concatenate([np.geomspace(low, high, POINTS), *turns]))
    w = w[(w >= low) & (w <= high)]
    return w[w < np.pi / W.period * (1 - 1e-6)] if W.period else w


def _verdict(held: tuple[Oscillation, ...], layer: bool, least: float | None, rest: float | None) -> str:
    stable = [o for o in held if o.stable]
    if stable:
        return "; ".join(
            f"an oscillation of amplitude {o.amplitude:.4g} at {o.frequency / (2 * np.pi):.4g} Hz, its third harmonic "
            f"{o.third:.1%}"
            for o in stable
        )
    if layer and rest is not None and rest < -ROUNDING:
        return "the rest within the layer is unstable, and no oscillation about it was found to attract"
    if layer and least:
        return (
            f"no oscillation: the layer is wider than {least:.4g}, which is K |W| where W has a phase of -180 degrees"
        )
    if held:
        return "no oscillation that attracts: those of the balance repel"
    return "no oscillation: the phases of W and of the switch meet at no finite frequency"
