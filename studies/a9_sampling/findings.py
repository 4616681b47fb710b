"""The verdicts of a9, each made of its figures."""

from collections.abc import Sequence

import numpy as np

from studies.a9_sampling.card import NOISY, PERIODS, QUIET, REALISTIC
from studies.a9_sampling.evidence import PLACES, SOME, Evidence, flips, judged, printed
from studies.a9_sampling.integrator import GIVEN, finite, integrator
from studies.a9_sampling.limits import QUIETLY, foreseen, halved, joined, thumb
from studies.a9_sampling.loops import RMSE, SWITCHING, TV, Audit, Computer
from studies.a9_sampling.steps import Curve
from studies.paper.card import LAWS
from studies.paper.comparison import MARGIN
from studies.paper.linearization import PROPOSED, SEVEN
from workbench.study.document.document import Section, Verdict

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
            computers(evidence, curves),
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
    quiet = f" Only {joined(calm)} {'stay' if len(calm) > 1 else 'stays'} within {QUIET:g} times." if calm else ""
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
    apart = printed(evidence.still(RMSE))
    ordered = len(apart.below) + len(apart.above)
    return Verdict(
        "found",
        f"By RMSE (43) no pair of the {ordered} of the paper's laws that have an order changes places up to "
        f"{1e3 * before:g} ms; by {1e3 * max(PERIODS):g} ms {len(found)} of {ordered} have.",
        f"{len(apart.undecided)} of {ordered + len(apart.undecided)} pairs at a joint in a scenario are too close in "
        "continuous time to have an order. "
        + (f"At {1e3 * first:g} ms these change: {', '.join(early)}. " if early else "")
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
        "With exact readings and the exact M a relay by backward Euler varies the torque in the first scenario at most "
        f"{factors[worst]:.2f} times as much as the layer does in continuous time, at "
        f"{joined([f'{1e3 * period:g}' for period in SOME])} ms.",
        f"The most is that of {_at(worst[:3])}, at {1e3 * worst[3]:g} ms. With noise at {MS} it reaches "
        f"{_round(rough[loud])} N m/s ({loud}): its slope is M / T, up to the limits of K.",
        estimand=f"TV of one run for {len(laws)} laws, both joints and {len(SOME)} periods; with noise the mean "
        f"of {NOISY} runs at joint 1.",
        given=f"{', '.join(laws)}: positions and velocities, and the exact M, which backward Euler uses.",
        reversal="Noise on the readings; a wrong M was not tried.",
    )


def computers(evidence: Evidence, curves: Sequence[Curve]) -> Verdict:
    """How far chattering is the computer's or the simulation's."""
    laws = joined(sorted({c.law for c in curves}))
    spread = max(float(np.ptp(c.TV, axis=0).max() / c.TV.min()) for c in curves if c.digital)
    own = {c.law: float((c.TV.max(axis=0) / c.TV[np.argmin(c.h)]).max()) for c in curves if _spread_layer(c)}
    worst = max(own, key=lambda law: own[law])
    return Verdict(
        "found",
        f"A shorter step of the simulation changes the total variation of {laws} with a computer of {MS} in the first "
        f"scenario by at most {100 * spread:.2g} % (of all laws, in both scenarios, by up to "
        f"{100 * evidence.worst_step(TV, REALISTIC):.2g} %); in continuous time the step changes it up to "
        f"{_round(own[worst])} times.",
        f"The latter is {worst} with its layer, beyond the stability limit of RK4, over what the shortest step shows. "
        "There it is the step that chatters. A relay in continuous time varies the more the shorter the step is.",
        estimand=f"TV of one run a law and step in the first scenario, of {laws} with layer and relay; of all laws, "
        "half the substep in place of the whole one, with the layer.",
        given=GIVEN,
    )


def _spread_layer(curve: Curve) -> bool:
    return curve.switching == "clip" and not curve.digital


def _at(place: tuple[str, str, int]) -> str:
    law, scenario, joint = place
    return f"{law}, {scenario}, joint {joint + 1}"


def _round(value: float) -> str:
    return f"{float(f'{value:.2g}'):,.6g}"
