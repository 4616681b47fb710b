"""The verdicts of a9 on the longest safe periods: what foretells them, and what a delay does to them."""

from collections.abc import Sequence

import numpy as np

from studies.a9_sampling.card import QUIET, RULE
from studies.a9_sampling.evidence import Evidence
from studies.a9_sampling.integrator import GIVEN
from studies.paper.linearization import SEVEN
from workbench.study.document.document import Verdict

FORESEEN = 1.15  # the factor within which a foreseen period is right: searches end 1.12 apart, if they resolve
QUIETLY = f"Quiet: at most {QUIET:g} times the total variation of continuous time."


def foreseen(evidence: Evidence) -> Verdict:
    """Multipliers against runs."""
    asked = {
        **{law: (safe.multipliers, safe.quiet) for law, safe in evidence.safe.items()},
        **{f"{law} late": (safe.late_multipliers, safe.late_quiet) for law, safe in evidence.safe.items()},
    }
    told = {name: one for name, one in asked.items() if one[1].within(FORESEEN)}
    left = {name: one for name, one in asked.items() if name not in told}
    right = [name for name, (limit, seen) in told.items() if seen.meets(limit, FORESEEN)]
    agreed = [name for name, (limit, seen) in left.items() if seen.holds(limit)]
    wrong = [name for name in asked if name not in right + agreed]
    ends = "; ".join(sorted({seen.ends for _, seen in left.values()}))
    return Verdict(
        "found",
        f"The multipliers of the frozen loop foretell the longest period without chattering within a factor "
        f"{FORESEEN:g} in {len(right)} of {len(told)} cases that the search by runs resolves"
        + (f"; in {len(agreed)} of {len(left)} others they lie where it leaves it ({ends})." if left else "."),
        f"They do not for {joined(wrong)}." if wrong else "",
        estimand=f"{len(SEVEN)} laws, with a period of delay and without, beside a search by runs in both scenarios. A "
        f"case is resolved where the ends of the search are a factor {FORESEEN:g} apart or less; a foretold period is "
        f"right where it lies within this factor of both. {QUIETLY}",
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
        + (f" It is too long for {joined(over)}." if over else "")
        + (f" For {joined(near)} the search leaves it open." if near else "")
        + (f" With a period of delay it is too long for {joined(late)}." if late else ""),
        estimand=f"The rule with the largest gain of a run and the worst pose, beside a search by runs in both "
        f"scenarios. {QUIETLY}",
        given=GIVEN,
        reversal="A period of delay." if late else "A larger gain than those of these runs.",
    )


def halved(evidence: Evidence) -> Verdict:
    """What a delay does to the longest quiet period."""
    both = {law: (safe.quiet, safe.late_quiet) for law, safe in evidence.safe.items()}
    ratios = {  # by the safe ends, and the least and the largest that both searches leave
        law: (late.safe / quiet.safe, late.safe / quiet.unsafe, late.unsafe / quiet.safe)
        for law, (quiet, late) in both.items()
        if quiet.safe and quiet.unsafe and late.safe and late.unsafe
    }
    if not ratios:
        return Verdict("open", "What a period of delay does to the longest period without chattering is not known.")
    found, least, largest = zip(*ratios.values(), strict=True)
    return Verdict(
        "found",
        f"With a period of delay the longest period without chattering is {min(found):.2f} to {max(found):.2f} times "
        f"as long by the safe ends of the searches, and {min(least):.2f} to {max(largest):.2f} by all that they leave "
        "open.",
        f"By law: {', '.join(f'{law} {one:.2f} ({a:.2f} to {b:.2f})' for law, (one, a, b) in ratios.items())}.",
        estimand=f"The longest period with the delay over the longest without, of {len(ratios)} laws that have both, "
        f"by a search by runs in both scenarios. {QUIETLY}",
        given=GIVEN,
    )


def joined(words: Sequence[str]) -> str:
    """Words in a row, as a sentence has them."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
