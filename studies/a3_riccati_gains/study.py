"""The Riccati part of AOSMC-RGS: P(t) of (34) beside what it could be exchanged for, and what it does to the loop.

Runs in about one and a half minutes on two cores.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

import workbench as wb
from studies.a3_riccati_gains import findings, path
from studies.a3_riccati_gains.path import TRANSIENT, WINDOW, RiccatiComparison
from studies.a3_riccati_gains.settings import (
    ALGEBRAIC,
    ASMC_WITH_OBSERVER,
    ASSUMED_WEIGHTS,
    AT_START,
    FORWARD,
    FROZEN,
    MEAN,
    NONE,
    PLACES,
    SETTINGS,
    TABLE_METRICS,
    WEIGHTS,
    scenario_of,
)
from studies.paper.card import BOLD, CARD, MARGIN, SCENARIOS
from studies.paper.citation import introduction
from studies.paper.comparison import METRICS, STEPS
from studies.paper.laws import RIVALS, proposed_repaired, repaired_observer, rival

MARK_COUNT = 14  # of the algebraic solution over the window, so that it is seen under another line


def choices_of(weights: str, mean: wb.Array) -> dict[str, dict[str, Any]]:
    """The fields of the repaired law by the choice of P; (33) with P = 0 leaves the gain at K(0)."""
    Q, R = (weight * np.eye(2) for weight in WEIGHTS[weights])
    of_all: dict[str, dict[str, Any]] = {
        FORWARD: {"Q": Q, "R": R},
        ALGEBRAIC: {"Q": Q, "R": R, "riccati": "algebraic", "P": None},
        MEAN: FROZEN | {"P": mean},
    }
    if weights != ASSUMED_WEIGHTS:  # P(0) and K(0) without (34) are the same for all weights
        return of_all
    return {
        FORWARD: {},
        ALGEBRAIC: {"riccati": "algebraic", "P": None},
        MEAN: FROZEN | {"P": mean},
        AT_START: FROZEN,
        NONE: FROZEN | {"P": np.zeros((2, 2))},
    }


def cases(scenario: str, means: Mapping[str, wb.Array]) -> Iterator[wb.Case]:
    """All loops of a scenario, on its horizon, with the mean of P by the name of the weights."""
    ours, until = proposed_repaired(scenario), CARD[f"{scenario}: horizon"]
    for weights, mean in means.items():
        for style, (name, fields) in enumerate(choices_of(weights, mean).items()):
            loop = replace(ours, controller=replace(ours.controller, **fields))
            named, run = scenario_of(scenario, weights), wb.Run(loop, METRICS[scenario], until, path.EVERY, path.STEP)
            yield wb.Case(named, name, run, style=style)
    observed = wb.ClosedLoop(ours.plant, repaired_observer(), RIVALS["ASMC"], ours.reference)
    for style, (name, loop) in enumerate({ASMC_WITH_OBSERVER: observed, "ASMC": rival(scenario, "ASMC")}.items(), 5):
        yield wb.Case(scenario, name, wb.Run(loop, METRICS[scenario], until, 0.01, STEPS["ASMC"] / 2), style=style)


def all_cases(work_answers: Mapping[str, Any]) -> tuple[wb.Case, ...]:
    """The loops of both scenarios."""
    answers = dict(zip(SETTINGS, work_answers["riccati"], strict=True))
    means = {s: {name: answers[s, name].mean for name in WEIGHTS} for s in SCENARIOS}
    return tuple(case for s in SCENARIOS for case in cases(s, means[s]))


def figure(one: RiccatiComparison, scenario: str) -> wb.document.Figure:
    """Diagonal entries of P over time, and the distance of (34) from the algebraic solution, which has marks, too."""
    lines = {"(34)": one.P, "algebraic": one.X, "backward": one.backward.P}
    some = np.searchsorted(one.t, np.linspace(0, one.t[-1], MARK_COUNT))
    entries = []
    for i in (0, 1):
        curves = [wb.document.Series(label, one.t, P[:, i, i], style) for style, (label, P) in enumerate(lines.items())]
        marks = wb.document.Series(
            "algebraic", one.t[some], one.X[some, i, i], list(lines).index("algebraic"), look="marks"
        )
        entries.append(wb.document.Panel((wb.notation.symbol(f"P_{i + 1}{i + 1}"), " [N m/rad]"), (*curves, marks)))
    gap = np.maximum(path.distance(one.P, one.X), 1e-16)
    far = wb.document.Panel("relative distance", (wb.document.Series("(34)", one.t, gap, 0),), yscale="log")
    caption = (
        f"P(t), {SCENARIOS[scenario]}: its diagonal, and the distance of (34) from the algebraic solution. The line of "
        f"(34) covers the algebraic solution, which therefore has marks: from {1e3 * TRANSIENT:g} ms on the two differ "
        f"by at most {findings.share(one.gap(one.X)[1])}."
    )
    return wb.document.Figure(f"{scenario.lower()}_p", caption, (*entries, far), columns=3)


def choices(one: RiccatiComparison, scenario: str) -> wb.document.ReportTable:
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
        f"P(t) of (34) and other choices of P over the first {WINDOW:g} s, {SCENARIOS[scenario]}: the distance of P(t) "
        "from each choice, and the ratio of J of (32) with each choice to the least J*, from the worst start. J is for "
        "(31) with u = -R^-1 B' P s."
    )
    note = (
        "Distance: the Frobenius norm of the difference, divided by the norm of the other choice, from "
        f"{TRANSIENT:g} s on, at {len(one.t)} instants; the median is over time. The residual of the algebraic "
        f"equation is at most {one.residual:.0e}. The error of the backward solution is at most "
        f"{one.backward.error.max():.0e} and of the forward solution {one.forward.error.max():.0e}, for a tolerance of "
        f"{path.RTOL:.0e}."
    )
    columns = (wb.document.TableColumn("P"), *(wb.document.TableColumn(head, align="right") for head in heads))
    return wb.document.ReportTable(f"{scenario.lower()}_cost", caption, columns, tuple(rows), (note,))


def loops(results: wb.Results) -> wb.Section:
    """The closed loops side by side."""
    about = wb.Paragraph(
        f"All rows but the last two have the same law and the same observer. In '{ALGEBRAIC}' P solves (34) with "
        f"P' = 0. In '{MEAN}' P is constant, with the mean that (34) gives over the run; in '{AT_START}' P stays at "
        f"{CARD['P(0)'][0, 0]:g} N m/rad. In '{NONE}' K stays at {CARD['K(0)'][0, 0]:g} N m. ASMC in the last row has "
        f"exact q and qd. {BOLD}"
    )
    tables = []
    for s, j in PLACES:
        name, caption = f"{s.lower()}_loops_q{j + 1}", f"Metrics of joint {j + 1}, {SCENARIOS[s]}."
        tables.append(wb.side_by_side(name, caption, results.scenario(s), TABLE_METRICS, j, margin=MARGIN))
    return wb.Section("The loops side by side", (about, *tables))


def sections(results: wb.Results) -> wb.Page:
    """The answer and the findings, P(t) over time, then the tables behind them."""
    answers = dict(zip(SETTINGS, results.work("riccati"), strict=True))
    paths = {scenario: answers[scenario, ASSUMED_WEIGHTS].comparison for scenario in SCENARIOS}
    figures = (figure(one, scenario) for scenario, one in paths.items())
    tables = (choices(one, scenario) for scenario, one in paths.items())
    held = findings.Evidence(results, answers)
    return wb.Page(
        findings.answer(held),
        findings.findings(held),
        (
            wb.Section("P(t) over time", tuple(figures)),
            wb.Section("P frozen at two values", (findings.frozen_table(held),)),
            wb.Section("P(t) and other choices of P", tuple(tables)),
            loops(results),
        ),
    )


study = wb.Study(
    name="a3_riccati_gains",
    title="AOSMC-RGS: what the Riccati part does",
    question=(
        "P(t) of (34) sets the rate at which the gain of the proposed law learns. Does the loop track better with P(t) "
        "than with a constant P? How far is P(t) from the solutions of the algebraic and of the backward equation?"
    ),
    method=(
        f"{introduction(31, 32, 33, 34, 43)} The repaired law runs in both scenarios, with three pairs of Q and R. "
        "Along each run, A = -M^-1 K and B = Lambda of (31) are functions of time. Each Riccati equation is solved "
        "along the run with its certificate; J of (32) follows from a linear equation. Then the loop runs with P from "
        "the algebraic equation, with P frozen at its mean, with P frozen at P(0), without adaptation, and with plain "
        "ASMC."
    ),
    cases=all_cases,
    works=(wb.Work("riccati", path.along, tuple(SETTINGS.values()), seconds=8.0),),
    sections=sections,
)
