"""The ledger's last lines: the paper's words on its rivals."""

import workbench as wb
from studies.a2_claims.checks import HORIZONS, CheckedClaim, judges, numbers
from studies.paper.card import LAWS, MARGIN, PROPOSED_LAW, PUBLISHED_COLUMNS

RIVALS = tuple(law for law in LAWS if law != PROPOSED_LAW)
GIVEN_NUMBERS = f"{numbers('Q', 'R', 'l', 'SS: a1, a2', 'SS: f')}, {HORIZONS}"
UNSTATED_NUMBERS = (
    "Q, R, l, both horizons, the levels and the frequency of the square wave, and the gains of the five rivals"
)
EXACT = "the rivals as in report a1, with exact q and qd where AOSMC-RGS has (10)"
OF_A1 = "the repaired law and the numbers of a1"
REPAIRED_WORDS = "Repaired, and under the numbers that a1 assumes,"
PAIRS = [column.values[PROPOSED_LAW] < column.values[law] for column in PUBLISHED_COLUMNS.values() for law in RIVALS]
TABLES = (
    f"The printed RMSE of AOSMC-RGS is below the rival's in {sum(PAIRS)} of {len(PAIRS)} pairs; the runs behind the "
    "tables cannot be repeated without the unstated numbers. Report a6 meets each of the 24 printed cells within 1 %, "
    "and all six rows of the second scenario together, with one square wave and one horizon. So the table of the "
    "second scenario is possible, but neither table is confirmed."
)
FIGURE_WORDS = (
    "The paper shows this in {} and prints no number for it. The runs cannot be repeated without the unstated numbers. "
    "The findings of report a6 concern only the RMSE."
)
TORQUES, MOTIONS = FIGURE_WORDS.format("figures 7, 8, 15 and 16"), FIGURE_WORDS.format("figures 3 to 6 and 11 to 14")
# Claim, statement, source; the metric by which a1 has it; the evidence in the paper.
METRICS = (
    ("superior tracking", "tracks better than each rival, by the printed RMSE", "section 5", "sampled RMSE", TABLES),
    ("lower steady-state error", "has less steady-state error than each rival", "section 5", "late error", MOTIONS),
    ("smaller control amplitude", "has smaller torques than each rival", "section 5", "peak torque", TORQUES),
    ("less chattering", "chatters less than each rival", "section 5", "TV", TORQUES),
    ("reduced overshoot", "overshoots less than each rival", "abstract, section 5", "overshoot", MOTIONS),
    ("faster settling", "settles faster than each rival", "abstract, section 5", "settling time", MOTIONS),
    ("lower control effort", "needs less control effort than each rival", "abstract", "effort", TORQUES),
)
ALSO_AS_PUBLISHED = "better disturbance rejection", "observer accuracy"
REJECTION = "better disturbance rejection", "rejects disturbances better than each rival", "abstract, sections 5, 6"


def as_published(name: str, words: str, source: str, evidence: str) -> CheckedClaim:
    """A comparison as published."""
    ruling = wb.proofs.Ruling("not checkable as published", evidence, unstated_numbers=UNSTATED_NUMBERS)
    return CheckedClaim(wb.core.Claim(name, f"AOSMC-RGS {words}.", source), lambda: ruling)


@judges("observer accuracy", "(10) estimates the states with minimal estimation errors.", "section 5")
def accuracy() -> wb.proofs.Ruling:
    return wb.proofs.Ruling(
        "not checkable as published",
        "Figures 9 and 17 show the estimation errors of (10) alone. 'Minimal' has no measure, no bound and no other "
        "observer to compare with.",
        unstated_numbers=f"the measure, and the bound or rival, of 'minimal'; {UNSTATED_NUMBERS}",
    )


def ranking(results: wb.Results, name: str, source: str, metric: str) -> CheckedClaim:
    """The proposed law, repaired, beside each rival by one metric, at each joint and in each scenario."""

    def check() -> wb.proofs.Ruling:
        stood: list[str] = []
        above: list[str] = []
        for scenario in ("FS", "SS"):
            ours = results[scenario, PROPOSED_LAW]
            if metric not in ours.measurement.names:
                continue
            unit = ours.score(metric).unit
            for law, joint in ((law, joint) for law in RIVALS for joint in (0, 1)):
                a, b = ours.score(metric, joint).pair, results[scenario, law].score(metric, joint).pair
                stood.append(wb.evidence.order(a, b, MARGIN))
                if stood[-1] == "above":
                    numbers = f"{law} {b[0]:.4g} {unit}, AOSMC-RGS {a[0]:.4g} {unit}"
                    above.append(f"{numbers} ({scenario}, joint {joint + 1})")
        tally = (
            f"With {GIVEN_NUMBERS}, {EXACT}: below in {stood.count('below')} of {len(stood)} comparisons, above in "
            f"{len(above)}, too close to call in {stood.count('undecided')}"
        )
        witness = f'beside("{metric}")'
        if above:
            return wb.proofs.Ruling(
                "does not hold under", f"{tally}. The first above: {above[0]}.", witness, under=OF_A1
            )
        return wb.proofs.Ruling("not refuted", f"{tally}.", witness, samples=len(stood), under=OF_A1)

    statement = f"{REPAIRED_WORDS} its {metric} is below that of each rival."
    return CheckedClaim(wb.core.Claim(f"{name}, numbers of a1", statement, source), check)


def checks(results: wb.Results) -> tuple[CheckedClaim, ...]:
    """The comparisons as published, then the same under the numbers of a1."""
    return (
        *(as_published(name, words, source, evidence) for name, words, source, _, evidence in METRICS),
        as_published(*REJECTION, FIGURE_WORDS.format("figures of runs with D, none of runs without D,")),
        accuracy,
        *(ranking(results, name, source, metric) for name, _, source, metric, _ in METRICS),
    )
