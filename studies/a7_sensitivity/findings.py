"""The findings of a7, which follow from the figures, and the leaders of each law."""

from collections.abc import Mapping

import numpy as np

from studies.a7_sensitivity.late_errors import BODY, EXACT, FEW, INDICES, OURS, late_parts
from studies.a7_sensitivity.results import ROBUST, Derivatives, LawResults, interval, leaders, named, narrow, percent
from studies.a7_sensitivity.sweeps import (
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
from workbench.study.document.document import Column, Finding, Phrase, Table, Variation
from workbench.study.sample import Sample
from workbench.study.uncertainty import Estimate, SobolIndices, share
from workbench.study.uncertainty.outputs import Flags

NEAR = 0.1  # of a variance: how far a linear share may lie from S1 and still foretell it
ASTRAY = 1.0  # rad, of a late error: as large as the reference itself


def answer(laws: Mapping[str, LawResults]) -> str:
    """The numbers that decide about the proposed law, in one line."""
    ours = laws[PROPOSED]
    shares = [ours.shares[named("RMSE", joint)] for joint in (0, 1)]
    arm, gains = (" and ".join(percent(float(one.of_group(of).value)) for one in shares) for of in ("arm", "gains"))
    body = late_parts(ours)[BODY][0]
    return (
        f"The arm has {arm} of the variance of {PROPOSED}'s RMSE (joints 1, 2) over these ranges, its gains {gains}; "
        f"of its late error's, a few stray runs aside, at most {100 * body:.0f} %."
    )


def deciding_gain(ours: LawResults, metric: str = "RMSE") -> Finding:
    """The gain with the largest total index at each joint, or the gains that the runs do not tell apart."""
    factors = ours.shares.factors
    places = [i for i, factor in enumerate(factors) if group_of(factor) == "gains"]
    names = [factors[i] for i in places]

    def totals_of(shares: SobolIndices, output: str) -> list[Estimate]:
        every = [shares[named(output, joint)].ST for joint in (0, 1)]
        return [Estimate(one.value[places], one.half[places]) for one in every]

    def said(totals: list[Estimate]) -> str:
        return " and ".join(" or ".join(leaders(names, one)) for one in totals)

    totals = totals_of(ours.shares, metric)
    first, second = (leaders(names, one) for one in totals)
    listed = [
        ", ".join(f"{names[i]} {interval(one[i])}" for i in np.argsort(-one.value)[:FEW].tolist()) for one in totals
    ]
    screened = [
        Estimate(size.value[spots], size.half[spots])
        for spots in [[ours.effects.factors.index(name) for name in names]]
        for size in (ours.effects[named(metric, joint)].mu_star for joint in (0, 1))
    ]
    others = {
        **{
            f"{one.name} in place of {metric}": totals_of(ours.shares, one.name)
            for one in METRICS
            if one.name != metric
        },
        **{f"{metric}, {words}": totals_of(ours.shares_by(metric, change), metric) for words, change in ROBUST.items()},
        "the screening's mu* in place of ST": screened,
    }
    return Finding(
        "deciding_gain",
        f"Of the gains of {PROPOSED}, over these ranges, {' or '.join(first)} decides most about the {metric} of "
        f"joint 1, and {' or '.join(second)} about the {metric} of joint 2.",
        f"Total indices of the gains, joint 1: {listed[0]}; joint 2: {listed[1]}.",
        statistic=f"The largest total index ST among the gains, for the {metric} up to {UNTIL:g} s, {INDICES}.",
        sample=f"{len(ours.indices):,} runs of the first scenario.",
        given=OURS,
        chosen=f"The ranges: Q and R a factor of {SPAN:g} either way, the stated gains 10 %.",
        answer=said(totals),
        variations=tuple(Variation(words, said(one)) for words, one in others.items()),
        untried="Equal ranges for stated and assumed gains, or ranges as wide as those on the card.",
        settled=narrow(*totals) and len(first) == len(second) == 1,
    )


def idle_gains(ours: LawResults, names: tuple[str, ...] = ("phi", "K(0)", "P(0)", "l")) -> str:
    """The effect of some gains on the tracking error beside the effect of the strongest factor, by the screening."""
    places = [ours.effects.factors.index(name) for name in names]
    sizes = [ours.effects[named("RMSE", joint)].mu_star for joint in (0, 1)]
    shares = [percent(size.value[places].max() / size.value.max()) for size in sizes]
    most = percent(max(size.high[places].max() / size.value.max() for size in sizes))
    return (
        f"{', '.join(names[:-1])} and {names[-1]} each move the RMSE of {PROPOSED} by at most {most} of what the "
        f"strongest factor does, over these ranges. The largest mu* among them is {shares[0]} and {shares[1]} of the "
        f"largest of all (joints 1 and 2); {most} is the upper end of its interval. Wider ranges may differ: these are "
        f"10 % either way for phi, K(0) and P(0), and a factor of {SPAN:g} for l."
    )


def chattering(ours: LawResults) -> Finding:
    """The parts of the variance of the total variation that the model and the gains have."""

    def said(shares: SobolIndices) -> str:
        model, gains = (
            [shares[named("TV", joint)].of_group(group) for joint in (0, 1)] for group in ("model", "gains")
        )
        if all(one.low > other.high for one, other in zip(model, gains, strict=True)):
            return "the model"
        below = all(one.high < other.low for one, other in zip(model, gains, strict=True))
        return "the gains" if below else "neither at both joints"

    shares = [ours.shares[named("TV", joint)] for joint in (0, 1)]
    model, gains = ([one.of_group(group) for one in shares] for group in ("model", "gains"))
    apart = all(one.low > two.high or one.high < two.low for one, two in zip(model, gains, strict=True))
    parts = [" and ".join(percent(float(one.value)) for one in group) for group in (model, gains)]
    return Finding(
        "chattering",
        f"The model has {parts[0]} of the variance of the total variation (TV) of the torque of {PROPOSED} at "
        f"joints 1 and 2 by itself, and all gains together {parts[1]}.",
        f"First-order parts of the model against the gains, joints 1 and 2: {interval(model[0])} against "
        f"{interval(gains[0])} and {interval(model[1])} against {interval(gains[1])}.",
        statistic=f"Sums of S1 of the total variation of the torque, sampled every {1e3 * SAMPLE:g} ms, {INDICES}.",
        sample=f"{len(ours.indices):,} runs of the first scenario.",
        given=OURS,
        chosen=f"The ranges: four numbers of the model and the stated gains 10 % off, Q and R a factor of {SPAN:g}; "
        "phi stays at its value.",
        answer=said(ours.shares),
        variations=tuple(Variation(words, said(ours.shares_by("TV", change))) for words, change in ROBUST.items()),
        untried="A model known to 2 %, or wider ranges of the gains.",
        settled=narrow(*model, *gains) and apart,
    )


def strays(laws: Mapping[str, LawResults]) -> Finding:
    """The number of runs that leave their reference."""

    def counts(bound: float) -> dict[str, tuple[int, int]]:
        runs = {law: [_astray(sample, bound) for sample in one.samples] for law, one in laws.items()}
        return {law: (int(sum(map(np.sum, some))), sum(map(len, some))) for law, some in runs.items()}

    def said(count: int) -> str:
        return "none" if count == 0 else "some"

    usual = counts(ASTRAY)
    drawn = {law: share(_astray(one.random)) for law, one in laws.items()}
    worst = max(np.nanmax(sample.score("late error", j).value) for sample in laws[PROPOSED].samples for j in (0, 1))
    shown = {
        law: f"{usual[law][0]:,} of {usual[law][1]:,}, of random draws {percent(part.low)} to {percent(part.high)}"
        for law, part in drawn.items()
    }
    ours, others = usual[PROPOSED], [law for law in laws if law != PROPOSED]
    listed = "; ".join(f"{law} {shown[law]}" for law in others if usual[law][0]) or "none"
    bounds = {bound: counts(bound)[PROPOSED][0] for bound in (ASTRAY / 2, 2 * ASTRAY)}
    return Finding(
        "strays",
        f"{ours[0]:,} of {ours[1]:,} runs of {PROPOSED} stray: they diverge, or their late error exceeds {ASTRAY:g} "
        "rad.",
        f"Of its random draws {percent(drawn[PROPOSED].low)} to {percent(drawn[PROPOSED].high)} stray; its largest "
        f"late error is {worst:.2g} rad. Runs of the other {len(others)} laws that stray: {listed}.",
        statistic="Counts over all runs of a law, the corners of the screening among them, so no probabilities; shares "
        "of the independent draws with the interval of Clopper and Pearson, 95 %.",
        sample="All runs of each law: screening, indices and random draws.",
        given=f"{EXACT}; SMC has the gain of 5 N m that a1 assumes, with which it strays with an exact model, too.",
        chosen="The ranges, and the gains of the rivals.",
        answer=said(ours[0]),
        variations=(
            *(
                Variation(f"a bound of {bound:g} rad", said(count), f"{count:,} runs")
                for bound, count in bounds.items()
            ),
            *(Variation(law, said(usual[law][0]), shown[law]) for law in others),
        ),
        untried="Ranges without the corners of the screening; for SMC a larger gain.",
    )


def _astray(sample: Sample, bound: float = ASTRAY) -> Flags:
    late = np.stack([sample.score("late error", joint).value for joint in (0, 1)])
    return np.asarray(~(late < bound).all(axis=0))  # a lost run, of NaN, is astray


def gap(one: LawResults, near: Derivatives, metric: str, joint: int) -> Estimate:
    """The distance from S1 of the linear share that lies farthest from it; NaN where there is no gradient."""
    first = one.shares[named(metric, joint)].S1
    apart = np.abs(near.shares(metric, joint) - first.value)
    worst = int(np.argmax(apart))  # of NumPy, whose largest value is NaN where one is
    return Estimate(apart[worst], first.half[worst])


def foretold(laws: Mapping[str, LawResults], near: Mapping[str, Derivatives], metric: str = "RMSE") -> Finding:
    """The derivatives at one point against the indices over the whole range."""
    gaps = {(law, joint): gap(laws[law], near[law], metric, joint) for law in near for joint in (0, 1)}
    sure = {key for key in gaps if narrow(laws[key[0]].shares[named(metric, key[1])].S1)}
    close = [key for key, far in gaps.items() if far.high <= NEAR and key in sure]
    # without a gradient, where the difference is NaN, nothing is foretold
    missed = [key for key, far in gaps.items() if not far.low <= NEAR]
    left = len(gaps) - len(close) - len(missed)
    shown = {key: interval(far) if np.isfinite(far.value) else "no gradient" for key, far in gaps.items()}
    farthest = sorted(gaps, key=lambda key: -np.nan_to_num(gaps[key].value, nan=np.inf))[:FEW]
    listed = ", ".join(f"{law} q{joint + 1} {shown[law, joint]}" for law, joint in farthest)
    slopes = ", ".join(
        f"{law} in {one.slopes(metric)}" for law, one in sorted(near.items(), key=lambda named: named[0] == PROPOSED)
    )

    def said(key: tuple[str, int]) -> str:
        return "foretold" if key in close else "not foretold" if key in missed else "open"

    first = (PROPOSED, 0)
    return Finding(
        "foretold",
        f"For {len(close)} of {len(gaps)} pairs of law and joint the gradient at the numbers of the card foretells "
        f"every first-order index of the {metric} within {NEAR:g}; for {len(missed)} it is farther off, and for "
        f"{left} the intervals leave it open.",
        f"Linear shares lie farthest from S1, with the interval of that S1, for {listed}. The gradient is the slope of "
        f"the runs in so many of all derivatives: {slopes}.",
        statistic="S1, of Sobol designs with a quadratic control variate, against the share of a linear function with "
        "the exact gradient; a slope compares runs over 0.01 % and over 1 % of a number.",
        sample="All runs of the indices, and one run with its derivatives for each law.",
        given="The ranges of this study, which are alike for all laws.",
        chosen="The ranges, and the gains of the rivals.",
        answer=said(first),
        variations=tuple(
            Variation(f"{law}, joint {joint + 1}", said((law, joint)), text)
            for (law, joint), text in shown.items()
            if (law, joint) != first
        ),
        untried="Wider ranges, over which gains act by curves.",
        settled=not left,
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
