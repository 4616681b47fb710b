"""The six laws in both scenarios: the tables and figures 3 to 18 of the paper, and the order of the laws."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import workbench as wb
from studies.a1_paper_tables.repairs import GAINS
from studies.paper.card import BOLD, CARD, LAWS, MARGIN, PROPOSED_LAW, PUBLISHED_COLUMNS, SCENARIOS
from studies.paper.comparison import LATE
from studies.paper.laws import rival

ERRORS = ("IAE", "ISE", "ITAE", "peak error")
COST = ("effort", "peak torque", "energy", "TV")
GROUPS: dict[str, tuple[str, dict[str, tuple[str, ...]]]] = {  # the tables of a scenario: words and metrics
    "rmse": ("Root mean squares of the error", dict.fromkeys(SCENARIOS, ("sampled RMSE", "RMSE", "RMSE of e_hat"))),
    "errors": ("Other errors", {"FS": (*ERRORS, "late error"), "SS": ERRORS}),
    "cost": ("Torque", dict.fromkeys(SCENARIOS, COST)),
    "steps": ("After the jumps of the reference: motion", {"SS": ("overshoot", "settling time")}),
}
MEANINGS = {  # of the symbols in the notes of these tables
    "rmse": ("e_hat = q_hat - q_d: the tracking error by the estimate of the observer.",),
    "cost": ("qd: the joint velocity.",),
}
FIRST = {"FS": 3, "SS": 11}  # the number of each scenario's first figure in the paper
TORQUE = {"FS": (-60.0, 60.0), "SS": (-150.0, 150.0)}  # N m, the part of a torque that is drawn
EARLY = 3.0  # s, where the left panel ends
PANEL_END = 12.0  # s, where the right panel ends at the latest
CURVES = (  # signal, joint, unit, words: six figures in the paper's order
    ("q", 0, "rad", "Angle of joint 1"),
    ("e", 0, "rad", "Tracking error of joint 1"),
    ("q", 1, "rad", "Angle of joint 2"),
    ("e", 1, "rad", "Tracking error of joint 2"),
    ("tau", 0, "N m", "Torque of joint 1"),
    ("tau", 1, "N m", "Torque of joint 2"),
)
ERRORS_SEEN = tuple((wb.notation.symbol(f"q_{j + 1}"), "q_error", j) for j in (0, 1))
FIRM = {20.0: 1e-4, 50.0: 5e-5}  # gains of SMC in N m, the last at the upper end of the card's range; steps in s
PLACES = [(scenario, joint) for scenario in SCENARIOS for joint in (0, 1)]


def firm(scenario: str, K: float) -> wb.ClosedLoop:
    """SMC with another gain than the assumed one."""
    loop = rival(scenario, "SMC")
    return replace(loop, controller=replace(loop.controller, K=np.full(2, K)))


def six(results: wb.Results, scenario: str, K: float | None = None) -> dict[str, wb.study.Outcome]:
    """The paper's laws in one scenario, SMC with the assumed gain or with one of the `FIRM` ones."""
    laws = {law: results[scenario, law] for law in LAWS}
    return laws if K is None else laws | {"SMC": results[f"{scenario}, SMC", f"K = {K:g} N m"]}


def count_pairs(
    results: wb.Results,
    K: float | None = None,
    *,
    columns: Sequence[wb.evidence.PublishedColumn] = tuple(PUBLISHED_COLUMNS.values()),
    without: str = "",
    margin: float = MARGIN,
    metric: str = "",
) -> tuple[int, int, int]:
    """Of the printed pairs those that keep their order, are reversed, and are too close to call.

    With another gain of SMC, in some columns alone, without a law, with another margin, or by another metric.
    """
    rows = []
    for (scenario, _), column in PUBLISHED_COLUMNS.items():
        if column in columns:
            values = {law: value for law, value in column.values.items() if law != without}
            asked = replace(column, values=values, metric=metric or column.metric)
            rows.append(wb.evidence.ranking(asked, six(results, scenario, K), margin))
    return (
        sum(len(row.kept_pairs) for row in rows),
        sum(len(row.reversed_pairs) for row in rows),
        sum(len(row.undecided_pairs) for row in rows),
    )


