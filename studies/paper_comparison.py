"""How the laws compare in a1: tables, figures, and the paper's claims held against them."""

from collections.abc import Mapping, Sequence

from paper_card import LAWS, PUBLISHED

from workbench.study.comparison import Ranking, against_published, order, ranking, side_by_side
from workbench.study.document import Block, Cell, Column, Itemize, Paragraph, Reference, Section, Table, Verdict
from workbench.study.study import Outcome, Results
from workbench.study.traces import Window, components, traces

PROPOSED = "AOSMC-RGS"
SCENARIOS = {"FS": "first scenario", "SS": "second scenario"}
BOLD = "Bold: smaller than all others by more than both errors."
FIGURES = {  # figure of the paper to (signal, joint, ordinate, what it shows)
    "FS": {
        3: ("q", 0, "q1 [rad]", "Angle of joint 1"),
        4: ("e", 0, "e1 [rad]", "Tracking error of joint 1"),
        5: ("q", 1, "q2 [rad]", "Angle of joint 2"),
        6: ("e", 1, "e2 [rad]", "Tracking error of joint 2"),
        7: ("tau", 0, "tau1 [N m]", "Torque of joint 1"),
        8: ("tau", 1, "tau2 [N m]", "Torque of joint 2"),
    },
    "SS": {
        11: ("q", 0, "q1 [rad]", "Angle of joint 1"),
        12: ("e", 0, "e1 [rad]", "Tracking error of joint 1"),
        13: ("q", 1, "q2 [rad]", "Angle of joint 2"),
        14: ("e", 1, "e2 [rad]", "Tracking error of joint 2"),
        15: ("tau", 0, "tau1 [N m]", "Torque of joint 1"),
        16: ("tau", 1, "tau2 [N m]", "Torque of joint 2"),
    },
}
OBSERVED = {"FS": "9", "SS": "17"}
ADAPTED = {"FS": "10", "SS": "18"}
TORQUE_FRAME = {"FS": (-60.0, 60.0), "SS": (-150.0, 150.0)}


def six(results: Results, scenario: str) -> dict[str, Outcome]:
    """The paper's laws in one scenario."""
    return {law: results[scenario, law] for law in LAWS}


def rankings(results: Results, scenario: str) -> tuple[Ranking, ...]:
    """The published rankings of a scenario, one a joint, held against ours."""
    return tuple(ranking(PUBLISHED[scenario, joint], six(results, scenario)) for joint in (1, 2))


def scenario_section(results: Results, scenario: str) -> Section:
    """Tables and figures of one scenario."""
    title, laws = SCENARIOS[scenario], six(results, scenario)
    key = scenario.lower()
    shown = results.scenario(scenario)
    tracking = ["RMSE (43)", "RMSE", "RMSE of e_hat", "IAE", "ISE", "ITAE", "peak error"] + (
        ["overshoot", "settling time"] if scenario == "SS" else []
    )
    cost = ["effort", "peak torque", "energy", "TV"]
    published = [
        against_published(
            f"{key}_rmse_q{j}",
            f"RMSE of q{j} in the {title}: printed, ours, and the difference.",
            PUBLISHED[scenario, j],
            laws,
        )
        for j in (1, 2)
    ]
    measured = [
        side_by_side(f"{key}_{what}_q{j}", f"{words} of joint {j}, {title}.", shown, metrics, j - 1, (BOLD,))
        for what, words, metrics in (("tracking", "Tracking", tracking), ("cost", "Torque", cost))
        for j in (1, 2)
    ]
    return Section(
        f"The {title}",
        (
            Paragraph(
                (
                    "Tables 1 and 2 of the paper hold RMSE alone. ",
                    "Ours are in ",
                    Reference(f"{key}_rmse_q1"),
                    " and ",
                    Reference(f"{key}_rmse_q2"),
                    "; the uncertainty is that of the step, not of the assumed numbers.",
                )
            ),
            *published,
            *measured,
            *_figures(results, scenario),
        ),
    )


