"""The late error of a law that follows jumps: the largest error once each jump is some time ago."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import casadi as ca

import workbench as wb


@dataclass(frozen=True)
class SettledError(wb.metrics.AbstractSignalMetric):
    """The largest absolute value of a signal from `after` s on, without `clear` s after each jump, `apart` s apart.

    The reference jumps at the multiples of `apart`. Half a step before a jump counts as the jump, as times are rounded.
    """

    remembers: ClassVar = ("peak",)
    signal: wb.metrics.Signal
    after: float
    clear: float
    apart: float

    def update(self, k: ca.SX, h: ca.SX, z: wb.metrics.Parts, y: wb.metrics.Parts) -> wb.metrics.Parts:
        """The larger of the memory and the present value, where that counts."""
        counts = ca.logic_and(k * h >= self.after - h / 2, ca.fmod(k * h + h / 2, self.apart) >= self.clear)
        size = ca.if_else(counts, ca.fabs(self.column_of(y)), 0)
        return {"peak": ca.if_else(z["peak"] >= size, z["peak"], size)}  # no number is never less, and so stays

    def value(self, integral: wb.Array, z: Mapping[str, wb.Array], horizon: float) -> wb.Array:
        """The largest value of the run."""
        return z["peak"]


def settled_error(name: str, after: float, clear: float, apart: float) -> SettledError:
    """The largest |e| from `after` s on, without the first `clear` s after each jump."""
    about = f"largest |e| from {after:g} s on, without the first {clear:g} s after each jump"
    return SettledError(name, "", about, signal="e", after=after, clear=clear, apart=apart)
