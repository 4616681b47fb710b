"""The verdicts of a9, each made of its figures."""

from collections.abc import Sequence

import numpy as np
from linear_loops import PROPOSED, SEVEN
from paper_card import LAWS
from paper_comparison import MARGIN
from sampling_card import PERIODS, QUIET, REALISTIC, RULE
from sampling_evidence import PLACES, SOME, Evidence, flips, judged, printed
from sampling_integrator import finite, integrator
from sampling_loops import RMSE, SWITCHING, TV, Audit, Computer
from sampling_steps import Curve

from workbench.study.document import Section, Verdict

ALIKE = 0.02  # of the total variation, by which it may depend on the substep
FORESEEN = 1.15  # the factor within which a foreseen period is right: searches end 1.12 apart
HALF = (0.4, 0.6)
MS = f"{1e3 * REALISTIC:g} ms"


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
    """Whether the paper's own figure shows the computer."""
    still, now = evidence.still(RMSE), evidence.at(RMSE, REALISTIC)
    change = {(law, *place): abs(now(law, *place)[0] / still(law, *place)[0] - 1) for law in SEVEN for place in PLACES}
    worst = max(change, key=lambda key: change[key])
    error = now(*worst)[1] / still(*worst)[0]
    past = change[worst] - error > MARGIN
    factor = {law: max(variation(evidence, law, *place) for place in PLACES) for law in SEVEN}
    loud, calm = max(factor, key=lambda law: factor[law]), [law for law in SEVEN if factor[law] <= QUIET]
    quiet = f" Only {_and(calm)} {'stay' if len(calm) > 1 else 'stays'} within {QUIET:g} times." if calm else ""
    return Verdict(
        "fails" if past else "holds" if change[worst] + error <= MARGIN else "open",
        f"A computer of {MS} leaves the RMSE (43) of every law within {100 * MARGIN:g} % of continuous time.",
        f"It changes by up to {100 * change[worst]:.2f} %, with an error of {100 * error:.2f} % ({_at(worst)}). The "
        f"total variation of the torque becomes up to {_round(factor[loud])} times what it is in continuous time "
        f"({loud}).{quiet}",
    )


def variation(evidence: Evidence, law: str, scenario: str, joint: int, period: float = REALISTIC) -> float:
    """Total variation with a computer over that in continuous time."""
    return evidence.at(TV, period)(law, scenario, joint)[0] / evidence.still(TV)(law, scenario, joint)[0]


def survives(evidence: Evidence) -> Verdict:
    """Whether a realistic computer changes what holds of the published ranking."""
    before, now, by_cayley = (
        printed(evidence.still(RMSE)),
        *(printed(evidence.at(RMSE, REALISTIC, delay=True, noisy=True, stepping=way)) for way in ("euler", "cayley")),
    )
    turned, opened = before.below & now.above, before.below & now.undecided
    return Verdict(
        "fails" if turned else "open" if opened else "holds",
        f"What holds of the published ranking in continuous time holds at {MS}, a period late, with noise.",
        f"Of the printed pairs, in continuous time {before.text}; with the realistic computer {now.text}, and "
        f"with Cayley steps of AOSMC-RGS {by_cayley.text}. Of the "
        f"{len(before.below)} that held, {len(turned)} are turned and {len(opened)} become too close to call.",
    )


