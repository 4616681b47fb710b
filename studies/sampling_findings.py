"""The verdicts of a9, each made of its figures."""

from collections.abc import Sequence

import numpy as np
from linear_loops import PROPOSED, SEVEN
from paper_card import LAWS
from paper_comparison import MARGIN
from sampling_card import NOISY, PERIODS, QUIET, REALISTIC, RULE
from sampling_evidence import PLACES, SOME, Evidence, flips, judged, printed
from sampling_integrator import GIVEN, finite, integrator
from sampling_loops import RMSE, SWITCHING, TV, Audit, Computer
from sampling_steps import Curve

from workbench.study.document import Section, Verdict

FORESEEN = 1.15  # the factor within which a foreseen period is right: searches end 1.12 apart
MS = f"{1e3 * REALISTIC:g} ms"
QUIETLY = f"Quiet: at most {QUIET:g} times the total variation of continuous time."


def findings(evidence: Evidence, curves: Sequence[Curve]) -> Section:
    """The answers first."""
    return Section(
        "What was found",
        (
            finite(evidence),
            integrator(evidence),
            unseen(evidence),
            survives(evidence),
            places(evidence),
            quieter(evidence),
            foreseen(evidence),
            thumb(evidence),
            halved(evidence),
            noisy(evidence),
            implicit(evidence),
            computers(curves),
        ),
    )


def unseen(evidence: Evidence) -> Verdict:
    """How far the paper's own figure shows the computer."""
    still, now = evidence.still(RMSE), evidence.at(RMSE, REALISTIC)
    change = {(law, *place): abs(now(law, *place)[0] / still(law, *place)[0] - 1) for law in SEVEN for place in PLACES}
    worst = max(change, key=lambda key: change[key])
    error = now(*worst)[1] / still(*worst)[0]
    factor = {law: max(variation(evidence, law, *place) for place in PLACES) for law in SEVEN}
    loud, calm = max(factor, key=lambda law: factor[law]), [law for law in SEVEN if factor[law] <= QUIET]
    quiet = f" Only {_and(calm)} {'stay' if len(calm) > 1 else 'stays'} within {QUIET:g} times." if calm else ""
    return Verdict(
        "found",
        f"A computer of {MS} changes the RMSE (43) of a law by up to {100 * change[worst]:.2f} %, and the total "
        f"variation of its torque by a factor of up to {_round(factor[loud])}.",
        f"The RMSE of {_at(worst)} changes most, with an error of {100 * error:.2f} %; the variation that of {loud}."
        f"{quiet}",
        estimand=f"Each over continuous time, the largest of {len(SEVEN)} laws and {len(PLACES)} joints and scenarios, "
        "one run each with exact readings, without delay, by explicit Euler.",
        given=GIVEN,
        reversal="A wider layer or a smaller gain, with which the laws do not chatter at this period.",
    )


def variation(evidence: Evidence, law: str, scenario: str, joint: int, period: float = REALISTIC) -> float:
    """Total variation with a computer over that in continuous time."""
    return evidence.at(TV, period)(law, scenario, joint)[0] / evidence.still(TV)(law, scenario, joint)[0]


def survives(evidence: Evidence) -> Verdict:
    """How much of what holds of the published ranking a realistic computer leaves."""
    before, now, by_cayley = (
        printed(evidence.still(RMSE)),
        *(printed(evidence.at(RMSE, REALISTIC, delay=True, noisy=True, stepping=way)) for way in ("euler", "cayley")),
    )
    turned, opened = before.below & now.above, before.below & now.undecided
    return Verdict(
        "found",
        f"Of {len(before.below)} printed pairs of laws that hold in continuous time {len(before.below & now.below)} "
        f"hold at {MS}, a period late, with noise.",
        f"{len(turned)} are turned and {len(opened)} become too close to call. Of all printed pairs, in continuous "
        f"time {before.text}; with this computer {now.text}, and with Cayley steps of AOSMC-RGS {by_cayley.text}.",
        estimand=f"Order by RMSE (43): with noise the mean of {NOISY} runs, apart by more than {100 * MARGIN:g} % and "
        "twice the standard errors.",
        given=GIVEN,
        reversal="A longer period, or other numbers of the rivals, which the paper does not state (a6).",
    )


