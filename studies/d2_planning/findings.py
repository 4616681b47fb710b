"""The findings on predictive and linear laws, on what limits are worth, and on the laws for the arm."""

from __future__ import annotations

from collections.abc import Sequence

import workbench as wb
from studies.d2_planning.batches import AGAIN, DELAYED, DRAWS
from studies.d2_planning.choices import CANDIDATES, TRAINING
from studies.d2_planning.designs import BY_KEY, CONVERGED, laws_of
from studies.d2_planning.evidence import MARGIN, PRIMARY, STATISTICS, WEIGHTS, Condition, Evidence
from studies.d2_planning.laws_section import cost_words, ratio_words
from studies.d2_planning.predictive import MANY_SWEEPS
from studies.d2_planning.problems import PROBLEMS

RIVALS = ("governor", "lqr", "lqi")
MPC, OTHER, NEITHER = "MPC", "the linear law", "neither"
TIGHT, ALWAYS, NEVER, MIXED = "at tight limits", "at all limits", "at no limits", "at some limits"
INFORMATION = (
    "All laws of a plant read the same noisy and coarse readings through the same steady Kalman filter, which has the "
    "model's numbers and estimates a disturbance of each input. All know the limits, and have the same period."
)
FITS = (
    f"Each law chose its own numbers among {CANDIDATES} candidates, by the number of lost runs and the mean cost in "
    f"{TRAINING} training runs with other draws and noise. MPC is tuned with {MANY_SWEEPS} sweeps, and judged with "
    "those that its design derives."
)
SAMPLE = f"{DRAWS} draws of the plant's numbers, the start, the target and the noise, the same for all laws."
ASSUMED = (
    "The sizes of what is acceptable in the cost, the ranges of the draws, and the horizons of the predictive law."
)


def orders(evidence: Evidence, conditions: Sequence[Condition], rival: str, words: str = "") -> list[str]:
    """The order of MPC and a rival at each condition."""
    return [evidence.order(at, BY_KEY[rival], words) for at in conditions]


def verdict(places: Sequence[str]) -> str:
    """The side that is lower at more of some conditions."""
    low, high = places.count("below"), places.count("above")
    return MPC if low > high else OTHER if high > low else NEITHER


def count_words(places: Sequence[str]) -> str:
    """The counts in words."""
    return f"MPC lower {places.count('below')}, higher {places.count('above')}, neither {places.count('undecided')}"


def usual(level: float = 1.0, kind: str = "") -> list[Condition]:
    """The condition of each plant at a level that all have."""
    return [Condition(key, level, kind) for key in PROBLEMS]


def tightest(kind: str = "") -> list[Condition]:
    """The condition of each plant at its tightest limits."""
    return [Condition(problem.key, problem.levels[0], kind) for problem in PROBLEMS.values()]


def widest() -> list[Condition]:
    """The condition of each plant at its widest limits."""
    return [Condition(problem.key, problem.levels[-1]) for problem in PROBLEMS.values()]


def changed_answers(evidence: Evidence, rival: str) -> list[wb.Variation]:
    """MPC beside a linear law at all limits, on each plant, by each statistic and with other weights."""
    law = BY_KEY[rival]
    places = {
        "usual limits": usual(),
        "tightest limits": tightest(),
        "tightest limits, tuned there": tightest(AGAIN),
        "widest limits": widest(),
        "usual limits, a delay that no law knows": usual(1.0, DELAYED),
    }
    by_words = {words: orders(evidence, conditions, rival) for words, conditions in places.items()}
    if rival == "lqr":
        del by_words["usual limits"]  # the answer itself
    for words, conditions in (("usual limits", usual()), ("tightest limits", tightest())):
        by_words[f"{words}, {CONVERGED.name}"] = [evidence.order_of_converged(at, law) for at in conditions]
    by_words |= {words: orders(evidence, usual(), rival, words) for words in WEIGHTS}
    by_words |= {words: [evidence.order_by(at, law, one) for at in usual()] for words, one in STATISTICS.items()}
    alone = [
        wb.Variation(
            f"{law.name}, {problem.name} at level {level:g}",
            verdict([evidence.order(at, law)]),
            ratio_words(evidence, at, rival),
        )
        for problem in PROBLEMS.values()
        for level in problem.levels
        for at in (Condition(problem.key, level),)
    ]
    return [
        wb.Variation(f"{law.name}, {words}", verdict(one), count_words(one)) for words, one in by_words.items()
    ] + alone


