"""What a7 found, first: which numbers decide each metric of each law, and verdicts that follow from the figures."""

import numpy as np
from paper_laws import RIVALS
from sensitivity_found import Found, named
from sensitivity_sweeps import HELD, LATE, LAWS, METRICS, PROPOSED
from sensitivity_words import GROUPS, group_of, leaders, percent, sums, with_interval, written

from workbench.study.document import Cell, Column, Paragraph, Part, Phrase, Reference, Section, Table, Verdict
from workbench.study.sample import Sample
from workbench.study.sensitivity import Estimate

FEW = 3  # leaders that a cell still names
HARDLY = 0.1  # of the largest mu*
ASTRAY = 1.0  # rad, of a late error: as large as the reference itself
SMALL = 1e-3  # rad, of an error that nobody would call one
EXACT = "The rivals are given exact positions and velocities; AOSMC-RGS observes its own from positions."


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
    """Whether the proposed law keeps the arm near its reference in all runs that were made."""
    counts = {law: [_lost(sample) for sample in one.samples] for law, one in found.items()}
    ours = counts[PROPOSED]
    late = [sample.outputs("late error", joint) for sample in found[PROPOSED].samples for joint in (0, 1)]
    worst = max(float(np.nanmax(values)) for values in late)
    others = ", ".join(f"{law} {sum(lost)} of {_runs(found[law])}" for law, lost in counts.items() if law != PROPOSED)
    return Verdict(
        "fails" if sum(ours) else "holds",
        f"{PROPOSED} keeps the late error below {ASTRAY:g} rad everywhere in these ranges.",
        f"It does not in {sum(ours)} of {_runs(found[PROPOSED])} runs, {ours[0]} of them in the screening, which goes "
        f"to the ends of the ranges; the largest late error is {worst:.2g} rad. Of the rivals: {others}.",
    )


def _lost(sample: Sample) -> int:
    """How many runs stray from the reference, or fail."""
    late = np.stack([sample.outputs("late error", joint) for joint in (0, 1)])
    return int((~(late < ASTRAY)).any(axis=0).sum())


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
        stands.append("fails" if gain not in first else "holds" if len(first) == 1 else "open")
        shown = sorted(zip(among.value, among.half, names, strict=True), reverse=True)[:FEW]
        listed = ", ".join(f"{name} {with_interval(value, half)}" for value, half, name in shown)
        said.append(f"joint {joint + 1}: {listed}")
    return Verdict(
        "fails" if "fails" in stands else "holds" if stands == ["holds", "holds"] else "open",
        f"Of the gains of {PROPOSED}, {gain} decides most about the {metric} of both joints.",
        f"Total indices of the gains, {'; '.join(said)}.",
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
    return Verdict(
        "holds" if max(sure) < HARDLY else "fails" if max(least) >= HARDLY else "open",
        f"{', '.join(names[:-1])} and {names[-1]} hardly move the RMSE of {PROPOSED}: less than a tenth of what the "
        "strongest factor does.",
        f"The largest mu* among them is {percent(highest[0])} and {percent(highest[1])} of the largest of all "
        f"(joints 1 and 2), at most {percent(max(sure))} within the intervals.",
    )


def late_error_of(ours: Found) -> Verdict:
    """Whether the late error is a matter of the arm and its model alone."""
    gains = [i for i, factor in enumerate(ours.shares.factors) if group_of(factor) == "gains"]
    shares = [ours.shares[named("late error", joint)] for joint in (0, 1)]
    value = [float(one.ST.value[gains].sum()) for one in shares]
    high = [float(one.ST.high[gains].sum()) for one in shares]
    # what gains do together counts in the total index of each, so their sum bounds from above, that of S1 from below
    least = [float(np.subtract(*sums(one.factors, one.S1)["gains"])) for one in shares]
    held = [factor for factor in HELD[PROPOSED] if group_of(factor) == "gains"]
    return Verdict(
        "holds" if max(high) < HARDLY else "fails" if max(least) >= HARDLY else "open",
        f"The late error of {PROPOSED} is that of its model: all gains have less than a tenth of its variance.",
        f"Their total indices sum to {value[0]:.2f} and {value[1]:.2f}, at most {max(high):.2f} within the intervals; "
        f"without {', '.join(held)}, which the screening left at their values.",
    )


def late_errors(found: dict[str, Found]) -> Verdict:
    """Whether the laws that learn a gain stay below a small late error where the proposed law does not."""
    ends = {law: [found[law].spread("late error", joint) for joint in (0, 1)] for law in LAWS}
    best = {law: float(min(one.low[0, -1] for one in ends[law])) for law in LAWS}
    worst = {law: float(max(one.high[0, -1] for one in ends[law])) for law in LAWS}
    learning = [law for law in RIVALS if law.endswith("ASMC")]
    shown = ", ".join(f"{law} {_plain(1e3 * max(one.value[0, -1] for one in ends[law]))}" for law in LAWS)
    small, large = all(worst[law] < SMALL for law in learning), best[PROPOSED] > SMALL
    broken = any(best[law] >= SMALL for law in learning) or worst[PROPOSED] <= SMALL
    return Verdict(
        "holds" if small and large else "fails" if broken else "open",
        f"With the same errors of the model, {', '.join(learning)} keep the late error below {1e3 * SMALL:g} mrad in "
        f"95 % of all cases, and {PROPOSED} does not.",
        f"The 95 % quantile of the late error (after {LATE:g} s) of the worse joint, in mrad: {shown}. {EXACT}",
    )


def _plain(value: float) -> str:
    return f"{float(f'{value:.2g}'):,g}"


def chattering(ours: Found) -> Verdict:
    """Whether the model decides more about the total variation than the gains."""
    shares = [sums(ours.shares.factors, ours.shares[named("TV", joint)].S1) for joint in (0, 1)]
    above = [s["model"][0] - s["model"][1] > s["gains"][0] + s["gains"][1] for s in shares]
    below = [s["model"][0] + s["model"][1] < s["gains"][0] - s["gains"][1] for s in shares]
    said = " and ".join(f"{with_interval(*s['model'])} against {with_interval(*s['gains'])}" for s in shares)
    return Verdict(
        "holds" if all(above) else "fails" if any(below) else "open",
        f"What {PROPOSED} believes of the arm decides more about its chattering (TV) than all of its gains do.",
        f"First-order parts of the model against those of the gains, joints 1 and 2: {said}.",
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
        "The factor with the largest total index ST, and its value. Where the intervals do not tell others from it, "
        "these follow.",
        columns,
        tuple(rows),
        (
            "'model' before a letter: the number that the law believes in, where the arm keeps its own.",
            "Intervals are of 95 %, each by itself: among so many a few miss.",
        ),
    )


def _leading(one: Found, metric: str, joint: int) -> Phrase:
    total = one.shares[named(metric, joint)].ST
    first = leaders(one.shares.factors, total)
    top = one.shares.factors.index(first[0])
    said = (*_joined(first[:1]), f" {total.value[top]:.2f}")
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
                parts = sums(shares.factors, shares.S1)
                rest = 1 - sum(value for value, _ in parts.values())
                half = sum(half for _, half in parts.values())
                cells = (with_interval(*parts[group]) if _has(one, group) else None for group in GROUPS)
                deviation = float(np.asarray(shares.deviation))
                rows.append((law, metric.name, joint + 1, f"{deviation:.2g}", *cells, with_interval(rest, half)))
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
            "An interval is the sum of those of its indices, so it is wider than it need be.",
        ),
    )


def _has(one: Found, group: str) -> bool:
    return any(group_of(factor) == group for factor in one.shares.factors)
