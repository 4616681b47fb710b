"""The six laws in both scenarios: tables and figures 3 to 18 of the paper beside ours, and the order of the laws."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from studies.a1_paper_tables.repairs import GAINS
from studies.paper.card import BOLD, CARD, LAWS, MARGIN, PROPOSED, PUBLISHED, SCENARIOS
from studies.paper.laws import rival
from workbench.loop import ClosedLoop
from workbench.notation.formula import symbol
from workbench.study.document.document import Bars, Figure, Itemize, Panel, Paragraph, Section
from workbench.study.document.phrases import Cell, Column, Table
from workbench.study.evidence.law_tables import against_published, ranking, side_by_side
from workbench.study.marks import bars, cell
from workbench.study.pictures.traces import Window, components, traces
from workbench.study.study import Outcome, Results

ERRORS = ("IAE", "ISE", "ITAE", "peak error")
COST = ("effort", "peak torque", "energy", "TV")
GROUPS = {  # the tables of a scenario: words and metrics
    "rmse": ("Root mean squares of the error", dict.fromkeys(SCENARIOS, ("RMSE (43)", "RMSE", "RMSE of e_hat"))),
    "errors": ("Other errors", {"FS": (*ERRORS, "late error"), "SS": ERRORS}),
    "cost": ("Torque", dict.fromkeys(SCENARIOS, COST)),
    "steps": ("After the jumps of the reference: motion", {"SS": ("overshoot", "settling time")}),
}
FIRST = {"FS": 3, "SS": 11}  # the number of each scenario's first figure in the paper
TORQUE = {"FS": (-60.0, 60.0), "SS": (-150.0, 150.0)}  # N m, the part of a torque that is drawn
EARLY = 3.0  # s, where the left panel ends and the right one begins
CURVES = (  # signal, joint, unit, words: six figures in the paper's order
    ("q", 0, "rad", "Angle of joint 1"),
    ("e", 0, "rad", "Tracking error of joint 1"),
    ("q", 1, "rad", "Angle of joint 2"),
    ("e", 1, "rad", "Tracking error of joint 2"),
    ("tau", 0, "N m", "Torque of joint 1"),
    ("tau", 1, "N m", "Torque of joint 2"),
)
ERRORS_SEEN = tuple((symbol(f"q_{j + 1}"), "q_error", j) for j in (0, 1))
FIRM = {20.0: 1e-4, 50.0: 5e-5}  # gains of SMC in N m, the last at the upper end of the card's range; steps in s
PLACES = [(scenario, joint) for scenario in SCENARIOS for joint in (0, 1)]


def firm(scenario: str, K: float) -> ClosedLoop:
    """SMC with another gain than the assumed one."""
    loop = rival(scenario, "SMC")
    return replace(loop, controller=replace(loop.controller, K=np.full(2, K)))


def six(results: Results, scenario: str, K: float | None = None) -> dict[str, Outcome]:
    """The paper's laws in one scenario, SMC with the assumed gain or with one of the `FIRM` ones."""
    laws = {law: results[scenario, law] for law in LAWS}
    return laws if K is None else laws | {"SMC": results[f"{scenario}, SMC", f"K = {K:g} N m"]}


def tally(results: Results, K: float | None = None) -> tuple[int, int, int]:
    """Of the printed pairs those that keep their order, are turned round, and are too close, with a gain of SMC."""
    rows = [ranking(column, six(results, scenario, K), MARGIN) for (scenario, _), column in PUBLISHED.items()]
    return sum(len(r.holds) for r in rows), sum(len(r.fails) for r in rows), sum(len(r.undecided) for r in rows)


def reaching_time(outcome: Outcome) -> float:
    """The time by which each |s_i| has been below phi, in s; infinite where one never is."""
    inside = np.abs(outcome.measurement.trajectories["s"][0]) < CARD["phi"]
    return float(max(outcome.t[np.argmax(joint)] if joint.any() else np.inf for joint in inside.T))


