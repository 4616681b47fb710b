"""The tables of d0: margins, ranges over poses, and predictions beside runs."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

import numpy as np

import workbench as wb
from studies.d0_frequency.draws import COUNT, ITEMS, draws_by_pose
from studies.d0_frequency.limit_cycles import PERIODS, QUIET, LimitCycle
from studies.d0_frequency.loops import ARM_POSES, COMPUTERS, CONTINUOUS, RUN_POSES, AtPose
from studies.d0_frequency.period_limits import limits
from studies.d0_frequency.rest_answers import over_poses, rests
from studies.d0_frequency.step_sizes import SIZE_POSES, SIZES, settlings
from studies.paper.card import LAWS
from studies.paper.linearization import LEVEL

MINUS = "\N{MINUS SIGN}"
UNSTABLE = wb.document.MissingCell("unstable")
PLACES = (CONTINUOUS, *COMPUTERS)


def span(values: Iterable[float], digits: int = 3, scale: float = 1.0) -> str:
    """The least and the largest of numbers in words: '0.34 to 2.0', or one number if both look alike."""
    return wb.document.span((scale * value for value in values), partial(number, digits=digits))


def number(value: float, digits: int = 3) -> str:
    """A number in words, of a few digits."""
    if np.isinf(value):
        return "any"
    text = f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.{digits}g}"
    return text.replace("-", MINUS)


def margins_table(results: wb.Results) -> wb.document.ReportTable:
    """The margins of each joint beside the disk margin of both, at the level of the second scenario."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for law in LAWS:
        for where in PLACES:
            answer = rests(results)[AtPose(law, LEVEL)][where]
            for joint, found in enumerate(answer.joints):
                period = "none" if where == CONTINUOUS else where
                head = (law if where == CONTINUOUS and not joint else "", period if not joint else "", joint + 1)
                held = found.margins
                if held is None:
                    rows.append((*head, UNSTABLE, *(6 * (None,))))
                    continue
                gains = (held.gain_low.value, held.gain_high.value)
                parts = (number(gains[0], 2), number(gains[1]), number(held.phase_margin.value))
                times = number(1e3 * held.delay_margin.value), held.Ms.gain.value
                rows.append((*head, *parts, *times, held.disk_margin.value, answer.alpha if not joint else ""))
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("period"),
        wb.document.TableColumn("joint"),
        wb.document.TableColumn("least gain", align="right"),
        wb.document.TableColumn("largest gain", align="right"),
        wb.document.TableColumn("phase margin", "deg", "right"),
        wb.document.TableColumn("delay margin", "ms", "right"),
        wb.document.TableColumn("Ms", "", "right", digits=3),
        wb.document.TableColumn("disk margin of the joint", "", "right", digits=3),
        wb.document.TableColumn("disk margin of both", "", "right", digits=3),
    )
    notes = (
        "The margins of a joint have the loop of the other joint closed. Least and largest gain: the loop stays stable "
        "between these factors at the torque. Any: no factor, or no delay, makes the loop unstable. Without a period "
        "the law acts in continuous time. With a period the torque acts one period late, and the margins are what this "
        "delay leaves. A delay at the torque is not a delay between AOSMC-RGS and its observer.",
    )
    caption = "Stability margins at the torques, at rest at the level of SS."
    return wb.document.ReportTable("margins", caption, columns, tuple(rows), notes)


def ranges_table(results: wb.Results) -> wb.document.ReportTable:
    """The ranges over the poses."""
    rows: list[tuple[wb.document.Cell, ...]] = []
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
        wb.document.TableColumn("law"),
        wb.document.TableColumn("stable poses"),
        wb.document.TableColumn("disk margin of both"),
        wb.document.TableColumn("disk margin of the worse joint"),
        wb.document.TableColumn("delay margin of the worse joint", "ms"),
        wb.document.TableColumn("Ms of the worse joint"),
        wb.document.TableColumn("slowest pole", "1/s"),
        wb.document.TableColumn("fastest pole", "1/s", "right"),
    )
    notes = (f"Poses: {', '.join(ARM_POSES)}. The table has the real parts of the slowest and the fastest pole.",)
    caption = "Margins and poles in continuous time over six poses: the least and the largest value of each."
    return wb.document.ReportTable("ranges", caption, columns, tuple(rows), notes)


