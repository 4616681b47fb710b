"""The ledger's first lines: the arm of (2) to (4), and Assumptions 1 to 4."""

import casadi as ca
import numpy as np

import workbench as wb
from studies.a2_claims.checks import CheckedClaim, judges, literal, row
from studies.a2_claims.searches import ASSUMPTION_4
from studies.paper.card import CARD
from studies.paper.laws import disturbance
from studies.paper.two_link_arm import DEFINITE, ENTRIES, PRINTED_DYNAMICS, SKEW, SYMMETRIC
from studies.paper.two_link_arm import DERIVED_DYNAMICS as ARM

PERIOD = 6.3  # s, just above 2 pi, the period of sines of 3 and 4 rad/s


def entries(matrix: str, name: str, statement: str) -> CheckedClaim:
    """Every printed entry of a matrix beside the derived one."""

    def check() -> wb.proofs.Ruling:
        mine = [entry for entry in ENTRIES if entry.matrix == matrix]
        if all(entry.kind == "same" for entry in mine):
            return wb.proofs.Ruling(
                "proved", f"Each of the {len(mine)} entries has the normal form of the derived one."
            )
        wrong = [entry for entry in mine if entry.kind == "differs"]
        if not wrong:
            return wb.proofs.Ruling("not refuted", "; ".join(entry.evidence for entry in mine), samples=len(mine))
        entry, seen = wrong[0], wrong[0].witness
        if seen is None:
            return wb.proofs.Ruling("not checkable", entry.evidence)
        matrices = f"matrices({literal(seen.q)}, {literal(seen.qd)})[1]"
        torques = [arm.matrices(seen.q, seen.qd)[1] @ np.array(seen.qd) for arm in (PRINTED_DYNAMICS, ARM)]
        return wb.proofs.Ruling(
            "refuted",
            f"{entry.label} is {entry.printed_value:.6g} where {entry.right_value:.6g} is right, at {seen}; "
            f"the other {len(mine) - len(wrong)} entries are proved right. There C qd is {row(torques[0])} N m and "
            f"should be {row(torques[1])}: (3) is not another factor of the right torque.",
            f"printed_dynamics.{matrices}, derived_dynamics.{matrices}",
        )

    return CheckedClaim(wb.core.Claim(name, f"{statement} of the arm.", name), check)


def skew_symmetric(arm: str, verdict: wb.arms.properties.PropertyVerdict, claim: wb.core.Claim) -> CheckedClaim:
    """Assumption 3 for one arm."""

    def check() -> wb.proofs.Ruling:
        if verdict.kind == "proved":
            return wb.proofs.Ruling("proved", "The normal form of M' - 2C plus its transpose is zero.")
        if verdict.witness is None or verdict.residual is None:
            return wb.proofs.Ruling("not checkable", verdict.evidence)
        return wb.proofs.Ruling(
            "refuted",
            f"M' - 2C plus its transpose has an entry of {np.abs(verdict.residual).max():.4g} kg m^2/s at "
            f"{verdict.witness}.",
            f"skewness({arm}_dynamics, {literal(verdict.witness.q)}, {literal(verdict.witness.qd)})",
        )

    return CheckedClaim(claim, check)


inertia = entries("M", "(2)", "M is the inertia matrix")
coriolis = entries("C", "(3)", "C is the Coriolis matrix")
gravity = entries("G", "(4)", "G is the gravity vector")
SKEW_PRINTED = wb.core.Claim("Assumption 3", "M' - 2C is skew-symmetric, with C as (3) prints it.", "(3), section 2.3")
SKEW_DERIVED = wb.core.Claim("Assumption 3, derived C", "M' - 2C is skew-symmetric, with C as derived.", "section 2.3")


@judges("Assumption 1", "The initial states lie in a bounded set.", "(5), (6)")
def bounded_start() -> wb.proofs.Ruling:
    sizes = ", ".join(f"|q(0)| = {np.linalg.norm(CARD[f'{s}: q(0)']):.4g} rad ({s})" for s in ("FS", "SS"))
    return wb.proofs.Ruling("proved", f"Two points lie in a bounded set: {sizes}, qd(0) = 0 in both.")


@judges("Assumption 2", "M is symmetric, and alpha1 I <= M(q) <= alpha2 I for all q, alpha1 > 0.", "(7)", inertia.claim)
def definite() -> wb.proofs.Ruling:
    low, high = DEFINITE.beyond
    if not (
        SYMMETRIC[ARM.name].kind == SYMMETRIC[PRINTED_DYNAMICS.name].kind == DEFINITE.kind == "proved" and low and high
    ):
        return wb.proofs.Ruling("not refuted", DEFINITE.evidence, samples=DEFINITE.samples)
    least, most = (wb.proofs.bound_text(DEFINITE.alpha1, -1), wb.proofs.bound_text(DEFINITE.alpha2, 1))
    return wb.proofs.Ruling(
        "proved",
        f"Symmetric by normal form; on the whole torus {wb.proofs.bound_text(low, 1)} <= alpha1 <= {least} "
        f"and {most} <= alpha2 <= {wb.proofs.bound_text(high, -1)} kg m^2 ({wb.proofs.guarantee()}).",
    )


def bounded_disturbance() -> wb.proofs.Ruling:
    """Assumption 4, for the two scenarios, over the period 2 pi s of both."""
    bounds, t = [], ca.SX.sym("t")
    for scenario in ("FS", "SS"):
        size, slope = wb.proofs.disturbance_bounds(disturbance(scenario).at(t), t, PERIOD)
        if size.bound is None or slope.bound is None:
            return wb.proofs.Ruling("not checkable", f"{scenario}: {size.why}; {slope.why}")
        largest, fastest = (wb.proofs.bound_text(one.bound, -1) for one in (size, slope) if one.bound is not None)
        bounds.append(f"|D| <= {largest} N m and |D'| <= {fastest} N m/s ({scenario})")
    return wb.proofs.Ruling(
        "proved",
        f"{' and '.join(bounds)}, by interval arithmetic over {PERIOD} s, which is more than the period 2 pi s of D, "
        f"with the amplitudes {row(CARD['FS: disturbance amplitude'])} N m ({wb.proofs.guarantee()}).",
    )


CHECKS = (
    *(inertia, coriolis, gravity, bounded_start, definite),
    skew_symmetric("printed", SKEW[PRINTED_DYNAMICS.name], SKEW_PRINTED),
    skew_symmetric("derived", SKEW[ARM.name], SKEW_DERIVED),
    CheckedClaim(ASSUMPTION_4, bounded_disturbance),
)
ASSUMPTIONS = (bounded_start.claim, definite.claim, SKEW_DERIVED, ASSUMPTION_4)
