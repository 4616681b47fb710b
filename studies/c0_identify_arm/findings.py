"""The findings of c0 on estimates: what the logs tell, and how biased others are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

import workbench as wb
from studies.c0_identify_arm.answers import FEW, REPEATED
from studies.c0_identify_arm.arm import BASE, FREE, ODD, SPAN, TRUTH, WORDS, Conditions
from studies.c0_identify_arm.estimates import CUTOFFS, RepeatedFits
from studies.c0_identify_arm.judgement import (
    MISLED,
    SMALL,
    TOLD,
    Evidence,
    digits,
    of_base_numbers,
    of_output_errors,
    of_regressions,
    verdict,
    words_of,
)
from studies.c0_identify_arm.logs import limit_of

ENCODER = "Readings of encoders of 12 bits with noise of half a step, and the torques that the computer commands."
SIMULATED = "The arm is simulated by the equations that are fitted: no flexible joints, no other friction."


# What the logs tell


def largest_share(evidence: Evidence) -> float:
    """The largest standard error of the first log, in parts of the true number."""
    return float((evidence.law.fit.errors / np.abs(TRUTH)).max())


def told_by_the_law(evidence: Evidence) -> wb.Finding:
    """The numbers that the log under the law tells."""
    base = evidence.law_repeats[BASE.name]
    held = of_output_errors(base)
    misled = [case for case in ODD if verdict(evidence.law_repeats[case.name], case.true_values) == MISLED]
    warned = [case for case in misled if evidence.law_repeats[case.name].has_warning.all()]
    variations = [
        wb.Variation(f"{log}: {case.words}", verdict(repeats[case.name], case.true_values), case_words(repeats, case))
        for log, repeats in (("law's log", evidence.law_repeats), ("designed log", evidence.designed_repeats))
        for case in (BASE, *ODD)
        if case.name in repeats and not (case is BASE and repeats is evidence.law_repeats)
    ]
    return wb.Finding(
        name="told_by_the_law",
        statement=f"A log of {SPAN:g} s under AOSMC-RGS tells all {len(FREE)} numbers of the arm; the largest standard "
        f"error is {digits(100 * largest_share(evidence))} % of its number."
        if verdict(base, TRUTH) == TOLD
        else f"The numbers that a log of {SPAN:g} s under AOSMC-RGS gives: {verdict(base, TRUTH)}.",
        evidence=f"In {held.count} logs, {100 * held.coverage.min():.0f} to {100 * held.coverage.max():.0f} % of the "
        f"95 % intervals hold the true number. Of {len(misled)} conditions that mislead the fit, {len(warned)} "
        "warn in each log. With gravity unknown, the scale of lengths and masses is told by no log.",
        statistic="The squared distance of the estimates from the truth, in their own covariance, summed over logs; a "
        "sum beyond chance at 99.9 % misleads. Not all is told if a standard error is above half of its number.",
        sample=f"{REPEATED} logs with new noise, and {FEW} under each other condition.",
        information=ENCODER,
        assumptions=f"Gravity, the smoothing speed of Coulomb friction and the noise are known. {SIMULATED}",
        fitted_numbers="Two masses, two lengths, two viscous and two Coulomb frictions.",
        answer=verdict(base, TRUTH),
        variations=tuple(variations),
        limitations="Real friction, drives whose torque is not the command, and elastic joints.",
    )


def case_words(repeats: Mapping[str, RepeatedFits], case: Conditions) -> str:
    """The largest error under some conditions, and whether the fits warn."""
    return words_of(repeats[case.name], case.true_values)


# The designed excitation


def error_ratios(evidence: Evidence) -> wb.Array:
    """The mean standard errors of the law's logs over those of the designed logs, number by number."""
    law, designed = (of_output_errors(one[BASE.name]) for one in (evidence.law_repeats, evidence.designed_repeats))
    return np.asarray(law.mean_errors / designed.mean_errors)


def mean_ratio(evidence: Evidence) -> float:
    """Their geometric mean."""
    return float(np.exp(np.log(error_ratios(evidence)).mean()))


def broken_limits(evidence: Evidence) -> list[str]:
    """The limits of the design that the true arm goes beyond, with the share of the limit."""
    return [
        f"{name} by {digits(100 * (value / limit_of(name) - 1))} %"
        for name, value in evidence.designed_log.largest_sizes
        if value > limit_of(name)
    ]


def shorter(ratio: float) -> str:
    """The log with the smaller errors."""
    return "the designed log" if ratio > 1 + SMALL else "the law's log" if ratio < 1 - SMALL else "neither"


