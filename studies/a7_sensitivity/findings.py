"""The findings of a7: verdicts that turn with the figures, and the leaders of each law."""

from collections.abc import Mapping

import numpy as np

from studies.a7_sensitivity.results import Derivatives, LawResults, interval, leaders, named, narrow, percent
from studies.a7_sensitivity.sweeps import (
    HELD,
    LATE,
    METRICS,
    NARROW,
    OF_LATE,
    PROPOSED,
    SAMPLE,
    SPAN,
    UNTIL,
    group_of,
    written,
)
from workbench.study.document.document import Column, Phrase, Table, Verdict
from workbench.study.sample import Sample
from workbench.study.uncertainty import Estimate, share
from workbench.study.uncertainty.outputs import Flags

NEAR = 0.1  # of a variance: how far a linear share may lie from S1 and still foretell it
FEW = 3  # leaders that a cell still names
ASTRAY = 1.0  # rad, of a late error: as large as the reference itself
EXACT = "Exact positions and velocities for the rivals, while AOSMC-RGS observes its own from positions"
INDICES = "of a Sobol design with a quadratic control variate, intervals by the jackknife over its scrambles, 95 %"


def deciding_gain(ours: LawResults, metric: str = "RMSE") -> Verdict:
    """The gain with the largest total index at each joint, or those that the runs do not tell apart."""
    factors = ours.shares.factors
    places = [i for i, factor in enumerate(factors) if group_of(factor) == "gains"]
    names = [factors[i] for i in places]
    every = [ours.shares[named(metric, joint)].ST for joint in (0, 1)]
    totals = [Estimate(one.value[places], one.half[places]) for one in every]
    first, second = (leaders(names, one) for one in totals)
    listed = [
        ", ".join(f"{names[i]} {interval(one[i])}" for i in np.argsort(-one.value)[:FEW].tolist()) for one in totals
    ]
    return Verdict(
        "found" if narrow(*totals) and len(first) == len(second) == 1 else "open",
        f"Of the gains of {PROPOSED}, over these ranges, {' or '.join(first)} decides most about the {metric} of "
        f"joint 1, and {' or '.join(second)} about that of joint 2.",
        f"Total indices of the gains, joint 1: {listed[0]}; joint 2: {listed[1]}.",
        f"ST of the {metric} up to {UNTIL:g} s, {INDICES}.",
        f"Q and R a factor of {SPAN:g} either way, as the paper does not state them, the stated gains 10 %.",
        "Equal ranges for stated and assumed gains, or ranges as wide as those of the card.",
    )


def idle_gains(ours: LawResults, names: tuple[str, ...] = ("phi", "K(0)", "P(0)", "l")) -> Verdict:
    """The effect of some gains on the tracking error beside that of the strongest factor, by the screening."""
    places = [ours.effects.factors.index(name) for name in names]
    sizes = [ours.effects[named("RMSE", joint)].mu_star for joint in (0, 1)]
    shares = [percent(size.value[places].max() / size.value.max()) for size in sizes]
    most = percent(max(size.high[places].max() / size.value.max() for size in sizes))
    return Verdict(
        "found",
        f"{', '.join(names[:-1])} and {names[-1]} each move the RMSE of {PROPOSED} by at most {most} of what the "
        "strongest factor does, over these ranges.",
        f"The largest mu* among them is {shares[0]} and {shares[1]} of the largest of all (joints 1 and 2); {most} is "
        "the upper end of its interval.",
        "The mean size mu* of the elementary effects of the screening, with Student's interval of 95 %.",
        f"phi, K(0) and P(0) 10 % either way, as they are stated, l a factor of {SPAN:g}.",
        "Wider ranges: these say nothing of a boundary layer or a first gain several times as large.",
    )


