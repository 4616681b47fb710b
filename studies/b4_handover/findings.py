"""The findings of b4 on periods and errors, each with the variations of its answer."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

import workbench as wb
from studies.b4_handover.loops import (
    ERROR,
    FAR_START,
    NEAR_START,
    STATISTICS,
    TRANSIENT_SHARE,
    HandoverLoop,
    handover_loops,
)
from studies.b4_handover.margins import (
    BOTH,
    DRAWS,
    JITTER,
    MEAN,
    MISSED_SHARE,
    NEAR,
    OVER_DRAWS,
    Loss,
    Losses,
    losses,
    margins,
    quiet_periods,
    scans,
)
from studies.paper.card import PROPOSED_LAW
from studies.paper.period_rules import HALF, MATRIX
from studies.paper.quiet_periods import (
    COMMANDED_TORQUE,
    FACTORS,
    HANDED_OVER,
    ON_REFERENCE,
    PAPERS,
    QUIET,
    at_hand_over,
    bracket_words,
    conditions,
    ends,
    in_ms,
)

INFORMATION = (
    "AOSMC-RGS, SMC, super-twisting: positions, velocities and the exact model. PID: positions and velocities. LQG: "
    "positions, velocities and the linear model at the pose. EKF + LQR: position, angle and the exact model. "
    "AOSMC-RGS estimates the disturbance."
)
HANDED = "handed"  # the table of what is handed over
FITS = "AOSMC-RGS: Q and R to the paper's printed RMSE (a1). The other laws: nothing."
CLOCK = f"jitter of {100 * JITTER:g} % of the period and {100 * MISSED_SHARE:g} % missed periods"
QUIET_MEANING = f"Quiet: the total variation of the commands is at most {QUIET:g} times that in continuous time."
START_WORDS = {NEAR_START: "near start", FAR_START: "far start"}
PATHS = {NEAR_START: ON_REFERENCE, FAR_START: PAPERS}  # the starts of the paper's laws, as a9 calls them
PARTS = {"single": "single precision alone", "jitter": "jitter alone", "missed_periods": "missed periods alone"}
PARTS |= {"readings": "the quantisation of the readings alone, compared with exact readings"}


def assumptions(more: str) -> wb.document.Phrase:
    """The assumptions of each finding on a computer, and those that one finding has `more`."""
    return ("Periods, delay, limits and quantisation of the readings as in ", wb.document.CrossReference(HANDED), more)


def loss_words(loss: Loss) -> str:
    """A loss in per cent, with two digits."""
    return f"{100 * loss.value:.2g} %".replace("-", "\N{MINUS SIGN}") if np.isfinite(loss.value) else "a whole run"


def amount(value: float, unit: str) -> str:
    """A length or an angle with three digits, in millionths of its unit if it is small."""
    return f"{1e6 * value:.3g} \N{MICRO SIGN}{unit}" if value < 1e-3 else f"{value:.3g} {unit}"


# The longest period


def _allowed_from(results: wb.Results, start: str, one: HandoverLoop) -> float:
    return allowed_period(results, one, start)


def allowed_period(results: wb.Results, one: HandoverLoop, start: str = NEAR_START) -> float:
    """The longest period allowed in s, of a loop from a start."""
    scan = scans(results).periods.get((one.key, start))
    return scan.threshold.largest if scan else ends(quiet_periods(results)[one.name, PATHS[start]])[0]


def declared_too_long(longest: Callable[[HandoverLoop], float]) -> list[str]:
    """The laws whose declared period is longer than a period that is given by loop."""
    return [one.name for one in handover_loops() if longest(one) < one.period]


def longest_period(results: wb.Results) -> wb.Finding:
    """The longest period and the declared one, by start."""
    quiet = quiet_periods(results)
    near, far = (quiet[PROPOSED_LAW, start] for start in (ON_REFERENCE, PAPERS))
    variations = [wb.Variation(conditions(near.search), at_hand_over(near), f"{bracket_words(ends(near))} ms")]
    variations += [
        wb.Variation(
            f"{conditions(one.search)}, at most {factor:g} times the total variation",
            at_hand_over(one, factor),
            f"{bracket_words(ends(one, factor))} ms",
        )
        for one in (far, near)
        for factor in FACTORS
    ]
    variations += [
        wb.Variation(conditions(one.search), at_hand_over(one), f"{bracket_words(ends(one))} ms")
        for one in results.work("quiet")
        if one.search.law == PROPOSED_LAW and (one.search.limit is not None or one.search.counts_on == COMMANDED_TORQUE)
    ]
    too_long = [wb.document.join_names(declared_too_long(partial(_allowed_from, results, start))) for start in BOTH]
    return wb.Finding(
        "longest_period",
        f"With commands a period late, {PROPOSED_LAW} is quiet up to {in_ms(ends(near))} ms from a start on the "
        f"reference but up to {in_ms(ends(far))} ms from the paper's start; its declared period is "
        f"{1e3 * HANDED_OVER:g} ms.",
        (
            f"{QUIET_MEANING} The limit follows from ρ, the largest eigenvalue of ",
            MATRIX,
            ", which grows with the error at the start. The least ",
            HALF,
            f" along the run is {1e3 * (near.rule or 0):.3g} ms from the reference and {1e3 * (far.rule or 0):.3g} ms "
            "from the paper's start. Laws for which the declared period is too long: "
            f"{too_long[0]} from the near start, {too_long[1]} from the far start.",
        ),
        statistic="The longest period allowed, with commands a period late and exact readings. Laws of the paper's "
        f"arm: the search of a9, with a total variation of at most {QUIET:g} times its value in continuous time. "
        f"LQG and EKF + LQR, designed anew for each period: error at most {wb.evidence.KEEPS_RATIO:g} and total "
        f"variation at most {QUIET:g} times their values at a quarter of the declared period.",
        sample="One run for each period, with exact readings; the first scenario for the laws of the paper's arm.",
        information=INFORMATION,
        assumptions=assumptions(
            "; both limits; the far starts of LQG and of the cart-pole. The observer of the momentum uses the torque "
            "that acts, which is a period late."
        ),
        fitted_numbers=FITS,
        answer=at_hand_over(far),
        variations=tuple(variations),
        limitations="Noise in the readings.",
        cites=("a9_sampling/longest_period",),
    )


# Errors


def all_losses(
    results: wb.Results, metric: str = ERROR, start: str = NEAR_START, joint: int | None = None, over: str = MEAN
) -> dict[str, Losses]:
    """The losses by the name of the loop."""
    return {one.name: losses(results, one, metric, start, joint, over) for one in handover_loops()}


def worst_loop(by: dict[str, Losses], part: str = "together") -> str:
    """The loop whose error grows most."""
    return max(by, key=lambda name: getattr(by[name], part).value)


def error_of(results: wb.Results, name: str, metric: str = ERROR, start: str = NEAR_START) -> tuple[float, float, str]:
    """The error of a loop with a perfect clock, the quantisation step of the reading, and the unit of both."""
    one = next(one for one in handover_loops() if one.name == name)
    unit = one.near(one.period).plant.outputs[one.follows].unit
    base = margins(results, one, metric=metric, start=start).without.mean(axis=0)
    return float(base.max()), one.quantum[one.follows], unit


def loss_variations(results: wb.Results) -> Iterator[wb.Variation]:
    """The loop whose error grows most, by other starts, statistics, joints, averages over the runs, and effects."""
    for start in BOTH:
        for metric in STATISTICS:
            if (start, metric) != (NEAR_START, ERROR):
                yield worst_variation(f"{metric}, {START_WORDS[start]}", all_losses(results, metric, start))
    for joint in (0, 1):
        yield worst_variation(f"joint {joint + 1} alone", all_losses(results, joint=joint))
    for over in OVER_DRAWS:
        if over != MEAN:
            yield worst_variation(f"the {over} over the runs", all_losses(results, over=over))
    for part, words in PARTS.items():
        yield worst_variation(words, all_losses(results), part)


def worst_variation(words: str, by: dict[str, Losses], part: str = "together") -> wb.Variation:
    """A variation of the loop whose error grows most."""
    worst = worst_loop(by, part)
    return wb.Variation(words, worst, loss_words(getattr(by[worst], part)))


def loss_finding(results: wb.Results) -> wb.Finding:
    """The growth of the error by single precision and an imperfect clock."""
    by = all_losses(results)
    worst = worst_loop(by)
    others = max((one.together for name, one in by.items() if name != worst), key=lambda loss: loss.value)
    error, step, unit = error_of(results, worst)
    grown = error * (1 + by[worst].together.value)
    far = all_losses(results, start=FAR_START)[worst].together
    chattering = declared_too_long(lambda one: allowed_period(results, one, FAR_START))
    unsound = (
        f" From the far start, the runs of {wb.document.join_names(chattering)} with a perfect clock chatter, and are "
        "no sound base for a ratio."
    ) * bool(chattering)
    return wb.Finding(
        "error_growth",
        f"Single precision, {CLOCK} together raise the error of {worst} most: by {loss_words(by[worst].together)}, "
        f"from {amount(error, unit)} to {amount(grown, unit)}. They raise the error of the other loops by at most "
        f"{loss_words(others)}.",
        f"The quantisation step of the readings is {amount(step, unit)}, {step / error:.2g} times the "
        f"{amount(error, unit)}. From the far start "
        f"{f'{worst} chatters at its declared period, and ' * (worst in chattering)}the error is "
        f"{amount(error_of(results, worst, start=FAR_START)[0], unit)} and changes by {loss_words(far)}.",
        statistic=f"{ERROR.capitalize()}: the root mean square of the error from {100 * TRANSIENT_SHARE:.0f} % of the "
        "run on, at the worst joint. It is divided by that of the run from the same start in double precision with a "
        f"perfect clock; the ratios are averaged over the runs.{unsound}",
        sample=f"Six loops, {DRAWS} starts within {NEAR:g} rad or m of the near start, each with its own jitter.",
        information=INFORMATION,
        assumptions=assumptions(f"; the statistic; the starts; {CLOCK}."),
        fitted_numbers=FITS,
        answer=worst,
        variations=tuple(loss_variations(results)),
        limitations="Noise in the readings, longer periods, missed periods in bursts.",
    )