def places(evidence: Evidence) -> Verdict:
    """Whether laws change places by RMSE as the period grows."""
    found, by_euler = flips(evidence, RMSE, "cayley"), flips(evidence, RMSE)
    statement = f"The paper's laws keep their places by RMSE (43) up to {1e3 * max(PERIODS):g} ms."
    if not found:
        return Verdict("holds", statement, "Every pair that is decided in continuous time stays or becomes open.")
    first = min(flip.period for flip in found)
    before = max((T for T in PERIODS if first > T), default=0.0)
    early = [f"{f.better} and {f.worse} ({f.scenario}, joint {f.joint + 1})" for f in found if f.period == first]
    ours, euler = (sum(PROPOSED in (f.better, f.worse) for f in kind) for kind in (found, by_euler))
    return Verdict(
        "fails",
        statement,
        f"All pairs keep them up to {1e3 * before:g} ms. At {1e3 * first:g} ms these change: {', '.join(early)}. By "
        f"{1e3 * max(PERIODS):g} ms {len(found)} of {len(PLACES) * len(LAWS) * (len(LAWS) - 1) // 2} pairs have, "
        f"{ours} with AOSMC-RGS, which takes Cayley steps here. With explicit Euler {euler} pairs with AOSMC-RGS "
        "have, as a run that diverges ranks above all others. A pair changes where exact and noisy readings agree, "
        "beyond 2 % and both errors.",
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
        "fails" if "above" in stands else "open" if "undecided" in stands else "holds",
        f"At {MS} AOSMC-RGS chatters less than its rivals (TV).",
        f"Below the rival in {stands.count('below')} of {len(stands)} comparisons, above in {stands.count('above')}; "
        f"by Cayley steps below in {by_cayley.count('below')}, above in {by_cayley.count('above')}. "
        f"Its torque varies by up to {_round(largest)} N m/s: by {_round(largest * REALISTIC)} N m each period.",
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
        "fails" if wrong else "holds",
        "The multipliers of the frozen loop foretell the longest period without chattering.",
        f"Within a factor {FORESEEN:g} of what the search by runs leaves, in {len(asked) - len(wrong)} of {len(asked)} "
        "cases, with a period of delay and without" + (f"; not for {_and(wrong)}." if wrong else "."),
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
    return Verdict(
        "fails" if over else "open" if near else "holds",
        ("For a computer without delay ", RULE, ", with the least eigenvalue of M, is a safe period."),
        f"The longest quiet period over the rule: {listed}. The rule takes the largest gain at the worst pose, "
        "which is the limit itself where all gains are equal, and too strict elsewhere"
        + (f"; for {_and(near)} the search leaves it open. " if near else ". ")
        + "With a period of delay it is "
        + (f"too long for {_and(late)}." if late else "safe too."),
    )


def halved(evidence: Evidence) -> Verdict:
    """What a delay does to the longest quiet period."""
    ratios = {
        law: safe.late_quiet.safe / safe.quiet.safe
        for law, safe in evidence.safe.items()
        if safe.quiet.safe and safe.late_quiet.safe and safe.quiet.unsafe
    }
    odd = [law for law, ratio in ratios.items() if not HALF[0] <= ratio <= HALF[1]]
    listed = ", ".join(f"{law} {ratio:.2f}" for law, ratio in ratios.items())
    return Verdict(
        "open" if not ratios else "fails" if odd else "holds",
        "One period of delay halves the longest period without chattering.",
        f"Longest with the delay over longest without: {listed or 'known of no law'}.",
    )


def noisy(evidence: Evidence) -> Verdict:
    """Whether a layer that suits the period suits the noise."""
    quiet: dict[tuple[str, str, int, float], float] = {}
    for law in SEVEN:
        for place in PLACES:
            for period in PERIODS:
                if law != "PID" and variation(evidence, law, *place, period) <= QUIET:
                    still = evidence.still(TV)(law, *place)[0]
                    quiet[law, *place, period] = evidence.at(TV, period, noisy=True)(law, *place)[0] / still
    loud = [key for key, factor in quiet.items() if factor > QUIET]
    worst = max(quiet, key=lambda key: quiet[key], default=None)
    most = f" The worst: {_round(quiet[worst])} times ({_at(worst[:3])}, {1e3 * worst[3]:g} ms)." if worst else ""
    return Verdict(
        "open" if worst is None else "fails" if loud else "holds",
        "A law with a layer that is quiet with exact readings is quiet with noisy ones.",
        f"Of {len(quiet)} runs that are quiet (at most {QUIET:g} times the total variation of continuous time), "
        f"{len(loud)} are not with noise.{most} The slope K / phi of a layer makes torque of noise.",
    )


def implicit(evidence: Evidence) -> Verdict:
    """Whether the implicit relay keeps quiet."""
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
        "holds" if factors[worst] <= QUIET else "fails",
        f"A relay by backward Euler does not chatter from {1e3 * min(SOME):g} to {1e3 * max(SOME):g} ms.",
        f"First scenario, exact readings and model: at most {factors[worst]:.2f} times the total variation of "
        f"the layer in continuous time ({_at(worst[:3])}, {1e3 * worst[3]:g} ms), whatever K has grown to. With "
        f"noise at {MS} it reaches {_round(rough[loud])} N m/s ({loud}): its slope is M / T, up to the limits of K.",
    )


def computers(curves: Sequence[Curve]) -> Verdict:
    """Whether chattering is the computer's or the simulation's."""
    spread = max(float(np.ptp(c.TV, axis=0).max() / c.TV.min()) for c in curves if c.digital)
    own = {c.law: float((c.TV.max(axis=0) / c.TV[np.argmin(c.h)]).max()) for c in curves if _spread_layer(c)}
    worst = max(own, key=lambda law: own[law])
    return Verdict(
        "holds" if spread <= ALIKE else "fails",
        f"Chattering of the loop with a computer of {MS} is the computer's, the same at every step of the simulation.",
        f"A shorter step within the period changes the total variation by at most {100 * spread:.2g} %. In continuous "
        f"time it is the step that chatters: with its layer {worst} reaches {_round(own[worst])} times what the "
        "shortest step shows, beyond the stability limit of RK4, and a relay varies the more the shorter the step is.",
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