def reaching_time(outcome: wb.study.Outcome) -> float:
    """The time by which each |s_i| has been below phi, in s; infinite where one never is."""
    inside = np.abs(outcome.measurement.trajectories["s"][0]) < CARD["phi"]
    return float(max(outcome.t[np.argmax(joint)] if joint.any() else np.inf for joint in inside.T))


def rmse_figure(results: wb.Results) -> wb.document.Figure:
    """The two published tables as bars, beside ours; the law that was fitted to them has a colour of its own."""
    rows, start = np.arange(len(LAWS)), np.zeros(len(LAWS))
    fitted = np.array([law == PROPOSED_LAW for law in LAWS])
    panels = []
    for (scenario, _), column in PUBLISHED_COLUMNS.items():
        printed = np.array([column.values[law] for law in LAWS])
        ours = six(results, scenario)
        here = tuple(
            wb.study.bars(
                words,
                [run for law, run in ours.items() if (law == PROPOSED_LAW) == own],
                column.metric,
                column.signal,
                rows[fitted == own] + 0.2,
                style,
                thick=0.35,
            )
            for words, own, style in (("here, fitted to the print", True, 2), ("here, not fitted", False, 1))
        )
        both = (wb.document.Bars("printed", np.asarray(rows - 0.2, dtype=float), printed, start, 0, thick=0.35), *here)
        panels.append(wb.document.Panel("", both, "sampled RMSE [rad]", ynames=LAWS, title=column.where))
    caption = (
        "Sampled RMSE, (43), as printed and from the runs here. Only AOSMC-RGS, with four repairs, was fitted to the "
        "printed values. The rivals have assumed gains, as the paper states none, so the bars do not compare the "
        "laws."
    )
    return wb.document.Figure("rmse", caption, tuple(panels), columns=2)


def figures(
    outcomes: Sequence[wb.study.Outcome], ours: wb.study.Outcome, scenario: str
) -> tuple[wb.document.Figure, ...]:
    """The figures of one scenario: the laws, then the observer's errors and the gains of the proposed law."""
    number, end = FIRST[scenario], float(ours.t[-1])
    first = scenario == "FS"
    whole = (
        wb.pictures.Window(0, EARLY),
        wb.pictures.Window(LATE if first else EARLY, min(end, PANEL_END)),
    )  # what is small shows late as well
    large = whole[:1] if first else whole  # later the curves of the first scenario lie on each other
    drawn = tuple(replace(window, ylim=TORQUE[scenario]) for window in large)

    def names(words: str, place: int, rest: str = "") -> tuple[str, str]:
        caption = f"{words}, {SCENARIOS[scenario]} (the paper's figure {number + place}).{rest}"
        return f"{scenario.lower()}_figure_{number + place}", caption

    laws = []
    for place, (signal, joint, unit, words) in enumerate(CURVES):
        label = wb.notation.symbol(f"{signal}_{joint + 1}"), f" [{unit}]"
        windows, wanted = {"tau": drawn, "q": large}.get(signal, whole), "q_ref" if signal == "q" else ""
        rest = " Later the curves lie on each other." if first and windows is not whole else ""
        laws.append(
            wb.pictures.traces(*names(words, place, rest), outcomes, signal, joint, label, windows, reference=wanted)
        )
    errors, gains = names("Estimation errors q - q_hat of (10)", 6), names("Gains K with four repairs", 7)
    return (
        *laws,
        wb.pictures.components(*errors, ours, ERRORS_SEEN, "estimation error [rad]", whole),
        wb.pictures.components(*gains, ours, GAINS, (wb.notation.symbol("K"), " [N m]"), large),
    )


