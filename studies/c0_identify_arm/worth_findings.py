"""The findings of c0 on what a model is worth: errors of laws, and limits on the linear loop."""

from __future__ import annotations

from collections.abc import Iterator

import workbench as wb
from studies.c0_identify_arm.judgement import METRICS, SMALL, Change, Evidence, change
from studies.c0_identify_arm.requirements import ARMS, SPECIFICATION, CheckedGains
from studies.c0_identify_arm.worth import DRAWS, LAWS, MODELS, MOTIONS, PUSHES, SETTLED, Trial


def nominal_costs(evidence: Evidence) -> dict[str, Change]:
    """By law, the change of the settled error by the paper's model in the place of the true one."""
    return {law: change(evidence, Trial(law, "nominal"), Trial(law, "true"), SETTLED) for law in LAWS}


def losers(changes: dict[str, Change]) -> str:
    """The laws that lose."""
    return wb.document.join_names([law for law, one in changes.items() if one.word == "higher"]) or "none"


def cost_variations(evidence: Evidence) -> Iterator[wb.Variation]:
    """The laws that lose by each model, in each motion, with each disturbance, by each metric."""
    for model in MODELS[:-1]:
        for motion in MOTIONS:
            for push in PUSHES:
                for metric, words in METRICS.items():
                    if (model, motion, push, metric) == ("nominal", "paper", "", SETTLED):
                        continue
                    changes = {
                        law: change(evidence, Trial(law, model, motion, push), Trial(law, "true", motion, push), metric)
                        for law in LAWS
                    }
                    told_by = f"{model} model, {motion} motion{', disturbed' if push else ''}, {words}"
                    figures = ", ".join(f"{law} {one.percent}" for law, one in changes.items())
                    question = "" if model == "nominal" else "Which laws lose by the model of a log?"
                    yield wb.Variation(told_by, losers(changes), figures, question)


def cost(evidence: Evidence) -> wb.Finding:
    """The cost of not having known the arm."""
    changes = nominal_costs(evidence)
    rest = {
        law: max(
            abs(change(evidence, Trial(law, model), Trial(law, "true"), SETTLED).value)
            for model in ("law's log", "designed log")
        )
        for law in LAWS
    }
    figures = ", ".join(f"{law} {one.percent}" for law, one in changes.items())
    efforts = {law: change(evidence, Trial(law, "nominal"), Trial(law, "true"), "effort") for law in LAWS}
    return wb.Finding(
        name="cost_of_not_knowing",
        statement=f"With the paper's model in the place of the true one, the settled error changes: {figures}.",
        evidence=f"With the model of either log it changes by at most {100 * max(rest.values()):.1g} %. The root mean "
        f"square of the torque changes with the paper's model: "
        + ", ".join(f"{law} {one.percent}" for law, one in efforts.items())
        + ".",
        statistic="The relative difference of the mean error of both joints from 2 s on, with its 95 % interval. A law "
        f"loses if the whole interval is above {100 * SMALL:g} %.",
        sample=f"{DRAWS} draws of the start and the noise, the same for all models.",
        information="All laws read positions alone. AOSMC-RGS estimates the disturbance, and friction with it; the "
        "others have an observer of the state alone, and compensate the modelled friction.",
        assumptions="The gains of AOSMC-RGS are those of a1; the errors that count alike in the LQR, and 8 rad/s and a "
        "damping of 1 for the computed torque; the motions.",
        fitted_numbers="The model of each log; the gain of the LQR follows from it.",
        answer=losers(changes),
        variations=tuple(cost_variations(evidence)),
        limitations="Laws tuned for each model; larger differences between the paper's arm and the true one.",
    )


# The specification


def all_checks(evidence: Evidence) -> tuple[CheckedGains, ...]:
    """All gains that were checked, on all arms."""
    return (*evidence.law.checks, *evidence.designed.checks)


def held_words(one: CheckedGains) -> str:
    """Whether gains hold all limits on all arms."""
    return "holds" if one.holds.all() else "fails"


def failed_limits(one: CheckedGains) -> str:
    """The limits that gains fail on some arm, in words."""
    names = [
        limit.words for limit, share in zip(SPECIFICATION.limits, one.holds.mean(axis=0), strict=True) if share < 1
    ]
    return wb.document.join_names(names) or "no limit fails"


def specification(evidence: Evidence) -> wb.Finding:
    """The limits on the linear loop, on the arms that the logs allow."""
    nominal, own, *_ = evidence.law.checks
    rest = [one for one in all_checks(evidence) if one is not own]
    return wb.Finding(
        name="specification",
        statement=f"On each of {ARMS} arms that the law's log allows, LQR gains for the paper's arm fail "
        f"{failed_limits(nominal)}; gains for the log hold all limits."
        if not nominal.holds.all(axis=1).any() and own.holds.all()
        else "On some of the arms that the law's log allows, LQR gains for the paper's arm fail: "
        f"{failed_limits(nominal)}; gains for the log: {failed_limits(own)}.",
        evidence=f"On the true arm, gains for the law's log: {failed_limits(evidence.law.checks[2])}. A search in the "
        "box of all intervals at 99.9 % refutes no limit of theirs."
        if "refuted" not in own.in_box
        else "A search in the box of all intervals at 99.9 % refutes a limit of theirs, too.",
        statistic="Each limit at each arm, from figures with proved bounds; all must hold.",
        sample=f"{ARMS} arms drawn by the factors of the fit, corners and a search in the box of intervals.",
        information="Positions; the loop is linear about the pose in which the arm hangs.",
        assumptions="The limits were chosen with these figures in view, among round numbers. The arm slides: Coulomb "
        "friction does not damp it.",
        fitted_numbers="The gain of the LQR, from the model.",
        answer=held_words(own),
        variations=tuple(
            wb.Variation(f"gains for {one.gains}, arms of {one.arms}", held_words(one), failed_limits(one))
            for one in rest
        ),
        limitations="Other poses, and friction at rest.",
    )
