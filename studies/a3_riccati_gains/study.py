"""The Riccati part of AOSMC-RGS: P(t) of (34) beside what it could be exchanged for, and what it does to the loop.

Runs in about half a minute on two cores.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from studies.a1_paper_tables.study import METRICS, PROPOSED_STEP, STEPS
from studies.a3_riccati_gains import path
from studies.a3_riccati_gains.path import SETTLED, WINDOW, Compared, compared, motion
from studies.paper.card import BOLD, CARD, MARGIN, SCENARIOS
from studies.paper.laws import RIVALS, proposed_repaired, repaired_observer, rival
from workbench.loop import ClosedLoop
from workbench.notation.formula import symbol
from workbench.study.contract import Run
from workbench.study.document.document import Figure, Panel, Paragraph, Section, Series, Verdict
from workbench.study.document.phrases import Column, Table, raised
from workbench.study.evidence.law_tables import order, side_by_side
from workbench.study.study import Case, Results, Study
from workbench.study.work import Work

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


def cases(scenario: str) -> Iterator[Case]:
    """All loops of a scenario, on its horizon."""
    ours = proposed_repaired(scenario)
    runs = {
        variant: (replace(ours, controller=replace(ours.controller, **fields)), EVERY, PROPOSED_STEP / 4)
        for variant, fields in CHOICES.items()  # P left at P(0) lets K grow by half as much again
    }
    observed = ClosedLoop(ours.plant, repaired_observer(), RIVALS["ASMC"], ours.reference)
    runs["ASMC, same observer"] = observed, 0.01, STEPS["ASMC"] / 2
    runs["ASMC"] = rival(scenario, "ASMC"), 0.01, STEPS["ASMC"] / 2
    for style, (name, (loop, every, h)) in enumerate(runs.items()):
        yield Case(scenario, name, Run(loop, METRICS[scenario], CARD[f"{scenario}: horizon"], every, h), style=style)


def works(results: Results) -> tuple[Work, ...]:
    """P of (34) beside its rivals, along the run of each scenario."""
    runs = tuple(motion(results[scenario, FORWARD]) for scenario in SCENARIOS)
    return (Work("riccati", compared, runs, seconds=3.0),)


def changes(results: Results, variant: str, metric: str) -> list[float]:
    """The change of a metric against the law with (34), in %, at either joint in either scenario."""
    pairs = [[results[s, law].score(metric, j).pair[0] for law in (variant, FORWARD)] for s, j in PLACES]
    return [100 * (other / ours - 1) for other, ours in pairs]


def of_the_equations(results: Results) -> tuple[Verdict, ...]:
    """(34) beside the equations it could be exchanged for."""
    paths: Sequence[Compared] = results.work("riccati")
    medians, largest = np.transpose([100 * np.array(one.gap(one.X)) for one in paths])
    memories, rises = [1e3 * one.memory for one in paths], [path.rise(one.K, one.t) for one in paths]
    costs = [100 * (one.ratios[path.FORWARD] - 1) for one in paths]
    without = [one.ratios["P = 0"] for one in paths]
    sample = f"along one run a scenario until {WINDOW:g} s ({' and '.join(SCENARIOS.values())})"
    numbers = "The assumed Q and R, which the paper does not state; K and the estimate of q along the run."
    return (
        Verdict(
            "found",
            f"P(t) of (34) is at most {largest[0]:.2g} % and {largest[1]:.2g} % from the algebraic solution X from "
            f"{1e3 * SETTLED:g} ms on, in the median over time {medians[0]:.2g} % and {medians[1]:.2g} %.",
            f"Differences of two solutions of (34) fall to 1/e in at most {memories[0]:.3g} and {memories[1]:.3g} ms, "
            f"while K takes {rises[0]:.3g} and {rises[1]:.3g} s for 63 % of its way.",
            estimand=f"|P - X| / |X|, Frobenius norms, {sample}.",
            given=numbers,
            reversal="A smaller Q or a larger R, which slow (34) down; no other pair was tried here.",
        ),
        Verdict(
            "found",
            raised(f"As a feedback u = -R^-1 B' P(t) s of (31), P(t) of (34) costs {costs[0]:.2g} % and ")
            + f"{costs[1]:.2g} % more than the least J of (32).",
            f"u = 0 costs {without[0]:.3g} and {without[1]:.3g} times the least. The law applies no such u: it uses P "
            "in (33), as a rate of learning.",
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
    pairs = [[results[s, law].score("RMSE (43)", j).pair for law in (FORWARD, AT_START)] for s, j in PLACES]
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


def findings(results: Results) -> tuple[Verdict, ...]:
    """The verdicts on the equations, then on the loop."""
    return (*of_the_equations(results), *of_the_loop(results))


def figure(one: Compared, scenario: str) -> Figure:
    """Diagonal entries of P over time, and the distance of (34) from the algebraic solution."""
    lines = {"(34)": one.P, "algebraic": one.X, "backward": one.backward.P}
    entries = tuple(
        Panel(
            (symbol(f"P_{i + 1}{i + 1}"), " [N m/rad]"),
            tuple(Series(label, one.t, P[:, i, i], style) for style, (label, P) in enumerate(lines.items())),
        )
        for i in (0, 1)
    )
    gap = np.maximum(path.distance(one.P, one.X), 1e-16)
    far = Panel("relative distance", (Series("(34)", one.t, gap, 0),), yscale="log")
    caption = f"P(t), {SCENARIOS[scenario]}: its diagonal, and the distance of (34) from the algebraic solution."
    return Figure(f"{scenario.lower()}_p", caption, (*entries, far), columns=3)


def choices(one: Compared, scenario: str) -> Table:
    """The distance of P of (34) from each other choice, and J of (32) with each."""
    others = {
        path.SDRE: one.X,
        "backward, from 0 at the end": one.backward.P,
        path.AT_START: np.broadcast_to(one.P[0], one.P.shape),
        "(34), solved again": one.forward.P,
    }
    rows = []
    for name in dict.fromkeys((path.FORWARD, *others, *one.ratios)):
        gaps = (f"{value:.2g}" for value in one.gap(others[name])) if name in others else (None, None)
        rows.append((name, *gaps, f"{one.ratios[name]:.4f}" if name in one.ratios else None))
    heads = "median distance", "largest distance", "J / J*"
    caption = (
        f"P(t) of (34) beside other choices over the first {WINDOW:g} s, {SCENARIOS[scenario]}: its distance from "
        "each, and J of (32) with each for (31), u = -R^-1 B' P s, over the least J, from the worst start."
    )
    note = (
        f"Distance: Frobenius norm of the difference over that of the other choice, from {SETTLED:g} s on, at "
        f"{len(one.t)} instants; the median is over time. Residual of the algebraic equation at most "
        f"{one.residual:.0e}; error of the backward and of the forward solution at most "
        f"{one.backward.error.max():.0e} and {one.forward.error.max():.0e}, asked for {path.RTOL:.0e}."
    )
    columns = (Column("P"), *(Column(head, align="right") for head in heads))
    return Table(f"{scenario.lower()}_cost", caption, columns, tuple(rows), (note,))


def loops(results: Results) -> Section:
    """The closed loops side by side."""
    about = Paragraph(
        f"The first four rows are one law on one observer; in '{ALGEBRAIC}' P solves (34) with P' = 0, in '{NONE}' K "
        f"stays {CARD['K(0)'][0, 0]:g} N m. ASMC in the last row knows q and qd exactly. {BOLD}"
    )
    tables = []
    for s, j in PLACES:
        name, caption = f"{s.lower()}_loops_q{j + 1}", f"Metrics of joint {j + 1}, {SCENARIOS[s]}."
        tables.append(side_by_side(name, caption, results.scenario(s), SHOWN, j, margin=MARGIN))
    return Section("The loops side by side", (about, *tables))


def sections(results: Results) -> Sequence[Section]:
    """The findings with P(t) over time, then the tables behind them."""
    paths = dict(zip(SCENARIOS, results.work("riccati"), strict=True))
    figures = (figure(one, scenario) for scenario, one in paths.items())
    tables = (choices(one, scenario) for scenario, one in paths.items())
    return (
        Section("Findings", (*figures, *findings(results))),
        Section("P(t) beside other choices", tuple(tables)),
        loops(results),
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
    works=works,
    sections=sections,
)