def late_error_of(ours: LawResults) -> Verdict:
    """The part of the variance of the late error that the gains have."""
    total = [ours.shares[named("late error", joint)].of_group("gains", True) for joint in (0, 1)]
    # what gains do together counts in the total index of each, so their sum bounds from above
    high = max(float(one.high) for one in total)
    held = [factor for factor in HELD[PROPOSED] if group_of(factor) == "gains"]
    return Verdict(
        "found" if narrow(*total) else "open",
        f"Of the gains those left free ({', '.join(ours.groups['gains'])}) have at most {100 * high:.1f} % of the "
        f"variance of the late error of {PROPOSED}; the arm and its model have at least the rest, over these ranges.",
        f"The total indices of these gains sum to {interval(total[0], 3)} and {interval(total[1], 3)} at joints 1 and "
        f"2; {', '.join(held)} the screening left at their values. {heaviest(ours.indices)}",
        f"The sum of ST over the gains, for the largest |e| from {LATE:g} to {UNTIL:g} s, {INDICES}.",
        "Links and masses of arm and model 10 % off either way, independently of each other.",
        "A better model: the smaller its errors, the larger the part of the variance that the gains have.",
    )


def heaviest(sample: Sample) -> str:
    """The part of the variance of the late error that a single run has, at the joint where it has most."""
    values = np.stack([sample.score("late error", joint).value for joint in (0, 1)])
    squares = (values - values.mean(axis=1, keepdims=True)) ** 2
    part = squares.max(axis=1) / squares.sum(axis=1)
    joint = int(part.argmax())
    second, first = np.sort(values[joint])[-2:]
    return (
        f"One of {len(sample):,} runs has {percent(part[joint])} of the variance at joint {joint + 1} "
        f"({first:.2f} rad; the next is {second:.2f})."
    )


def chattering(ours: LawResults) -> Verdict:
    """The parts of the variance of the total variation that the model and the gains have."""
    shares = [ours.shares[named("TV", joint)] for joint in (0, 1)]
    model, gains = ([one.of_group(group) for one in shares] for group in ("model", "gains"))
    above = all(one.low > other.high for one, other in zip(model, gains, strict=True))
    below = any(one.high < other.low for one, other in zip(model, gains, strict=True))
    parts = [" and ".join(percent(float(one.value)) for one in group) for group in (model, gains)]
    return Verdict(
        "found" if narrow(*model, *gains) and (above or below) else "open",
        f"The model has {parts[0]} of the variance of the chattering (TV) of {PROPOSED} at joints 1 and 2 by "
        f"itself, and all gains together {parts[1]}.",
        f"First-order parts of the model against those of the gains, joints 1 and 2: {interval(model[0])} against "
        f"{interval(gains[0])} and {interval(model[1])} against {interval(gains[1])}.",
        f"Sums of S1 of the total variation of the torque, sampled every {1e3 * SAMPLE:g} ms, {INDICES}.",
        "Four numbers of the model and the stated gains 10 % off, Q and R a factor of "
        f"{SPAN:g}; phi stays at its value.",
        "A model known to 2 %, or wider ranges of the gains.",
    )


def strays(laws: Mapping[str, LawResults]) -> Verdict:
    """The number of runs that leave their reference."""
    astray = {law: [_astray(sample) for sample in one.samples] for law, one in laws.items()}
    drawn = {law: share(_astray(one.random)) for law, one in laws.items()}
    counts = {law: f"{sum(map(np.sum, runs)):,} of {sum(map(len, runs)):,}" for law, runs in astray.items()}
    worst = max(np.nanmax(sample.score("late error", j).value) for sample in laws[PROPOSED].samples for j in (0, 1))
    listed = ", ".join(
        f"{law} {counts[law]}, of random draws {percent(part.low)} to {percent(part.high)}"
        for law, part in drawn.items()
    )
    return Verdict(
        "found",
        f"{counts[PROPOSED]} runs of {PROPOSED} stray: they diverge, or their late error exceeds {ASTRAY:g} rad.",
        f"Its largest late error is {worst:.2g} rad. Runs that stray: {listed}.",
        "Counts over all runs of a law, the screening at the ends of the ranges among them, so no probabilities; "
        "shares of the independent draws with the interval of Clopper and Pearson, 95 %.",
        f"{EXACT}; SMC has the gain of 5 N m that a1 assumes, too small for these errors of the model.",
        "Ranges that leave the screened corners out; for SMC a larger gain.",
    )


