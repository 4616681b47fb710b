"""What switches: torques -f(s) by their describing functions, the gain that a sine of amplitude a sees."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

from scipy.optimize import brentq

from workbench.validation.refusals import finite, positive
from workbench.validation.signatures import door

# The first and third Fourier coefficients of |sin|^(1/2) sign(sin), by the beta function.
ROOT_FIRST = 2 * math.gamma(5 / 4) / (math.sqrt(math.pi) * math.gamma(7 / 4))
LEAST = 1e-100  # an amplitude
ROOT_THIRD = 3 * ROOT_FIRST - 8 * math.gamma(9 / 4) / (math.sqrt(math.pi) * math.gamma(11 / 4))


class AbstractSwitch(ABC):
    """An odd f(s), as a gain N(a) + J(a) I on s = a sin(w t), where I is what the loop makes of an integrator."""

    @abstractmethod
    def amplitude(self, G: float | complex, I: float | complex) -> float | None:
        """The a for which Im(G + N) = 0 if f has an integral and Re(G + N) = 0 otherwise, where G = 1 / W; or None."""

    @abstractmethod
    def gain(self, a: float) -> tuple[float, float]:
        """N(a) and J(a)."""

    @abstractmethod
    def slope(self, a: float) -> tuple[float, float]:
        """dN/da and dJ/da."""

    @abstractmethod
    def third(self, a: float, I: float | complex) -> float:
        """The amplitude of the third harmonic of f, where I is the integrator at 3 w."""


@dataclass(frozen=True)
@door
class Relay(AbstractSwitch):
    """f(s) = K sign(s), N(a) = 4 K / (pi a).

    Raises
    ------
    ValueError
        If K is not positive and finite.

    References
    ----------
    Gelb and Vander Velde (1968), Multiple-Input Describing Functions, appendix B.
    """

    K: float

    def __post_init__(self) -> None:
        _positive(self, "K")

    @door
    def amplitude(self, G: float | complex, I: float | complex) -> float | None:
        """4 K / (pi |G|)."""
        return 4 * self.K / (math.pi * -G.real) if G.real < 0 else None

    @door
    def gain(self, a: float) -> tuple[float, float]:
        """4 K / (pi a)."""
        a = _of_use("gain", a)
        return 4 * self.K / (math.pi * a), 0.0

    @door
    def slope(self, a: float) -> tuple[float, float]:
        """Falling."""
        a = _of_use("slope", a)
        return -4 * self.K / (math.pi * a**2), 0.0

    @door
    def third(self, a: float, I: float | complex) -> float:
        """4 K / (3 pi)."""
        return 4 * self.K / (3 * math.pi)


@dataclass(frozen=True)
@door
class BoundaryLayer(AbstractSwitch):
    """f(s) = K sat(s / phi), clipped; with r = phi / a, N(a) = 2 K (asin r + r sqrt(1 - r^2)) / (pi phi) for r < 1.

    Raises
    ------
    ValueError
        If K or phi is not positive and finite.

    References
    ----------
    Gelb and Vander Velde (1968), Multiple-Input Describing Functions, appendix B.
    """

    K: float
    phi: float

    def __post_init__(self) -> None:
        _positive(self, "K", "phi")

    @door
    def amplitude(self, G: float | complex, I: float | complex) -> float | None:
        """None where the layer's own gain K / phi does not reach |G|."""
        g = -G.real
        if not 0 < g < self.K / self.phi:
            return None
        relay = 4 * self.K / (math.pi * g)  # a saturation does less than the relay, so its amplitude is smaller
        return float(brentq(lambda a: self.gain(a)[0] - g, self.phi, relay, xtol=1e-15 * relay, rtol=1e-14))

    @door
    def gain(self, a: float) -> tuple[float, float]:
        """K / phi within the layer."""
        a = _of_use("gain", a)
        r = min(self.phi / a, 1.0)
        return 2 * self.K / (math.pi * self.phi) * (math.asin(r) + r * math.sqrt(1 - r**2)), 0.0

    @door
    def slope(self, a: float) -> tuple[float, float]:
        """Falling outside the layer."""
        a = _of_use("slope", a)
        r = min(self.phi / a, 1.0)
        return -4 * self.K / (math.pi * a**2) * math.sqrt(1 - r**2), 0.0

    @door
    def third(self, a: float, I: float | complex) -> float:
        """None within the layer, that of the relay far beyond it."""
        a = _of_use("third", a)
        c = math.asin(min(self.phi / a, 1.0))
        rising = a / self.phi * (math.sin(2 * c) / 4 - math.sin(4 * c) / 8)
        return abs(4 * self.K / math.pi * (rising + math.cos(3 * c) / 3))


@dataclass(frozen=True)
@door
class SuperTwist(AbstractSwitch):
    """f(s) = k1 |s|^(1/2) sign(s) + k2 times the integral of sign(s): N(a) = 1.1128 k1 / a^(1/2), J(a) = 4 k2 / (pi a).

    Raises
    ------
    ValueError
        If k1 or k2 is not positive and finite.

    References
    ----------
    Boiko and Fridman (2005), Analysis of chattering in continuous sliding-mode controllers, IEEE Transactions on
    Automatic Control 50(9).
    Perez-Ventura and Fridman (2019), When is it reasonable to implement the discontinuous sliding-mode
    controllers instead of the continuous ones? Frequency domain criteria, International Journal of Robust
    and Nonlinear Control 29(3).
    """

    k1: float
    k2: float

    def __post_init__(self) -> None:
        _positive(self, "k1", "k2")

    @door
    def amplitude(self, G: float | complex, I: float | complex) -> float | None:
        """From Im G + J(a) Im I = 0."""
        rest = -G.imag / I.imag if I.imag else 0.0
        return 4 * self.k2 / (math.pi * rest) if rest > 0 else None

    @door
    def gain(self, a: float) -> tuple[float, float]:
        """N and J as above."""
        a = _of_use("gain", a)
        return ROOT_FIRST * self.k1 / math.sqrt(a), 4 * self.k2 / (math.pi * a)

    @door
    def slope(self, a: float) -> tuple[float, float]:
        """Falling, both."""
        a = _of_use("slope", a)
        N, J = self.gain(a)
        return -N / (2 * a), -J / a

    @door
    def third(self, a: float, I: float | complex) -> float:
        """Of root and integral together."""
        a = _of_use("third", a)
        return abs(ROOT_THIRD * self.k1 * math.sqrt(a) + 4 * self.k2 / (3 * math.pi) * I)


def _of_use(call: str, a: float) -> float:
    """An amplitude whose square and root are floats."""
    return finite(f"{call}(a=...)", a, " beyond zero", low=LEAST, high=1 / LEAST)


def _positive(switch: AbstractSwitch, *fields: str) -> None:
    """Refuse a gain that is none: one of the wrong sign drives s away from zero."""
    for field in fields:
        object.__setattr__(switch, field, positive(f"{type(switch).__name__}({field}=...)", getattr(switch, field)))
