"""What a9 says over the sampling period: errors and chattering, who changes places, and how long a period may be."""

import numpy as np

from studies.a9_sampling.card import CARD, PERIODS, QUIET, REALISTIC, RULE, TRACKS
from studies.a9_sampling.evidence import PLACES, ROWS, Evidence, Score, Scores, flips, printed
from studies.a9_sampling.figures import errors, variations
from studies.a9_sampling.loops import RMSE, TV
from studies.paper.card import LAWS
from studies.paper.comparison import SCENARIOS as TITLES
from workbench.study.document.document import Cell, Column, Measured, Paragraph, Reference, Section, Table

MS = f"{1e3 * REALISTIC:g} ms"
LIST = ", ".join(f"{1e3 * period:g}" for period in PERIODS)
SHOWN = {RMSE: (1e-4, 1e-3, 2e-3, 5e-3, 1e-2), TV: (1e-4, 1e-3, 5e-3, 1e-2)}  # s, as a page is wide
UNITS = {RMSE: ("rad", 1.0), TV: ("kN m/s", 1e-3)}  # with what makes them of rad and N m/s
PAIR = {"euler": "Euler", "cayley": "Cayley"}
CHAOS = (
    "Errors in brackets: the change by half the substep of the plant. Where an adaptive law chatters widely a run is "
    "chaotic, and the change tells the size of its error and bounds nothing.",
)


def computer_section() -> Section:
    """What a computer is here."""
    return Section(
        "The computer",
        (
            Paragraph(
                "Once in a period it reads q and qd, steps the memories of law and observer, and holds the torque "
                "until the next; the plant moves by Runge-Kutta steps of at most 2.5 ms in between. All memories "
                "step by explicit Euler; those of AOSMC-RGS also in another way, side by side: P by a Cayley step of "
                "(34) and its observer by one of (10), K by explicit Euler. Where no step is named, it is explicit "
                "Euler. With a delay, the torque of one instant acts from the next on. The laws, their numbers, both "
                "scenarios (FS and SS) and the horizons are those of a1; AOSMC-RGS is the repaired one, whose observer "
                "uses the true disturbance, which no instrument gives. Total "
                "variation (TV) is that of the held torque, each change of it counted; in "
                "continuous time it is taken on a grid of 1 ms. No torque is limited."
            ),
            CARD.table("assumed", "computer", "What is assumed of a realistic computer."),
        ),
    )


def periods_section(evidence: Evidence) -> Section:
    """Error and chattering over the period."""
    tables = (_over_periods(evidence, metric, scenario, joint) for metric in (RMSE, TV) for scenario, joint in PLACES)
    return Section(
        "Over the sampling period",
        (
            Paragraph(
                (
                    f"Each law at {LIST} ms, with exact readings and no delay: ",
                    Reference("rmse_periods"),
                    " and ",
                    Reference("tv_periods"),
                    ". Where a layer chatters, its torque jumps by up to 2 K each period: with a K that stays, TV "
                    "falls as 1/T and the error that chattering leaves grows as T; a K that learns from s grows with "
                    "it.",
                )
            ),
            errors(evidence),
            variations(evidence),
            *tables,
        ),
    )


def _over_periods(evidence: Evidence, metric: str, scenario: str, joint: int) -> Table:
    what, (unit, scale) = {RMSE: "rmse", TV: "tv"}[metric], UNITS[metric]
    heads = (f"{1e3 * period:g} ms" for period in SHOWN[metric])
    columns = (Column("law"), *(Column(head, unit, "right") for head in ("continuous", *heads)))
    rows = []
    for law, way, name in ROWS:
        cases = (evidence.still(metric), *(evidence.at(metric, T, stepping=way) for T in SHOWN[metric]))
        rows.append((name, *(cell(scores(law, scenario, joint), scale) for scores in cases)))
    caption = f"{metric} of joint {joint + 1} over the sampling period, {TITLES[scenario]}."
    return Table(f"{what}_{scenario.lower()}_q{joint + 1}", caption, columns, tuple(rows), CHAOS if joint else ())


def cell(score: Score, scale: float = 1.0) -> Cell:
    """A value with its error in another unit, or that the run diverged."""
    return "diverged" if np.isinf(score[0]) else Measured(scale * score[0], scale * score[1])


def places_section(evidence: Evidence) -> Section:
    """Rankings over the period."""
    chatter = [f for f in flips(evidence, TV) if f.period <= REALISTIC]
    return Section(
        "Who changes places",
        (
            _pairs(evidence),
            _flips(evidence),
            Paragraph(
                f"By TV {len(chatter)} of the {len(PLACES) * len(LAWS) * (len(LAWS) - 1) // 2} pairs have changed "
                f"places at {MS} or before."
            ),
        ),
    )