def places(evidence: Evidence) -> Verdict:
    """Which laws change places by RMSE as the period grows."""
    found, by_euler = flips(evidence, RMSE, "cayley"), flips(evidence, RMSE)
    first = min((flip.period for flip in found), default=np.inf)
    before = max((T for T in PERIODS if first > T), default=0.0)
    early = [f"{f.better} and {f.worse} ({f.scenario}, joint {f.joint + 1})" for f in found if f.period == first]
    ours, euler = (sum(PROPOSED in (f.better, f.worse) for f in kind) for kind in (found, by_euler))
    pairs = len(PLACES) * len(LAWS) * (len(LAWS) - 1) // 2
    return Verdict(
        "found",
        f"By RMSE (43) all pairs of the paper's laws keep their order up to {1e3 * before:g} ms; by "
        f"{1e3 * max(PERIODS):g} ms {len(found)} of {pairs} have changed it.",
        (f"At {1e3 * first:g} ms these change: {', '.join(early)}. " if early else "")
        + f"Pairs with AOSMC-RGS that change: {ours}, and with explicit Euler {euler}, as a run that diverges ranks "
        "above all others.",
        estimand=f"Order in one run with exact readings and by the mean of {NOISY} with noise, where both agree, "
        f"beyond {100 * MARGIN:g} % and both errors; {len(PERIODS)} periods without delay.",
        given=f"{GIVEN} AOSMC-RGS steps by Cayley, all others by explicit Euler.",
        reversal="Explicit Euler of (34), for the pairs with AOSMC-RGS.",
    )


def quieter(evidence: Evidence) -> Verdict:
    """The paper's claim of reduced chattering, in a sampled-data loop."""
    now, rivals = evidence.at(TV, REALISTIC), [law for law in LAWS if law != PROPOSED]
    stands, by_cayley = (
        [judged(at(PROPOSED, *place), at(rival, *place)) for place in PLACES for rival in rivals]
        for at in (now, evidence.at(TV, REALISTIC, stepping="cayley"))
    )
    largest = max(now(PROPOSED, *place)[0] for place in PLACES)
    return Verdict(
        "found",
        f"At {MS} AOSMC-RGS has a smaller total variation than the rival in {stands.count('below')} of {len(stands)} "
        f"comparisons, and a larger one in {stands.count('above')}.",
        f"By Cayley steps it is smaller in {by_cayley.count('below')}, larger in {by_cayley.count('above')}. Its "
        f"torque varies by up to {_round(largest)} N m/s: by {_round(largest * REALISTIC)} N m each period. The paper "
        "claims reduced chattering.",
        estimand="TV of the held torque of one run with exact readings, without delay, at each joint in each scenario.",
        given=GIVEN,
        reversal="A wider layer, or other gains of the rivals, which the paper does not state.",
    )


def foreseen(evidence: Evidence) -> Verdict:
    """Multipliers against runs."""
    asked = {
        **{law: (safe.multipliers, safe.quiet) for law, safe in evidence.safe.items()},
        **{f"{law} late": (safe.late_multipliers, safe.late_quiet) for law, safe in evidence.safe.items()},
    }
    wrong = [
        name
        for name, (limit, seen) in asked.items()
        if not (seen.safe or 0.0) / FORESEEN <= limit <= (seen.unsafe or np.inf) * FORESEEN
    ]
    return Verdict(
        "found",
        f"The multipliers of the frozen loop foretell the longest period without chattering within a factor "
        f"{FORESEEN:g} in {len(asked) - len(wrong)} of {len(asked)} cases.",
        f"They do not for {_and(wrong)}." if wrong else "",
        estimand=f"{len(SEVEN)} laws, with a period of delay and without, beside what a search by runs in both "
        f"scenarios leaves. {QUIETLY}",
        given=GIVEN,
        reversal="Noise, which no multiplier knows of.",
    )


def thumb(evidence: Evidence) -> Verdict:
    """The rule of thumb against runs."""
    ruled = {law: (safe.rule, safe) for law, safe in evidence.safe.items() if safe.rule}
    ratios = {
        law: ((safe.quiet.safe or 0.0) / rule, (safe.quiet.unsafe or np.inf) / rule)
        for law, (rule, safe) in ruled.items()
    }
    over = [law for law, (_, unsafe) in ratios.items() if unsafe < 1]
    near = [law for law, (quiet, unsafe) in ratios.items() if quiet < 1 <= unsafe]
    late = [law for law, (rule, safe) in ruled.items() if (safe.late_quiet.unsafe or np.inf) < rule]
    listed = ", ".join(f"{law} {low:.2f} to {high:.2f}" for law, (low, high) in ratios.items())
    safe_for = len(ratios) - len(over) - len(near)
    return Verdict(
        "found",
        (
            "Without delay ",
            RULE,
            f", with the least eigenvalue of M, is a safe period of {safe_for} of {len(ratios)} laws.",
        ),
        f"The longest quiet period over the rule: {listed}."
        + (f" It is too long for {_and(over)}." if over else "")
        + (f" For {_and(near)} the search leaves it open." if near else "")
        + (f" With a period of delay it is too long for {_and(late)}." if late else ""),
        estimand=f"The rule with the largest gain of a run and the worst pose, beside a search by runs in both "
        f"scenarios. {QUIETLY}",
        given=GIVEN,
        reversal="A period of delay." if late else "A larger gain than those of these runs.",
    )