def _astray(sample: Sample) -> Flags:
    late = np.stack([sample.score("late error", joint).value for joint in (0, 1)])
    return np.asarray(~(late < ASTRAY).all(axis=0))  # a lost run, of NaN, is astray


def gap(one: LawResults, near: Derivatives, metric: str, joint: int) -> Estimate:
    """The distance from S1 of the linear share that lies farthest from it; NaN where there is no gradient."""
    first = one.shares[named(metric, joint)].S1
    apart = np.abs(near.shares(metric, joint) - first.value)
    worst = int(np.argmax(apart))  # of NumPy, whose largest value is NaN where one is
    return Estimate(apart[worst], first.half[worst])


def foretold(laws: Mapping[str, LawResults], near: Mapping[str, Derivatives], metric: str = "RMSE") -> Verdict:
    """The derivatives at one point against the indices over the whole range."""
    gaps = {(law, joint): gap(laws[law], near[law], metric, joint) for law in near for joint in (0, 1)}
    sure = {key for key in gaps if narrow(laws[key[0]].shares[named(metric, key[1])].S1)}
    held = [key for key, far in gaps.items() if far.high <= NEAR and key in sure]
    # without a gradient, where the difference is NaN, nothing is foretold
    missed = [key for key, far in gaps.items() if not far.low <= NEAR]
    left = len(gaps) - len(held) - len(missed)
    listed = ", ".join(f"{law} q{joint + 1} {interval(far)}" for (law, joint), far in gaps.items())
    slopes = ", ".join(f"{law} in {one.slopes(metric)}" for law, one in near.items())
    return Verdict(
        "open" if left else "found",
        f"For {len(held)} of {len(gaps)} pairs of law and joint the gradient at the numbers of the card foretells "
        f"every first-order index of the {metric} within {NEAR:g}; for {len(missed)} it is farther off, and for "
        f"{left} the intervals leave it open.",
        f"Largest difference of a linear share from S1, with the interval of that S1: {listed}. The gradient is the "
        f"slope of the runs, of all derivatives at both joints: {slopes}.",
        "S1, of Sobol designs with a quadratic control variate, against the share of a linear function with the exact "
        "gradient, exact for the steps that are taken; a slope is that of runs over 0.01 % and over 1 % of a number.",
        "The ranges of this study, which are alike for all laws.",
        "Wider ranges, over which gains act by curves.",
    )


def leaders_table(laws: Mapping[str, LawResults]) -> Table:
    """The factor with the largest total index, law by law and metric by metric."""
    outputs = [(metric.name, joint) for metric in METRICS for joint in (0, 1)]
    return Table(
        "leaders",
        "The factor with the largest total index ST, and its interval of 95 %, which holds by itself. Where the "
        "intervals leave room for others, these follow; where its own is wider than "
        f"{NARROW:g}, the cell is open. 'model' before a letter: the number that the law believes in. {OF_LATE}",
        (Column("law"), *(Column(f"{metric}, q{joint + 1}") for metric, joint in outputs)),
        tuple((law, *(_leading(one, *output) for output in outputs)) for law, one in laws.items()),
    )


def _leading(one: LawResults, metric: str, joint: int) -> Phrase:
    total = one.shares[named(metric, joint)].ST
    first, *others = leaders(one.shares.factors, total)
    top = total[one.shares.factors.index(first)]
    known = (*written(first), f" {interval(top)}")
    if not narrow(top):
        return ("open: ", *known)
    if len(others) >= FEW:
        return (*known, f" or {len(others)} others")
    return (*known, *(part for other in others for part in (" or ", *written(other))))
