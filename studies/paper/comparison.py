"""How the laws compare in a1: tables, figures, and the paper's claims held against them."""

from collections.abc import Mapping

from studies.paper.card import LAWS, PUBLISHED
from studies.paper.figures import figures
from workbench.study.document.document import Cell, Column, Itemize, Paragraph, Reference, Section, Table, Verdict
from workbench.study.evidence.law_tables import Ranking, against_published, order, ranking, side_by_side
from workbench.study.study import Outcome, Results

PROPOSED = "AOSMC-RGS"
SCENARIOS = {"FS": "first scenario", "SS": "second scenario"}
MARGIN = 0.02  # of the smaller value: closer pairs are too close to call, as other assumed numbers turn them
BOLD = f"Bold: smaller than all others by more than {100 * MARGIN:g} % and both errors."
SQUARES = ("RMSE (43)", "RMSE", "RMSE of e_hat")
ERRORS = ("IAE", "ISE", "ITAE", "peak error")
COST = ("effort", "peak torque", "energy", "TV")
AFTER_STEPS = ("overshoot", "settling time")


def six(results: Results, scenario: str) -> dict[str, Outcome]:
    """The paper's laws in one scenario."""
    return {law: results[scenario, law] for law in LAWS}


def rankings(results: Results, scenario: str) -> tuple[Ranking, ...]:
    """The published rankings of a scenario, one a joint, held against ours."""
    return tuple(ranking(PUBLISHED[scenario, joint], six(results, scenario), MARGIN) for joint in (1, 2))


def scenario_section(results: Results, scenario: str) -> Section:
    """Tables and figures of one scenario."""
    title, key = SCENARIOS[scenario], scenario.lower()
    shown, laws = results.scenario(scenario), six(results, scenario)
    groups = [
        ("rmse", "Root mean squares of the error", SQUARES),
        ("errors", "Other errors", (*ERRORS, "late error") if scenario == "FS" else ERRORS),
        ("cost", "Torque", COST),
    ]
    if scenario == "SS":
        groups.append(("steps", "After the jumps of the reference: motion", AFTER_STEPS))
    measured = (
        side_by_side(
            f"{key}_all_{what}_q{j}", f"{words} of joint {j}, {title}.", shown, metrics, j - 1, (BOLD,), MARGIN
        )
        for what, words, metrics in groups
        for j in (1, 2)
    )
    published = (
        against_published(
            f"{key}_rmse_q{j}",
            f"RMSE of joint {j} in the {title}: printed, ours by (43), and the difference.",
            PUBLISHED[scenario, j],
            laws,
        )
        for j in (1, 2)
    )
    return Section(
        f"The {title}",
        (
            Paragraph(
                (
                    "The paper's tables hold RMSE alone: ",
                    Reference(f"{key}_rmse_q1"),
                    " and ",
                    Reference(f"{key}_rmse_q2"),
                    " hold ours beside it. (43) is a mean over samples, which begins with the initial error; the "
                    "column RMSE of the tables behind is the integral. The errors are those of the step, not of the "
                    "assumed numbers.",
                )
            ),
            *published,
            *measured,
            *figures(shown, results[scenario, PROPOSED], scenario, title),
        ),
    )


CLAIMS: Mapping[str, str] = {
    "superior tracking": "RMSE (43)",
    "lower steady-state error": "late error",
    "smaller control amplitudes": "peak torque",
    "lower control effort": "effort",
    "reduced chattering": "TV",
    "reduced overshoot": "overshoot",
    "faster settling": "settling time",
}


def claims_section(results: Results, gains: Table) -> Section:
    """The paper's words held against the six laws here, and what the ranks owe to assumed gains."""
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
                f"each scenario where the metric exists, by more than {100 * MARGIN:g} % and the errors of the step. "
                "Each comparison is of two runs without noise. The rivals are given exact positions and velocities, "
                "the proposed law positions and the true disturbance. The paper states no number of a "
                "rival: each count below is under the assumed ones, and others can reverse it."
            ),
            *(_verdict(results, words, metric) for words, metric in CLAIMS.items()),
            Table(
                "claims",
                "Rank of the proposed law among the six by each metric: 1 is the smallest value.",
                columns,
                tuple(rows),
                ("A range, as in 2-3, where a rival is too close to call.",),
            ),
            gains,
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
    return [order(ours.score(metric, joint), other, MARGIN) for other in others]


def _rank(results: Results, metric: str, scenario: str, joint: int) -> str | None:
    stands = _against(results, metric, scenario, joint)
    first, last = 1 + stands.count("above"), 1 + stands.count("above") + stands.count("undecided")
    return None if not stands else str(first) if first == last else f"{first}-{last}"


def _verdict(results: Results, words: str, metric: str) -> Verdict:
    stands = {
        (scenario, joint): _against(results, metric, scenario, joint) for scenario in SCENARIOS for joint in (0, 1)
    }
    where = [SCENARIOS[s] for s in SCENARIOS if stands[s, 0]]
    judged = [stand for place in stands.values() for stand in place]
    below, above, close = (judged.count(stand) for stand in ("below", "above", "undecided"))
    return Verdict(
        "found",
        f"{words[0].upper()}{words[1:]}: AOSMC-RGS has the smaller {metric} in {below} of {len(judged)} comparisons.",
        f"Larger in {above}, too close to call in {close}. "
        + ("The claim holds" if below == len(judged) else "The claim does not hold" if above else "The claim is open")
        + " under the assumed numbers.",
        estimand=f"{metric[0].upper()}{metric[1:]} of one run a law, at both joints, {' and '.join(where)}, against "
        "five rivals.",
    )
