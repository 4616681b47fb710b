"""The ledger's last lines: what the paper says of its rivals, and what laws and observers promise of themselves."""

from collections.abc import Sequence
from dataclasses import replace

from studies.a2_claims import statements as paper
from studies.a2_claims.checks import HORIZONS, Check, numbers, searched, sought
from studies.a2_claims.replay import observed, pushed
from studies.a2_claims.searches import hunt
from studies.paper.card import LAWS, PUBLISHED
from studies.paper.comparison import MARGIN, PROPOSED
from workbench.claims.falsify import Found
from workbench.claims.verdicts import Finding
from workbench.core import Claim
from workbench.core.claim import Declared
from workbench.study.evidence.law_tables import order
from workbench.study.study import Results

SCENARIOS = ("FS", "SS")
RIVALS = tuple(law for law in LAWS if law != PROPOSED)
GIVEN = f"{numbers('Q', 'R', 'l', 'SS: a1, a2', 'SS: f')}, {HORIZONS}"
UNSTATED = "Q, R, l, both horizons, the levels and the frequency of the square wave, and the gains of the five rivals"
EXACT = "the rivals as a1 has them, on exact q and qd where AOSMC-RGS has (10)"
OF_A1 = "the repaired law and the numbers of a1"
TORQUES, MOTIONS = "figures 7, 8, 15 and 16", "figures 3 to 6 and 11 to 14"
# As published; the metric by which a1 has it; where the paper shows it.
METRICS: tuple[tuple[Claim, str, str], ...] = (
    (paper.TRACKING, "RMSE (43)", "two tables"),
    (paper.STEADY, "late error", MOTIONS),
    (paper.AMPLITUDE, "peak torque", TORQUES),
    (paper.CHATTERING, "TV", TORQUES),
    (paper.OVERSHOOT, "overshoot", MOTIONS),
    (paper.SETTLING, "settling time", MOTIONS),
    (paper.EFFORT, "effort", TORQUES),
)
# A search of `searches`: the block that makes the promise, the unit of its margin, what the paper leaves open.
PROMISES = {
    "smc": ("SlidingMode", "rad^2/s", ""),
    "asmc": ("AdaptiveSlidingMode", "N m", ""),
    "super_twisting": ("SuperTwisting", "rad/s^3", ""),
    "oracle_filter": ("OracleFilter", "N^2 m^2/s", "l"),
    "printed_filter": ("PrintedFilter", "N^2 m^2/s", "l"),
    "momentum": ("MomentumObserver", "N^2 m^2/s", "l"),
    "nonlinear": ("NonlinearDisturbanceObserver", "N^2 m^2/s", "l"),
}


Stand = tuple[str, str]  # below, above or undecided, and the two numbers in words


def under(claim: Claim, words: str) -> Claim:
    """A claim of the paper where it can be checked: repaired, and under the numbers that a1 assumes."""
    statement = f"Repaired, and under the numbers that a1 assumes, {words}."
    return Claim(f"{claim.name}, numbers of a1", statement, claim.source)


def uncheckable(shown: str) -> Check:
    """A comparison that the paper shows in figures, without a number."""

    def check() -> Finding:
        return Finding(
            "not checkable as published",
            f"The paper shows it in {shown} and prints no number for it; the runs cannot be repeated without the "
            "numbers that are unstated. What a6 finds concerns RMSE alone.",
            unstated=UNSTATED,
        )

    return check


def printed_tracking() -> Finding:
    """The printed tables."""
    below = [column.values[PROPOSED] < column.values[law] for column in PUBLISHED.values() for law in RIVALS]
    return Finding(
        "not checkable as published",
        f"The printed RMSE of AOSMC-RGS is below the rival's in {sum(below)} of {len(below)} pairs; the runs behind "
        "the tables cannot be repeated without the numbers that are unstated. a6 meets each of the 24 printed cells "
        "within 1 %, and, with a plus in (33) and one horizon, all six rows of a scenario together; in the second "
        "scenario with one square wave. So both tables are possible, and neither is confirmed.",
        unstated=UNSTATED,
    )


def accuracy() -> Finding:
    """Figures 9 and 17."""
    return Finding(
        "not checkable as published",
        "Figures 9 and 17 show the estimation errors of (10) alone. 'Minimal' names no measure, no bound and no other "
        "observer to compare with.",
        unstated=f"the measure, and the bound or rival, of 'minimal'; {UNSTATED}",
    )