def predictive(evidence: Evidence) -> wb.Finding:
    """MPC beside clipped LQR at the usual limits."""
    base = orders(evidence, usual(), "lqr")
    ratios = "; ".join(f"{PROBLEMS[at.problem].name} {ratio_words(evidence, at, 'lqr')}" for at in usual())
    low, high = base.count("below"), base.count("above")
    return wb.Finding(
        name="predictive_law",
        statement=f"At the usual limits, MPC is significantly better than clipped LQR on {low} of {len(base)} "
        f"plants, and worse on {high}.",
        evidence=f"The mean cost of clipped LQR over that of MPC: {ratios}. Both have the same observer, which knows "
        "the clipped input, so that nothing winds up.",
        statistic="The share of lost runs where either law loses any, else the mean cost. A difference is significant "
        f"if its whole interval lies beyond {100 * MARGIN:g} % and the errors of the step; the intervals of all laws, "
        "plants and limits hold at once at 95 %.",
        sample=SAMPLE,
        information=INFORMATION,
        assumptions=ASSUMED,
        fitted_numbers=FITS,
        answer=verdict(base),
        variations=tuple(one for rival in RIVALS for one in changed_answers(evidence, rival)),
        limitations="Limits of states, rates of inputs, longer horizons, targets that are known ahead, and models that "
        "are linearised along a motion.",
    )


def where(evidence: Evidence, problem: str, rival: str, statistic: str = "") -> str:
    """The limits at which MPC is significantly better than a rival."""
    law, found = BY_KEY[rival], []
    for level in PROBLEMS[problem].levels:
        at = Condition(problem, level)
        order = evidence.order_by(at, law, statistic) if statistic else evidence.order(at, law)
        found.append(order == "below")
    if all(found):
        return ALWAYS
    if not any(found):
        return NEVER
    count = sum(found)
    return TIGHT if all(found[:count]) else MIXED


def most_common(answers: Sequence[str]) -> str:
    """The answer of more than half of some plants."""
    best = max(sorted(set(answers)), key=list(answers).count)
    return best if 2 * list(answers).count(best) > len(answers) else "differs by plant"


def first_loss(evidence: Evidence, problem: str, key: str) -> str:
    """The widest level at which a law loses runs, in words."""
    law = BY_KEY[key]
    for level in reversed(PROBLEMS[problem].levels):
        if lost := evidence.lost_runs(Condition(problem, level), law):
            return f"{law.name} loses {lost} at level {level:g}"
    return ""


def limit_variations(evidence: Evidence) -> tuple[wb.Variation, ...]:
    """The limits at which MPC is better than each rival, on each plant and by each statistic."""
    alone = [
        wb.Variation(
            f"{BY_KEY[rival].name}, {PROBLEMS[key].name} alone",
            where(evidence, key, rival),
            ratio_words(evidence, Condition(key, PROBLEMS[key].levels[0]), rival),
        )
        for rival in RIVALS
        for key in PROBLEMS
    ]
    together = [
        wb.Variation(
            f"{BY_KEY[rival].name}, all plants", most_common([where(evidence, key, rival) for key in PROBLEMS])
        )
        for rival in RIVALS
        if rival != "lqr"
    ]
    by_statistic = [
        wb.Variation(
            f"clipped LQR by the {words}", most_common([where(evidence, key, "lqr", statistic) for key in PROBLEMS])
        )
        for words, statistic in STATISTICS.items()
    ]
    return (*alone, *together, *by_statistic)


