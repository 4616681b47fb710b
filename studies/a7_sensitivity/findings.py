"""The findings of a7, which follow from the figures, and the leaders of each law."""

from collections.abc import Mapping, Sequence

import numpy as np

import workbench as wb
from studies.a7_sensitivity.fitted_derivatives import with_equal_ranges
from studies.a7_sensitivity.late_errors import FEW, INDICES, OURS
from studies.a7_sensitivity.results import (
    ROBUST,
    Derivatives,
    LawResults,
    interval,
    leaders,
    narrow,
    output_name,
    percent,
)
from studies.a7_sensitivity.sweeps import METRICS, NARROW, OF_LATE, PROPOSED_LAW, UNTIL
from studies.paper.factors import SPAN, TOLERANCE, factor_phrase, group_of
from studies.paper.fitted_arm import FIT

ALIKE = f"{percent(TOLERANCE)} for all numbers{'' if FIT is None else ' that are no estimates'}"


def answer(laws: Mapping[str, LawResults]) -> str:
    """The numbers that decide about the proposed law, in one line."""
    ours = laws[PROPOSED_LAW]

    def both(of: wb.uncertainty.SobolIndices, group: str) -> str:
        parts = [of[output_name("RMSE", joint)].of_group(group) for joint in (0, 1)]
        return " and ".join(percent(float(one.value)) for one in parts)

    return (
        f"The arm causes {both(ours.shares, 'arm')} of the RMSE variance of {PROPOSED_LAW} at joints 1 and 2; the "
        f"gains cause {both(ours.shares, 'gains')}, or {both(ours.equal_shares, 'gains')} if "
        f"{'all' if FIT is None else 'they'} vary by equal percentages."
    )


Totals = list[wb.uncertainty.Estimate]  # of the gains, by joint


def gains_of(ours: LawResults) -> list[str]:
    """The gains among the factors of the indices."""
    return [factor for factor in ours.shares.factors if group_of(factor) == "gains"]


def totals_of(ours: LawResults, shares: wb.uncertainty.SobolIndices, metric: str) -> Totals:
    """The total indices of the gains at both joints."""
    places = [shares.factors.index(name) for name in gains_of(ours)]
    every = [shares[output_name(metric, joint)].ST for joint in (0, 1)]
    return [wb.uncertainty.Estimate(one.value[places], one.half[places]) for one in every]


def other_totals(ours: LawResults, near: Derivatives, metric: str) -> dict[str, Totals]:
    """The total indices of the gains in other readings, and their equivalents by other methods, by words."""
    names, joints = gains_of(ours), (0, 1)
    places = [ours.shares.factors.index(name) for name in names]
    spots = [ours.effects.factors.index(name) for name in names]
    effects = [ours.effects[output_name(metric, joint)].mu_star for joint in joints]
    slopes = {
        "the exact gradient": with_equal_ranges(ours.law, near),
        "slopes of runs over 1 %": with_equal_ranges(ours.law, near.of_runs),
    }
    return {
        ALIKE: totals_of(ours, ours.equal_shares, metric),
        **{
            f"the same range for all numbers, by {words}": [
                wb.uncertainty.Estimate(of.shares(metric, joint)[places], np.zeros(len(places))) for joint in joints
            ]
            for words, of in slopes.items()
        },
        **{
            f"{one.name} in place of {metric}": totals_of(ours, ours.shares, one.name)
            for one in METRICS
            if one.name != metric
        },
        **{
            f"{metric}, {words}": totals_of(ours, ours.shares_by(metric, change), metric)
            for words, change in ROBUST.items()
        },
        "the screening's mu* in place of ST": [
            wb.uncertainty.Estimate(one.value[spots], one.half[spots]) for one in effects
        ],
    }


def largest(names: Sequence[str], totals: wb.uncertainty.Estimate) -> str:
    """The largest total indices of some factors."""
    return ", ".join(f"{names[i]} {interval(totals[i])}" for i in np.argsort(-totals.value)[:FEW].tolist())


def parts_of(shares: wb.uncertainty.SobolIndices, group: str, metric: str = "RMSE") -> str:
    """The first-order parts of a group at joints 1 and 2."""
    return " and ".join(interval(shares[output_name(metric, joint)].of_group(group)) for joint in (0, 1))


def leading_gains(ours: LawResults, totals: Totals) -> str:
    """The gains that lead at each joint, as far as the intervals tell."""
    first, second = (" or ".join(leaders(gains_of(ours), one)) for one in totals)
    return f"{first} at both joints" if first == second else f"{first} at joint 1 and {second} at joint 2"


