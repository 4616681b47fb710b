"""The Riccati part of AOSMC-RGS: P(t) of (34) beside what it could be exchanged for, and what it does to the loop.

Runs in about half a minute on two cores.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from studies.a1_paper_tables.study import METRICS, PROPOSED_STEP, STEPS
from studies.a3_riccati_gains.path import RTOL, SETTLED, WINDOW, Compared, compared, distance, median_in_time, rise
from studies.paper.card import CARD
from studies.paper.comparison import BOLD, MARGIN, SCENARIOS
from studies.paper.laws import RIVALS, proposed_repaired, repaired_observer, rival
from workbench.loop import ClosedLoop
from workbench.notation.formula import symbol
from workbench.study.contract import Run
from workbench.study.document.document import Cell, Column, Figure, Panel, Paragraph, Section, Series, Table, Verdict
from workbench.study.document.phrases import raised
from workbench.study.evidence.law_tables import order, side_by_side
from workbench.study.study import Case, Results, Study

FORWARD, ALGEBRAIC, AT_START, NONE = "(34)", "algebraic", "P = P(0)", "no adaptation"
CHOICES: dict[str, dict[str, Any]] = {  # the fields of the repaired law; (33) with P = 0 leaves the gain at K(0)
    FORWARD: {},
    ALGEBRAIC: {"riccati": "algebraic", "P": None},
    AT_START: {"riccati": "frozen", "Q": None, "R": None},
    NONE: {"riccati": "frozen", "Q": None, "R": None, "P": np.zeros((2, 2))},
}
EVERY = 1e-3 / 12 * 30  # s: the path of P is a spline through the kept states
SHOWN = ("RMSE (43)", "RMSE", "IAE", "peak error", "effort", "peak torque", "TV")
PLACES = [(scenario, joint) for scenario in SCENARIOS for joint in (0, 1)]
OURS = "P(t) of (34)"


def cases(scenario: str) -> tuple[Case, ...]:
    """All loops of a scenario, on its horizon."""
    ours = proposed_repaired(scenario)
    fine = PROPOSED_STEP / 4  # P left at P(0) lets K grow by half as much again
    runs = {
        variant: (replace(ours, controller=replace(ours.controller, **fields)), EVERY, fine)
        for variant, fields in CHOICES.items()
    }
    observed = ClosedLoop(ours.plant, repaired_observer(), RIVALS["ASMC"], ours.reference)
    runs["ASMC, same observer"] = observed, 0.01, STEPS["ASMC"] / 2
    runs["ASMC"] = rival(scenario, "ASMC"), 0.01, STEPS["ASMC"] / 2
    return tuple(
        Case(scenario, name, Run(loop, METRICS[scenario], CARD[f"{scenario}: horizon"], every, h), style=style)
        for style, (name, (loop, every, h)) in enumerate(runs.items())
    )


def changes(results: Results, variant: str, metric: str) -> list[float]:
    """The change of a metric against the law with (34), in %, at either joint in either scenario."""
    pairs = [[results[s, law].score(metric, j)[0] for law in (variant, FORWARD)] for s, j in PLACES]
    return [100 * (other / ours - 1) for other, ours in pairs]


def of_the_equations(paths: Sequence[Compared]) -> tuple[Verdict, ...]:
    """(34) beside the equations it could be exchanged for."""
    first, second = paths
    costs = [100 * (path.ratios[OURS] - 1) for path in paths]
    sample = f"along one run a scenario until {WINDOW:g} s ({' and '.join(SCENARIOS.values())})"
    numbers = "The assumed Q and R, which the paper does not state; K and the estimate of q along the run."
    return (
        Verdict(
            "found",
            f"P(t) of (34) is at most {100 * first.largest:.2g} % and {100 * second.largest:.2g} % from the algebraic "
            f"solution X from {1e3 * SETTLED:g} ms on, in the median over time {100 * first.median:.2g} % and "
            f"{100 * second.median:.2g} %.",
            f"Differences of two solutions of (34) fall to 1/e in at most {1e3 * first.memory:.3g} and "
            f"{1e3 * second.memory:.3g} ms, while K takes {rise(first.K, first.t):.3g} and "
            f"{rise(second.K, second.t):.3g} s for 63 % of its way.",
            estimand=f"|P - X| / |X|, Frobenius norms, {sample}.",
            given=numbers,
            reversal="A smaller Q or a larger R, which slow (34) down; no other pair was tried here.",
        ),
        Verdict(
            "found",
            raised(f"As a feedback u = -R^-1 B' P(t) s of (31), P(t) of (34) costs {costs[0]:.2g} % and ")
            + f"{costs[1]:.2g} % more than the least J of (32).",
            f"u = 0 costs {first.ratios['P = 0']:.3g} and {second.ratios['P = 0']:.3g} times the least. This is about "
            "(31) and (32) alone: the law applies no such u, and uses P in (33), as a rate of learning.",
            estimand=f"J of (32) over the first {WINDOW:g} s, from the worst s(0), over the least; A {sample}.",
            given=numbers,
            reversal="A smaller Q or a larger R, which slow (34) down, or another horizon of J.",
        ),
    )


def of_the_loop(results: Results) -> tuple[Verdict, ...]:
    """The loop with (34) beside the other loops."""
    same = max(abs(c) for name in ("RMSE (43)", "IAE", "effort") for c in changes(results, ALGEBRAIC, name))
    fs1, fs2, ss1, ss2 = changes(results, AT_START, "RMSE (43)")
    effort = changes(results, AT_START, "effort")
    pairs = [[results[s, law].score("RMSE (43)", j) for law in (FORWARD, AT_START)] for s, j in PLACES]
    constant = [order(ours, other, MARGIN) for ours, other in pairs]
    sample = "at two joints in two scenarios, one run each without noise, the whole horizon."
    observer = "Both loops: positions, one observer, the true disturbance, the exact model."
    return (
        Verdict(
            "found",
            "With the algebraic equation at each instant in place of (34), RMSE (43), IAE and effort change by at most "
            f"{same:.2g} %.",
            estimand=f"Three metrics {sample}",
            given=observer,
            reversal="A smaller Q or a larger R, with which (34) lags behind X.",
        ),
        Verdict(
            "found",
            f"With P left at P(0) in place of (34), RMSE (43) of joints 1 and 2 changes by {fs1:+.2g} and {fs2:+.2g} % "
            f"in the first scenario and by {ss1:+.2g} and {ss2:+.2g} % in the second scenario, and the effort by "
            f"{min(effort):+.2g} to {max(effort):+.2g} % over the four.",
            f"Beyond {100 * MARGIN:g} % RMSE (43) is the smaller with P(0) in {constant.count('above')} of "
            f"{len(PLACES)} comparisons, and the larger in {constant.count('below')}. Two rates of learning are "
            "compared: (33) learns with P.",
            estimand=f"RMSE (43) and effort {sample}",
            given=observer,
            reversal="Another Q, R or P(0): of these the paper states P(0) alone.",
        ),
    )


def figure(path: Compared, scenario: str) -> Figure:
    """Diagonal entries of P over time, and the distance of (34) from the algebraic solution."""
    lines = {"(34)": path.P, "algebraic": path.X, "backward": path.backward.P}
    entries = tuple(
        Panel(
            (symbol(f"P_{i + 1}{i + 1}"), " [N m/rad]"),
            tuple(Series(label, path.t, P[:, i, i], style) for style, (label, P) in enumerate(lines.items())),
        )
        for i in (0, 1)
    )
    gap = np.maximum(distance(path.P, path.X), 1e-16)
    far = Panel("relative distance", (Series("(34)", path.t, gap, 0),), yscale="log")
    caption = f"P(t), {SCENARIOS[scenario]}: its diagonal, and the distance of (34) from the algebraic solution."
    return Figure(f"{scenario.lower()}_p", caption, (*entries, far), columns=3)


def costs(path: Compared, scenario: str) -> Table:
    """J of (32) with each P."""
    return Table(
        f"{scenario.lower()}_cost",
        f"J of (32) for (31) along the run with u = -R^-1 B' P s, over the least J, from the worst start, "
        f"{SCENARIOS[scenario]}.",
        (Column("P"), Column("J / J*", align="right")),
        tuple((name, f"{ratio:.4f}") for name, ratio in path.ratios.items()),
    )


def distances(path: Compared, scenario: str) -> Table:
    """The distance of P of (34) from each other choice."""
    rows: list[tuple[Cell, ...]] = []
    rivals = {
        "SDRE: the CARE at each instant": path.X,
        "backward, from 0 at the end": path.backward.P,
        "P = P(0)": np.broadcast_to(path.P[0], path.P.shape),
        "(34), solved again": path.forward.P,
    }
    for name, P in rivals.items():
        end = len(P) - (P is path.backward.P)  # where it is zero, a distance relative to it has no meaning
        gaps, t = distance(path.P[:end], P[:end]), path.t[:end]
        late = t >= SETTLED
        numbers = gaps[0], median_in_time(gaps[late], t[late]), gaps[late].max()
        rows.append((name, f"{np.linalg.eigvalsh(P[:end])[:, 0].min():.3g}", *(f"{value:.2g}" for value in numbers)))
    columns = (
        Column("P by"),
        Column("least eigenvalue", "N m/rad", "right"),
        *(Column(words, align="right") for words in ("at t = 0", "median after", "largest after")),
    )
    return Table(
        f"{scenario.lower()}_distance",
        f"Distance of P(t) of (34) from other choices over the first {WINDOW:g} s, {SCENARIOS[scenario]}; 'after' is "
        f"from {SETTLED:g} s on.",
        columns,
        tuple(rows),
        (
            f"Frobenius norm of the difference over that of the other choice, at {len(path.t)} instants; the median is "
            f"over time. Residual of the algebraic equation at most {path.residual:.0e}; error of the backward and of "
            f"the forward solution at most {path.backward.error.max():.0e} and {path.forward.error.max():.0e}, asked "
            f"for {RTOL:.0e}.",
        ),
    )


def loops(results: Results) -> Section:
    """The closed loops side by side."""
    about = Paragraph(
        f"The first four rows are one law on one observer; in '{ALGEBRAIC}' P solves (34) with P' = 0, in '{AT_START}' "
        f"(34) is switched off, in '{NONE}' (33) as well, so that K stays {CARD['K(0)'][0, 0]:g} N m. ASMC in the last "
        f"row knows q and qd exactly. {BOLD}"
    )
    tables = (
        side_by_side(
            f"{s.lower()}_loops_q{j + 1}",
            f"Metrics of joint {j + 1}, {SCENARIOS[s]}.",
            results.scenario(s),
            SHOWN,
            j,
            margin=MARGIN,
        )
        for s, j in PLACES
    )
    return Section("The loops side by side", (about, *tables))


def sections(results: Results) -> Sequence[Section]:
    """The findings with P(t) over time, then the tables behind them."""
    paths = {scenario: compared(results[scenario, FORWARD]) for scenario in SCENARIOS}
    figures = (figure(path, scenario) for scenario, path in paths.items())
    tables = (table(path, scenario) for scenario, path in paths.items() for table in (distances, costs))
    return (
        Section("Findings", (*figures, *of_the_equations(tuple(paths.values())), *of_the_loop(results))),
        Section("P(t) beside other choices", tuple(tables)),
        loops(results),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    paths = {title: compared(results[scenario, FORWARD]) for scenario, title in SCENARIOS.items()}
    return tuple(
        f"{title}: P(t) of (34) is at most {path.largest:.1%} from the algebraic solution, in the median over time "
        f"{path.median:.2%}, and costs {path.ratios[OURS] - 1:.2%} more than the least J."
        for title, path in paths.items()
    )


study = Study(
    name="a3_riccati_gains",
    title="AOSMC-RGS: what the Riccati part does",
    question=(
        "P(t) of (34) sets the rate at which the gain of the proposed law learns. How far is it from what the "
        "algebraic, the backward and the constant choice would give, what does that cost in (32), and does the loop "
        "track better with it than without?"
    ),
    method=(
        "The repaired law in both scenarios. Along each run A = -M^-1 K, B = Lambda of (31) are a path in time, on "
        "which each equation is solved with its certificate, and J of (32) by a linear equation. Then the loop with "
        "P solved for at each instant, left at P(0), without any adaptation, and with plain ASMC."
    ),
    cases=(*cases("FS"), *cases("SS")),
    sections=sections,
    headlines=headlines,
)
