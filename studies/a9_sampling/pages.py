"""The pictures and tables of a9 after its findings."""

from collections.abc import Mapping, Sequence

import numpy as np

from studies.a1_paper_tables.study import STYLES
from studies.a9_sampling.evidence import (
    APART,
    PARTS,
    PERIODS,
    PLACES,
    QUIET,
    ROWS,
    RULE,
    SWITCHING,
    Curve,
    Evidence,
    Score,
    Scores,
    in_ms,
    printed,
)
from studies.a9_sampling.loops import CARD, MS, NOISY, REALISTIC, RMSE, SCENARIOS, SEED, TV, WAYS
from studies.paper.card import PROPOSED
from studies.paper.card import SCENARIOS as TITLES
from workbench.study.document.document import Cell, Column, Figure, Measured, Panel, Paragraph, Section, Series, Table

SHOWN = {RMSE: (1e-4, 1e-3, 5e-3, 1e-2), TV: (1e-4, 1e-3, 1e-2)}  # s, as a page is wide
UNITS = {RMSE: ("rad", 1.0), TV: ("kN m/s", 1e-3)}  # with what makes them of rad and N m/s
PAIR = {"euler": "Euler", "cayley": "Cayley"}
ROUGH = {"late": (True, False), "noisy": (False, True), "both": (True, True)}  # with a delay, with noise


def over_periods(evidence: Evidence, metric: str, name: str) -> Figure:
    panels, x, what = [], 1e3 * np.array(PERIODS), metric if metric == RMSE else "Total variation (TV) of the torque"
    for scenario, joint in PLACES:
        series = []
        for law, way, label in ROWS:
            y = np.array([evidence.at(metric, T, way)(law, scenario, joint)[0] for T in PERIODS])
            style, still = STYLES[law] if way == "euler" else len(STYLES), evidence.still(metric)(law, scenario, joint)
            series.append(Series(label, x, np.where(np.isinf(y), np.nan, y), style))
            series.append(Series(label, [x[0]], [still[0]], style, look="marks"))
        title, unit = f"{TITLES[scenario]}, joint {joint + 1}", "rad" if metric == RMSE else "N m/s"
        axes = f"{metric} [{unit}]", tuple(series), "sampling period [ms]"
        panels.append(Panel(*axes, xscale="log", yscale="log", title=title))
    caption = (
        f"{what} over the sampling period, with exact readings and no delay. Marks at the left edge: in "
        "continuous time. A line ends where the run diverges."
    )
    return Figure(name, caption, tuple(panels), columns=2)


def cell(score: Score, scale: float = 1.0) -> Cell:
    """A value with its error in another unit, or that the run diverged."""
    return "diverged" if np.isinf(score[0]) else Measured(scale * score[0], scale * score[1])


def scores_table(metric: str, name: str, evidence: Evidence) -> Table:
    """A metric of all laws and places over the period, and at one period with delay and noise."""
    unit, scale = UNITS[metric]
    heads = ["continuous", *(f"{1e3 * T:g} ms" for T in SHOWN[metric]), *(f"{MS}, {how}" for how in ROUGH)]
    rows = []
    for scenario, joint in PLACES:
        for law, way, label in ROWS:
            over = [evidence.at(metric, T, way) for T in SHOWN[metric]]
            over += [evidence.at(metric, REALISTIC, way, *how) for how in ROUGH.values()]
            cells = (cell(of(law, scenario, joint), scale) for of in (evidence.still(metric), *over))
            rows.append((label, f"{scenario} {joint + 1}", *cells))
    columns = (Column("law"), Column("joint"), *(Column(head, unit, "right") for head in heads))
    return Table(name, f"{metric} over the sampling period, and at {MS} with delay and noise.", columns, tuple(rows))


def periods_section(evidence: Evidence) -> Section:
    """Error and chattering over the period, and at one with delay and noise."""
    words = (
        "In brackets: the error by half the substep of the plant, and with noise twice the standard error of the "
        f"mean of {NOISY} runs. Where an adaptive law chatters widely a run is chaotic, and the error bounds nothing. "
        "Where a layer chatters, its torque jumps by up to 2 K each period: with a K that stays, TV falls as 1/T and "
        "the error that chattering leaves grows as T; a K that learns from s grows with it."
    )
    tables = scores_table(RMSE, "rmse_table", evidence), scores_table(TV, "tv_table", evidence)
    return Section("Over the sampling period, with delay and noise", (Paragraph(words), *tables))


def computer_section() -> Section:
    words = (
        "Once in a period it reads q and qd, steps the memories of law and observer, and holds the torque until the "
        "next; the plant moves by Runge-Kutta steps of at most 2.5 ms in between. All memories step by explicit Euler; "
        "those of AOSMC-RGS also in another way, side by side: P by a Cayley step of (34) and its observer by one of "
        "(10), K by explicit Euler. Where no step is named, it is explicit Euler. With a delay, the torque of one "
        "instant acts from the next on. The laws, their numbers, both scenarios (FS and SS) and the horizons are those "
        "of a1; AOSMC-RGS is the repaired one, whose observer uses the true disturbance, which no instrument gives. "
        "Total variation (TV) is that of the held torque, each change of it counted; in continuous time it is taken on "
        "a grid of 1 ms. No torque is limited."
    )
    table = CARD.table("assumed", "computer", "What is assumed of a realistic computer.")
    return Section("The computer", (Paragraph(words), table))


