"""The total variation of the torque of the proposed law: when it arises, and which numbers decide it then."""

import numpy as np

from studies.a7_sensitivity.late_errors import INDICES, OURS
from studies.a7_sensitivity.results import ROBUST, LawResults, interval, named, narrow, percent
from studies.a7_sensitivity.sweeps import GROUPS, LATE, PROPOSED, SAMPLE, SECOND, SPAN, UNTIL
from studies.paper.card import CARD
from workbench.study.document.document import Finding, Variation
from workbench.study.sample import Sample
from workbench.study.uncertainty import Estimate, SobolIndices

NO_GROUP = "no group at both joints"
NAMES = {"model": "the law's model of the arm", "gains": "its gains", "arm": "the arm"}
FIRST_ERROR = float(np.abs(np.subtract(CARD["FS: q(0)"], CARD["q_hat(0)"])).max())  # rad, of the observer


def parts_of(shares: SobolIndices, metric: str = "TV") -> dict[str, list[Estimate]]:
    """The sums of S1 over gains, arm and model, at both joints."""
    return {group: [shares[named(metric, joint)].of_group(group) for joint in (0, 1)] for group in GROUPS}


def leading_group(parts: dict[str, list[Estimate]]) -> str:
    """The group whose part lies above that of every other one at both joints, as far as the intervals tell."""

    def leads(group: str) -> bool:
        others = [parts[other] for other in parts if other != group]
        return all(parts[group][joint].low > one[joint].high for one in others for joint in (0, 1))

    return next((f"the {group}" for group in parts if leads(group)), NO_GROUP)


def first_second(sample: Sample) -> list[float]:
    """The mean over runs of the share of the total variation that falls in the first second, by joint."""
    at = int(np.flatnonzero(np.isclose(sample.t, SECOND))[0])
    sums = [sample.over_time("TV", joint) * sample.t for joint in (0, 1)]  # (N, T), N m
    return [float((total[:, at] / total[:, -1]).mean()) for total in sums]


def listed(parts: dict[str, list[Estimate]]) -> str:
    """The parts of the groups in percent, each at joints 1 and 2."""
    return ", ".join(
        f"{NAMES[group]} {' and '.join(percent(max(0.0, float(one.value))) for one in parts[group])}" for group in NAMES
    )


def torque_variation(ours: LawResults) -> Finding:
    """The parts of the variance of the torque's total variation, over the whole run and late in it."""
    whole, late = parts_of(ours.shares), parts_of(ours.shares, "late TV")
    middle = parts_of(ours.shares_within("TV", SECOND, LATE))
    early = first_second(ours.indices)
    leader = leading_group(whole)
    intervals = "; ".join(f"{NAMES[group]} {' and '.join(map(interval, whole[group]))}" for group in NAMES)
    return Finding(
        "torque_variation",
        f"The total variation (TV) of the torque of {PROPOSED} over {UNTIL:g} s has the following parts of its "
        f"variance at joints 1 and 2: {listed(whole)}. From {LATE:g} s on they are: {listed(late)}.",
        f"{percent(early[0])} and {percent(early[1])} of the TV fall in the first second, as the observer starts "
        f"{FIRST_ERROR:.2f} rad away from each joint. So the TV over {UNTIL:g} s says little about chattering. "
        f"First-order parts over {UNTIL:g} s with their intervals: {intervals}.",
        statistic=f"Sums of S1 of the total variation of the torque, sampled every {1e3 * SAMPLE:g} ms, {INDICES}. The "
        "share of the first second is the mean over the runs.",
        sample=f"{len(ours.indices):,} runs of the first scenario.",
        given=OURS,
        chosen=f"The ranges: four numbers of the model and the stated gains 10 % off, Q and R a factor of {SPAN:g}; "
        "phi stays at its value.",
        answer=leader,
        variations=(
            Variation(f"the TV from {SECOND:g} to {LATE:g} s", leading_group(middle), listed(middle)),
            Variation(f"the TV from {LATE:g} s on", leading_group(late), listed(late)),
            *(Variation(key, leading_group(parts_of(ours.shares_by("TV", change)))) for key, change in ROBUST.items()),
        ),
        untried="A model known to 2 %, or wider ranges of the gains.",
        settled=leader != NO_GROUP and narrow(*(one for group in whole.values() for one in group)),
    )
