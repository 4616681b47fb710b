"""The linear loops of draws: the numbers of the arm, of the model and of the law vary as in a7."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.d0_frequency.loops import AtPose, linear
from studies.d0_frequency.rest_answers import JOINTS, Complex
from studies.paper.card import PROPOSED_LAW
from studies.paper.factors import SEED, factors
from studies.paper.linearization import LEVEL

COUNT = 100
OMEGA = np.geomspace(0.1, 1e4, 81)  # rad/s
DRAWN_POSES = (LEVEL, "upright")
LAWS_DRAWN = (PROPOSED_LAW, "SMC", "PID")
ITEMS = tuple(AtPose(law, pose) for law in LAWS_DRAWN for pose in DRAWN_POSES)
FIXED_FACTORS = ("D",)  # at rest nothing disturbs


@dataclass(frozen=True, eq=False)
class DrawnLoops:
    """The loops of `COUNT` draws: the disk margin of both torques (N,), 0 if unstable, NaN if there is no rest.

    `own` is the margin of the loop itself, `single` (N, m) the answers of joint 1 with joint 2 closed at `OMEGA`, and
    `reason` why the first draw without rest has none.
    """

    own: float
    alpha: wb.Array
    single: Complex
    reason: str

    @property
    def rest_count(self) -> int:
        """The number of draws that rest."""
        return int(np.isfinite(self.alpha).sum())

    @property
    def worst(self) -> int:
        """The place of the draw with the least disk margin."""
        return int(np.nanargmin(self.alpha))


def rest_factors(law: str) -> tuple[wb.Factor, ...]:
    """The factors of a7 that a loop at rest has."""
    return tuple(factor for factor in factors(law) if factor.name not in FIXED_FACTORS)


def values(loop: wb.linear_loops.LinearLoop, law: str) -> dict[str, wb.Array]:
    """The draws by the names of parameters, (N, *shape) each."""
    space = wb.uncertainty.Space(rest_factors(law), loop.parameters, loop.states)
    p, x = space.rows(wb.study.MonteCarlo(len(space.factors), COUNT, seed=SEED).points())
    del x  # the start of a loop that rests
    names = [
        entry.name for entry in loop.parameters.entries if np.ptp(p[:, loop.parameters.slice(entry.name)], 0).any()
    ]
    return {name: loop.parameters.unpack(p)[name] for name in names}


def drawn_loops(one: AtPose) -> DrawnLoops:
    """The loops of a law at a pose over the draws."""
    both, single = linear(one), linear(one, at=JOINTS[0])
    rows = both.rows(values(both, one.law))
    model, alpha = rows.models.kind("drawn_loops", "L"), np.full(COUNT, np.nan)
    for i in np.flatnonzero(~rows.flagged_rows):
        try:
            alpha[i] = wb.linear.disk_margin(model.row(int(i)).system()).alpha
        except ValueError:
            alpha[i] = 0.0
    answers = single.rows(values(single, one.law)).response(OMEGA).values[:, :, 0, 0]
    reason = next(iter(rows.reasons.values()), "")
    return DrawnLoops(both.disk_margin.alpha, alpha, answers, reason)


def draws_by_pose(results: wb.Results) -> Mapping[AtPose, DrawnLoops]:
    """The draws of each law at each pose."""
    return dict(zip(ITEMS, results.work("draws"), strict=True))