def apart_section(evidence: Evidence) -> Section:
    rows: list[tuple[Cell, ...]] = []
    for scenario, period, way in ((s, T, way) for s in SCENARIOS for T in APART for way in WAYS):
        found = evidence.found(PROPOSED, scenario, period, way)
        scores = (cell(found.score(m, joint), UNITS[m][1]) for m in (RMSE, TV) for joint in (0, 1))
        rows.append((scenario, 1e3 * period, WAYS[way], f"{found.lost.sum()} of {1 + NOISY}", *scores))
    columns = (
        Column("scenario"),
        Column("period", "ms"),
        Column("memories step by"),
        Column("diverged", "", "right"),
        *(Column(f"{metric}, joint {j}", UNITS[metric][0], "right") for metric in (RMSE, TV) for j in (1, 2)),
    )
    words = (
        "(34) has modes of about -2 |a| with a of A = -M^-1 K, which the loop makes faster as K grows; explicit Euler "
        "multiplies them by 1 - 2 |a| T, beyond -1 where T > 1 / |a|. The Cayley step keeps P definite at every T. 16 "
        "Runge-Kutta steps a period of all memories, with readings, reference and torque held, are near the exact flow "
        "of their equations: a run that they keep finite was lost by the integrator, one that every way loses by the "
        "law."
    )
    caption = f"{PROPOSED} with its memories stepped in four ways, with the same noise in each; values without noise."
    return Section("Integrator and law", (Paragraph(words), Table("integrators", caption, columns, tuple(rows))))


def places_section(evidence: Evidence) -> Section:
    """The published order over the period."""
    cases: dict[str, Mapping[str, Scores]] = {"continuous time": {way: evidence.still(RMSE) for way in PAIR}}
    cases |= {f"{1e3 * period:g} ms": {way: evidence.at(RMSE, period, way) for way in PAIR} for period in PERIODS}
    cases |= {f"{MS}, {n}": {w: evidence.at(RMSE, REALISTIC, w, *how) for w in PAIR} for n, how in ROUGH.items()}
    kinds = (f"{kind}, {way}" for way in PAIR.values() for kind in ("hold", "turned", "open"))
    pairs = Table(
        "printed_pairs",
        "The 60 pairs of the two published tables, by RMSE (43) here.",
        (Column("run by"), *map(Column, kinds)),
        tuple((name, *(len(p) for way in PAIR for p in printed(case[way]).values())) for name, case in cases.items()),
        ("Euler, Cayley: the steps of AOSMC-RGS. Open: closer than 2 % or both errors. Diverged: above all others.",),
    )
    return Section("The published order over the period", (pairs,))


def safe_section(evidence: Evidence) -> Section:
    rows = [
        (law, 1e3 * safe.rule if np.isfinite(safe.rule) else None, *map(in_ms, safe.quiet))
        for law, safe in evidence.safe.items()
    ]
    again = [law for law, safe in evidence.safe.items() if any(one.beyond for one in safe.quiet)]
    unsure = [law for law, safe in evidence.safe.items() if not safe.sure]
    words = (
        f"Quiet: TV at most {QUIET:g} times that in continuous time, at both joints, in both scenarios. Runs at "
        f"{len(PARTS)} periods 10 ms / m from 0.02 ms on, then bisection before the first that is not quiet, to 12 % "
        "or two neighbours. A longer period that was looked at is quiet again for: "
        f"{', '.join(again) or 'none'}. An end is within the error of the step for: {', '.join(unsure) or 'none'}. All "
        "memories step by explicit Euler. The rule of thumb is the least ",
        RULE,
        " along the runs in continuous time, of the least eigenvalue of M and the largest gain.",
    )
    caption = "The longest safe period of each law, without delay and with a torque that is a period late."
    heads = (Column(name, "ms", digits=2) for name in ("rule of thumb", "quiet", "quiet, late"))
    table = Table("safe", caption, (Column("law"), *heads), tuple(rows), ("A dash: no gain K. With exact readings.",))
    return Section("The longest safe period", (Paragraph(words), table))


def steps_figure(curves: Sequence[Curve]) -> Figure:
    panels = []
    for law in dict.fromkeys(one.law for one in curves):
        series = []
        for style, one in enumerate(curve for curve in curves if curve.law == law):
            label = f"{SWITCHING[one.switching]}, {f'computer of {MS}' if one.digital else 'continuous time'}"
            points = label, 1e3 * one.h, one.TV[:, 0], style
            series += [Series(*points), Series(*points, look="marks")]
        axes = "TV of joint 1 [N m/s]", tuple(series), "step [ms]"
        panels.append(Panel(*axes, xscale="log", yscale="log", title=law))
    caption = (
        "Total variation of the first torque over the step of Runge-Kutta, first scenario, 10 s: in continuous time a "
        "step of the loop, with the computer a step of the plant within its period."
    )
    return Figure("tv_steps", caption, tuple(panels), columns=2)


def trust_section(evidence: Evidence, steps: Figure) -> Section:
    shares = (
        f"{100 * evidence.worst_step(RMSE, T):.2g} and {100 * evidence.worst_step(TV, T):.2g} % at {1e3 * T:g} ms"
        for T in PERIODS
    )
    lost = np.array([one.lost for (_, _, computer), one in evidence.audits.items() if computer])
    words = (
        "Errors are twice the change by half the substep: over all laws, joints and scenarios, with exact readings, of "
        f"RMSE and TV at most {', '.join(shares)}. In continuous time RK4 runs at half of the steps of a1, and at a "
        "quarter for the error. A run that chatters depends on what it rounds: at 5 and 10 ms one run of an adaptive "
        f"law stands for many, of which the noisy ones show how they differ. Of {len(lost)} loops with a "
        f"computer {lost[:, 0].sum()} diverged with exact readings, "
        f"and {lost[:, 1:].sum()} of {NOISY * len(lost)} runs with noise. They are named, count as above all others "
        f"and are never averaged away. The seed of the noise is {SEED}."
    )
    return Section("How far these numbers can be trusted", (Paragraph(words), steps))
