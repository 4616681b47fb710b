"""Goals of a structured design: a norm, a decay or a damping, which is made good or kept within a limit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from workbench.core.validation.refusals import finite, positive, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency import CertifiedValue, h2_norm, hinf_norm
from workbench.design.frequency.pole_figures import pole_figures
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import DesignError
from workbench.design.structured_tuning.figure_pieces import (
    FigurePiece,
    damping_pieces,
    h2_piece,
    logarithm,
    pole_pieces,
)
from workbench.design.structured_tuning.gain_peaks import gain_pieces
from workbench.design.structured_tuning.system_jets import SystemJet

if TYPE_CHECKING:
    import control

Figure = Literal["hinf", "h2", "decay", "damping"]
WORDS = {"hinf": "H-infinity norm", "h2": "H2 norm", "decay": "slowest decay", "damping": "least damping"}
ROOM = 1e-6  # relative, by which a limit is kept in the search, so that it is kept for certain in the end
ROUNDING = 1e-12  # relative, of a singular value in doubles


@dataclass(frozen=True)
@check_arguments
class DesignGoal:
    """A goal for one figure of the closed loop: hard if it has a limit, else soft and made as good as possible.

    Attributes
    ----------
    figure
        "hinf" or "h2", a norm from w to z, made small; "decay", the rate of the slowest pole in 1/s, or "damping", the
        ratio of the least damped pole, made large.
    limit
        The largest norm, or the least decay or damping; None for a soft goal.
    scale
        The value of a soft goal that counts as one: each soft goal is divided by its scale, and the largest quotient is
        made small. Of a figure that is made large, the quotient is inverted.
    inputs, outputs
        The indices of the entries of w and z, all by default.

    Raises
    ------
    ValueError
        If a limit or scale is not positive, or a damping is 1 or more.

    Examples
    --------
    >>> wb.structured_tuning.DesignGoal("decay", limit=0.5).words
    'slowest decay >= 0.5'
    """

    figure: Figure
    limit: float | None = None
    scale: float = 1.0
    inputs: tuple[int, ...] | None = None
    outputs: tuple[int, ...] | None = None

    def __post_init__(self) -> None:
        positive("DesignGoal(scale=...)", self.scale)
        if self.limit is not None:
            finite("DesignGoal(limit=...)", self.limit)
            if not self.limit > 0 or (self.figure == "damping" and not self.limit < 1):
                raise refusal(
                    "DesignGoal(limit=...)",
                    "above 0" + (" and below 1" if self.figure == "damping" else ""),
                    self.limit,
                )

    @property
    def is_hard(self) -> bool:
        """True for a limit."""
        return self.limit is not None

    @property
    def grows(self) -> bool:
        """True for a figure that is better when it is larger."""
        return self.figure in ("decay", "damping")

    @property
    def words(self) -> str:
        """The goal in words."""
        name = WORDS[self.figure]
        if self.limit is None:
            return f"{name} as {'large' if self.grows else 'small'} as possible"
        return f"{name} {'>=' if self.grows else '<='} {self.limit:g}"

    @check_arguments
    def part(self, jet: SystemJet) -> SystemJet:
        """The system from the entries of w to those of z that the goal names."""
        outputs = range(len(jet.D)) if self.outputs is None else self.outputs
        inputs = range(jet.D.shape[1]) if self.inputs is None else self.inputs
        return jet.part(list(outputs), list(inputs))

    @check_arguments
    def pieces(self, jet: SystemJet, width: float) -> list[FigurePiece]:
        """The pieces of log(figure / reference) of a stable loop; not above zero where a limit is kept."""
        room = 1 - ROOM if self.grows else 1 + ROOM
        reference = self.scale if self.limit is None else self.limit / room
        if self.figure == "hinf":
            return [logarithm(one, reference) for one in gain_pieces(self.part(jet), width)]
        if self.figure == "h2":
            return [logarithm(h2_piece(self.part(jet)), reference)]
        found = pole_pieces(jet, width) if self.figure == "decay" else damping_pieces(jet)
        return [
            logarithm(FigurePiece(-one.value, -one.gradient, one.place, one.rank), reference, -1.0) for one in found
        ]

    @check_arguments
    def value_of(self, system: control.StateSpace) -> GoalValue:
        """The figure of a closed loop between bounds that do not trust the search."""
        state_space("DesignGoal.value_of", system)
        if self.grows:
            figures = pole_figures(np.asarray(system.A, dtype=float), float(system.dt) or None)
            return GoalValue(self, figures.decay if self.figure == "decay" else figures.damping)
        outputs = list(range(system.noutputs)) if self.outputs is None else list(self.outputs)
        inputs = list(range(system.ninputs)) if self.inputs is None else list(self.inputs)
        own = system[outputs, inputs]
        if self.figure == "h2":
            return GoalValue(self, h2_norm(own).gain)
        try:
            return GoalValue(self, hinf_norm(own).gain)
        except DesignError:
            from workbench.design.linear.feedback_loops import largest_gain

            if system.dt:
                raise
            found = largest_gain(own)
            return GoalValue(self, CertifiedValue(found.below, found.below * (1 - ROUNDING), found.above), False)


@dataclass(frozen=True)
class GoalValue:
    """A figure between its bounds; `is_proved` says whether exact arithmetic proves them, or doubles only estimate."""

    goal: DesignGoal
    value: CertifiedValue
    is_proved: bool = True

    @property
    def holds(self) -> bool | None:
        """True or False for a limit that is certainly kept or broken; None for a soft goal, or between the bounds."""
        if self.goal.limit is None:
            return None
        low, high = self.value.low, self.value.high
        if self.goal.grows:
            return True if low >= self.goal.limit else False if high < self.goal.limit else None
        return True if high <= self.goal.limit else False if low > self.goal.limit else None

    @property
    def excess(self) -> float:
        """The logarithm of the figure over its limit or scale, positive if it is worse; infinite at zero or below."""
        reference = self.goal.scale if self.goal.limit is None else self.goal.limit
        if not self.value.value > 0:
            return math.inf if self.goal.grows else -math.inf
        return math.log(self.value.value / reference) * (-1 if self.goal.grows else 1)
