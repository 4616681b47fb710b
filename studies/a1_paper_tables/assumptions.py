"""How much of a1 rests on numbers that the paper does not state: Q of the printed law, and the rivals' gains."""

from dataclasses import replace

import numpy as np

from studies.a1_paper_tables.printed import gain_floor, loses_positivity
from studies.paper.card import CARD, LAWS, PUBLISHED
from studies.paper.comparison import MARGIN, PROPOSED, SCENARIOS, six
from studies.paper.laws import proposed_as_printed, rival
from workbench.controllers.aosmc_rgs import SHAPES
from workbench.loop import ClosedLoop
from workbench.study.document.document import Cell, Column, Measured, Table
from workbench.study.evidence.law_tables import ranking
from workbench.study.study import Outcome, Results

SMALL_Q = "FS as printed, small Q"
SMALL = 0.01  # the lower end of the card's range of Q, in N m/(rad s); R = I as before
FIRM = {20.0: 1e-4, 50.0: 5e-5}  # gains of SMC in N m, the last at the upper end of the card's range; steps in s


def with_small_q(shape: str) -> ClosedLoop:
    """The law as printed in the first scenario on the derived arm, with so small a Q that its gain falls slowly."""
    loop = proposed_as_printed("FS", shape)
    return replace(loop, controller=replace(loop.controller, Q=SMALL * np.eye(2)))


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


def place(results: Results, scenario: str, joint: int, K: float | None = None) -> int:
    """The rank of the proposed law among the six by RMSE (43), 1 for the smallest, with a gain of SMC."""
    laws = six(results, scenario) | {"SMC": smc(results, scenario, K)}
    values = {law: outcome.score("RMSE (43)", joint)[0] for law, outcome in laws.items()}
    return 1 + sum(values[law] < values[PROPOSED] for law in LAWS)


def reached(outcome: Outcome) -> float:
    """When each |s_i| has been below phi at a kept time, in s; infinite where one never is."""
    inside = np.abs(outcome.measurement.trajectories["s"][0]) < CARD["phi"]
    return float(max(outcome.t[np.argmax(joint)] if joint.any() else np.inf for joint in inside.T))


def apart(results: Results, scenario: str) -> float:
    """The largest difference of RMSE (43) between RBF-ASMC and ASMC, relative to ASMC, of both joints."""
    pairs = [[results[scenario, law].score("RMSE (43)", j)[0] for law in ("RBF-ASMC", "ASMC")] for j in (0, 1)]
    return max(abs(ours / theirs - 1) for ours, theirs in pairs)


def table(results: Results) -> Table:
    """What the ranks owe to the gain that is assumed for SMC."""
    places = [(scenario, joint) for scenario in SCENARIOS for joint in (0, 1)]
    assumed = float(CARD["SMC: K"][0])
    rows: list[tuple[Cell, ...]] = []
    for K in (None, *FIRM):
        runs = {scenario: smc(results, scenario, K) for scenario in SCENARIOS}
        rows.append(
            (
                f"{assumed:g}, assumed" if K is None else f"{K:g}",
                *(Measured(*runs[scenario].score("RMSE (43)", joint)) for scenario, joint in places),
                *(f"{reached(run):.2f}" for run in runs.values()),
                ", ".join(str(place(results, *where, K)) for where in places),
                " / ".join(map(str, tally(results, K))),
            )
        )
    columns = (
        Column("K of SMC, N m"),
        *(Column(f"RMSE, {scenario}, q{joint + 1}", "rad", "right") for scenario, joint in places),
        *(Column(f"layer reached, {scenario}", "s", "right") for scenario in SCENARIOS),
        Column(f"ranks of {PROPOSED}", align="right"),
        Column("pairs", align="right"),
    )
    gaps = [apart(results, scenario) for scenario in SCENARIOS]
    notes = (
        "RMSE: by (43). Layer reached: each |s_i| has been below phi. Ranks: by the value of RMSE (43) alone among the "
        "six laws, in the order of the columns of RMSE. Pairs: of the printed pairs those that keep their order / are "
        f"turned round / are within {100 * MARGIN:g} % or both errors.",
        f"RBF-ASMC differs from ASMC by at most {gaps[0]:.0e} (FS) and {100 * gaps[1]:.1f} % (SS) of its RMSE (43): "
        "the model is exact, which leaves its network next to nothing to learn, and its ranks repeat those of ASMC.",
    )
    caption = "The published ranks with other gains of SMC than the assumed one, all else as before."
    return Table("gains_of_smc", caption, columns, tuple(rows), notes)


def small_q(results: Results) -> Table:
    """The law as printed with a small Q, in each reading of (33)."""
    rows: list[tuple[Cell, ...]] = []
    for shape in SHAPES:
        run = results[SMALL_Q, shape]
        lost = loses_positivity(run)
        late = (Measured(*run.score("late error", j)) for j in (0, 1))
        rows.append((shape, "never" if lost is None else f"{lost:.2f}", float(np.nanmin(gain_floor(run))), *late))
    columns = (
        Column("reading of (33)"),
        Column("K not positive", "s", "right"),
        Column("least eigenvalue of K", "N m", digits=3),
        Column("late error of q1", "rad", "right"),
        Column("late error of q2", "rad", "right"),
    )
    caption = f"The same on the derived arm in the first scenario over {CARD['FS: horizon']:g} s, with Q = {SMALL:g} I."
    note = "Least eigenvalue: of the symmetric part of K, over the run."
    return Table("as_printed_small_q", caption, columns, tuple(rows), (note,))