def limits(evidence: Evidence) -> wb.Finding:
    """The worth of planning within limits."""
    base = {key: where(evidence, key, "lqr") for key in PROBLEMS}
    ratios = "; ".join(
        f"{PROBLEMS[at.problem].name} {ratio_words(evidence, at, 'lqr')}, and {ratio_words(evidence, wide, 'lqr')}"
        for at, wide in zip(tightest(), widest(), strict=True)
    )
    losses = "; ".join(
        f"{problem.name}: {', '.join(words)}"
        for problem in PROBLEMS.values()
        if (words := [one for law in laws_of(problem) if (one := first_loss(evidence, problem.key, law.key))])
    )
    return wb.Finding(
        name="worth_of_planning_limits",
        statement="By plant, MPC is significantly better than clipped LQR: "
        + "; ".join(f"{PROBLEMS[key].name} {answer}" for key, answer in base.items())
        + ".",
        evidence="The mean cost of clipped LQR over that of MPC, or lost runs, at the tightest and at the widest "
        f"limits: {ratios}. The widest limits at which runs are lost: {losses or 'none are lost'}.",
        statistic="The levels of the limits at which MPC is significantly better: by the share of lost runs where "
        "either law loses any, else by the mean cost. The answer is that of most plants.",
        sample=SAMPLE,
        information=INFORMATION,
        assumptions=f"{ASSUMED} The numbers of each law stay those of the usual limits.",
        fitted_numbers=FITS,
        answer=most_common(list(base.values())),
        variations=limit_variations(evidence),
        limitations="Limits of states, and limits that a law does not know.",
    )


def arm_laws(evidence: Evidence) -> wb.Finding:
    """The laws on the arm at the usual limits."""
    at, problem = Condition("arm"), PROBLEMS["arm"]
    base = evidence.judge(at).by[PRIMARY.words]
    figures = ", ".join(f"{law.name} {cost_words(evidence, at, law.key)}" for law in laws_of(problem))
    others = {f"level {level:g}": Condition("arm", level) for level in problem.levels if level != 1.0}
    others["tightest limits, tuned there"] = Condition("arm", problem.levels[0], AGAIN)
    others["a delay that no law knows"] = Condition("arm", 1.0, DELAYED)
    variations = [
        wb.Variation(words, place.by[PRIMARY.words].answer)
        for words, place in ((words, evidence.judge(where)) for words, where in others.items())
    ]
    variations += [
        wb.Variation(f"by the {words}", evidence.judge(at).by[statistic].answer)
        for words, statistic in STATISTICS.items()
        if statistic != PRIMARY.words
    ]
    variations += [wb.Variation(words, evidence.judge(at, words).by[PRIMARY.words].answer) for words in WEIGHTS]
    return wb.Finding(
        name="laws_for_the_arm",
        statement=f"On the arm at its usual limits, the lowest mean cost is: {base.answer}.",
        evidence=f"The mean costs, or lost runs: {figures}. The linear laws, MPC among them, use one linear model "
        "about the usual target; computed torque, SMC and AOSMC-RGS use the model of the arm at each pose.",
        statistic="The law whose mean cost is significantly below that of each other, else the laws between which the "
        "runs do not decide. Intervals of all laws, plants and limits hold at once at 95 %.",
        sample=SAMPLE,
        information=INFORMATION,
        assumptions=f"{ASSUMED} AOSMC-RGS has the four repairs of report a1; computed torque and SMC add the estimate "
        "of the disturbance.",
        fitted_numbers=f"{FITS} Of AOSMC-RGS the slope, the layer and the size of K(0); P(0), Q and R are the paper's.",
        answer=base.answer,
        variations=tuple(variations),
        limitations="Motions along a path, for which report a8 compares the paper's laws.",
        is_decided=base.best is not None or any(base.answer != one.answer for one in variations),
    )
