"""What a9 says over the sampling period: errors and chattering, who changes places, and how long a period may be."""

import numpy as np
from linear_loops import SEVEN
from paper_card import LAWS
from paper_comparison import SCENARIOS as TITLES
from sampling_card import CARD, PERIODS, QUIET, REALISTIC, RULE, TRACKS
from sampling_evidence import PLACES, Evidence, Score, flips, printed
from sampling_figures import errors, variations
from sampling_loops import RMSE, TV

from workbench.study.document import Cell, Column, Measured, Paragraph, Reference, Section, Table

MS = f"{1e3 * REALISTIC:g} ms"
LIST = ", ".join(f"{1e3 * period:g}" for period in PERIODS)
SHOWN = {RMSE: (1e-4, 1e-3, 2e-3, 5e-3, 1e-2), TV: (1e-4, 1e-3, 5e-3, 1e-2)}  # s, as a page is wide
UNITS = {RMSE: ("rad", 1.0), TV: ("kN m/s", 1e-3)}  # with what makes them of rad and N m/s
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
                "Once in a period it reads q and qd, moves its law and its observer on by one explicit Euler step, and "
                "holds the torque until the next; the plant moves by Runge-Kutta steps of at most 2.5 ms in between. "
                "With a delay, the torque of one instant acts from the next on. The laws, their numbers, both "
                "scenarios (FS and SS) and the horizons are those of a1; AOSMC-RGS is the repaired one, and is told "
                "the true disturbance. Total variation (TV) is that of the held torque, each change of it counted; in "
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
    cases = (evidence.still(metric), *(evidence.at(metric, period) for period in SHOWN[metric]))
    rows = tuple((law, *(cell(scores(law, scenario, joint), scale) for scores in cases)) for law in SEVEN)
    caption = f"{metric} of joint {joint + 1} over the sampling period, {TITLES[scenario]}."
    return Table(f"{what}_{scenario.lower()}_q{joint + 1}", caption, columns, rows, CHAOS if joint else ())


def cell(score: Score, scale: float = 1.0) -> Cell:
    """A value with its error in another unit, or that the run diverged."""
    return "diverged" if np.isinf(score[0]) else Measured(scale * score[0], scale * score[1])


def places_section(evidence: Evidence) -> Section:
    """Rankings over the period."""
    cases = {
        "continuous time": evidence.still(RMSE),
        **{f"{1e3 * period:g} ms": evidence.at(RMSE, period) for period in PERIODS},
        f"{MS}, a period late": evidence.at(RMSE, REALISTIC, delay=True),
        f"{MS}, noisy": evidence.at(RMSE, REALISTIC, noisy=True),
        f"{MS}, late and noisy": evidence.at(RMSE, REALISTIC, delay=True, noisy=True),
    }
    counts = []
    for name, scores in cases.items():
        found = printed(scores)
        counts.append((name, len(found.below), len(found.above), len(found.undecided)))
    turned = tuple((f.scenario, f.joint + 1, f.better, f.worse, 1e3 * f.period) for f in flips(evidence, RMSE))
    chatter = [f for f in flips(evidence, TV) if f.period <= REALISTIC]
    return Section(
        "Who changes places",
        (
            Table(
                "printed_pairs",
                "The 60 pairs of the two published tables, by RMSE (43) here.",
                (Column("run by"), Column("hold"), Column("turned"), Column("open")),
                tuple(counts),
                (
                    "Open: closer than 2 % or both errors. A run that diverges is above all others. With noise: the "
                    "mean over runs, and twice its standard error.",
                ),
            ),
            Table(
                "flips",
                "Pairs that change places by RMSE (43), and the shortest period at which they have.",
                (
                    Column("scenario"),
                    Column("joint"),
                    Column("below in continuous time"),
                    Column("above"),
                    Column("from", "ms"),
                ),
                turned,
                ("Both with exact readings and with noisy ones, by more than 2 % and both errors.",),
            ),
            Paragraph(
                f"By TV {len(chatter)} of the {len(PLACES) * len(LAWS) * (len(LAWS) - 1) // 2} pairs have changed "
                f"places at {MS} or before."
            ),
        ),
    )


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
            "0.02 ms on, to 12 % or two neighbours, as if what is safe at a period were so at all shorter ones. The "
            "rule of thumb is the least ",
            RULE,
            " along the runs in continuous time, of the least eigenvalue of M and the largest gain. The multipliers "
            "are those of the exact Jacobian along them, where the law is within its layer and its gains are frozen: "
            "the plant by exp(A T), the law and its observer by explicit Euler; the longest period at which no mode "
            "faster than an eighth of the sampling rate grows.",
        )
    )


def _ms(seconds: float | None) -> float | None:
    return None if seconds is None else 1e3 * seconds
