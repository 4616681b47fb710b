"""What a7 found, first: which numbers decide each metric of each law, and verdicts that follow from the figures."""

from decimal import ROUND_CEILING, ROUND_FLOOR

import numpy as np

from studies.a7_sensitivity.factors import SPAN
from studies.a7_sensitivity.results import Found, heaviest, named
from studies.a7_sensitivity.sweeps import HELD, LATE, LAWS, METRICS, NARROW, OF_LATE, PROPOSED, SAMPLE, UNTIL
from studies.a7_sensitivity.words import GROUPS, group_of, leaders, narrow, percent, plain, with_interval, written
from studies.paper.laws import RIVALS
from workbench.study.document.document import Cell, Column, Paragraph, Part, Phrase, Reference, Section, Table, Verdict
from workbench.study.sample import Sample
from workbench.study.uncertainty import Estimate, Quantiles, SobolIndices, share
from workbench.study.uncertainty.outputs import Flags

FEW = 3  # leaders that a cell still names
ASTRAY = 1.0  # rad, of a late error: as large as the reference itself
EXACT = "Exact positions and velocities for the rivals, while AOSMC-RGS observes its own from positions"
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
    """How many of the runs that were made leave their reference."""
    counts = {law: sum(map(_lost, one.samples)) for law, one in found.items()}
    drawn = {law: share(_astray(one.random)) for law, one in found.items()}
    late = [sample.outputs("late error", joint) for sample in found[PROPOSED].samples for joint in (0, 1)]
    worst = max(float(np.nanmax(values)) for values in late)
    listed = ", ".join(
        f"{law} {counts[law]:,} of {_runs(one):,}, of random draws {percent(drawn[law].low)} to "
        f"{percent(drawn[law].high)}"
        for law, one in found.items()
    )
    return Verdict(
        "found",
        f"{counts[PROPOSED]:,} of {_runs(found[PROPOSED]):,} runs of {PROPOSED} stray: they diverge, or their "
        f"late error exceeds {ASTRAY:g} rad.",
        f"Its largest late error is {worst:.2g} rad. Runs that stray: {listed}.",
        "Counts over all runs of a law, the screening at the ends of the ranges among them, so no probabilities; "
        "shares of the independent draws with the interval of Clopper and Pearson, 95 %.",
        f"{EXACT}; SMC has the gain of 5 N m that a1 assumes, too small for these errors of the model.",
        "Ranges that leave the screened corners out; for SMC a larger gain.",
    )


def _astray(sample: Sample) -> Flags:
    """Which runs stray from the reference, or fail."""
    late = np.stack([sample.outputs("late error", joint) for joint in (0, 1)])
    return np.asarray(~(late < ASTRAY).all(axis=0))


def _lost(sample: Sample) -> int:
    return int(_astray(sample).sum())


def _runs(one: Found) -> int:
    return sum(len(sample) for sample in one.samples)


def deciding_gain(ours: Found, metric: str = "RMSE") -> Verdict:
    """Which gain has the largest total index among the gains at each joint."""
    gains = [i for i, factor in enumerate(ours.shares.factors) if group_of(factor) == "gains"]
    names = [ours.shares.factors[i] for i in gains]
    first, said = [], []  # by joint
    for joint in (0, 1):
        total = ours.shares[named(metric, joint)].ST
        among = Estimate(total.value[gains], total.half[gains])
        first.append(_leads(f"the {metric} of joint {joint + 1}", names, among))
        shown = sorted(zip(among.value, among.half, names, strict=True), reverse=True)[:FEW]
        listed = ", ".join(f"{name} {with_interval(value, half)}" for value, half, name in shown)
        said.append(f"joint {joint + 1}: {listed}")
    return Verdict(
        "found" if all(known for known, _ in first) else "open",
        f"Of the gains of {PROPOSED}, over these ranges, {'; '.join(words for _, words in first)}.",
        f"Total indices of the gains, {'; '.join(said)}.",
        f"ST of the {metric} up to {UNTIL:g} s, {INDICES}.",
        f"Q and R a factor of {SPAN:g} either way, as the paper does not state them, the stated gains 10 %.",
        "Equal ranges for stated and assumed gains, or ranges as wide as those of the card.",
    )


def _leads(output: str, names: list[str], total: Estimate) -> tuple[bool, str]:
    """Whether one name leads, and the sentence on it."""
    first, *others = leaders(names, total)
    if not narrow(total):
        return False, f"which decides most about {output} is open, as an interval is wider than {NARROW:g}"
    if others:
        return False, f"about {output} the runs do not tell {first} from {', '.join(others)}"
    return True, f"{first} decides most about {output}"


