"""The exact derivatives of each law at the numbers of the card, against the indices over the whole ranges."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.a7_sensitivity.late_errors import FEW
from studies.a7_sensitivity.results import Derivatives, LawResults, interval, narrow, output_name
from studies.a7_sensitivity.sweeps import PROPOSED_LAW

NEAR = 0.1  # of a variance: how far a linear share may lie from S1 and still foretell it
# By the answer for a law at a joint: the sentence that names those with it.
ANSWERS = {
    "predicted": "",
    "near by luck": "For {} it is as near, but by luck, as there it is not the slope of the runs.",
    "not predicted": "For {} it is farther off.",
    "open": "For {} the intervals do not decide.",
}
Pair = tuple[str, int]  # a law and a joint


@dataclass(frozen=True, eq=False)
class Comparison:
    """The distance of the linear shares of a law from S1 at a joint, and what else decides the answer."""

    far: wb.uncertainty.Estimate
    is_known: bool  # the intervals of S1 are narrow
    is_slope: bool  # the gradient is the slope of the runs

    def answer(self, bound: float = NEAR) -> str:
        """One of `ANSWERS`."""
        if not self.far.low <= bound:  # without a gradient, where the difference is NaN, nothing is foretold
            return "not predicted"
        if self.far.high > bound or not self.is_known:
            return "open"
        return "predicted" if self.is_slope else "near by luck"

    @property
    def words(self) -> str:
        """The distance, and what the intervals add to it."""
        return interval(self.far, 3) if np.isfinite(self.far.value) else "no gradient"


def gap(one: LawResults, near: Derivatives, metric: str, joint: int) -> wb.uncertainty.Estimate:
    """The largest distance of a linear share from S1, up to the largest with its interval; NaN without a gradient."""
    first = one.shares[output_name(metric, joint)].S1
    apart = np.abs(near.shares(metric, joint) - first.value)
    most = apart.max()  # of NumPy, whose largest value is NaN where one is
    return wb.uncertainty.Estimate(most, (apart + first.half).max() - most)


def comparison(one: LawResults, near: Derivatives, metric: str, joint: int, is_slope: bool | None = None) -> Comparison:
    """The comparison for one law at one joint; `is_slope` if it is known that the derivatives are slopes."""
    known = narrow(one.shares[output_name(metric, joint)].S1)
    return Comparison(gap(one, near, metric, joint), known, near.hold(metric, joint) if is_slope is None else is_slope)


def gradient_finding(
    laws: Mapping[str, LawResults], near: Mapping[str, Derivatives], metric: str = "RMSE"
) -> wb.Finding:
    """The derivatives at one point against the indices over the whole range."""
    found = {(law, joint): comparison(laws[law], near[law], metric, joint) for law in near for joint in (0, 1)}
    of = {answer: [pair for pair, one in found.items() if one.answer() == answer] for answer in ANSWERS}
    first = (PROPOSED_LAW, 0)
    ours = laws[PROPOSED_LAW], near[PROPOSED_LAW].of_runs, metric
    by_runs = {joint: comparison(*ours, joint, True) for joint in (0, 1)}
    exceptions = [words.format(pairs_words(of[answer])) for answer, words in ANSWERS.items() if of[answer] and words]
    return wb.Finding(
        "foretold",
        " ".join(
            [
                f"For {len(of['predicted'])} of {len(found)} pairs of law and joint, the exact gradient at the numbers "
                f"of the card predicts every first-order index of the {metric} within {NEAR:g}.",
                *exceptions,
            ]
        ),
        evidence(laws, near, found, metric),
        statistic="The largest difference between S1, from Sobol designs with a quadratic control variate, and the "
        "share that a linear function with the exact gradient would have; with the part that the intervals of S1 add. "
        "A slope compares runs in which a number differs by 0.01 % and by 1 %.",
        sample="All runs of the indices, and one run with its derivatives for each law.",
        information="The ranges of this study, by the same rule for all laws.",
        assumptions="The ranges, and the gains of the rivals.",
        answer=found[first].answer(),
        variations=(
            wb.Variation(
                f"within {NEAR / 2:g} in place of {NEAR:g}", found[first].answer(NEAR / 2), found[first].words
            ),
            *(
                wb.Variation(f"{PROPOSED_LAW}, joint {joint + 1}, slopes of runs over 1 %", one.answer(), one.words)
                for joint, one in by_runs.items()
            ),
            *(
                wb.Variation(f"{law}, joint {joint + 1}", one.answer(), one.words)
                for (law, joint), one in found.items()
                if (law, joint) != first
            ),
        ),
        limitations="Wider ranges, over which gains do not act linearly.",
        is_decided=not of["open"],
    )


def evidence(
    laws: Mapping[str, LawResults], near: Mapping[str, Derivatives], comparisons: Mapping[Pair, Comparison], metric: str
) -> str:
    """The largest distances, the size of what is foretold, and where the gradient is a slope."""
    farthest = sorted(comparisons, key=lambda pair: -np.nan_to_num(comparisons[pair].far.value, nan=np.inf))[:FEW]
    listed = ", ".join(f"{comparisons[law, joint].words} for {law} at joint {joint + 1}" for law, joint in farthest)
    indices = np.concatenate([laws[law].shares[output_name(metric, joint)].S1.value for law, joint in comparisons])
    return (
        f"The largest differences between the shares by the gradient and S1 are {listed}. For comparison, "
        f"{int((indices < NEAR).sum())} of the {indices.size} indices are below {NEAR:g} themselves. "
        f"{slopes_words(near, metric)}"
    )


def slopes_words(near: Mapping[str, Derivatives], metric: str) -> str:
    """The laws of which the gradient is not the slope of neighbouring runs, with the counts of derivatives."""
    off = [law for law, one in near.items() if not all(one.hold(metric, joint) for joint in (0, 1))]
    if not off:
        return "The gradient is the slope of neighbouring runs in all derivatives."
    counts = " and ".join(f"{near[law].slopes(metric)} derivatives of {law}" for law in off)
    rest = ", but in all derivatives of the other laws" if len(off) < len(near) else ""
    return f"The gradient is the slope of neighbouring runs in only {counts}{rest}."


def pairs_words(pairs: Sequence[Pair]) -> str:
    """Laws and joints in words."""
    joints: dict[str, list[int]] = {}
    for law, joint in pairs:
        joints.setdefault(law, []).append(joint)
    words = [f"{law} at {'both joints' if len(of) > 1 else f'joint {of[0] + 1}'}" for law, of in joints.items()]
    return " and ".join(words) if len(words) < 3 else f"{', '.join(words[:-1])} and {words[-1]}"
