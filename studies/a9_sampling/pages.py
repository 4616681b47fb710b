"""The pictures and tables of a9, which follow its findings."""

from collections.abc import Mapping

import numpy as np

import workbench as wb
from studies.a9_sampling.evidence import (
    APART,
    PERIODS,
    PLACES,
    ROWS,
    Evidence,
    Score,
    Scores,
    printed_pairs,
)
from studies.a9_sampling.findings import PAIR, ROUGH
from studies.a9_sampling.loops import CARD, MS, NOISY, REALISTIC, WAYS
from studies.paper.card import PROPOSED_LAW
from studies.paper.card import SCENARIOS as TITLES
from studies.paper.comparison import STYLES
from studies.paper.period_rules import BOUND, HALF, MATRIX, RULE
from studies.paper.quiet_periods import (
    ACTING_TORQUE,
    GRID,
    OBSERVERS,
    ON_REFERENCE,
    PAPERS,
    PARTS,
    QUIET,
    RMSE,
    SCENARIOS,
    STARTS,
    TRUTH,
    TV,
    QuietSearch,
    bracket_words,
    ends,
)

TABLE_STEPS = {RMSE: (1e-4, 1e-3, 5e-3, 1e-2), TV: (1e-4, 1e-3, 1e-2)}  # s, as a page is wide
UNITS = {RMSE: ("rad", 1.0), TV: ("kN m/s", 1e-3)}  # with what makes them of rad and N m/s


def over_periods(evidence: Evidence, metric: str, name: str) -> wb.document.Figure:
    """A metric of all laws over the sampling period, a panel for each scenario and joint."""
    panels, x, what = [], 1e3 * np.array(PERIODS), metric if metric == RMSE else "Total variation (TV) of the torque"
    for scenario, joint in PLACES:
        series = []
        for law, way, label in ROWS:
            y = np.array([evidence.computer_scores(metric, T, way)(law, scenario, joint)[0] for T in PERIODS])
            style, still = (
                STYLES[law] if way == "euler" else len(STYLES),
                evidence.continuous_scores(metric)(law, scenario, joint),
            )
            series.append(wb.document.Series(label, x, np.where(np.isinf(y), np.nan, y), style))
            series.append(wb.document.Series(label, x[:1], np.array(still[:1]), style, look="marks"))
        title, unit = f"{TITLES[scenario]}, joint {joint + 1}", "rad" if metric == RMSE else "N m/s"
        axes = f"{metric} [{unit}]", tuple(series), "sampling period [ms]"
        panels.append(wb.document.Panel(*axes, xscale="log", yscale="log", title=title))
    caption = (
        f"{what} against the sampling period, with exact readings and no delay. The marks at the left edge are the "
        "values in continuous time. A line ends where the run diverges."
    )
    return wb.document.Figure(name, caption, tuple(panels), columns=2)


def cell(score: Score, scale: float = 1.0) -> wb.document.Cell:
    """A value with its error in another unit, or that the run diverged."""
    return "diverged" if np.isinf(score[0]) else wb.document.ValueWithError(scale * score[0], scale * score[1])


def scores_table(metric: str, name: str, evidence: Evidence) -> wb.document.ReportTable:
    """A metric of all laws and places over the period, and at one period with delay and noise."""
    unit, scale = UNITS[metric]
    heads = ["continuous", *(f"{1e3 * T:g} ms" for T in TABLE_STEPS[metric]), *(f"{MS}, {how}" for how in ROUGH)]
    rows = []
    for scenario, joint in PLACES:
        for law, way, label in ROWS:
            over = [evidence.computer_scores(metric, T, way) for T in TABLE_STEPS[metric]]
            over += [evidence.computer_scores(metric, REALISTIC, way, *how) for how in ROUGH.values()]
            cells = (cell(of(law, scenario, joint), scale) for of in (evidence.continuous_scores(metric), *over))
            rows.append((label, f"{scenario} {joint + 1}", *cells))
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("joint"),
        *(wb.document.TableColumn(head, unit, "right") for head in heads),
    )
    return wb.document.ReportTable(
        name, f"{metric} at several sampling periods, and at {MS} with delay and noise.", columns, tuple(rows)
    )


def periods_section(evidence: Evidence) -> wb.Section:
    """Error and chattering over the period, and at one with delay and noise."""
    words = (
        "Brackets have the error, from a run with half the substep of the plant; with noise they have twice the "
        f"standard error of the mean of {NOISY} runs. If an adaptive law chatters strongly, its run is chaotic, and "
        "this error is not a bound. If the boundary layer chatters, the torque jumps by up to 2 K in each period. With "
        "a constant K, TV then falls as 1/T, and the error that chattering leaves grows as T. An adaptive K grows with "
        "that error."
    )
    tables = scores_table(RMSE, "rmse_table", evidence), scores_table(TV, "tv_table", evidence)
    return wb.Section("Over the sampling period, with delay and noise", (wb.Paragraph(words), *tables))