def deciding_gain(ours: LawResults, near: Derivatives, metric: str = "RMSE") -> wb.Finding:
    """The gain with the largest total index at each joint, or the gains that the runs do not tell apart."""
    names, totals, others = gains_of(ours), totals_of(ours, ours.shares, metric), other_totals(ours, near, metric)
    (first, second), alike = ([largest(names, one) for one in some] for some in (totals, others[ALIKE]))
    return wb.Finding(
        "deciding_gain",
        f"The gain that decides most about the {metric} of {PROPOSED_LAW} is {leading_gains(ours, totals)}, if Q and R "
        f"vary by a factor of {SPAN:g} up and down and the other gains by {percent(TOLERANCE)}. With {ALIKE} it is "
        f"{leading_gains(ours, others[ALIKE])}.",
        f"Total indices of the gains over the unequal ranges, joint 1: {first}; joint 2: {second}. With {ALIKE}, joint "
        f"1: {alike[0]}; joint 2: {alike[1]}. Then the first-order part of all gains together is "
        f"{parts_of(ours.equal_shares, 'gains')} at joints 1 and 2, and that of the arm is "
        f"{parts_of(ours.equal_shares, 'arm')}.",
        statistic=f"The largest total index ST among the gains, for the {metric} up to {UNTIL:g} s, {INDICES}.",
        sample=f"{len(ours.indices):,} runs of the first scenario, and {len(ours.equal or ()):,} with equal ranges.",
        information=OURS,
        assumptions=f"The ranges: a factor of {SPAN:g} up and down for Q and R, which the paper does not state; 10 % "
        "up and down for the gains that it states.",
        answer=leading_gains(ours, totals),
        variations=tuple(wb.Variation(words, leading_gains(ours, one)) for words, one in others.items()),
        limitations="Ranges as wide as those on the card.",
        is_decided=narrow(*totals) and all(len(leaders(names, one)) == 1 for one in totals),
    )


def idle_gains(ours: LawResults, names: tuple[str, ...] = ("phi", "K(0)", "P(0)", "l")) -> str:
    """The effect of some gains on the tracking error beside the effect of the strongest factor, by the screening."""
    places = [ours.effects.factors.index(name) for name in names]
    sizes = [ours.effects[output_name("RMSE", joint)].mu_star for joint in (0, 1)]
    shares = [percent(size.value[places].max() / size.value.max()) for size in sizes]
    most = percent(max(size.high[places].max() / size.value.max() for size in sizes))
    return (
        f"By the screening, the mean effect mu* of each of {', '.join(names[:-1])} and {names[-1]} on the RMSE of "
        f"{PROPOSED_LAW} is at most {most} of the effect of the strongest factor. This is the upper end of an "
        f"interval; the largest estimates are {shares[0]} at joint 1 and {shares[1]} at joint 2. The ranges are 10 % "
        f"up and down for phi, K(0) and P(0), and a factor of {SPAN:g} up and down for l; wider ranges may give larger "
        "effects."
    )


def leaders_table(laws: Mapping[str, LawResults]) -> wb.document.ReportTable:
    """The factor with the largest total index, law by law and metric by metric."""
    return wb.document.ReportTable(
        "leaders",
        "The factor with the largest total index ST, and the interval of this index, 95 % for each index alone. Other "
        "factors whose intervals allow them to be the largest follow. If the interval of the first is wider than "
        f"{NARROW:g}, the cell is open. 'model' before a letter: the number in the law's model of the arm. {OF_LATE} "
        "The late TV is the TV in the same time.",
        tuple(map(wb.document.TableColumn, ("law", "metric", "joint 1", "joint 2"))),
        tuple(
            (law, metric.name, *(_leading(one, metric.name, joint) for joint in (0, 1)))
            for law, one in laws.items()
            for metric in METRICS
        ),
    )


def _leading(one: LawResults, metric: str, joint: int) -> wb.document.Phrase:
    total = one.shares[output_name(metric, joint)].ST
    first, *others = leaders(one.shares.factors, total)
    top = total[one.shares.factors.index(first)]
    known = (*factor_phrase(first), f" {interval(top)}")
    if not narrow(top):
        return ("open: ", *known)
    if len(others) >= FEW:
        return (*known, f" or {len(others)} others")
    return (*known, *(part for other in others for part in (" or ", *factor_phrase(other))))
