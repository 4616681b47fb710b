"""The findings of b4, each a sentence with its figures."""

from __future__ import annotations

import numpy as np

from studies.b4_handover.loops import ERROR, SETTLED, handed
from studies.b4_handover.margins import DRAWS, JITTER, MISSED, NEAR, QUIET, Loss, Losses, losses, margins, scans
from workbench.study import Results, Verdict
from workbench.study.evidence import Threshold
from workbench.study.evidence.computer_margins import KEPT

GIVEN = (
    "AOSMC-RGS, SMC, super-twisting: positions, velocities and the exact model. PID: no model. LQG: the linear model "
)
GIVEN += (
    "at the pose. EKF and LQR: position and angle, and the exact model. AOSMC-RGS estimates the disturbance itself."
)
ESTIMAND = f"{ERROR}: the root of the mean square from {100 * SETTLED:.0f} % of the run on, the worst joint, mean over "
ESTIMAND += f"{DRAWS} starts within {NEAR:g} of each loop's own, paired"
CLOCK = f"jitter of {100 * JITTER:g} % of the period and {100 * MISSED:g} % missed periods"


def findings(results: Results) -> tuple[Verdict, ...]:
    """All findings."""
    return (loss_finding(results), precision_finding(results), clock_finding(results), period_finding(results))


def percent(loss: Loss) -> str:
    """A loss in per cent, with two digits."""
    return f"{100 * loss.value:.2g} %".replace("-", "\N{MINUS SIGN}") if np.isfinite(loss.value) else "a whole run"


def all_losses(results: Results) -> dict[str, Losses]:
    """The losses by the name of the loop."""
    return {one.name: losses(results, one) for one in handed()}


def loss_finding(results: Results) -> Verdict:
    """All that leaving double precision and a perfect clock costs."""
    by = all_losses(results)
    worst = max(by, key=lambda name: by[name].together.value)
    within = [name for name, one in by.items() if one.together.value <= KEPT - 1]
    each = "; ".join(f"{name} {percent(one.together)}" for name, one in by.items())
    error, step, unit = sizes(results, worst)
    return Verdict(
        "found",
        f"Without double precision and a perfect clock {len(within)} of {len(by)} loops keep their error within "
        f"{100 * (KEPT - 1):.0f} %; most is lost by {worst}, {percent(by[worst].together)}.",
        f"Single precision with {CLOCK}, over double precision and a perfect clock, with the same readings: {each}. "
        f"Without them the error of {worst} is {error:.2g} {unit}, and the step of its readings {step:.2g} {unit}.",
        estimand=f"{ESTIMAND}, each with its own jitter.",
        given=GIVEN,
        reversal="A longer period, or the misses of a computer that is busier than declared.",
    )


def sizes(results: Results, name: str) -> tuple[float, float, str]:
    """The error of a loop with a perfect clock, the step of the reading that it is of, and their unit."""
    one = next(one for one in handed() if one.name == name)
    unit = one.made(one.period).plant.outputs[one.follows].unit
    return float(margins(results, one).without.mean(axis=0).max()), one.quantum[one.follows], unit


def precision_finding(results: Results) -> Verdict:
    """The part of single precision."""
    by = all_losses(results)
    worst = max(by, key=lambda name: abs(by[name].single.value))
    coarse = max(by, key=lambda name: abs(by[name].readings.value))
    return Verdict(
        "found",
        f"Single precision by itself changes the error most for {worst}, by {percent(by[worst].single)}; the steps of "
        f"the readings most for {coarse}, by {percent(by[coarse].readings)}.",
        "Single precision: each operation of the law rounded to 24 bits, its memory and readings too, over double "
        "precision with the same readings. Steps of the readings: over exact ones, both in double precision.",
        estimand=f"{ESTIMAND}, with a perfect clock.",
        given=GIVEN,
        reversal="A period so short that what the memory gains in it is less than its last bit, or readings of more "
        "than 24 bits.",
    )


def clock_finding(results: Results) -> Verdict:
    """The part of the clock, and the effects that end a loop first."""
    reach = {
        one.name: {each.effect.name: each.largest(KEPT) for each in margins(results, one).each} for one in handed()
    }
    missed = {name: own["missed periods"] for name, own in reach.items()}
    jitter = {one.name: reach[one.name]["jitter"] / one.period for one in handed()}
    frail, steady = min(missed, key=missed.__getitem__), max(missed, key=missed.__getitem__)
    listed = "; ".join(f"{name} {100 * missed[name]:.3g} % and {100 * jitter[name]:.3g} %" for name in missed)
    return Verdict(
        "found",
        f"{frail} keeps its error within {100 * (KEPT - 1):.0f} % up to {100 * missed[frail]:.3g} % missed periods, "
        f"{steady} up to {100 * missed[steady]:.3g} %.",
        "The largest level of each by itself up to which no run is worse, missed periods and jitter in parts of the "
        f"period: {listed}.",
        estimand=f"{ESTIMAND.replace(', mean over', ', each of')}, at rising levels; in double precision.",
        given=GIVEN,
        reversal="Misses that come in bursts: here each period is missed by itself.",
    )


def period_finding(results: Results) -> Verdict:
    """The longest period, beside the declared one."""
    found = {key: scan.threshold for key, scan in scans(results).periods.items()}
    room = {one.name: found[one.key].largest / one.period for one in handed()}
    least = min(room, key=room.__getitem__)
    short = [name for name, ratio in room.items() if ratio < 1]
    listed = "; ".join(f"{one.name} {milliseconds(found[one.key])}" for one in handed())
    return Verdict(
        "holds" if not short else "fails",
        f"The declared period is within what sampling allows for all {len(room)} loops."
        if not short
        else f"The declared period is longer than sampling allows for {', '.join(short)}.",
        f"The longest period found: {listed}. Least room: {least}, {room[least]:.2f} times its own.",
        estimand=f"Rising periods: error at most {KEPT:g} and total variation at most {QUIET:g} times those of a "
        "quarter of the declared period, with exact readings and commands a period late; one run each.",
        given=f"{GIVEN} LQG and EKF are designed anew for each period.",
        reversal="Larger gains, as AOSMC-RGS learns them from a start that is farther off: from that of a1, a9 finds "
        "much shorter periods for it.",
    )


def milliseconds(found: Threshold) -> str:
    """The longest period in ms, and that no longer one was tried if that is so."""
    return f"{1e3 * found.largest:.3g} ms{' or more' if np.isinf(found.next) else ''}"