def rmse_figure(results: Results) -> Figure:
    """The two published tables as bars, beside ours."""
    rows, start = np.arange(len(LAWS)), np.zeros(len(LAWS))
    panels = []
    for (scenario, _), column in PUBLISHED.items():
        printed = np.array([column.values[law] for law in LAWS])
        ours = [*six(results, scenario).values()]
        both = (
            Bars("printed", rows - 0.2, printed, start, 0, thick=0.35),
            bars("ours", ours, column.metric, column.signal, rows + 0.2, 1, thick=0.35),
        )
        panels.append(Panel("", both, "RMSE (43) [rad]", ynames=LAWS, title=column.where))
    caption = (
        "RMSE (43) as printed, and as run here: AOSMC-RGS with four slips repaired, the rivals with gains of ours, as "
        "the paper states none."
    )
    return Figure("rmse", caption, tuple(panels), columns=2)


def figures(shown: Sequence[Outcome], ours: Outcome, scenario: str) -> tuple[Figure, ...]:
    """The figures of one scenario: the laws, then the observer's errors and the gains of the proposed law."""
    number, end = FIRST[scenario], float(ours.t[-1])
    whole = Window(0, EARLY), Window(EARLY, end)
    drawn = Window(0, EARLY, TORQUE[scenario]), Window(EARLY, end, TORQUE[scenario] if scenario == "SS" else None)

    def names(words: str, place: int) -> tuple[str, str]:
        caption = f"{words}, {SCENARIOS[scenario]} (the paper's figure {number + place})."
        return f"{scenario.lower()}_figure_{number + place}", caption

    laws = []
    for place, (signal, joint, unit, words) in enumerate(CURVES):
        label = symbol(f"{signal}_{joint + 1}"), f" [{unit}]"
        windows, wanted = drawn if signal == "tau" else whole, "q_ref" if signal == "q" else ""
        laws.append(traces(*names(words, place), shown, signal, joint, label, windows, reference=wanted))
    errors, gains = names("Estimation errors q - q_hat of (10)", 6), names("Gains K of the repaired law", 7)
    return (
        *laws,
        components(*errors, ours, ERRORS_SEEN, "estimation error [rad]", whole),
        components(*gains, ours, GAINS, (symbol("K"), " [N m]"), whole),
    )


def scenario_section(results: Results, scenario: str) -> Section:
    """Figures and tables of one scenario."""
    title, key, shown = SCENARIOS[scenario], scenario.lower(), results.scenario(scenario)
    about = Paragraph(
        "(43), the paper's only metric, is a mean over samples that begins with the initial error; the column RMSE is "
        f"the integral. Errors are those of the step, not of the assumed numbers. {BOLD} A torque that leaves its "
        "frame is in the tables as peak torque."
    )
    tables = []
    for j in (1, 2):
        caption = f"RMSE of joint {j} in the {title}: printed, ours by (43), and the difference."
        tables.append(against_published(f"{key}_rmse_q{j}", caption, PUBLISHED[scenario, j], six(results, scenario)))
    for group, (words, metrics) in GROUPS.items():
        for j in (1, 2) if scenario in metrics else ():
            name, caption = f"{key}_all_{group}_q{j}", f"{words} of joint {j}, {title}."
            tables.append(side_by_side(name, caption, shown, metrics[scenario], j - 1, margin=MARGIN))
    return Section(f"The {title}", (about, *figures(shown, results[scenario, PROPOSED], scenario), *tables))


def order_section(results: Results) -> Section:
    """The printed order of the laws held against ours, and its debt to the assumed gain of SMC."""
    rows: list[tuple[Cell, ...]] = []
    for K in (None, *FIRM):
        smc = {scenario: six(results, scenario, K)["SMC"] for scenario in SCENARIOS}
        scores = (cell(smc[scenario], "RMSE (43)", joint) for scenario, joint in PLACES)
        reached = (f"{reaching_time(run):.2f}" for run in smc.values())
        gain = f"{CARD['SMC: K'][0]:g}, assumed" if K is None else f"{K:g}"
        rows.append((gain, *scores, *reached, " / ".join(map(str, tally(results, K)))))
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
    sentences = (
        ranking(column, six(results, scenario), MARGIN).sentence(PROPOSED)
        for (scenario, _), column in PUBLISHED.items()
    )
    table = Table("gains_of_smc", caption, columns, tuple(rows), (note,))
    return Section("The printed order of the laws", (Itemize(tuple(sentences)), table))