def _figures(results: Results, scenario: str) -> Sequence[Block]:
    shown, title, key = results.scenario(scenario), SCENARIOS[scenario], scenario.lower()
    end = float(shown[0].t[-1])
    figures = []
    for number, (signal, joint, ylabel, words) in FIGURES[scenario].items():
        frame = TORQUE_FRAME[scenario] if signal == "tau" else None
        beyond = " Torques beyond the frame are in the tables as peak torque." if frame else ""
        figures.append(
            traces(
                f"{key}_figure_{number}",
                f"{words}, {title} (the paper's figure {number}).{beyond}",
                shown,
                signal,
                joint,
                ylabel,
                (Window(0, end, frame), Window(0, 3, frame)),
                reference="q_ref" if signal == "q" else "",
            )
        )
    ours = results[scenario, PROPOSED]
    errors = (("q1", "q_error", 0), ("q2", "q_error", 1))
    gains = (
        ("K11", "controller.K", 0),
        ("K12", "controller.K", 1),
        ("K21", "controller.K", 2),
        ("K22", "controller.K", 3),
    )
    return (
        *figures,
        components(
            f"{key}_figure_{OBSERVED[scenario]}",
            f"Estimation errors q - q_hat of observer (10), {title} (the paper's figure {OBSERVED[scenario]}).",
            ours,
            errors,
            "q - q_hat [rad]",
            (Window(0, end), Window(0, 3)),
        ),
        components(
            f"{key}_figure_{ADAPTED[scenario]}",
            f"Adaptive gains K of the repaired law, {title} (the paper's figure {ADAPTED[scenario]}).",
            ours,
            gains,
            "K [N m]",
            (Window(0, end), Window(0, 3)),
        ),
    )


CLAIMS: Mapping[str, str] = {
    "superior tracking": "RMSE (43)",
    "smaller control amplitudes": "peak torque",
    "lower control effort": "effort",
    "reduced chattering": "TV",
    "reduced overshoot": "overshoot",
    "faster settling": "settling time",
}


def claims_section(results: Results) -> Section:
    """The paper's words held against the six laws here."""
    sentences = tuple(r.sentence(PROPOSED) for scenario in SCENARIOS for r in rankings(results, scenario))
    places = [(scenario, joint) for scenario in SCENARIOS for joint in (0, 1)]
    rows: list[tuple[Cell, ...]] = [
        (words, metric, *(_rank(results, metric, *place) for place in places)) for words, metric in CLAIMS.items()
    ]
    columns = (
        Column("the proposed law has"),
        Column("metric"),
        *(Column(f"{scenario}, joint {joint + 1}", align="center") for scenario, joint in places),
    )
    return Section(
        "Which of the paper's comparisons hold here",
        (
            Paragraph(
                "A claim holds if the proposed law (repaired) is below each of the five rivals, at both joints, in "
                "each "
                "scenario where the metric exists, by more than the errors of the step. This is a statement about the "
                "assumed numbers of the rivals; others may turn it."
            ),
            *(_verdict(results, words, metric) for words, metric in CLAIMS.items()),
            Table(
                "claims",
                "Rank of the proposed law among the six by each metric: 1 is the smallest value.",
                columns,
                tuple(rows),
                ("A range, as in 2-3, where a rival lies within the errors.",),
            ),
            Paragraph("The printed rankings by RMSE, pair by pair:"),
            Itemize(sentences),
        ),
    )


def _against(results: Results, metric: str, scenario: str, joint: int) -> list[str]:
    """How the proposed law stands to each rival: below, above or undecided; nothing where the metric does not exist."""
    ours = results[scenario, PROPOSED]
    if metric not in ours.measurement.scores:
        return []
    others = (results[scenario, law].score(metric, joint) for law in LAWS if law != PROPOSED)
    return [order(ours.score(metric, joint), other) for other in others]


def _rank(results: Results, metric: str, scenario: str, joint: int) -> str | None:
    stands = _against(results, metric, scenario, joint)
    first, last = 1 + stands.count("above"), 1 + stands.count("above") + stands.count("undecided")
    return None if not stands else str(first) if first == last else f"{first}-{last}"


def _verdict(results: Results, words: str, metric: str) -> Verdict:
    stands = {
        (scenario, joint): _against(results, metric, scenario, joint) for scenario in SCENARIOS for joint in (0, 1)
    }
    judged = [stand for place in stands.values() for stand in place]
    statement = f"AOSMC-RGS has {words} ({metric})."
    evidence = f"Below the rival in {judged.count('below')} of {len(judged)} comparisons"
    open_ = judged.count("undecided")
    evidence += f", undecided in {open_}." if open_ else "."
    kind = "fails" if "above" in judged else "open" if open_ else "holds"
    return Verdict(kind, statement, evidence)
