"""The figures of a loop on which limits can be set, with their units and their sides."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from workbench.core.validation.refusals import as_number, refusal
from workbench.design.frequency import CertifiedValue

BELOW_ZERO = -5e-324  # the end of a range that begins with zero
Side = Literal["at most", "at least", "within"]


@dataclass(frozen=True)
class FigureKind:
    """A figure of a loop: its name, its words, its unit, the side of its limit, and the range in which a limit lies.

    `why` gives the reason of the range.
    """

    name: str
    words: str
    unit: str
    side: Side
    low: float
    high: float
    why: str

    def check(self, limit: object) -> float:
        """The limit, if it lies within the range, its ends not included."""
        number = as_number(limit)
        if number is None or not self.low < number < self.high:
            upper = f" and below {self.high:g}" if self.high < math.inf else ""
            lower = "at least 0" if self.low == BELOW_ZERO else f"above {self.low:g}"
            raise refusal(f"Specification({self.name}=...)", f"{lower}{upper}, {self.why}", limit)
        return number


KINDS = {
    kind.name: kind
    for kind in (
        FigureKind("Ms", "peak of S", "", "at most", 1, math.inf, "as no loop has a smaller peak of S"),
        FigureKind("Mt", "peak of T", "", "at most", 0, math.inf, "as a gain is positive"),
        FigureKind("bandwidth", "bandwidth", "rad/s", "within", 0, math.inf, "a range (low, high)"),
        FigureKind("damping", "least damping", "", "at least", 0, 1, "as a pole that oscillates has less than 1"),
        FigureKind("decay", "slowest decay", "1/s", "at least", 0, math.inf, "as a stable loop decays"),
        FigureKind("gain_margin", "gain margin", "", "at least", 1, math.inf, "a factor, whose inverse counts as well"),
        FigureKind("phase_margin", "phase margin", "deg", "at least", 0, 180, "in degrees"),
        FigureKind("delay_margin", "delay margin", "s", "at least", 0, math.inf, "in seconds"),
        FigureKind("disk_margin", "disk margin", "", "at least", 0, math.inf, "the size of a disk"),
        FigureKind("noise_gain", "gain from noise", "", "at most", 0, math.inf, "as a gain is positive"),
        FigureKind("overshoot", "overshoot", "%", "at most", BELOW_ZERO, math.inf, "in percent of the final value"),
        FigureKind("settling_time", "settling time", "s", "at most", 0, math.inf, "in seconds"),
        FigureKind("rise_time", "rise time", "s", "at most", 0, math.inf, "in seconds"),
    )
}


@dataclass(frozen=True)
class FigureLimit:
    """A limit low <= figure <= high of one kind of figure, with an infinite end where it has one side alone."""

    kind: FigureKind
    low: float
    high: float

    @staticmethod
    def of(kind: FigureKind, value: object) -> FigureLimit:
        """The limit that a specification names."""
        if kind.side == "within":
            return FigureLimit(kind, *_range(kind, value))
        number = kind.check(value)
        return FigureLimit(kind, -math.inf, number) if kind.side == "at most" else FigureLimit(kind, number, math.inf)

    def margin(self, value: float) -> float:
        """The distance of a figure from the nearer end of the limit, negative beyond it."""
        return min(value - self.low, self.high - value)

    def judge(self, figure: CertifiedValue) -> Literal["holds", "fails", "undecided"]:
        """The verdict on a figure that is known between bounds."""
        if self.low <= figure.low and figure.high <= self.high:
            return "holds"
        if figure.high < self.low or figure.low > self.high:
            return "fails"
        return "undecided"

    def margin_of(self, figure: CertifiedValue) -> float:
        """The distance from the limit that is certain: of the bound that is nearer to it, or farther beyond."""
        return min(self.margin(figure.low), self.margin(figure.high))

    @property
    def words(self) -> str:
        """The limit as text: 'Ms <= 1.4'."""
        unit = f" {self.kind.unit}" if self.kind.unit else ""
        if self.low == -math.inf:
            return f"{self.kind.name} <= {self.high:g}{unit}"
        if self.high == math.inf:
            return f"{self.kind.name} >= {self.low:g}{unit}"
        return f"{self.low:g} <= {self.kind.name} <= {self.high:g}{unit}"


def _range(kind: FigureKind, value: object) -> tuple[float, float]:
    """Both ends of a range; the upper one may be infinite, and the lower one zero."""
    call, must = f"Specification({kind.name}=...)", f"a pair (low, high) in {kind.unit} with 0 <= low < high"
    ends = [as_number(end) for end in value] if isinstance(value, list | tuple) else []
    pair = [end for end in ends if end is not None]
    if len(ends) != 2 or len(pair) != 2:
        raise refusal(call, must, value)
    low, high = pair
    if not 0 <= low < high or math.isinf(low):
        raise refusal(call, must, value, ": exchange its ends" if 0 <= high < low else "")
    if low == 0 and math.isinf(high):
        raise refusal(call, must, value, ", which limits nothing")
    return low, high
