"""The longest period of a computer: as the linear map of the period predicts it, and in runs from two starts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.d0_frequency.loops import CARD, RUNS, AtPose, digital, linear, start_states, substeps
from studies.paper.linearization import HELD_STATES

SCAN = tuple(1.5e-4 * 3.0**k for k in range(6))  # s, of the linear prediction, which a bisection then narrows
RATIO = 1.02  # of the ends of its bracket
SHARES = (0.25, 0.5, 0.8, 0.97, 1.03, 1.25)  # of the predicted period: those at which runs are made
UNTIL, LATE = 8.0, 6.0  # s: the torque is looked at after `LATE`
REST = 10.0  # N m/s of total variation: below it a run rests; one that chatters has some thousands
STARTS = {"small": float(CARD["small start"]), "large": float(CARD["large start"])}


@dataclass(frozen=True, eq=False)
class PeriodLimit:
    """A law at a pose whose torque acts one period late.

    The linear map is stable at the period `stable` in s, and not at `unstable`. `late` (2, shares) is the total
    variation of the torque after `LATE` from both starts, in N m/s: the larger of both joints, NaN if the run diverged.
    `learned_gain_agrees` says of each start if the linear map at the gain with which the run ends is stable at the
    longest period at which the run rests and unstable at the next; None where the gain is not learned, or either end
    was not tried.
    """

    stable: float
    unstable: float
    late: wb.Array
    learned_gain_agrees: tuple[bool | None, bool | None]

    @property
    def limit(self) -> float:
        """The middle of the bracket in s."""
        return float(np.sqrt(self.stable * self.unstable))

    def rests(self, start: str) -> tuple[bool, ...]:
        """True for each of `SHARES` at which the run from a start comes to rest."""
        row = self.late[list(STARTS).index(start)]
        return tuple((row <= REST).tolist())

    def ends(self, start: str) -> tuple[float, float]:
        """The largest share up to which all runs rest, 0 if none does, and the next, infinite if all do."""
        rests = self.rests(start)
        count = len(rests) if all(rests) else rests.index(False)
        return (0.0, *SHARES)[count], (*SHARES, float("inf"))[count]


def radius(one: AtPose, period: float, K: wb.Array | None = None) -> float:
    """The largest absolute value of a pole of the map over a period in s."""
    return max(abs(pole.value) for pole in linear(one, period, K=K).poles)


def period_limit(one: AtPose) -> PeriodLimit:
    """The predicted limit of a law at a pose, and the runs about it."""
    found = wb.evidence.find_largest(lambda T: radius(one, T) < 1, SCAN, ratio=RATIO, patience=1)
    limit = float(np.sqrt(found.largest * found.next))
    runs = [_run(one, share * limit) for share in SHARES]
    late = np.array([values for values, _ in runs]).T
    made = PeriodLimit(found.largest, found.next, late, (None, None))
    if "controller.K" not in HELD_STATES.get(one.law, ()):
        return made
    gains = [K for _, K in runs]
    first, second = (_learned(one, made, start, gains) for start in STARTS)
    return PeriodLimit(found.largest, found.next, late, (first, second))


def _run(one: AtPose, period: float) -> tuple[wb.Array, wb.Array]:
    """The late total variation (2,) from both starts, and the adapting gains with which these runs end."""
    equation = digital(one, period).ode()
    until = period * round(UNTIL / period)
    metric = wb.total_variation(period, after=LATE)
    x = start_states(equation, one, np.array(list(STARTS.values())))
    found = wb.measure(equation, [metric], x0=x, until=until, h=period / substeps(period), every=until)
    worst = np.max([score.value for score in found.scores_of("late TV")], axis=0)
    path = found.trajectories
    gains = path["controller.K"][:, -1] if "controller.K" in HELD_STATES.get(one.law, ()) else np.zeros((2, 0))
    return worst, gains


def _learned(one: AtPose, made: PeriodLimit, start: str, gains: list[wb.Array]) -> bool | None:
    """The verdict of the linear map at the gain that a run from a start has learned."""
    low, high = made.ends(start)
    if not low or np.isinf(high):
        return None
    K = gains[SHARES.index(low)][list(STARTS).index(start)]
    return radius(one, low * made.limit, K) < 1 <= radius(one, high * made.limit, K)


def limits(results: wb.Results) -> Mapping[AtPose, PeriodLimit]:
    """The limits of each law at each pose."""
    return dict(zip(RUNS, results.work("period_limits"), strict=True))
