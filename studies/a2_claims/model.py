"""The ledger's first lines: the arm of (2) to (4), and Assumptions 1 to 4."""

import casadi as ca
import numpy as np

from studies.a0_two_link_arm import DEFINITE, ENTRIES, PRINTED, SKEW, SYMMETRIC
from studies.a0_two_link_arm import DERIVED as ARM
from studies.a2_claims import statements as paper
from studies.a2_claims.checks import Check, listed
from studies.paper.card import CARD
from studies.paper.laws import plant
from workbench.claims.verdicts import Finding
from workbench.core import Claim
from workbench.proofs.bounds import disturbance_bounds, shown
from workbench.proofs.interval import guarantee
from workbench.proofs.properties import PropertyVerdict
from workbench.proofs.witness import Witness
from workbench.validation.refusals import Array

PERIOD = 6.3  # s, just above 2 pi, the period of sines of 3 and 4 rad/s


def entries(matrix: str) -> Check:
    """Every printed entry of a matrix beside the derived one."""

    def check() -> Finding:
        mine = [entry for entry in ENTRIES if entry.matrix == matrix]
        wrong = [entry for entry in mine if entry.kind == "differs"]
        if wrong:
            entry = wrong[0]
            assert entry.witness is not None
            return Finding(
                "refuted",
                f"{entry.label} is {entry.printed_value:.6g} where {entry.right_value:.6g} is right, at "
                f"{entry.witness}; the other {len(mine) - len(wrong)} entries are proved right.",
                f"printed.{_matrices(entry.witness)}, derived.{_matrices(entry.witness)}",
            )
        if any(entry.kind != "same" for entry in mine):
            return Finding("not refuted", "; ".join(entry.evidence for entry in mine), samples=len(mine))
        return Finding("proved", f"Each of the {len(mine)} entries has the normal form of the derived one.")

    return check


def skewness(name: str, arm: str) -> Check:
    """Assumption 3 for one arm."""

    def check() -> Finding:
        found: PropertyVerdict = SKEW[name]
        if found.kind == "proved":
            return Finding("proved", "The normal form of M' - 2C plus its transpose is zero.")
        if found.witness is None or found.residual is None:
            return Finding("not checkable", found.evidence)
        worst = np.abs(found.residual).max()
        return Finding(
            "refuted",
            f"M' - 2C plus its transpose has an entry of {worst:.4g} kg m^2/s at {found.witness}.",
            f"skewness({arm}, {_tuple(found.witness.q)}, {_tuple(found.witness.qd)})",
        )

    return check


def bounded_start() -> Finding:
    """Assumption 1, for the two scenarios."""
    sizes = ", ".join(f"|q(0)| = {np.linalg.norm(CARD[f'{s}: q(0)']):.4g} rad ({s})" for s in ("FS", "SS"))
    return Finding("proved", f"Two points lie in a bounded set: {sizes}, qd(0) = 0 in both.")


def definite() -> Finding:
    """Assumption 2, at nominal parameters."""
    low, high = DEFINITE.beyond
    if SYMMETRIC[ARM.name].kind == SYMMETRIC[PRINTED.name].kind == DEFINITE.kind == "proved" and low and high:
        return Finding(
            "proved",
            f"Symmetric by normal form; on the whole torus {shown(low, 1)} <= alpha1 <= {shown(DEFINITE.alpha1, -1)} "
            f"and "
            f"{shown(DEFINITE.alpha2, 1)} <= alpha2 <= {shown(high, -1)} kg m^2 ({guarantee()}).",
        )
    return Finding("not refuted", DEFINITE.evidence, samples=DEFINITE.samples)


def bounded_disturbance() -> Finding:
    """Assumption 4, for the two scenarios, over the period 2 pi s of both."""
    said, t = [], ca.SX.sym("t")
    for scenario in ("FS", "SS"):
        D = plant(scenario).disturbance
        assert D is not None
        size, slope = disturbance_bounds(D.at(t), t, PERIOD)
        if size.beyond is None or slope.beyond is None:
            return Finding("not checkable", f"{scenario}: {size.why}; {slope.why}")
        said.append(f"|D| <= {shown(size.beyond, -1)} N m and |D'| <= {shown(slope.beyond, -1)} N m/s ({scenario})")
    amplitudes = listed(CARD["FS: disturbance amplitude"])
    return Finding(
        "proved",
        f"{' and '.join(said)}, by interval arithmetic over {PERIOD} s, which is more than the period 2 pi s of D, "
        f"with the amplitudes {amplitudes} N m ({guarantee()}).",
    )


def _matrices(witness: Witness) -> str:
    """The line that gives C at a state."""
    return f"matrices({_tuple(witness.q)}, {_tuple(witness.qd)})[1]"


def _tuple(values: Array) -> str:
    return "(" + ", ".join(f"{value:g}" for value in values) + ")"


CHECKS: tuple[tuple[Claim, Check], ...] = (
    (paper.INERTIA, entries("M")),
    (paper.CORIOLIS, entries("C")),
    (paper.GRAVITY, entries("G")),
    (paper.ASSUMPTION_1, bounded_start),
    (paper.ASSUMPTION_2, definite),
    (paper.ASSUMPTION_3, skewness(PRINTED.name, "printed")),
    (paper.ASSUMPTION_3_DERIVED, skewness(ARM.name, "derived")),
    (paper.ASSUMPTION_4, bounded_disturbance),
)
