"""The total variation of the torque of the proposed law: when it arises, and which numbers decide it then."""

import numpy as np

import workbench as wb
from studies.a7_sensitivity.late_errors import BODY, INDICES, OURS
from studies.a7_sensitivity.results import ROBUST, LawResults, interval, narrow, output_name, percent
from studies.a7_sensitivity.sweeps import LATE, PROPOSED_LAW, SAMPLE, SECOND, UNTIL
from studies.paper.card import CARD
from studies.paper.factors import GROUPS, SPAN

NO_GROUP = "no group at both joints"
NAMES = {"model": "the law's model of the arm", "gains": "the law's gains", "arm": "the arm"}
FIRST_ERROR = float(np.abs(np.subtract(CARD["FS: q(0)"], CARD["q_hat(0)"])).max())  # rad, of the observer


def parts_of(shares: wb.uncertainty.SobolIndices, metric: str = "TV") -> dict[str, list[wb.uncertainty.Estimate]]:
    """The sums of S1 over gains, arm and model, at both joints."""
    return {group: [shares[output_name(metric, joint)].of_group(group) for joint in (0, 1)] for group in GROUPS}


def leading_group(parts: dict[str, list[wb.uncertainty.Estimate]]) -> str:
    """The group whose part lies above that of every other one at both joints, as far as the intervals tell."""

    def leads(group: str) -> bool:
        others = [parts[other] for other in parts if other != group]
        return all(parts[group][joint].low > one[joint].high for one in others for joint in (0, 1))

    return next((f"the {group}" for group in parts if leads(group)), NO_GROUP)


def first_second(sample: wb.study.Sample) -> list[float]:
    """The mean over runs of the share of the total variation that falls in the first second, by joint."""
    at = int(np.flatnonzero(np.isclose(sample.t, SECOND))[0])
    sums = [sample.over_time("TV", joint) * sample.t for joint in (0, 1)]  # (N, T), N m
    return [float((total[:, at] / total[:, -1]).mean()) for total in sums]


def both(parts: list[wb.uncertainty.Estimate]) -> str:
    """The parts at joints 1 and 2 in percent."""
    return " and ".join(percent(max(0.0, float(one.value))) for one in parts)


def group_words(parts: dict[str, list[wb.uncertainty.Estimate]]) -> str:
    """The parts of the groups in percent, each at joints 1 and 2."""
    return ", ".join(f"{NAMES[group]} {both(parts[group])}" for group in NAMES)


def intervals(parts: dict[str, list[wb.uncertainty.Estimate]]) -> str:
    """The parts of the groups with their intervals, each at joints 1 and 2."""
    return "; ".join(f"{NAMES[group]} {' and '.join(map(interval, parts[group]))}" for group in NAMES)


def leader_words(parts: dict[str, list[wb.uncertainty.Estimate]]) -> str:
    """The group that leads, with its parts."""
    leader = leading_group(parts).removeprefix("the ")
    if leader not in NAMES:
        return "no group causes the largest part at both joints"
    verb = "cause" if leader == "gains" else "causes"
    return f"{NAMES[leader]} {verb} the largest part, {both(parts[leader])} at joints 1 and 2"


def torque_variation(ours: LawResults) -> wb.Finding:
    """The parts of the variance of the torque's total variation, over the whole run and late in it."""
    whole, late = parts_of(ours.shares), parts_of(ours.shares, "late TV")
    middle = parts_of(ours.shares_within("TV", SECOND, LATE))
    body = parts_of(ours.shares_by("late TV", ROBUST[BODY]), "late TV")
    early = first_second(ours.indices)
    leader = leading_group(whole)
    return wb.Finding(
        "torque_variation",
        f"Of the variance of the total variation (TV) of the torque of {PROPOSED_LAW} over {UNTIL:g} s, "
        f"{leader_words(whole)}. From {LATE:g} s on, {leader_words(late)}.",
        f"{percent(early[0])} and {percent(early[1])} of the TV occur in the first second, as the observer starts "
        f"{FIRST_ERROR:.2f} rad away from each joint. So the TV over {UNTIL:g} s shows little about chattering. "
        f"First-order parts at joints 1 and 2 over {UNTIL:g} s: {intervals(whole)}. From {LATE:g} s on: "
        f"{intervals(late)}.",
        statistic=f"Sums of S1 of the total variation of the torque, sampled every {1e3 * SAMPLE:g} ms, {INDICES}. The "
        "share of the first second is the mean over the runs.",
        sample=f"{len(ours.indices):,} runs of the first scenario.",
        information=OURS,
        assumptions="The ranges: 10 % for four numbers of the model and the stated gains, a factor of "
        f"{SPAN:g} for Q and R; phi stays at its value.",
        answer=leader,
        variations=(
            wb.Variation(f"the TV from {SECOND:g} to {LATE:g} s", leading_group(middle), group_words(middle)),
            wb.Variation(f"the TV from {LATE:g} s on", leading_group(late), group_words(late)),
            wb.Variation(f"the TV from {LATE:g} s on, {BODY}", leading_group(body), group_words(body)),
            *(
                wb.Variation(key, leading_group(parts_of(ours.shares_by("TV", change))))
                for key, change in ROBUST.items()
            ),
        ),
        limitations="A model known to 2 %, or wider ranges of the gains.",
        is_decided=leader != NO_GROUP and narrow(*(one for group in whole.values() for one in group)),
    )