def _pairs(evidence: Evidence) -> Table:
    """What becomes of the printed pairs, by both ways to step AOSMC-RGS."""

    def cases(way: str) -> dict[str, Scores]:
        return {
            "continuous time": evidence.still(RMSE),
            **{f"{1e3 * period:g} ms": evidence.at(RMSE, period, stepping=way) for period in PERIODS},
            f"{MS}, a period late": evidence.at(RMSE, REALISTIC, delay=True, stepping=way),
            f"{MS}, noisy": evidence.at(RMSE, REALISTIC, noisy=True, stepping=way),
            f"{MS}, late and noisy": evidence.at(RMSE, REALISTIC, delay=True, noisy=True, stepping=way),
        }

    ways = [cases(way) for way in PAIR]
    rows: list[tuple[Cell, ...]] = []
    for name in ways[0]:
        found = [printed(case[name]) for case in ways]
        rows.append((name, *(n for one in found for n in (len(one.below), len(one.above), len(one.undecided)))))
    kinds = (f"{kind}, {way}" for way in PAIR.values() for kind in ("hold", "turned", "open"))
    notes = (
        "Euler, Cayley: how the memories of AOSMC-RGS step; all others step by explicit Euler. Open: closer than 2 % "
        "or both errors. A run that diverges is above all others. With noise: the mean over runs, and twice its "
        "standard error.",
    )
    caption = "The 60 pairs of the two published tables, by RMSE (43) here."
    return Table("printed_pairs", caption, (Column("run by"), *map(Column, kinds)), tuple(rows), notes)


def _flips(evidence: Evidence) -> Table:
    """The pairs of laws that change places, by both ways to step AOSMC-RGS."""
    first = [{(f.scenario, f.joint, f.better, f.worse): f.period for f in flips(evidence, RMSE, way)} for way in PAIR]
    rows = tuple(
        (scenario, joint + 1, better, worse, *(_ms(one.get((scenario, joint, better, worse))) for one in first))
        for scenario, joint, better, worse in sorted(first[0].keys() | first[1].keys())
    )
    columns = (
        *map(Column, ("scenario", "joint", "below in continuous time", "above")),
        *(Column(f"from, {way}", "ms") for way in PAIR.values()),
    )
    notes = (
        "With exact readings and with noisy ones alike, by more than 2 % and both errors. A dash: the pair keeps its "
        f"order up to {1e3 * max(PERIODS):g} ms.",
    )
    caption = "Pairs that change places by RMSE (43), and the shortest period at which they have."
    return Table("flips", caption, columns, rows, notes)


def safe_section(evidence: Evidence) -> Section:
    """The longest safe periods."""
    late = ", late"
    columns = (
        Column("law"),
        Column("rule of thumb", "ms", digits=2),
        *(
            column
            for when in ("", late)
            for column in (
                Column(f"multipliers{when}", "ms", digits=2),
                Column(f"quiet{when}", "ms", "right"),
                Column(f"keeps its error{when}", "ms", "right"),
            )
        ),
    )
    rows = tuple(
        (
            law,
            *(_ms(safe.rule), _ms(safe.multipliers), safe.quiet.text, safe.tracks.text),
            *(_ms(safe.late_multipliers), safe.late_quiet.text, safe.late_tracks.text),
        )
        for law, safe in evidence.safe.items()
    )
    notes = (
        "A dash: no gain K. With exact readings. The runs of the search take the "
        "longer of the two substeps, whose errors are in the tables above. Below 10 ms the next "
        "periods tried are 5 and 3.3 ms.",
    )
    caption = "The longest safe period of each law, without delay and with a torque that is a period late."
    return Section("The longest safe period", (_what_is_safe(), Table("safe", caption, columns, rows, notes)))


def _what_is_safe() -> Paragraph:
    return Paragraph(
        (
            f"Quiet: TV at most {QUIET:g} times that in continuous time, at both joints, in both scenarios. Keeps its "
            f"error: RMSE (43) at most {TRACKS:g} times. Both by bisection on runs over the periods 10 ms / m from "
            "0.02 ms on, to 12 % or two neighbours; it takes for granted that every period shorter than a safe one is "
            "safe. All memories step by explicit Euler. The rule of thumb is the least ",
            RULE,
            " along the runs in continuous time, of the least eigenvalue of M and the largest gain. The multipliers "
            "are those of the exact Jacobian along them, where the law is within its layer and its gains are frozen: "
            "the plant by exp(A T), the law and its observer by explicit Euler; the longest period at which no mode "
            "faster than an eighth of the sampling rate grows.",
        )
    )


def _ms(seconds: float | None) -> float | None:
    return None if seconds is None else 1e3 * seconds