def idle_gains(ours: Found, names: tuple[str, ...] = ("phi", "K(0)", "P(0)", "l")) -> Verdict:
    """How much some gains move the tracking error beside the strongest factor, by the screening."""
    shares, most = [], []
    for joint in (0, 1):
        size = ours.effects[named("RMSE", joint)].mu_star
        places = [ours.effects.factors.index(name) for name in names]
        shares.append(float(size.value[places].max() / size.value.max()))
        most.append(float(size.high[places].max() / size.value.max()))
    return Verdict(
        "found",
        f"{', '.join(names[:-1])} and {names[-1]} each move the RMSE of {PROPOSED} by at most {percent(max(most))} of "
        "what the strongest factor does, over these ranges.",
        f"The largest mu* among them is {percent(shares[0])} and {percent(shares[1])} of the largest of all (joints 1 "
        f"and 2); {percent(max(most))} is the upper end of its interval.",
        "The mean size mu* of the elementary effects of the screening, with Student's interval of 95 %.",
        f"phi, K(0) and P(0) 10 % either way, as they are stated, l a factor of {SPAN:g}.",
        "Wider ranges: these say nothing of a boundary layer or a first gain several times as large.",
    )


def late_error_of(ours: Found) -> Verdict:
    """How much of the variance of the late error the gains have."""
    total = [ours.shares[named("late error", joint)].of_group("gains", True) for joint in (0, 1)]
    # what gains do together counts in the total index of each, so their sum bounds from above
    high = max(float(one.high) for one in total)
    held = [factor for factor in HELD[PROPOSED] if group_of(factor) == "gains"]
    free = [factor for factor in ours.indices.factors if group_of(factor) == "gains"]
    said = " and ".join(with_interval(float(one.value), float(one.half), 3) for one in total)
    return Verdict(
        "found" if narrow(*total) else "open",
        f"Of the gains those left free ({', '.join(free)}) have at most {100 * high:.1f} % of the variance of the late "
        f"error of {PROPOSED}; the arm and its model have at least the rest, over these ranges.",
        f"The total indices of these gains sum to {said} at joints 1 and 2; {', '.join(held)} the screening left at "
        f"their values. {heaviest(ours.indices)}",
        f"The sum of ST over the gains, for the largest |e| from {LATE:g} to {UNTIL:g} s, {INDICES}.",
        "Links and masses of arm and model 10 % off either way, independently of each other.",
        "A better model: the smaller its errors, the larger the part of the variance that the gains have.",
    )


def late_errors(found: dict[str, Found]) -> Verdict:
    """The late error of the laws that learn a gain, beside that of the proposed law."""
    ends = {law: [found[law].spread("late error", joint) for joint in (0, 1)] for law in LAWS}
    learning = [law for law in RIVALS if law.endswith("ASMC")]
    ours = float(_worse(ends[PROPOSED]).low[0, -1])
    theirs = max(float(one.high[0, -1]) for law in learning for one in ends[law])
    shown = ", ".join(f"{law} {_quantile(ends[law])}" for law in LAWS)
    return Verdict(
        "found" if theirs < ours else "open",
        f"The 95 % quantile of the late error of the worse joint is at least {plain(1e3 * ours, ROUND_FLOOR)} mrad "
        f"with {PROPOSED} behind its observer, and at most {plain(1e3 * theirs, ROUND_CEILING)} mrad with "
        f"{', '.join(learning)} on exact states.",
        f"The quantile at the worse joint, in mrad: {shown}.",
        f"The 95 % quantile of the largest |e| from {LATE:g} to {UNTIL:g} s over {len(found[PROPOSED].random)} "
        "independent draws, with the interval of order statistics, 95 %.",
        f"{EXACT}. The laws are not given the same, so this says nothing of the law apart from its observer.",
        "The same observer for all laws, which a8 gives them, or measurements with noise.",
    )


def _worse(joints: list[Quantiles]) -> Quantiles:
    return max(joints, key=lambda held: float(held.value[0, -1]))


def _quantile(joints: list[Quantiles]) -> str:
    one = _worse(joints)
    value, low, high = (1e3 * float(part[0, -1]) for part in (one.value, one.low, one.high))
    return f"{plain(value)} ({plain(low, ROUND_FLOOR)} to {plain(high, ROUND_CEILING)})"


def chattering(ours: Found) -> Verdict:
    """What parts of the variance of the total variation the model and the gains have."""
    shares = [ours.shares[named("TV", joint)] for joint in (0, 1)]
    pairs = [(one.of_group("model"), one.of_group("gains")) for one in shares]
    above = all(model.low > gains.high for model, gains in pairs)
    below = any(model.high < gains.low for model, gains in pairs)
    said = " and ".join(" against ".join(with_interval(float(e.value), float(e.half)) for e in two) for two in pairs)
    known = narrow(*(one for two in pairs for one in two))
    return Verdict(
        "found" if known and (above or below) else "open",
        f"The model has {_parts(pairs, 0)} of the variance of the chattering (TV) of {PROPOSED} at joints 1 and 2 by "
        f"itself, and all gains together {_parts(pairs, 1)}.",
        f"First-order parts of the model against those of the gains, joints 1 and 2: {said}.",
        f"Sums of S1 of the total variation of the torque, sampled every {1e3 * SAMPLE:g} ms, {INDICES}.",
        "Four numbers of the model and the stated gains 10 % off, Q and R a factor of "
        f"{SPAN:g}; phi stays at its value.",
        "A model known to 2 %, or wider ranges of the gains.",
    )


def _parts(pairs: list[tuple[Estimate, Estimate]], place: int) -> str:
    return " and ".join(percent(float(pair[place].value)) for pair in pairs)


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
            OF_LATE,
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
