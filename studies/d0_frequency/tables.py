"""The tables of d0: margins, ranges over poses, and predictions beside runs."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from studies.d0_frequency.draws import COUNT, ITEMS, drawn
from studies.d0_frequency.limit_cycles import PERIODS, QUIET, LimitCycle
from studies.d0_frequency.loops import ARM_POSES, COMPUTERS, CONTINUOUS, RUN_POSES, AtPose
from studies.d0_frequency.period_limits import limits
from studies.d0_frequency.rest_answers import over_poses, rests
from studies.d0_frequency.step_sizes import SIZE_POSES, SIZES, settlings
from studies.paper.card import LAWS
from studies.paper.linearization import LEVEL
from workbench.study import Results, Table
from workbench.study.document.document import Cell, Column, Missing

MINUS = "\N{MINUS SIGN}"
UNSTABLE = Missing("not stable")
PLACES = (CONTINUOUS, *COMPUTERS)


def span(values: Iterable[float], digits: int = 3, scale: float = 1.0) -> str:
    """The least and the largest of numbers in words: '0.34 to 2.0', or one number if both look alike."""
    held = [scale * value for value in values]
    ends = [number(end, digits) for end in (min(held), max(held))]
    return ends[0] if ends[0] == ends[1] else " to ".join(ends)


def number(value: float, digits: int = 3) -> str:
    """A number in words, of a few digits."""
    if np.isinf(value):
        return "any"
    text = f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.{digits}g}"
    return text.replace("-", MINUS)


def margins_table(results: Results) -> Table:
    """The margins of each joint beside the disk margin of both, at the level of the second scenario."""
    rows: list[tuple[Cell, ...]] = []
    for law in LAWS:
        for where in PLACES:
            answer = rests(results)[AtPose(law, LEVEL)][where]
            for joint, found in enumerate(answer.joints):
                head = (law if where == CONTINUOUS and not joint else "", where if not joint else "", joint + 1)
                held = found.margins
                if held is None:
                    rows.append((*head, UNSTABLE, *(6 * (None,))))
                    continue
                gains = (held.gain_low.value, held.gain_high.value)
                parts = (number(gains[0], 2), number(gains[1]), number(held.phase_margin.value))
                times = number(1e3 * held.delay_margin.value), held.Ms.gain.value
                rows.append((*head, *parts, *times, held.disk_margin.value, answer.alpha if not joint else ""))
    columns = (
        Column("law"),
        Column("time"),
        Column("joint"),
        Column("gain down to", align="right"),
        Column("up to", align="right"),
        Column("phase", "deg", "right"),
        Column("delay", "ms", "right"),
        Column("Ms", "", "right", digits=3),
        Column("disk margin of the joint", "", "right", digits=3),
        Column("of both at once", "", "right", digits=3),
    )
    notes = (
        "Margins of a joint: with the other joint closed. Any: no increase, or no delay, makes the loop unstable. In a "
        "computer the torque acts one period late; what is left of each margin is printed. The observer of AOSMC-RGS "
        "counts on the torque that the law commands, so that a delay at the cut is none between law and observer.",
    )
    caption = "Margins at the torques, at rest at the level of the second scenario, adapting gains held at K(0)."
    return Table("margins", caption, columns, tuple(rows), notes)


def ranges_table(results: Results) -> Table:
    """The ranges over the poses."""
    rows: list[tuple[Cell, ...]] = []
    for law in LAWS:
        every = list(over_poses(rests(results), law).values())
        stable = [one for one in every if one.stable]
        margins = [span(values) for values in ([one.alpha for one in stable], [one.single for one in stable])]
        delays, peaks = span((one.delay for one in stable), scale=1e3), span(one.Ms for one in stable)
        poles = np.concatenate([one.poles.real for one in stable])
        fastest = number(float(poles.min()))
        slow = span(sorted(float(one.poles.real.max()) for one in stable))
        rows.append((law, f"{len(stable)} of {len(every)}", *margins, delays, peaks, slow, fastest))
    columns = (
        Column("law"),
        Column("stable"),
        Column("disk margin of both"),
        Column("least of one joint"),
        Column("delay margin", "ms"),
        Column("largest Ms"),
        Column("slowest pole", "1/s"),
        Column("fastest pole", "1/s", "right"),
    )
    notes = (f"Poses: {', '.join(ARM_POSES)}. Poles: their real parts.",)
    caption = "Margins in continuous time over six poses, from the least to the largest."
    return Table("ranges", caption, columns, tuple(rows), notes)


def limits_table(results: Results) -> Table:
    """The longest periods, predicted and in runs."""
    rows: list[tuple[Cell, ...]] = []
    for law in LAWS:
        for pose in RUN_POSES:
            one = AtPose(law, pose)
            own = limits(results)[one]
            rule = rests(results)[one][CONTINUOUS].delay / 1.5
            brackets = [bracket(own.ends(start), own.limit) for start in ("small", "large")]
            learned = own.learned[1]
            verdict = None if learned is None else ("yes" if learned else "no")
            first = law if pose == RUN_POSES[0] else ""
            rows.append((first, pose, number(1e3 * rule), 1e3 * own.limit, *brackets, verdict))
    columns = (
        Column("law"),
        Column("pose"),
        Column("delay margin / 1.5", "ms", "right"),
        Column("linear map", "ms", "right", digits=3),
        Column("small start: rests, chatters", "ms"),
        Column("large start: rests, chatters", "ms"),
        Column("predicted by the learned gain"),
    )
    notes = (
        "Delay margin / 1.5: the period at which a delay of one period, and half a period for the hold, use up the "
        "delay margin of continuous time. Linear map: the period at which a pole of the exact map of the period "
        "reaches the unit circle. Runs: the longest period tried at which a run rests, and the next one.",
        "Learned gain: if the linear map, with the gain that the run from the large start has learned by its end, is "
        "stable at the one period and unstable at the other. A dash: the law learns no gain, or an end was not tried.",
    )
    caption = "The longest period of the computer, as predicted and as run, with the torque one period late."
    return Table("period_limits_table", caption, columns, tuple(rows), notes)


def bracket(ends: tuple[float, float], limit: float) -> str:
    """The ends of a bracket, given as shares of a limit in s, in ms."""
    low, high = (1e3 * end * limit for end in ends)
    last = "no longer one tried" if np.isinf(high) else number(high)
    return f"{number(low)}, {last}" if low else f"none tried, {last}"


def sizes_table(results: Results) -> Table:
    """Settling times by size at the level, and the range of the prediction over the poses."""
    rows: list[tuple[Cell, ...]] = []
    for law in LAWS:
        own = settlings(results)[AtPose(law, LEVEL)]
        cells = (value if np.isfinite(value) else Missing("never") for value in map(float, own.runs))
        over = span(settlings(results)[AtPose(law, pose)].predicted for pose in SIZE_POSES)
        rows.append((law, over, own.predicted, *cells))
    columns = (
        Column("law"),
        Column("linear, both poses", "s"),
        Column("linear", "s", "right", digits=3),
        *(Column(f"{size:g} rad", "s", "right", digits=3) for size in SIZES),
    )
    notes = (
        "Until the slower joint stays within 5 % of the size. Linear: with the adapting gains held at K(0). Both "
        "poses: this level and the extended arm.",
    )
    caption = "Settling times at the level of the second scenario, of the linear part and of runs by the size."
    return Table("settling", caption, columns, tuple(rows), notes)


def draws_table(results: Results) -> Table:
    """The disk margins over the draws."""
    rows: list[tuple[Cell, ...]] = []
    for one in ITEMS:
        own = drawn(results)[one]
        low, middle, high = np.nanquantile(own.alpha, (0.05, 0.5, 0.95))
        unstable = int((own.alpha == 0).sum())
        cells = (float(low), float(middle), float(high), float(np.nanmin(own.alpha)), own.worst)
        rows.append((one.law, one.pose, own.resting, unstable, own.own, *cells))
    columns = (
        Column("law"),
        Column("pose"),
        Column(f"rest, of {COUNT}"),
        Column("of these unstable"),
        Column("own numbers", "", "right", digits=3),
        Column("5 %", "", "right", digits=3),
        Column("median", "", "right", digits=3),
        Column("95 %", "", "right", digits=3),
        Column("worst", "", "right", digits=3),
        Column("worst draw"),
    )
    notes = (
        "Draws: the factors of a7 over its ranges, the arm and the model that the law believes in apart. A draw "
        "without rest has no linear answer: holding what the model misses takes s out of the layer.",
    )
    return Table("draws", "The disk margin of both torques at once over draws.", columns, tuple(rows), notes)


def cycles_table(results: Results) -> Table:
    """Harmonic balance and runs by period."""
    rows: list[tuple[Cell, ...]] = []
    held: dict[float, LimitCycle] = dict(zip(PERIODS, results.work("limit_cycles"), strict=True))
    for T, one in held.items():
        still = Missing("rest")
        balance: tuple[Cell, Cell] = (still, still) if one.rest or one.predicted is None else one.predicted
        moving = [run for run in one.runs if run.amplitude > QUIET]
        runs: tuple[Cell, Cell] = (still, still)
        if moving:
            runs = span(run.frequency or 0.0 for run in moving), span(run.amplitude for run in moving)
        rows.append((1e3 * T, one.balance.least_phi, *balance, *runs, f"{len(moving)} of {len(one.runs)}"))
    columns = (
        Column("period", "ms", "right"),
        Column("least width", "rad/s", "right", digits=3),
        Column("balance", "rad/s", "right", digits=3),
        Column("balance, s", "rad/s", "right", digits=3),
        Column("runs", "rad/s", "right"),
        Column("runs, s", "rad/s", "right"),
        Column("runs that oscillate"),
    )
    notes = ("Frequency, then amplitude of s of joint 1. Least width: of a layer without an oscillation.",)
    caption = "The limit cycle of SMC on the folded arm, its torque one period late, in a layer of 0.01 rad/s."
    return Table("cycles", caption, columns, tuple(rows), notes)