def limits_table(results: wb.Results) -> wb.document.ReportTable:
    """The longest periods, predicted and in runs."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for law in LAWS:
        for pose in RUN_POSES:
            one = AtPose(law, pose)
            own = limits(results)[one]
            rule = rests(results)[one][CONTINUOUS].delay / 1.5
            brackets = [bracket(own.ends(start), own.limit) for start in ("small", "large")]
            learned = own.learned_gain_agrees[1]
            verdict = None if learned is None else ("yes" if learned else "no")
            first = law if pose == RUN_POSES[0] else ""
            rows.append((first, pose, number(1e3 * rule), 1e3 * own.limit, *brackets, verdict))
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("pose"),
        wb.document.TableColumn("delay margin / 1.5", "ms", "right"),
        wb.document.TableColumn("linear loop", "ms", "right", digits=3),
        wb.document.TableColumn("run from 10 µrad: at rest, chatters", "ms"),
        wb.document.TableColumn("run from 0.3 rad: at rest, chatters", "ms"),
        wb.document.TableColumn("linear loop with learned gain is right"),
    )
    notes = (
        "Delay margin / 1.5: the period at which a delay of one period, and half a period for the hold, use up the "
        "delay margin of continuous time. Linear loop: the period at which a pole of this loop reaches the unit "
        "circle. Runs: the longest tried period at which a run comes to rest, and the next one.",
        "Learned gain: 'yes' if the linear loop, with the gain that the run from 0.3 rad has learned, is stable at the "
        "first of these periods and unstable at the second. A dash: the law learns no gain, or one of the two periods "
        "was not tried.",
    )
    caption = "The longest sampling period, predicted and in runs, with the torque one period late."
    return wb.document.ReportTable("period_limits_table", caption, columns, tuple(rows), notes)


def bracket(ends: tuple[float, float], limit: float) -> str:
    """The ends of a bracket, given as shares of a limit in s, in ms."""
    low, high = (1e3 * end * limit for end in ends)
    last = "none longer tried" if np.isinf(high) else number(high)
    return f"{number(low)}, {last}" if low else f"none tried, {last}"


def sizes_table(results: wb.Results) -> wb.document.ReportTable:
    """Settling times by size at the level, and the range of the prediction over the poses."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for law in LAWS:
        own = settlings(results)[AtPose(law, LEVEL)]
        cells = (value if np.isfinite(value) else wb.document.MissingCell("never") for value in map(float, own.runs))
        over = span(settlings(results)[AtPose(law, pose)].prediction for pose in SIZE_POSES)
        rows.append((law, over, own.prediction, *cells))
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("linear, both poses", "s"),
        wb.document.TableColumn("linear", "s", "right", digits=3),
        *(wb.document.TableColumn(f"{1e3 * size:,g} mrad", "s", "right", digits=3) for size in SIZES),
    )
    notes = (
        "Settling time: the time after which the slower joint stays within 5 % of the start. Linear: for the linear "
        "loop, which has the same settling time for all starts, at the level of SS and for the extended arm. All other "
        "columns are at the level of SS.",
    )
    caption = (
        "Settling times of the linear loop, and of runs in which both joints start 0.1 to 1,000 mrad from equilibrium."
    )
    return wb.document.ReportTable("settling", caption, columns, tuple(rows), notes)


def draws_table(results: wb.Results) -> wb.document.ReportTable:
    """The disk margins over the draws."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for one in ITEMS:
        own = draws_by_pose(results)[one]
        low, middle, high = np.nanquantile(own.alpha, (0.05, 0.5, 0.95))
        unstable = int((own.alpha == 0).sum())
        cells = (float(low), float(middle), float(high), float(np.nanmin(own.alpha)), own.worst)
        rows.append((one.law, one.pose, own.rest_count, unstable, own.own, *cells))
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("pose"),
        wb.document.TableColumn(f"draws at rest, of {COUNT}"),
        wb.document.TableColumn("of these unstable"),
        wb.document.TableColumn("without draws", "", "right", digits=3),
        wb.document.TableColumn("5 % quantile", "", "right", digits=3),
        wb.document.TableColumn("median", "", "right", digits=3),
        wb.document.TableColumn("95 % quantile", "", "right", digits=3),
        wb.document.TableColumn("least", "", "right", digits=3),
        wb.document.TableColumn("draw with the least"),
    )
    notes = (
        "The draws vary the numbers that report a7 varies, over the same ranges; the arm and the law's model of it "
        "vary separately. The margin of an unstable loop is 0. A draw without an equilibrium has no linear answer: to "
        "hold the arm in spite of the error of the model, s would have to leave the layer.",
    )
    return wb.document.ReportTable(
        "draws",
        "The disk margin of both torques at once, with numbers of arm, model and law drawn at random.",
        columns,
        tuple(rows),
        notes,
    )


def cycles_table(results: wb.Results) -> wb.document.ReportTable:
    """Harmonic balance and runs by period."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    held: dict[float, LimitCycle] = dict(zip(PERIODS, results.work("limit_cycles"), strict=True))
    for T, one in held.items():
        still = wb.document.MissingCell("rest")
        balance: tuple[wb.document.Cell, wb.document.Cell] = (
            (still, still) if one.rest or one.prediction is None else one.prediction
        )
        moving = [run for run in one.runs if run.amplitude > QUIET]
        runs: tuple[wb.document.Cell, wb.document.Cell] = (still, still)
        if moving:
            runs = span(run.frequency or 0.0 for run in moving), span(run.amplitude for run in moving)
        rows.append((1e3 * T, one.balance.least_phi, *balance, *runs, f"{len(moving)} of {len(one.runs)}"))
    columns = (
        wb.document.TableColumn("period", "ms", "right"),
        wb.document.TableColumn("narrowest layer at rest", "rad/s", "right", digits=3),
        wb.document.TableColumn("frequency by balance", "rad/s", "right", digits=3),
        wb.document.TableColumn("amplitude by balance", "rad/s", "right", digits=3),
        wb.document.TableColumn("frequency in runs", "rad/s", "right"),
        wb.document.TableColumn("amplitude in runs", "rad/s", "right"),
        wb.document.TableColumn("runs that oscillate"),
    )
    notes = (
        "Amplitude: of s of joint 1. Narrowest layer: by the balance a narrower layer leads to an oscillation. Four "
        "runs start with different velocities; if they differ, the table has the least and the largest value.",
    )
    caption = (
        "The oscillation of SMC on the folded arm, with the torque one period late, in a boundary layer of 0.01 rad/s."
    )
    return wb.document.ReportTable("cycles", caption, columns, tuple(rows), notes)