def scenario_section(results: wb.Results, scenario: str) -> wb.Section:
    """Figures and tables of one scenario."""
    title, key, runs = SCENARIOS[scenario], scenario.lower(), results.scenario(scenario)
    about = wb.Paragraph(
        "The paper has one metric, (43): a root mean square over samples, the initial error among them: the "
        "sampled RMSE. The column 'RMSE' is the same mean, taken as an integral over time. The error of a value, in "
        "brackets, comes from the "
        f"step of the simulation only; the assumed numbers matter far more. {BOLD} Where a torque leaves the frame of "
        "a figure, its peak is in the tables. Super-twisting is a seventh law that the paper does not have; only the "
        "tables have it."
    )
    tables = []
    for j in (1, 2):
        caption = (
            f"Sampled RMSE, (43), of joint {j} in the {title}: as printed, from the runs here, and the difference."
        )
        tables.append(
            wb.evidence.against_published(
                f"{key}_rmse_q{j}", caption, PUBLISHED_COLUMNS[scenario, j], six(results, scenario)
            )
        )
    for group, (words, metrics) in GROUPS.items():
        for j in (1, 2) if scenario in metrics else ():
            name, caption = f"{key}_all_{group}_q{j}", f"{words} of joint {j}, {title}."
            notes = MEANINGS.get(group, ())
            tables.append(wb.side_by_side(name, caption, runs, metrics[scenario], j - 1, notes, MARGIN))
    drawn = figures(tuple(six(results, scenario).values()), results[scenario, PROPOSED_LAW], scenario)
    return wb.Section(f"The {title}", (about, *drawn, *tables))


def order_section(results: wb.Results) -> wb.Section:
    """The published values beside ours, the printed order of the laws, and the part of the assumed gain of SMC."""
    about = wb.Paragraph(
        "The printed tables put AOSMC-RGS first at each joint in each scenario. The runs here cannot test that order, "
        "as they rest on "
        "assumed numbers of the rivals. They show which pairs keep their order with these numbers."
    )
    return wb.Section(
        "The printed order of the laws", (rmse_figure(results), about, _columns_table(results), _gains_table(results))
    )


def _columns_table(results: wb.Results) -> wb.document.ReportTable:
    """A row for each joint and scenario: the pairs of laws, and the laws on the other side of the proposed one."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for (scenario, _), column in PUBLISHED_COLUMNS.items():
        judged = wb.evidence.ranking(column, six(results, scenario), MARGIN)
        below = ", ".join(law for first, law in judged.reversed_pairs if first == PROPOSED_LAW)
        rows.append(
            (
                column.where,
                len(judged.kept_pairs),
                len(judged.reversed_pairs),
                len(judged.undecided_pairs),
                below or "none",
            )
        )
    columns = (
        wb.document.TableColumn("scenario and joint"),
        wb.document.TableColumn("keep their order", align="right"),
        wb.document.TableColumn("reversed", align="right"),
        wb.document.TableColumn("too close to call", align="right"),
        wb.document.TableColumn(f"larger RMSE than {PROPOSED_LAW} in print, smaller here"),
    )
    caption = "The fifteen pairs of laws at each joint in each scenario, by the sampled RMSE, (43), of the runs here."
    return wb.document.ReportTable("pairs", caption, columns, tuple(rows))


def _gains_table(results: wb.Results) -> wb.document.ReportTable:
    """One row for each gain of SMC: its RMSE, the time to its layer, and the pairs."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for K in (None, *FIRM):
        smc = {scenario: six(results, scenario, K)["SMC"] for scenario in SCENARIOS}
        scores = (wb.study.cell(smc[scenario], "sampled RMSE", joint) for scenario, joint in PLACES)
        reached = (f"{reaching_time(run):.2f}" for run in smc.values())
        gain = f"{CARD['SMC: K'][0]:g}, assumed" if K is None else f"{K:g}"
        rows.append((gain, *scores, *reached, *count_pairs(results, K)))
    columns = (
        wb.document.TableColumn("K of SMC [N m]"),
        *(
            wb.document.TableColumn(f"sampled RMSE of q{joint + 1}, {scenario}", "rad", "right")
            for scenario, joint in PLACES
        ),
        *(wb.document.TableColumn(f"layer reached, {scenario}", "s", "right") for scenario in SCENARIOS),
        *(wb.document.TableColumn(f"pairs {words}", align="right") for words in ("in order", "reversed", "too close")),
    )
    caption = (
        "The printed pairs with the assumed gain of SMC and with two other gains; all other numbers stay the same."
    )
    note = "Layer reached: the time by which each |s_i| has been below phi. FS, SS: first and second scenario."
    return wb.document.ReportTable("gains_of_smc", caption, columns, tuple(rows), (note,))
