"""Quantisation: a signal in steps, with its rule of rounding, and the converter between a wire and a computer."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.core import block, option, parameter
from workbench.core.block import Scalar, Vector
from workbench.core.validation.refusals import Array

LEAST_QUANTUM = 1e-100  # of a smaller one a reading of 1e208 would have more than a double can count
MOST_BITS = 32  # whose codes exp(bits log 2) gives exactly, once rounded
LOG_2 = float(np.log(2.0))
ROUNDING = {
    "nearest": "the nearest step, the upper one of two: floor(x / q + 1/2) q",
    "down": "the step below: floor(x / q) q",
    "toward zero": "the step nearer to zero, as a cast to a whole number does: floor(x / q) q, of x < 0 ceil(x / q) q",
}


def quantise(x: ca.SX, quantum: ca.SX, rounding: str = "nearest") -> ca.SX:
    """x rounded to a multiple of the quantum by a rule of `ROUNDING`; x itself if the quantum is 0."""
    some = quantum > 0
    b = ca.if_else(some, quantum, 1)  # nothing is ever divided by 0
    return ca.if_else(some, _count(x / b, rounding) * b, x)


def refuse_quantum(call: str, name: str, quantum: Array | float) -> None:
    """Refuse a quantum so small that a double cannot count it."""
    if np.any((quantum > 0) & (quantum < LEAST_QUANTUM)):
        raise ValueError(
            f"`{call}` of '{name}' must be 0, for none, or at least {LEAST_QUANTUM:g}, as a "
            f"reading is a count of quanta, which a number must hold; got {quantum}."
        )


@block
class Converter:
    """A converter between a signal and a computer, with `bits` bits for the range from `low` to `high`:

        y = low + c q,   c = min(max(round((x - low) / q), 0), N - 1),   q = (high - low) / N,   N = 2^bits.

    So the highest code stands for high - q, as in data sheets, and 0 has a code if low = -high. Each end is one number,
    or (k,), one for each number of the signal. If `bits` is not a whole number, as in a search, there are
    N = floor(2^bits + 1/2) codes.
    """

    signal: str
    unit: str
    bits: Scalar = parameter(unit="bit", low=1, high=MOST_BITS, symbol="b")
    low: Vector = parameter(unit="{unit}", shape=("*",), symbol="v_min")
    high: Vector = parameter(unit="{unit}", shape=("*",), symbol="v_max")
    rounding: str = option(ROUNDING, default="nearest")

    def __post_init__(self) -> None:
        if np.any(self.low >= self.high):
            raise ValueError(
                f"`Converter(low=..., high=...)` of '{self.signal}' must leave room between them; got {self.low} and "
                f"{self.high}."
            )

    @property
    def quantum(self) -> Vector:
        """The step q, in the unit of the signal."""
        return (self.high - self.low) / self._codes

    @property
    def top(self) -> Vector:
        """The value of the highest code, high - q."""
        return self.low + (self._codes - 1) * self.quantum

    def output(self, x: ca.SX) -> ca.SX:
        """The converted signal, element by element."""
        code = _count((x - self.low) / self.quantum, self.rounding)
        y: ca.SX = self.low + ca.fmin(ca.fmax(code, 0), self._codes - 1) * self.quantum
        return y

    def value(self, x: Array | float) -> Array | float:
        """The converted number for x, or numbers (k,); x has the shape of the ends."""
        y = np.array(ca.evalf(ca.SX(self.output(ca.SX(ca.DM(np.asarray(x, dtype=float))))))).ravel()
        return float(y[0]) if np.ndim(x) == 0 and y.size == 1 else y

    @property
    def _codes(self) -> Scalar:
        lifted = isinstance(self.bits, ca.SX)
        return ca.floor(ca.exp(self.bits * LOG_2) + 0.5) if lifted else float(np.floor(2.0**self.bits + 0.5))


def _count(x: ca.SX, rounding: str) -> ca.SX:
    """x rounded to a whole number."""
    if rounding == "toward zero":
        return ca.if_else(x < 0, ca.ceil(x), ca.floor(x))
    return ca.floor(x + 0.5 if rounding == "nearest" else x)
