"""The findings of c0 on what a model is worth: errors of laws, and limits on the linear loop."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import workbench as wb
from studies.c0_identify_arm.judgement import METRICS, SMALL, Change, Evidence, both, change, digits
from studies.c0_identify_arm.requirements import ARMS, SPECIFICATION, CheckedGains
from studies.c0_identify_arm.worth import DRAWS, LAWS, MOTIONS, PUSHES, SETTLED, Trial

LOOSER = (0.1, 0.2, -0.1, -0.2)  # shares by which limits may as well be looser


def nominal_costs(evidence: Evidence) -> dict[str, Change]:
    """By law, the change of the settled error by the paper's model in the place of the true one."""
    return {law: change(evidence, Trial(law, "nominal"), Trial(law, "true"), SETTLED) for law in LAWS}


def log_costs(evidence: Evidence) -> dict[str, float]:
    """By law, the largest size of the same change by the model of either log, in any motion, disturbed or not."""
    every = [(model, at, push) for model in ("law's log", "designed log") for at in MOTIONS for push in PUSHES]
    return {
        law: max(
            abs(change(evidence, Trial(law, model, at, push), Trial(law, "true", at, push), SETTLED).value)
            for model, at, push in every
        )
        for law in LAWS
    }


def losers(changes: dict[str, Change]) -> str:
    """The laws that lose."""
    return wb.document.join_names([law for law, one in changes.items() if one.word == "higher"]) or "none"


def cost_variations(evidence: Evidence) -> Iterator[wb.Variation]:
    """The laws that lose by the paper's model in each motion, with each disturbance, by each metric."""
    for motion in MOTIONS:
        for push in PUSHES:
            for metric, words in METRICS.items():
                if (motion, push, metric) == ("paper", "", SETTLED):
                    continue
                changes = {
                    law: change(evidence, Trial(law, "nominal", motion, push), Trial(law, "true", motion, push), metric)
                    for law in LAWS
                }
                figures = ", ".join(f"{law} {one.percent}" for law, one in changes.items())
                where = f"{motion} motion{', disturbed' if push else ''}, {words}"
                yield wb.Variation(where, losers(changes), figures)


def spans(evidence: Evidence, law: str) -> str:
    """The settled error with the true model and with the paper's, in words."""
    true, nominal = (1e3 * both(evidence.samples[Trial(law, model)], SETTLED).mean() for model in ("true", "nominal"))
    return f"from {true:.3g} to {nominal:.3g} mrad,"


def cost(evidence: Evidence) -> wb.Finding:
    """The cost of not having known the arm."""
    changes, rest = nominal_costs(evidence), log_costs(evidence)
    figures = wb.document.join_names([f"{law} {spans(evidence, law)} {one.percent}" for law, one in changes.items()])
    efforts = {law: change(evidence, Trial(law, "nominal"), Trial(law, "true"), "effort") for law in LAWS}
    return wb.Finding(
        name="cost_of_not_knowing",
        statement=f"With the paper's model in the place of the true one, the error from 2 s on changes: {figures}.",
        evidence="With the model of either log, in both motions, disturbed or not, it changes by at most "
        + ", ".join(f"{digits(100 * value)} % of {law}" for law, value in rest.items())
        + ". The root mean square of the torque changes with the paper's model: "
        + ", ".join(f"{law} {one.percent}" for law, one in efforts.items())
        + ".",
        statistic="The relative difference of the mean error of both joints from 2 s on, with its 95 % interval. A law "
        f"loses if the whole interval is above {100 * SMALL:g} %.",
        sample=f"{DRAWS} draws of the start and the noise, the same for all models.",
        information="All laws read positions alone. AOSMC-RGS estimates the disturbance, and friction with it; the "
        "others have an observer of the state alone, and compensate the modelled friction.",
        assumptions="The gains of AOSMC-RGS are those of a1, not tuned; the errors that count alike in the LQR, "
        "and 8 rad/s and a damping of 1 for the computed torque; the motions.",
        fitted_numbers="The model of each log; the gain of the LQR follows from it.",
        answer=losers(changes),
        variations=tuple(cost_variations(evidence)),
        limitations="Laws tuned for each model; larger differences between the paper's arm and the true one.",
    )


# The specification


def all_checks(evidence: Evidence) -> tuple[CheckedGains, ...]:
    """All gains that were checked, on all arms."""
    return (*evidence.law.checks, *evidence.designed_log.checks)


def limit_words(words: str) -> str:
    """A limit in words."""
    return (
        words.replace("_", " ").replace(">=", "\N{GREATER-THAN OR EQUAL TO}").replace("<=", "\N{LESS-THAN OR EQUAL TO}")
    )


def failed_limits(one: CheckedGains) -> str:
    """The limits that gains fail on some arm, in words."""
    shares = one.holds.mean(axis=0)
    names = [limit_words(limit.words) for limit, share in zip(SPECIFICATION.limits, shares, strict=True) if share < 1]
    return wb.document.join_names(names) if names else "no limit"


def is_held(one: CheckedGains, looser: float) -> bool:
    """True if gains hold all limits on all arms, with limits that are looser by a share."""
    low = np.array([limit.low for limit in SPECIFICATION.limits]) * (1 - looser)
    high = np.array([limit.high for limit in SPECIFICATION.limits]) * (1 + looser)
    return bool(((one.figures >= low) & (one.figures <= high)).all())


def holders(nominal: CheckedGains, own: CheckedGains, looser: float = 0.0) -> str:
    """The gains that hold all limits on all arms."""
    names = {"gains for the paper's arm": is_held(nominal, looser), "gains for the log": is_held(own, looser)}
    return wb.document.join_names([name for name, held in names.items() if held]) if any(names.values()) else "neither"


def specification(evidence: Evidence) -> wb.Finding:
    """The limits on the linear loop, on the arms that the logs allow."""
    nominal, own, own_on_true = evidence.law.checks
    later_nominal, later_own, later_on_true, nominal_on_true, _ = evidence.designed_log.checks
    other = [
        *(
            wb.Variation(f"limits {100 * abs(r):g} % {'looser' if r > 0 else 'tighter'}", holders(nominal, own, r))
            for r in LOOSER
        ),
        wb.Variation("gains and arms of the designed log", holders(later_nominal, later_own)),
        wb.Variation("on the true arm", holders(nominal_on_true, own_on_true)),
        wb.Variation("on the true arm, gains for the designed log", holders(nominal_on_true, later_on_true)),
    ]
    in_box = [kind for kind in own.in_box if kind == "refuted"]
    return wb.Finding(
        name="specification",
        statement=f"On {ARMS} arms that the law's log allows, LQR gains for the paper's arm fail "
        f"{failed_limits(nominal)}; gains for the log fail {failed_limits(own)}.",
        evidence=f"On the true arm, gains for the log fail {failed_limits(own_on_true)}. A search in the box of all "
        f"intervals at 99.9 % refutes {len(in_box)} of their {len(own.in_box)} limits.",
        statistic="The gains that hold all limits on all arms, by figures with proved bounds.",
        sample=f"{ARMS} arms drawn by the factors of the fit; corners and other points of the box of its intervals.",
        information="Positions; the loop is linear about the pose in which the arm hangs.",
        assumptions="The limits were chosen among round numbers with these figures in view. The arm slides: Coulomb "
        "friction does not damp it.",
        fitted_numbers="The gain of the LQR, from the model.",
        answer=holders(nominal, own),
        variations=tuple(other),
        limitations="Other poses, and friction at rest.",
    )