def excitation(evidence: Evidence) -> wb.Finding:
    """The worth of a designed excitation beside the log under the law."""
    ratios, plan = error_ratios(evidence), evidence.designed_log.plan
    spreads = (
        of_output_errors(evidence.law_repeats[BASE.name]).spread
        / of_output_errors(evidence.designed_repeats[BASE.name]).spread
    )
    blind = evidence.law.fit.errors / evidence.blind.fit.errors
    single = evidence.law.fit.errors / evidence.designed_log.fit.errors
    promised = (
        np.abs(TRUTH) * of_output_errors(evidence.designed_repeats[BASE.name]).mean_errors / np.array(plan.errors)
    )
    means = {
        "by the spread of the estimates of repeated logs": spreads,
        "of one log of each kind, without the last second, which is held out": single,
        "the same, with an excitation designed for the arm of the paper, before any log": blind,
    }
    variations = [
        *(wb.Variation(f"{WORDS[name]} alone", shorter(r), f"{r:.2g}") for name, r in zip(FREE, ratios, strict=True)),
        *(
            wb.Variation(words, shorter(m), f"{m:.2g}")
            for words, m in ((w, float(np.exp(np.log(r).mean()))) for w, r in means.items())
        ),
    ]
    beyond, count = broken_limits(evidence), len(evidence.designed_log.largest_sizes)
    plain = " and ".join(f"{ratio:.2g} times as large after {kind}" for kind, ratio in plan.plain)
    return wb.Finding(
        name="designed_excitation",
        statement=f"A designed excitation of the same length has standard errors that are smaller by a factor of "
        f"{mean_ratio(evidence):.1f} in the geometric mean, from {ratios.min():.1f} to {ratios.max():.1f}.",
        evidence=f"The errors that the design promises are met by those of the fits: their ratios are "
        f"{promised.min():.3f} to {promised.max():.3f}. Within the same limits, mean errors are {plain}. The true arm "
        f"goes beyond {len(beyond)} of {count} limits{': ' if beyond else ''}{', '.join(beyond)}.",
        statistic="The ratio of the mean standard errors, number by number, and its geometric mean.",
        sample=f"{REPEATED} logs of each kind.",
        information=ENCODER,
        assumptions="The limits of position, velocity and torque of the design. The law's log keeps those of position "
        "and velocity; its drives may give more torque.",
        fitted_numbers="The harmonics of both torques, for the arm that the law's log gave.",
        answer=shorter(mean_ratio(evidence)),
        variations=tuple(variations),
        limitations="Other limits, other lengths, and a law with less chattering, which excites less.",
    )


# Bias


def unbiased_estimators(evidence: Evidence, log: str) -> str:
    """The estimators without significant bias on a log."""
    repeats = evidence.law_repeats if log == "law" else evidence.designed_repeats
    fits = {"output errors": of_base_numbers(repeats[BASE.name])}
    fits |= {f"regression at {c:g} Hz": of_regressions(evidence.regressions[log, c]) for c in CUTOFFS}
    return wb.document.join_names([words for words, one in fits.items() if one.is_unbiased]) or "none"


def worst_bias(evidence: Evidence, log: str, cutoff: float) -> float:
    """The largest relative bias of the inertias and moments of a regression."""
    return float(np.abs(of_regressions(evidence.regressions[log, cutoff]).bias[:4]).max())


def bias(evidence: Evidence) -> wb.Finding:
    """The bias of the regression of torques in the closed loop, beside output errors."""
    by_log = {
        log: ", ".join(f"{digits(100 * worst_bias(evidence, log, c))} % at {c:g} Hz" for c in CUTOFFS)
        for log in ("law", "designed")
    }
    least = {c: of_regressions(evidence.regressions["law", c]).coverage.min() for c in CUTOFFS}
    return wb.Finding(
        name="bias_in_the_loop",
        statement=f"Without significant bias on the law's log: {unbiased_estimators(evidence, 'law')}. A regression of "
        f"the torques is off in inertias and moments by up to {by_log['law']}, the cutoff of its filter.",
        evidence=f"On the designed log, which no reading changes, the same figures are {by_log['designed']}. "
        "On the law's log, the regressions' 95 % intervals hold the truth of the worst number in "
        + ", ".join(f"{100 * share:.0f} % at {c:g} Hz" for c, share in least.items())
        + ".",
        statistic="The mean of the estimates less the truth; significant beyond 3.3 standard errors of the mean.",
        sample=f"{REPEATED} logs of each kind, the same for all estimators.",
        information=ENCODER,
        assumptions="The regression knows the smoothing speed of Coulomb friction, and that a torque is held for a "
        f"period. {SIMULATED}",
        fitted_numbers="Base parameters and frictions.",
        answer=unbiased_estimators(evidence, "law"),
        variations=(
            wb.Variation("on the designed log", unbiased_estimators(evidence, "designed"), by_log["designed"]),
        ),
        limitations="Lower cutoffs, finer encoders and measured velocities, with which a regression does better.",
    )