def halved(evidence: Evidence) -> Verdict:
    """What a delay does to the longest quiet period."""
    ratios = {
        law: safe.late_quiet.safe / safe.quiet.safe
        for law, safe in evidence.safe.items()
        if safe.quiet.safe and safe.late_quiet.safe and safe.quiet.unsafe
    }
    if not ratios:
        return Verdict("open", "What a period of delay does to the longest period without chattering is not known.")
    low, high = min(ratios.values()), max(ratios.values())
    return Verdict(
        "found",
        f"With a period of delay the longest period without chattering is {low:.2f} to {high:.2f} times as long.",
        f"By law: {', '.join(f'{law} {ratio:.2f}' for law, ratio in ratios.items())}.",
        estimand=f"The longest period with the delay over the longest without, of {len(ratios)} laws that have both, "
        f"by a search by runs in both scenarios. {QUIETLY}",
        given=GIVEN,
    )


def noisy(evidence: Evidence) -> Verdict:
    """How many runs whose layer suits the period chatter with noise."""
    quiet: dict[tuple[str, str, int, float], float] = {}
    for law in SEVEN:
        for place in PLACES:
            for period in PERIODS:
                if law != "PID" and variation(evidence, law, *place, period) <= QUIET:
                    still = evidence.still(TV)(law, *place)[0]
                    quiet[law, *place, period] = evidence.at(TV, period, noisy=True)(law, *place)[0] / still
    if not quiet:
        return Verdict("open", "No law with a layer is quiet with exact readings.")
    loud = [key for key, factor in quiet.items() if factor > QUIET]
    worst = max(quiet, key=lambda key: quiet[key])
    return Verdict(
        "found",
        f"Of {len(quiet)} cases in which a law with a layer is quiet with exact readings, {len(loud)} chatter with "
        "noise.",
        f"The worst varies {_round(quiet[worst])} times as much as in continuous time ({_at(worst[:3])}, "
        f"{1e3 * worst[3]:g} ms). The slope K / phi of a layer makes torque of noise.",
        estimand=f"Cases: a law, joint, scenario and period without delay; with noise the mean of {NOISY} runs. "
        f"{QUIETLY}",
        given=GIVEN,
        reversal="Readings with less noise than assumed, or a filter of the velocities: none is in these loops.",
    )


def implicit(evidence: Evidence) -> Verdict:
    """How quiet the implicit relay is."""
    laws, still = SWITCHING["implicit"], evidence.still(TV)

    def found(law: str, period: float) -> Audit:
        return evidence.audits[law, "FS", Computer(period, switching="implicit")]

    factors = {
        (law, "FS", joint, period): found(law, period).score(TV, joint)[0] / still(law, "FS", joint)[0]
        for law in laws
        for joint in (0, 1)
        for period in SOME
    }
    worst = max(factors, key=lambda key: factors[key])
    rough = {law: found(law, REALISTIC).noisy_score(TV, 0)[0] for law in laws}
    loud = max(laws, key=lambda law: rough[law])
    return Verdict(
        "found",
        f"A relay by backward Euler varies the torque at most {factors[worst]:.2f} times as much as the layer does in "
        f"continuous time, from {1e3 * min(SOME):g} to {1e3 * max(SOME):g} ms.",
        f"The most is that of {_at(worst[:3])}, at {1e3 * worst[3]:g} ms. With noise at {MS} it reaches "
        f"{_round(rough[loud])} N m/s ({loud}): its slope is M / T, up to the limits of K.",
        estimand=f"TV of one run with exact readings in the first scenario, for {len(laws)} laws, both joints and "
        f"{len(SOME)} periods; with noise the mean of {NOISY} runs at joint 1.",
        given=f"{', '.join(laws)}: positions and velocities, and the exact M, which backward Euler uses.",
        reversal="Noise on the readings; a wrong M was not tried.",
    )


def computers(curves: Sequence[Curve]) -> Verdict:
    """How far chattering is the computer's or the simulation's."""
    spread = max(float(np.ptp(c.TV, axis=0).max() / c.TV.min()) for c in curves if c.digital)
    own = {c.law: float((c.TV.max(axis=0) / c.TV[np.argmin(c.h)]).max()) for c in curves if _spread_layer(c)}
    worst = max(own, key=lambda law: own[law])
    return Verdict(
        "found",
        f"A shorter step of the simulation changes the total variation of the loop with a computer of {MS} by at most "
        f"{100 * spread:.2g} %; in continuous time the step changes it up to {_round(own[worst])} times.",
        f"The latter is {worst} with its layer, beyond the stability limit of RK4, over what the shortest step shows. "
        "There it is the step that chatters. A relay in continuous time varies the more the shorter the step is.",
        estimand=f"TV of one run a law and step in the first scenario, of {_and(sorted({c.law for c in curves}))}.",
        given=GIVEN,
    )


def _spread_layer(curve: Curve) -> bool:
    return curve.switching == "clip" and not curve.digital


def _at(place: tuple[str, str, int]) -> str:
    law, scenario, joint = place
    return f"{law}, {scenario}, joint {joint + 1}"


def _and(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _round(value: float) -> str:
    return f"{float(f'{value:.2g}'):,.6g}"
