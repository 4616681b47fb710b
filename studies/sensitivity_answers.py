"""What a7 found, first: which numbers decide each metric of each law, and verdicts that follow from the figures."""

import numpy as np
from findings import finding
from paper_laws import RIVALS
from sensitivity_factors import SPAN
from sensitivity_found import Found, named
from sensitivity_sweeps import HELD, LATE, LAWS, METRICS, NARROW, PROPOSED, SAMPLE, UNTIL
from sensitivity_words import GROUPS, group_of, leaders, narrow, percent, with_interval, written

from workbench.study.document import Cell, Column, Paragraph, Part, Phrase, Reference, Section, Table, Verdict
from workbench.study.sample import Sample
from workbench.study.sensitivity import Estimate, Quantiles, SobolIndices, share
from workbench.study.sensitivity.outputs import Flags

FEW = 3  # leaders that a cell still names
HARDLY = 0.1  # of the largest mu*
ASTRAY = 1.0  # rad, of a late error: as large as the reference itself
SMALL = 1e-3  # rad, of an error that nobody would call one
EXACT = "exact positions and velocities for the rivals, while AOSMC-RGS observes its own from positions"
INDICES = "of a Sobol design with a quadratic control variate, intervals by the jackknife over its scrambles, 95 %"


def answers(found: dict[str, Found]) -> Section:
    """The findings first."""
    ours = found[PROPOSED]
    return Section(
        "What was found",
        (
            Paragraph(
                (
                    Reference("leaders"),
                    " names the number that decides most about each metric, ",
                    Reference("groups"),
                    " what part of each variance the gains, the arm and its model have by themselves.",
                )
            ),
            deciding_gain(ours),
            idle_gains(ours),
            late_error_of(ours),
            late_errors(found),
            chattering(ours),
            strays(found),
            leaders_table(found),
        ),
    )


def groups(found: dict[str, Found]) -> Section:
    """Gains against arm and model."""
    return Section("Gains, arm or model", (groups_table(found),))


def strays(found: dict[str, Found]) -> Verdict:
    """Whether the proposed law leaves its reference in some of the runs that were made."""
    counts = {law: sum(map(_lost, one.samples)) for law, one in found.items()}
    drawn = {law: share(_astray(one.random)) for law, one in found.items()}
    late = [sample.outputs("late error", joint) for sample in found[PROPOSED].samples for joint in (0, 1)]
    worst = max(float(np.nanmax(values)) for values in late)
    listed = ", ".join(
        f"{law} {counts[law]:,} of {_runs(one):,}, of random draws {percent(drawn[law].low)} to "
        f"{percent(drawn[law].high)}"
        for law, one in found.items()
    )
    return finding(
        "holds" if counts[PROPOSED] else "fails",
        f"Within these ranges there are runs in which {PROPOSED} strays: its late error exceeds {ASTRAY:g} rad.",
        f"Its largest late error is {worst:.2g} rad. Runs that stray: {listed}.",
        estimand=f"counts over all {_runs(found[PROPOSED]):,} runs of the law, the screening at the ends of the "
        "ranges among them; shares of the independent draws with the interval of Clopper and Pearson, 95 %",
        given=f"{EXACT}; SMC has the gain of 5 N m that a1 assumes, too small for these errors of the model",
        reversal="ranges that leave the screened corners out; for SMC a larger gain",
    )


def _astray(sample: Sample) -> Flags:
    """Which runs stray from the reference, or fail."""
    late = np.stack([sample.outputs("late error", joint) for joint in (0, 1)])
    return np.asarray(~(late < ASTRAY).all(axis=0))


def _lost(sample: Sample) -> int:
    return int(_astray(sample).sum())


def _runs(one: Found) -> int:
    return sum(len(sample) for sample in one.samples)


def deciding_gain(ours: Found, gain: str = "Q", metric: str = "RMSE") -> Verdict:
    """Whether one gain has the largest total index among the gains, at both joints."""
    gains = [i for i, factor in enumerate(ours.shares.factors) if group_of(factor) == "gains"]
    names = [ours.shares.factors[i] for i in gains]
    stands, said = [], []
    for joint in (0, 1):
        total = ours.shares[named(metric, joint)].ST
        among = Estimate(total.value[gains], total.half[gains])
        first = leaders(names, among)
        sure = "fails" if gain not in first else "holds" if len(first) == 1 else "open"
        stands.append(sure if narrow(among) else "open")
        shown = sorted(zip(among.value, among.half, names, strict=True), reverse=True)[:FEW]
        listed = ", ".join(f"{name} {with_interval(value, half)}" for value, half, name in shown)
        said.append(f"joint {joint + 1}: {listed}")
    return finding(
        "fails" if "fails" in stands else "holds" if stands == ["holds", "holds"] else "open",
        f"Of the gains of {PROPOSED}, {gain} decides most about the {metric} of both joints.",
        f"Total indices of the gains, {'; '.join(said)}.",
        estimand=f"ST of the {metric} up to {UNTIL:g} s, {INDICES}",
        given=f"Q and R a factor of {SPAN:g} either way, as the paper does not state them, the stated gains 10 %",
        reversal="equal ranges for stated and assumed gains, or ranges as wide as those of the card",
    )