def computer_section() -> wb.Section:
    """The computer that is assumed."""
    words = (
        "Once in a period the computer reads q and qd, steps the memories of law and observer, and sets the torque, "
        "which it holds until the next instant. The plant moves by Runge-Kutta steps of at most 2.5 ms in between. All "
        "memories step by explicit Euler. AOSMC-RGS also runs in a second way: P takes a Cayley step of (34), the "
        "observer a Cayley step of (10), and K a step of explicit Euler. Steps are by explicit Euler unless another is "
        "named. With a delay, the torque of one instant acts from the next instant on, and the observer uses the "
        "torque that acts. In report a5 the observer uses the commanded torque; the searches for the longest quiet "
        "period have both. "
        "Laws, numbers, "
        "scenarios (FS and SS) and horizons are those of a1. AOSMC-RGS is the repaired law; its observer uses the true "
        "disturbance, which no instrument gives. The total variation (TV) counts each change of the torque, on a grid "
        "of 1 ms in continuous time. No torque is limited."
    )
    table = CARD.table("assumed", "computer", "The assumed numbers of a realistic computer.")
    return wb.Section("The computer", (wb.Paragraph(words), table))


def apart_section(evidence: Evidence) -> wb.Section:
    """AOSMC-RGS with four ways to step its memories."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for scenario, period, way in ((s, T, way) for s in SCENARIOS for T in APART for way in WAYS):
        found = evidence.audit(PROPOSED_LAW, scenario, period, way)
        scores = (cell(found.score(m, joint), UNITS[m][1]) for m in (RMSE, TV) for joint in (0, 1))
        rows.append((scenario, 1e3 * period, WAYS[way], f"{found.is_lost.sum()} of {1 + NOISY}", *scores))
    columns = (
        wb.document.TableColumn("scenario"),
        wb.document.TableColumn("period", "ms"),
        wb.document.TableColumn("memories step by"),
        wb.document.TableColumn("diverged", "", "right"),
        *(
            wb.document.TableColumn(f"{metric}, joint {j}", UNITS[metric][0], "right")
            for metric in (RMSE, TV)
            for j in (1, 2)
        ),
    )
    words = (
        "The modes of (34) are about -2 |a|, where a is an eigenvalue of A = -M^-1 K, and they become faster as K "
        "grows. Explicit Euler multiplies a mode by 1 - 2 |a| T in each period, which is below -1 where T > 1 / |a|. "
        "The Cayley step keeps P definite at every T. With 16 Runge-Kutta steps per period all memories are near the "
        "exact solution of their equations; readings, reference and torque stay constant in the period. If these finer "
        "steps keep a run finite, the integrator caused the divergence. If the run diverges in every way, the law "
        "caused it."
    )
    caption = (
        f"{PROPOSED_LAW} with four ways to step its memories and the same noise in each; values are without noise."
    )
    table = wb.document.ReportTable("integrators", caption, columns, tuple(rows))
    return wb.Section("Divergence by the integrator and by the law", (wb.Paragraph(words), table, lost_table(evidence)))


def lost_table(evidence: Evidence) -> wb.document.ReportTable:
    """The runs that diverge, by law and period."""
    runs = len(SCENARIOS) * (1 + NOISY)
    rows: list[tuple[wb.document.Cell, ...]] = [
        (label, *(sum(int(evidence.audit(law, at, T, way).is_lost.sum()) for at in SCENARIOS) for T in PERIODS))
        for law, way, label in ROWS
    ]
    columns = (
        wb.document.TableColumn("law"),
        *(wb.document.TableColumn(f"{1e3 * T:g} ms", align="right") for T in PERIODS),
    )
    caption = (
        f"Runs that diverge, of {runs} at each period: in both scenarios one run with exact readings and {NOISY} with "
        "noise."
    )
    return wb.document.ReportTable("lost", caption, columns, tuple(rows))


def places_section(evidence: Evidence) -> wb.Section:
    """The published order over the period."""
    cases: dict[str, Mapping[str, Scores]] = {
        "continuous time": {way: evidence.continuous_scores(RMSE) for way in PAIR}
    }
    cases |= {
        f"{1e3 * period:g} ms": {way: evidence.computer_scores(RMSE, period, way) for way in PAIR} for period in PERIODS
    }
    cases |= {
        f"{MS}, {n}": {w: evidence.computer_scores(RMSE, REALISTIC, w, *how) for w in PAIR} for n, how in ROUGH.items()
    }
    kinds = (f"{kind}, {way}" for way in PAIR.values() for kind in ("as printed", "opposite", "too close"))
    pairs = wb.document.ReportTable(
        "printed_pairs",
        "The 60 pairs of laws of the two published tables, by the sampled RMSE, (43), of the runs here.",
        (wb.document.TableColumn("run by"), *map(wb.document.TableColumn, kinds)),
        tuple(
            (name, *(len(p) for way in PAIR for p in printed_pairs(case[way]).values())) for name, case in cases.items()
        ),
        (
            "Euler and Cayley are the steps of AOSMC-RGS. Too close: the difference is below 2 % or below both errors. "
            "A run that diverged counts as larger than all others.",
        ),
    )
    return wb.Section("The published order over the period", (pairs,))


def safe_section(evidence: Evidence) -> wb.Section:
    """The longest quiet periods of all laws, by scenario and start, beside the two rules."""
    again = [one.search.law for one in evidence.quiet if one.largest_setting.threshold.beyond]
    unsure = [one.search.law for one in evidence.quiet if not one.largest_setting.sure]
    words = (
        f"A period is quiet if TV is at most {QUIET:g} times its value in continuous time, at both joints. The search "
        f"tries {len(PARTS)} periods from {1e3 * GRID / PARTS[0]:g} to {1e3 * GRID / PARTS[-1]:g} ms. It then tries "
        "periods between the last quiet one and the next one, until these two are 12 % apart or no other fraction of "
        f"100 ms lies between them. Laws that are quiet again at a longer period: "
        f"{', '.join(dict.fromkeys(again)) or 'none'}. Laws for which the error of the step could decide whether one "
        f"of the two periods is quiet: {', '.join(dict.fromkeys(unsure)) or 'none'}. Readings are exact, and all "
        "memories step by explicit Euler. In a start on the reference, the arm and the observer have the position and "
        "the speed of the reference. In SS the reference jumps every 2 s, so no start removes all errors from which K "
        f"grows{gain_of_start(evidence)}."
    )
    rules = (
        "Within the layer, at a period T, s of a mode is 1 - T ρ / φ times its value at the previous instant, where ρ "
        "is an eigenvalue of ",
        MATRIX,
        ". So the mode grows if T is longer than ",
        RULE,
        ", and with a torque one period late if T is longer than ",
        HALF,
        ". The table has the least of these periods along the run in continuous time. It also has the least ",
        BOUND,
        ". This is only a bound, as the eigenvalue and the gain in it may belong to different directions.",
    )
    return wb.Section("The longest quiet period", (wb.Paragraph(words), wb.Paragraph(rules), quiet_table(evidence)))


def gain_of_start(evidence: Evidence) -> str:
    """The longest quiet period of AOSMC-RGS in SS from a start on the reference over that from the paper's start."""
    near, far = (
        next(one for one in evidence.quiet if one.search == QuietSearch(PROPOSED_LAW, "SS", start))
        for start in (ON_REFERENCE, PAPERS)
    )
    times = ends(near)[0] / ends(far)[0]
    return f"; from a start on the reference {PROPOSED_LAW} is still quiet up to a period {times:.1f} times as long"


