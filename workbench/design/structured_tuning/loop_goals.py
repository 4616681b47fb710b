"""The goals of a loop: figures as `Specification` has them, and gains between signals, as pieces of logarithms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from workbench.core.validation.refusals import positive, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.structured_tuning.crossover_pieces import (
    bandwidth_pieces,
    delay_margin_pieces,
    gain_margin_pieces,
    phase_margin_pieces,
)
from workbench.design.structured_tuning.figure_pieces import (
    FigurePiece,
    damping_pieces,
    h2_piece,
    logarithm,
    pole_pieces,
)
from workbench.design.structured_tuning.gain_peaks import gain_pieces
from workbench.design.structured_tuning.loop_jets import LoopJet
from workbench.design.structured_tuning.step_pieces import step_piece

LoopFigureName = Literal[
    "Ms", "Mt", "bandwidth", "damping", "decay", "gain_margin", "phase_margin", "delay_margin", "disk_margin",
    "noise_gain", "overshoot", "settling_time", "rise_time", "gain", "h2",
]  # fmt: skip
ROOM = 1e-6  # relative, by which a limit is kept in the search, so that it is kept for certain in the end
LARGER_IS_BETTER = ("damping", "decay", "gain_margin", "phase_margin", "delay_margin", "disk_margin", "bandwidth")
MARGINS = {
    "phase_margin": phase_margin_pieces,
    "delay_margin": delay_margin_pieces,
    "gain_margin": gain_margin_pieces,
}


@dataclass(frozen=True)
@check_arguments
class LoopGoal:
    """A figure of a loop that is made as good as possible, or kept within a limit.

    Attributes
    ----------
    figure
        A figure of `Specification`, in its unit; or "gain" or "h2", the H-infinity or H2 norm from `inputs` to
        `outputs`.
    limit
        The largest value, or the least of a figure that is better when larger; None for a soft goal.
    scale
        The value of a soft goal that counts as one: each soft goal is divided by its scale, and the largest quotient is
        made small. Of a figure that is better when larger, the quotient is inverted.
    inputs, outputs
        Names of signals of `linear_loop(loop).inputs` and `.outputs`, for a gain.

    Raises
    ------
    ValueError
        If a limit or scale is not positive, or a gain lacks its signals.

    Examples
    --------
    >>> wb.structured_tuning.LoopGoal("gain", inputs=("v_load",), outputs=("omega",)).words
    'gain from v_load to omega as small as possible'
    """

    figure: LoopFigureName
    limit: float | None = None
    scale: float = 1.0
    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        positive("LoopGoal(scale=...)", self.scale)
        if self.limit is not None:
            positive("LoopGoal(limit=...)", self.limit)
        if (self.figure in ("gain", "h2")) != bool(self.inputs and self.outputs):
            must = "names of signals for a gain or an H2 norm, and left out for another figure"
            raise refusal("LoopGoal(inputs=..., outputs=...)", must, (self.inputs, self.outputs))

    @property
    def grows(self) -> bool:
        """True for a figure that is better when it is larger."""
        return self.figure in LARGER_IS_BETTER

    @property
    def words(self) -> str:
        """The goal in words."""
        signals = f" from {', '.join(self.inputs)} to {', '.join(self.outputs)}" if self.inputs else ""
        name = f"{'H2 norm' if self.figure == 'h2' else self.figure}{signals}"
        if self.limit is None:
            return f"{name} as {'large' if self.grows else 'small'} as possible"
        return f"{name} {'>=' if self.grows else '<='} {self.limit:g}"

    @property
    def range(self) -> tuple[float, float]:
        """The range of the figure; a soft goal compares it with its scale."""
        reference = self.scale if self.limit is None else self.limit
        return (reference, math.inf) if self.grows else (-math.inf, reference)


@dataclass(frozen=True)
class LoopAnswer:
    """The signals between which the bandwidth and the step are told, and those of the noise; T without the first."""

    answer: tuple[str, str] | None
    noises: tuple[str, ...]
    noise_outputs: tuple[str, ...]


def loop_pieces(
    jet: LoopJet, goal: LoopGoal, ends: tuple[float, float], at: LoopAnswer, width: float
) -> list[FigurePiece]:
    """The pieces of the logarithm of a figure over the end of its range, above zero where it is beyond."""
    low, high = ends[0] * (1 + ROOM), ends[1] * (1 - ROOM)
    limit = low if goal.grows else high
    if goal.figure in ("gain", "h2", "noise_gain"):
        inputs, outputs = (at.noises, at.noise_outputs) if goal.figure == "noise_gain" else (goal.inputs, goal.outputs)
        own = jet.part(inputs, outputs)
        return _logs([h2_piece(own)] if goal.figure == "h2" else gain_pieces(own, width), limit)
    if goal.figure in ("Ms", "Mt"):
        return _logs(gain_pieces(jet.loop_gain().feedback(goal.figure[1].upper()), width), limit)
    if goal.figure == "disk_margin":
        S = jet.loop_gain().feedback("S")
        return _logs(gain_pieces(S.plus_direct(-np.eye(len(S.D)) / 2), width), 1 / limit)
    if goal.figure in MARGINS:
        pieces = list[FigurePiece]()
        for k in range(len(jet.channels)):
            made = MARGINS[goal.figure](jet.loop_gain([k]), limit)
            pieces += [replace(one, rank=one.rank + 10 * k) for one in made]
        return pieces
    if goal.figure in ("damping", "decay"):
        found = damping_pieces(jet.closed_loop) if goal.figure == "damping" else pole_pieces(jet.closed_loop, width)
        return [logarithm(FigurePiece(-one.value, -one.gradient, one.place, one.rank), limit, -1.0) for one in found]
    answer = jet.part((at.answer[0],), (at.answer[1],)) if at.answer else jet.loop_gain().feedback("T")
    if goal.figure == "bandwidth":
        return bandwidth_pieces(answer, max(low, 0.0), high)
    return [step_piece(answer, goal.figure, limit)]


def _logs(pieces: Sequence[FigurePiece], limit: float) -> list[FigurePiece]:
    return [logarithm(one, limit) for one in pieces]
