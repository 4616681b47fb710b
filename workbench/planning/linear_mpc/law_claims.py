"""The claims on a predictive law: those that are proved, with hypotheses, and those that are only sampled."""

from __future__ import annotations

from workbench.core.claim import Claim
from workbench.design.matrices import DesignError
from workbench.planning.linear_mpc.linear_problem import LinearMpc
from workbench.planning.linear_mpc.splitting import SplittingNumbers
from workbench.planning.linear_mpc.sweep_choice import SweepEvidence
from workbench.planning.linear_mpc.terminal_ellipsoid import TerminalSet, terminal_set

SAMPLE = "the sample of `predictive_design`; sampled, not proved"
FILTER = "Wabersich and Zeilinger (2021), A predictive safety filter for learning-based control, Automatica 129"
HERE = "the theory page Linear predictive control, section What is proved"


def law_claims(problem: LinearMpc, numbers: SplittingNumbers, evidence: SweepEvidence) -> tuple[Claim, ...]:
    """The claims on the exact law of a problem, and on the law with its number of sweeps."""
    claims: list[Claim] = []
    try:
        ends = terminal_set(problem)
        claims += ends.claims
        proof = "in exact rational arithmetic" if ends.decrease_is_proved else "not proved, only found in rounding"
        claims.append(
            Claim(
                "hypotheses",
                f"All limits hold 0, by comparison; P - (A - B K)'P (A - B K) is positive definite, {proof}"
                + ("; Q is positive definite, by its eigenvalues." if len(ends.claims) > 1 else "; Q is singular."),
                HERE,
            )
        )
    except DesignError as reason:
        claims.append(Claim("no terminal set", f"Nothing is claimed of feasibility and stability: {reason}", HERE))
    if numbers.is_proved:
        claims.append(
            Claim(
                "contraction",
                f"Once its active rows are right, a sweep reduces an error to {numbers.contraction:.3g} of it or less, "
                "whichever limits act.",
                HERE,
            )
        )
    claims.append(
        Claim(
            "accuracy",
            f"Along {evidence.loops} closed loops of the exact law with {evidence.moves} moves, limits active in "
            f"{evidence.active_share:.0%}, {numbers.sweeps} sweeps err by {evidence.largest_error:.1g} of a span at "
            f"most; along {evidence.other_loops} other loops, by which they were not chosen, by "
            f"{evidence.other_error:.1g} at most and {evidence.other_rms_error:.1g} in the root mean square.",
            SAMPLE,
        )
    )
    claims.append(
        Claim(
            "cost",
            f"The cost of a loop under the law exceeds the exact law's by {max(evidence.cost_excess, 0.0):.1g} of it "
            "at most. The optimal cost falls in each period by that of the stage, but for "
            f"{evidence.fall_error:.1g} of the cost of the start.",
            SAMPLE,
        )
    )
    return tuple(claims)


def filter_claims(ends: TerminalSet) -> tuple[Claim, ...]:
    """The claim on a safety filter with a terminal ellipsoid, which holds for any law and any number of sweeps."""
    invariant = ends.claims[0]
    proof = "in exact rational arithmetic" if ends.decrease_is_proved else "not proved, only found in rounding"
    falls = Claim("invariance", f"P - (A - B K)'P (A - B K) is positive definite, {proof}.", FILTER)
    model = Claim("model", "The plant is the linear model, without disturbance, and its state is known.", FILTER)
    return (
        Claim(
            "safe forever",
            "From the first period on in which one of its plans is safe, a loop with the filter keeps all limits, "
            "whatever command it gets and however many sweeps it makes: the rest of a safe plan, with the LQR law "
            "behind it, is a safe plan of the next period.",
            FILTER,
            (invariant, falls, model),
        ),
    )