def idle_gains(ours: Found, names: tuple[str, ...] = ("phi", "K(0)", "P(0)", "l")) -> Verdict:
    """Whether some gains have little effect on the tracking error, by the screening."""
    highest, sure, least = [], [], []
    for joint in (0, 1):
        size = ours.effects[named("RMSE", joint)].mu_star
        top = size.value.max()
        places = [ours.effects.factors.index(name) for name in names]
        highest.append(float(size.value[places].max() / top))
        sure.append(float(size.high[places].max() / top))
        least.append(float(size.low[places].max() / top))
    return finding(
        "holds" if max(sure) < HARDLY else "fails" if max(least) >= HARDLY else "open",
        f"{', '.join(names[:-1])} and {names[-1]} hardly move the RMSE of {PROPOSED}: less than a tenth of what the "
        "strongest factor does.",
        f"The largest mu* among them is {percent(highest[0])} and {percent(highest[1])} of the largest of all "
        f"(joints 1 and 2), at most {percent(max(sure))} within the intervals.",
        estimand="the mean size mu* of the elementary effects of the screening, with Student's interval of 95 %",
        given=f"phi, K(0) and P(0) 10 % either way, as they are stated, l a factor of {SPAN:g}",
        reversal="wider ranges: these say nothing of a boundary layer or a first gain several times as large",
    )


def late_error_of(ours: Found) -> Verdict:
    """Whether the late error is a matter of the arm and its model alone."""
    shares = [ours.shares[named("late error", joint)] for joint in (0, 1)]
    total, alone = ([one.of_group("gains", both) for one in shares] for both in (True, False))
    high = max(float(one.high) for one in total)
    # what gains do together counts in the total index of each, so their sum bounds from above, that of S1 from below
    least = max(float(one.low) for one in alone)
    held = [factor for factor in HELD[PROPOSED] if group_of(factor) == "gains"]
    sure = "holds" if high < HARDLY else "fails" if least >= HARDLY else "open"
    said = " and ".join(with_interval(float(one.value), float(one.half)) for one in total)
    return finding(
        sure if narrow(*total) else "open",
        f"The late error of {PROPOSED} is that of its model: all gains have less than a tenth of its variance.",
        f"Their total indices sum to {said}; without {', '.join(held)}, which the screening left at their values.",
        estimand=f"the sum of ST over the gains, for the RMSE from {LATE:g} to {UNTIL:g} s, {INDICES}",
        given="links and masses of arm and model 10 % off either way, independently of each other",
        reversal="a better model: the smaller its errors, the larger the part of the variance that the gains have",
    )


def late_errors(found: dict[str, Found]) -> Verdict:
    """Whether the laws that learn a gain stay below a small late error where the proposed law does not."""
    ends = {law: [found[law].spread("late error", joint) for joint in (0, 1)] for law in LAWS}
    best = {law: float(min(one.low[0, -1] for one in ends[law])) for law in LAWS}
    worst = {law: float(max(one.high[0, -1] for one in ends[law])) for law in LAWS}
    learning = [law for law in RIVALS if law.endswith("ASMC")]
    shown = ", ".join(f"{law} {_quantile(ends[law])}" for law in LAWS)
    small, large = all(worst[law] < SMALL for law in learning), best[PROPOSED] > SMALL
    broken = any(best[law] >= SMALL for law in learning) or worst[PROPOSED] <= SMALL
    return finding(
        "holds" if small and large else "fails" if broken else "open",
        f"With the same errors of the model the 95 % quantile of the late error is below {1e3 * SMALL:g} mrad with "
        f"{', '.join(learning)}, and above it with {PROPOSED}.",
        f"The quantile at the worse joint, in mrad: {shown}.",
        estimand=f"the 95 % quantile of the RMSE from {LATE:g} to {UNTIL:g} s over {len(found[PROPOSED].random)} "
        "independent draws, with the interval of order statistics, 95 %",
        given=EXACT,
        reversal="the same observer for all laws, which a8 gives them, or measurements with noise",
    )


