"""The paper's two scenarios: its tables and figures 3 to 18 beside ours, and the order of the six laws."""

from collections.abc import Sequence

import numpy as np

from studies.paper.card import LAWS, PUBLISHED
from workbench.notation.formula import symbol
from workbench.study.document.document import Bars, Figure, Panel, Paragraph, Section
from workbench.study.evidence.law_tables import against_published, side_by_side
from workbench.study.pictures.traces import Window, components, traces
from workbench.study.study import Outcome, Results

PROPOSED = "AOSMC-RGS"
SCENARIOS = {"FS": "first scenario", "SS": "second scenario"}
MARGIN = 0.02  # of the smaller value: closer pairs are too close to call, as other assumed numbers turn them
BOLD = f"Bold: smaller than all others by more than {100 * MARGIN:g} % and both errors."

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
CURVES = (  # signal, joint, letter, unit, words: six figures in the paper's order
    ("q", 0, "q_1", "rad", "Angle of joint 1"),
    ("e", 0, "e_1", "rad", "Tracking error of joint 1"),
    ("q", 1, "q_2", "rad", "Angle of joint 2"),
    ("e", 1, "e_2", "rad", "Tracking error of joint 2"),
    ("tau", 0, "tau_1", "N m", "Torque of joint 1"),
    ("tau", 1, "tau_2", "N m", "Torque of joint 2"),
)
ERRORS_SEEN = tuple((symbol(f"q_{j + 1}"), "q_error", j) for j in (0, 1))
GAINS = tuple((symbol(f"K_{i}{j}"), "controller.K", 2 * (i - 1) + j - 1) for i in (1, 2) for j in (1, 2))


def six(results: Results, scenario: str) -> dict[str, Outcome]:
    """The paper's laws in one scenario."""
    return {law: results[scenario, law] for law in LAWS}


def rmse_figure(results: Results) -> Figure:
    """The two published tables as bars, beside ours."""
    rows, start = np.arange(len(LAWS)), np.zeros(len(LAWS))
    panels = []
    for (scenario, joint), column in PUBLISHED.items():
        printed = np.array([column.values[law] for law in LAWS])
        ours = np.array([run.score("RMSE (43)", joint - 1)[0] for run in six(results, scenario).values()])
        bars = (
            Bars("printed", rows - 0.2, printed, start, 0, thick=0.35),
            Bars("ours", rows + 0.2, ours, start, 1, thick=0.35),
        )
        panels.append(Panel("", bars, "RMSE (43) [rad]", ynames=LAWS, title=column.where))
    caption = (
        "RMSE (43) as printed, and as run here: AOSMC-RGS with four slips repaired, the rivals with gains of ours, as "
        "the paper states none."
    )
    return Figure("rmse", caption, tuple(panels), columns=2)


def figures(shown: Sequence[Outcome], ours: Outcome, scenario: str) -> tuple[Figure, ...]:
    """The figures of one scenario: the laws, then the observer's errors and the gains of the proposed law."""
    key, title, number, end = scenario.lower(), SCENARIOS[scenario], FIRST[scenario], float(ours.t[-1])
    whole = Window(0, EARLY), Window(EARLY, end)
    drawn = Window(0, EARLY, TORQUE[scenario]), Window(EARLY, end, TORQUE[scenario] if scenario == "SS" else None)
    laws = (
        traces(
            f"{key}_figure_{number + place}",
            f"{words}, {title} (the paper's figure {number + place}).",
            shown,
            signal,
            joint,
            (symbol(letter), f" [{unit}]"),
            drawn if signal == "tau" else whole,
            reference="q_ref" if signal == "q" else "",
        )
        for place, (signal, joint, letter, unit, words) in enumerate(CURVES)
    )
    observed = f"Estimation errors q - q_hat of (10), {title} (the paper's figure {number + 6})."
    adapted = f"Gains K of the repaired law, {title} (the paper's figure {number + 7})."
    return (
        *laws,
        components(f"{key}_figure_{number + 6}", observed, ours, ERRORS_SEEN, "estimation error [rad]", whole),
        components(f"{key}_figure_{number + 7}", adapted, ours, GAINS, (symbol("K"), " [N m]"), whole),
    )


def scenario_section(results: Results, scenario: str) -> Section:
    """Figures and tables of one scenario."""
    title, key, shown = SCENARIOS[scenario], scenario.lower(), results.scenario(scenario)
    about = Paragraph(
        "(43), the paper's only metric, is a mean over samples that begins with the initial error; the column RMSE is "
        f"the integral. Errors are those of the step, not of the assumed numbers. {BOLD} A torque that leaves its "
        "frame is in the tables as peak torque."
    )
    published = (
        against_published(
            f"{key}_rmse_q{j}",
            f"RMSE of joint {j} in the {title}: printed, ours by (43), and the difference.",
            PUBLISHED[scenario, j],
            six(results, scenario),
        )
        for j in (1, 2)
    )
    measured = (
        side_by_side(
            f"{key}_all_{group}_q{j}", f"{words} of joint {j}, {title}.", shown, of[scenario], j - 1, margin=MARGIN
        )
        for group, (words, of) in GROUPS.items()
        if scenario in of
        for j in (1, 2)
    )
    curves = figures(shown, results[scenario, PROPOSED], scenario)
    return Section(f"The {title}", (about, *curves, *published, *measured))
