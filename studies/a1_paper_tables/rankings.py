"""The order of the six laws: the paper's comparisons held against it, and its debt to the assumed gain of SMC."""

from dataclasses import replace

import numpy as np

from studies.paper.card import CARD, LAWS, PUBLISHED
from studies.paper.comparison import MARGIN, PROPOSED, SCENARIOS, six
from studies.paper.laws import rival
from workbench.loop import ClosedLoop
from workbench.study.document.document import Cell, Column, Itemize, Measured, Paragraph, Section, Table
from workbench.study.evidence.law_tables import order, ranking
from workbench.study.study import Outcome, Results

FIRM = {20.0: 1e-4, 50.0: 5e-5}  # gains of SMC in N m, the last at the upper end of the card's range; steps in s
PLACES = [(scenario, joint) for scenario in SCENARIOS for joint in (0, 1)]
CLAIMS = {
    "superior tracking": "RMSE (43)",
    "lower steady-state error": "late error",
    "smaller control amplitudes": "peak torque",
    "lower control effort": "effort",
    "reduced chattering": "TV",
    "reduced overshoot": "overshoot",
    "faster settling": "settling time",
}


def firm(scenario: str, K: float) -> ClosedLoop:
    """SMC with another gain than the assumed one."""
    loop = rival(scenario, "SMC")
    return replace(loop, controller=replace(loop.controller, K=np.full(2, K)))


def smc(results: Results, scenario: str, K: float | None) -> Outcome:
    """SMC with one of the `FIRM` gains, or with the assumed one."""
    return results[scenario, "SMC"] if K is None else results[f"{scenario}, SMC", f"K = {K:g} N m"]


def tally(results: Results, K: float | None = None) -> tuple[int, int, int]:
    """Of the printed pairs those that keep their order, are turned round, and are too close, with a gain of SMC."""
    laws = {scenario: six(results, scenario) | {"SMC": smc(results, scenario, K)} for scenario in SCENARIOS}
    rows = [ranking(column, laws[scenario], MARGIN) for (scenario, _), column in PUBLISHED.items()]
    return sum(len(r.holds) for r in rows), sum(len(r.fails) for r in rows), sum(len(r.undecided) for r in rows)


def reaching_time(outcome: Outcome) -> float:
    """The time by which each |s_i| has been below phi, in s; infinite where one never is."""
    inside = np.abs(outcome.measurement.trajectories["s"][0]) < CARD["phi"]
    return float(max(outcome.t[np.argmax(joint)] if joint.any() else np.inf for joint in inside.T))


def network_gap(results: Results, scenario: str) -> float:
    """The largest difference of RMSE (43) between RBF-ASMC and ASMC, relative to ASMC, of both joints."""
    pairs = [[results[scenario, law].score("RMSE (43)", j)[0] for law in ("RBF-ASMC", "ASMC")] for j in (0, 1)]
    return max(abs(ours / theirs - 1) for ours, theirs in pairs)


def stands(results: Results, metric: str, scenario: str, joint: int) -> list[str]:
    """The proposed law is below, above or undecided beside each rival; nothing where the metric does not exist."""
    ours = results[scenario, PROPOSED]
    if metric not in ours.measurement.scores:
        return []
    others = (results[scenario, law].score(metric, joint) for law in LAWS if law != PROPOSED)
    return [order(ours.score(metric, joint), other, MARGIN) for other in others]


def claims(results: Results) -> Table:
    """The paper's comparisons, each by its metric."""
    rows: list[tuple[Cell, ...]] = []
    for words, metric in CLAIMS.items():
        judged = [stands(results, metric, *where) for where in PLACES]
        first = [1 + one.count("above") for one in judged]
        last = [rank + one.count("undecided") for rank, one in zip(first, judged, strict=True)]
        ranks = (f"{a}" if a == b else f"{a}-{b}" for a, b in zip(first, last, strict=True))
        counts = [sum(one.count(side) for one in judged) for side in ("below", "above", "undecided")]
        verdict = "fails" if counts[1] else "open" if counts[2] else "holds"
        shown = (rank if one else None for rank, one in zip(ranks, judged, strict=True))
        rows.append((words, metric, *shown, " / ".join(map(str, counts)), verdict))
    columns = (
        Column("the proposed law has"),
        Column("metric"),
        *(Column(f"{scenario}, joint {joint + 1}", align="center") for scenario, joint in PLACES),
        Column("smaller / larger / open", align="center"),
        Column("the claim"),
    )
    caption = "Rank of the proposed law among the six by each metric: 1 is the smallest value."
    return Table("claims", caption, columns, tuple(rows), ("2-3: a rival is too close to call.",))


def gains(results: Results) -> Table:
    """The ranks with other gains of SMC."""
    rows: list[tuple[Cell, ...]] = []
    for K in (None, *FIRM):
        runs = {scenario: smc(results, scenario, K) for scenario in SCENARIOS}
        rows.append(
            (
                f"{CARD['SMC: K'][0]:g}, assumed" if K is None else f"{K:g}",
                *(Measured(*runs[scenario].score("RMSE (43)", joint)) for scenario, joint in PLACES),
                *(f"{reaching_time(run):.2f}" for run in runs.values()),
                " / ".join(map(str, tally(results, K))),
            )
        )
    columns = (
        Column("K of SMC, N m"),
        *(Column(f"RMSE, {scenario}, q{joint + 1}", "rad", "right") for scenario, joint in PLACES),
        *(Column(f"layer reached, {scenario}", "s", "right") for scenario in SCENARIOS),
        Column("pairs", align="right"),
    )
    caption = "The published ranks with other gains of SMC than the assumed one, all else as before."
    note = (
        "Layer reached: each |s_i| has been below phi. Pairs: of the "
        "printed pairs those that keep their order / are turned round / are too close to call."
    )
    return Table("gains_of_smc", caption, columns, tuple(rows), (note,))


def claims_section(results: Results) -> Section:
    """The paper's words held against the six laws here, and what the ranks owe to assumed gains."""
    about = (
        "A claim holds if the proposed law (repaired) is below each of the five rivals, at both joints, in each "
        f"scenario where the metric exists, by more than {100 * MARGIN:g} % and the errors of the step. Each "
        "comparison is of two runs without noise, under the assumed numbers of the rivals: others can reverse it."
    )
    sentences = tuple(
        ranking(column, six(results, scenario), MARGIN).sentence(PROPOSED)
        for (scenario, _), column in PUBLISHED.items()
    )
    blocks = (Paragraph(about), claims(results), gains(results), Itemize(sentences))
    return Section("Which of the paper's comparisons hold here", blocks)