def quiet_table(evidence: Evidence) -> wb.document.ReportTable:
    """The two ends of each search beside the rules."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for one in evidence.quiet:
        search = one.search
        label = search.law if search.observer == TRUTH else f"{search.law}, {OBSERVERS[search.observer]}"
        torque = (
            "at once"
            if not search.delay
            else "late, commanded torque used"
            if search.counts_on != ACTING_TORQUE
            else "late"
        )
        rule, bound = (None if value is None else 1e3 * value for value in (one.rule, one.bound))
        K = None if one.rules is None else one.rules.K
        rows.append((label, search.scenario, STARTS[search.start], torque, K, bound, rule, bracket_words(ends(one))))
    columns = (
        *map(wb.document.TableColumn, ("law", "scenario", "start", "torque")),
        wb.document.TableColumn("largest K", "N m", digits=2),
        *(wb.document.TableColumn(name, "ms", digits=3) for name in ("bound", "rule")),
        wb.document.TableColumn("quiet up to, not at", "ms"),
    )
    caption = "The longest quiet period of each law, the next period tried, the rule and the bound."
    notes = (
        "Late: by one period, and the observer uses the torque that acts. Commanded torque used: the observer uses the "
        "commanded torque. A dash: no gain K.",
    )
    return wb.document.ReportTable("quiet", caption, columns, tuple(rows), notes)