def _quantile(joints: list[Quantiles]) -> str:
    one = max(joints, key=lambda held: float(held.value[0, -1]))
    value, low, high = (_plain(1e3 * float(part[0, -1])) for part in (one.value, one.low, one.high))
    return f"{value} ({low} to {high})"


def _plain(value: float) -> str:
    return f"{float(f'{value:.2g}'):,g}"


def chattering(ours: Found) -> Verdict:
    """Whether the model decides more about the total variation than the gains."""
    shares = [ours.shares[named("TV", joint)] for joint in (0, 1)]
    pairs = [(one.of_group("model"), one.of_group("gains")) for one in shares]
    above = all(model.low > gains.high for model, gains in pairs)
    below = any(model.high < gains.low for model, gains in pairs)
    said = " and ".join(" against ".join(with_interval(float(e.value), float(e.half)) for e in two) for two in pairs)
    known = narrow(*(one for two in pairs for one in two))
    return finding(
        "open" if not known else "holds" if above else "fails" if below else "open",
        f"What {PROPOSED} believes of the arm decides more about its chattering (TV) than all of its gains do.",
        f"First-order parts of the model against those of the gains, joints 1 and 2: {said}.",
        estimand=f"sums of S1 of the total variation of the torque, sampled every {1e3 * SAMPLE:g} ms, {INDICES}",
        given="four numbers of the model and the stated gains 10 % off, Q and R a factor of "
        f"{SPAN:g}; phi stays at its value",
        reversal="a model known to 2 %, or wider ranges of the gains",
    )


def leaders_table(found: dict[str, Found]) -> Table:
    """The factor with the largest total index, law by law and metric by metric."""
    places = [(metric.name, joint) for metric in METRICS for joint in (0, 1)]
    rows: list[tuple[Cell, ...]] = [
        (law, *(_leading(one, metric, joint) for metric, joint in places)) for law, one in found.items()
    ]
    columns = (Column("law"), *(Column(f"{metric}, q{joint + 1}") for metric, joint in places))
    return Table(
        "leaders",
        "The factor with the largest total index ST, and its interval of 95 %. Where the intervals leave room for "
        f"others, these follow; where its own interval is wider than {NARROW:g}, the cell is open.",
        columns,
        tuple(rows),
        (
            "'model' before a letter: the number that the law believes in, where the arm keeps its own.",
            "Each interval holds by itself: among so many a few miss.",
        ),
    )


def _leading(one: Found, metric: str, joint: int) -> Phrase:
    total = one.shares[named(metric, joint)].ST
    first = leaders(one.shares.factors, total)
    top = one.shares.factors.index(first[0])
    value, half = float(total.value[top]), float(total.half[top])
    said = (*_joined(first[:1]), f" {with_interval(value, half)}")
    if 2 * half >= NARROW:
        return ("open: ", *said)
    if len(first) > FEW:
        return (*said, f" or {len(first) - 1} others")
    return (*said, *(part for name in first[1:] for part in (" or ", *_joined((name,)))))


def _joined(names: tuple[str, ...]) -> tuple[Part, ...]:
    return tuple(part for name in names for part in written(name))


def groups_table(found: dict[str, Found]) -> Table:
    """First-order parts of gains, arm and model, and what is left for factors that act together."""
    rows: list[tuple[Cell, ...]] = []
    for law, one in found.items():
        for metric in METRICS:
            for joint in (0, 1):
                shares = one.shares[named(metric.name, joint)]
                whole = shares.of_group("all")
                rest = with_interval(float(1 - whole.value), float(whole.half))
                cells = (_sum(shares, group) if _has(one, group) else None for group in GROUPS)
                deviation = float(np.asarray(shares.deviation))
                rows.append((law, metric.name, joint + 1, f"{deviation:.2g}", *cells, rest))
    columns = (
        Column("law"),
        Column("metric"),
        Column("joint"),
        Column("standard deviation", align="right"),
        *(Column(group, align="right") for group in GROUPS),
        Column("together", align="right"),
    )
    return Table(
        "groups",
        "The parts of the variance of each metric that gains, arm and model have by themselves (sums of S1), and what "
        "is left, which is due to factors that act together.",
        columns,
        tuple(rows),
        (
            "Deviations are in rad, of the TV in N m/s, of the effort in N m.",
            f"Intervals are of 95 %, those of each sum its own; one wider than {NARROW:g} decides nothing here.",
        ),
    )


def _sum(shares: SobolIndices, group: str) -> str:
    part = shares.of_group(group)
    return with_interval(float(part.value), float(part.half))


def _has(one: Found, group: str) -> bool:
    return any(group_of(factor) == group for factor in one.shares.factors)
