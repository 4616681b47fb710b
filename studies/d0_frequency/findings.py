"""The findings of d0: where linear answers hold for the nonlinear loops, and where they mislead."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

import workbench as wb
from studies.d0_frequency.limit_cycles import PERIODS, PUSHES, QUIET, LimitCycle
from studies.d0_frequency.loops import CONTINUOUS, LAYER_LAWS, RUN_POSES, RUNS, AtPose
from studies.d0_frequency.margin_findings import one_channel
from studies.d0_frequency.period_limits import STARTS, PeriodLimit, limits
from studies.d0_frequency.rest_answers import rests
from studies.d0_frequency.step_sizes import SIZE_POSES, settlings
from studies.d0_frequency.tables import MINUS, number, span
from studies.paper.card import LAWS, PROPOSED_LAW
from studies.paper.linearization import LEVEL

INFORMATION = (
    "AOSMC-RGS: only positions. Other laws: exact positions and velocities. All laws but PID: the exact model."
)
ASSUMPTIONS = (
    "The numbers of the laws as in report a1; in the linear loop adaptive gains are constant at K(0); starts and poses."
)
FITS = "Q and R of AOSMC-RGS, to its printed RMSE (report a1)."
INSIDE = (0.97, 1.03)  # shares of the predicted period between which the limit of the runs lies if both agree
WIDER = (0.8, 1.25)
FAR = "a start 0.3 rad from equilibrium"
HOLD = 1.5  # periods of delay that a computer adds whose torque comes a period late
CLOSE = 0.1  # of the settling time


def findings(results: wb.Results) -> tuple[wb.Finding, ...]:
    """All findings, those on periods first."""
    return tuple(one(results) for one in (period_limit, delay_rule, step_size, one_channel, limit_cycle))


def answer(results: wb.Results) -> str:
    """The answer of the page in one line."""
    every = limits(results)
    small = agreement_count(every, RUNS, "small")
    ratio = over_rule(results)
    size = valid_size(results)
    laws = sorted(ratio, key=lambda law: -max(ratio[law]))
    return (
        f"In {small} loops near equilibrium, chattering begins within 3 % of the sampling period that linear models "
        f"predict; delay margins overestimate this period up to {number(max(ratio[laws[0]]))}-fold. Settling times "
        f"hold within {100 * CLOSE:g} % up to {number(1e3 * size)} mrad from equilibrium."
    )


def agreement_count(
    every: Mapping[AtPose, PeriodLimit], some: Iterable[AtPose], start: str, inside: tuple[float, float] = INSIDE
) -> str:
    """The loops whose runs rest up to the lower share of the predicted period, and no longer at the higher one."""
    held = [every[one].ends(start) for one in some]
    count = sum(low >= inside[0] and high <= inside[1] for low, high in held)
    return f"{count} of {len(held)}"


def learned_gain_count(every: Mapping[AtPose, PeriodLimit], start: str) -> str:
    """The loops whose limit the linear map foretells with the gain that the run has learned."""
    verdicts = [one.learned_gain_agrees[list(STARTS).index(start)] for one in every.values()]
    held = [verdict for verdict in verdicts if verdict is not None]
    return f"{sum(held)} of {len(held)}"


def period_limit(results: wb.Results) -> wb.Finding:
    """The linear map of the period beside runs from rest."""
    every = limits(results)
    small, large = (agreement_count(every, RUNS, start) for start in STARTS)
    earlier = [one for one in RUNS if every[one].ends("large")[1] < 1]
    later = [one for one in RUNS if every[one].ends("large")[0] > 1]
    variations = [
        wb.Variation(FAR, large, f"a shorter period in {len(earlier)} loops, a longer one in {len(later)}"),
        wb.Variation(
            f"{FAR}, linear loops with the learned gain, where one is learned", learned_gain_count(every, "large")
        ),
        *(
            wb.Variation(f"only {law}", agreement_count(every, [one for one in RUNS if one.law == law], "small"))
            for law in LAWS
        ),
        wb.Variation(
            f"{FAR}, between {WIDER[0]:g} and {WIDER[1]:g} times the predicted period",
            agreement_count(every, RUNS, "large", WIDER),
        ),
    ]
    whole = small.split(" of ")
    return wb.Finding(
        name="longest_period",
        statement=f"In {small} loops a run that starts 10 µrad from equilibrium comes to rest up to {INSIDE[0]:g} "
        f"times the sampling period at which the linear loop becomes unstable, but not at {INSIDE[1]:g} times. From "
        f"{FAR} this holds in {large} loops.",
        evidence="From 0.3 rad the adaptive gains end at other values than K(0). If linearised with the gain that the "
        f"run has learned, {learned_gain_count(every, 'large')} loops that learn a gain are stable at the longest "
        "period at which the run comes to rest, and unstable at the next period tried.",
        statistic="The longest period at which the torque comes to rest, divided by the period at which a pole of the "
        "linear loop reaches the unit circle. The torque is at rest if its total variation is below 10 N m/s after "
        "6 s.",
        sample=f"{len(LAWS)} laws at {len(RUN_POSES)} poses ({', '.join(RUN_POSES)}), one run each, with the torque "
        "one period late and exact readings.",
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        fitted_numbers=FITS,
        answer="all" if whole[0] == whole[1] else small,
        variations=tuple(
            wb.Variation(v.words, "all" if len(set(v.answer.split(" of "))) == 1 else v.answer, v.detail)
            for v in variations
        ),
        limitations="Noise in the readings, with which a loop near its limit does not come to rest.",
    )


def over_rule(results: wb.Results) -> dict[str, list[float]]:
    """By law and pose the period that the delay margin promises, over the one that the linear map has."""
    held, every = rests(results), limits(results)
    return {
        law: [held[AtPose(law, pose)][CONTINUOUS].delay / HOLD / every[AtPose(law, pose)].limit for pose in RUN_POSES]
        for law in LAWS
    }


def delay_rule(results: wb.Results) -> wb.Finding:
    """The delay margin as a rule for the period of a computer."""
    ratio = over_rule(results)
    worst = max(ratio, key=lambda law: max(ratio[law]))
    others = {law: ratio[law] for law in LAWS if law != worst}
    variations = [
        wb.Variation(
            f"the pose '{pose}'",
            max(LAWS, key=lambda law: ratio[law][place]),
            f"{number(max(ratio[law][place] for law in LAWS))} times",
        )
        for place, pose in enumerate(RUN_POSES)
    ]
    second = max(others, key=lambda law: max(others[law]))
    variations.append(wb.Variation(f"without {worst}", second, f"{number(max(others[second]))} times"))
    return wb.Finding(
        name="delay_margin_as_a_rule",
        statement=f"The delay margin of continuous time, divided by {HOLD:g}, is {span(ratio[worst])} times the "
        f"longest stable sampling period for {worst}, and {span(r for law in others for r in others[law])} times for "
        "the other laws.",
        evidence="A torque that acts one period late, and is then held for one period, is late by 1.5 periods. The "
        f"margin of {PROPOSED_LAW} is for a delay that its observer does not know. A computer also samples the loop "
        "between law and observer, which no margin at the torque shows.",
        statistic="Delay margin of the worse joint, divided by 1.5 and by the period at which the linear loop becomes "
        "unstable. The answer is the law with the largest quotient.",
        sample=f"{len(LAWS)} laws at {len(RUN_POSES)} poses.",
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        fitted_numbers=FITS,
        answer=worst,
        variations=tuple(variations),
        limitations="A cut between the law and its observer, at which the delay margin would be short.",
    )


def valid_size(results: wb.Results, tolerance: float = CLOSE, laws: Iterable[str] = LAYER_LAWS) -> float:
    """The largest size in rad up to which the settling times of all these laws at all poses are as predicted."""
    every = settlings(results)
    return min(every[AtPose(law, pose)].valid(tolerance) for law in laws for pose in SIZE_POSES)


def step_size(results: wb.Results) -> wb.Finding:
    """The sizes for which the linear settling time holds."""
    every, size = settlings(results), valid_size(results)

    def words(value: float) -> str:
        return f"{number(1e3 * value)} mrad" if value else "none tried"

    at_level = {law: every[AtPose(law, LEVEL)] for law in LAWS}
    largest = {law: own.runs[-2] / own.prediction for law, own in at_level.items()}
    slow = max(LAYER_LAWS, key=lambda law: largest[law])
    variations = [
        *(
            wb.Variation(f"a tolerance of {100 * share:g} %", words(valid_size(results, share)))
            for share in (0.05, 0.2, 0.5)
        ),
        *(wb.Variation(f"only {law}", words(valid_size(results, laws=(law,)))) for law in LAWS),
    ]
    return wb.Finding(
        name="size_of_linear_motion",
        statement=f"Settling takes as long as the linear loop predicts, within {100 * CLOSE:g} %, from starts up to "
        f"{words(size)} from equilibrium under all {len(LAYER_LAWS)} laws with a boundary layer, and up to "
        f"{words(valid_size(results, laws=('PID',)))} under PID.",
        evidence="The boundary layer of 0.01 rad/s ends 1.7 mrad from equilibrium. From 0.3 rad the ratio of the "
        f"settling time to the predicted one is {largest[slow]:.2f} under {slow}, {largest[PROPOSED_LAW]:.2f} under "
        f"{PROPOSED_LAW} and {largest['PID']:.2f} under PID.",
        statistic="The largest tried start up to which the settling time of the slower joint, to 5 % of the start, is "
        "within 10 % of the linear one; the least over laws and poses.",
        sample=f"{len(LAWS)} laws at {len(SIZE_POSES)} poses, with nine starts from 0.1 mrad to 1 rad, both joints to "
        "the same side, in continuous time.",
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        fitted_numbers=FITS,
        answer=words(size),
        variations=tuple(variations),
        limitations="Starts with a velocity, or with the joints to opposite sides.",
    )


def cycle_errors(cycles: Mapping[float, LimitCycle], run: int) -> np.ndarray:
    """Errors of the balance in %, (periods, 2): of frequency and amplitude, where a run oscillates as predicted."""
    rows = [
        (abs(one.prediction[0] / found.frequency - 1), abs(one.prediction[1] / found.amplitude - 1))
        for one in cycles.values()
        if one.prediction is not None and not one.rest
        for found in (one.runs[run],)
        if found.frequency and found.amplitude > QUIET
    ]
    return 100 * np.array(rows)


def limit_cycle(results: wb.Results) -> wb.Finding:
    """Harmonic balance for the layer, with a delay."""
    held: dict[float, LimitCycle] = dict(zip(PERIODS, results.work("limit_cycles"), strict=True))
    runs = range(len(next(iter(held.values())).runs))
    counts = [sum(one.agrees(run) for one in held.values()) for run in runs]
    errors = [cycle_errors(held, run) for run in runs]
    middle = [np.median(one, axis=0) for one in errors]
    worst = np.max([one.max(axis=0) for one in errors], axis=0)

    def verdict(count: int) -> str:
        return "all" if count == len(held) else f"{count} of {len(held)}"

    right = f"all {len(held)}" if counts[0] == len(held) else verdict(counts[0])
    return wb.Finding(
        name="limit_cycle_in_the_layer",
        statement=f"At {right} sampling periods harmonic balance is right on whether SMC "
        f"oscillates in its boundary layer. The predicted frequency is off by {number(middle[0][0], 2)} % and the "
        f"amplitude by {number(middle[0][1], 2)} % (medians), at worst by {number(worst[0], 2)} % and "
        f"{number(worst[1], 2)} %.",
        evidence="By the balance the narrowest layer without an oscillation is the one below which the linear loop is "
        "unstable, so the count tests only the linear loop. The torque changes once per period, in steps that the "
        "balance leaves out.",
        statistic="Rest or oscillation of s of joint 1 after 4 s; errors relative to the run.",
        sample=f"SMC on the folded arm, where M is diagonal, at {len(held)} periods from 0.5 to 10 ms, with the torque "
        "one period late, from one start; three other starts are variations.",
        information="SMC: exact positions and velocities, and the exact model.",
        assumptions=ASSUMPTIONS,
        answer=verdict(counts[0]),
        variations=tuple(
            wb.Variation(
                f"start with joint velocities of {PUSHES[run][0]:g} and {PUSHES[run][1]:g} rad/s".replace("-", MINUS),
                verdict(counts[run]),
                f"{number(middle[run][0], 2)} % and {number(middle[run][1], 2)} %",
            )
            for run in runs
            if run
        ),
        limitations="Poses where M couples both joints, and other laws.",
    )