def judged(stands: Sequence[Stand], witness: str, given: str) -> Finding:
    """Comparisons that a claim wants to be all below."""
    lost = [words for stood, words in stands if stood == "above"]
    below = sum(stood == "below" for stood, _ in stands)
    tally = f"With {given}: below in {below} of {len(stands)} comparisons, above in {len(lost)}"
    tally += f", too close to call in {len(stands) - below - len(lost)}"
    if lost:
        return Finding("does not hold under", f"{tally}. The first above: {lost[0]}.", witness, under=OF_A1)
    shown = "; ".join(words for _, words in stands)
    return Finding("not refuted", f"{tally}: {shown}.", witness, samples=len(stands), under=OF_A1)


def ranked(results: Results, metric: str) -> Check:
    """The proposed law, repaired, beside each rival by one metric, at each joint and in each scenario."""

    def check() -> Finding:
        stands: list[Stand] = []
        for scenario in SCENARIOS:
            ours = results[scenario, PROPOSED]
            if metric not in ours.measurement.scores:
                continue
            unit = ours.measurement.scores[metric].metric.unit
            for law in RIVALS:
                for joint in (0, 1):
                    a, b = ours.score(metric, joint), results[scenario, law].score(metric, joint)
                    place = f"({scenario}, joint {joint + 1})"
                    said = f"{law} {b[0]:.4g} {unit}, AOSMC-RGS {a[0]:.4g} {unit} {place}"
                    stands.append((order(a, b, MARGIN), said))
        return judged(stands, f'beside("{metric}")', f"{GIVEN}, {EXACT}")

    return check


def rejected() -> Finding:
    """How far D of the first scenario moves each law's arm."""
    (ours, change), stands = pushed(PROPOSED), []
    for law in RIVALS:
        theirs, error = pushed(law)
        for joint in (0, 1):
            a, b = (ours[joint], change[joint]), (theirs[joint], error[joint])
            said = f"D moves the arm by {b[0]:.3g} rad under {law}, and by {a[0]:.3g} rad under AOSMC-RGS"
            stands.append((order(a, b, MARGIN), f"{said} (joint {joint + 1})"))
    given = f"{numbers('Q', 'R', 'l')}, {EXACT} and knows D by (24), first scenario, 15 s to 20 s"
    return judged(stands, "{law: pushed(law) for law in LAWS}", given)


def estimated() -> Finding:
    """The late error of the estimated velocity, which no instrument gives, beside that of the velocity itself."""
    (e, e_change), (lost, change) = observed()
    stands = [
        (order((b, db), (a, da), MARGIN), f"|qd - qd_hat| {b:.4g} rad/s, |qd - qd_d| {a:.4g} rad/s (joint {joint + 1})")
        for joint, (a, da, b, db) in enumerate(zip(e, e_change, lost, change, strict=True))
    ]
    return judged(stands, "observed()", f"{numbers('Q', 'R', 'l')}, first scenario, from 5 s on")


def promise(name: str) -> tuple[Claim, Check]:
    """What a block declares, and the search for a run that breaks it."""
    target = hunt(name).target
    assert isinstance(target, Declared)
    block, unit, open_ = PROMISES[name]
    claim, given = replace(target.claim, name=block), f"With {numbers(open_)}, of" if open_ else "Of"

    def sentence(result: Found) -> str:
        assert result.worst is not None
        worst = (
            f"its margin is broken by {result.worst.value:.4g} {unit}"
            if result.kind == "refuted"
            else "no run breaks it"
        )
        return f"{given} {sought(name)}, {worst}."

    return claim, searched(name, sentence)


def checks(results: Results) -> tuple[tuple[Claim, Check], ...]:
    """The comparisons as published, the same under the numbers of a1, then the promises."""
    shown = tuple((claim, uncheckable(where)) for claim, _, where in METRICS if claim is not paper.TRACKING)
    rejection = (paper.REJECTION, uncheckable("figures of runs with D, none without,"))
    published = ((paper.TRACKING, printed_tracking), *shown, rejection, (paper.ACCURACY, accuracy))
    assumed = tuple((UNDER[claim.name], ranked(results, metric)) for claim, metric, _ in METRICS)
    rest = ((UNDER[paper.REJECTION.name], rejected), (AS_READ, estimated))
    return (*published, *assumed, *rest, *(promise(name) for name in PROMISES))


UNDER = {claim.name: under(claim, f"its {metric} is below that of each rival") for claim, metric, _ in METRICS} | {
    paper.REJECTION.name: under(paper.REJECTION, "D moves its joints less than those of each rival"),
}
# 'Minimal' names no measure: this one is ours, and no comparison of the paper.
AS_READ = replace(
    under(paper.ACCURACY, "the late |qd - qd_hat| of each joint is below its late |qd - qd_d|"),
    name=f"{paper.ACCURACY.name}, as read here",
)
