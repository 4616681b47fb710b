"""The two-link arm of (2) to (4), as printed and as derived from its energies: its entries and its properties."""

import workbench as wb
from studies.paper.printed_arm import PrintedArm

DERIVED_DYNAMICS = wb.arms.Dynamics.of(wb.paper_arm(), "derived from the energies")
PRINTED_DYNAMICS = wb.arms.Dynamics.of(PrintedArm(), "as printed")
REPAIRED_DYNAMICS = wb.arms.Dynamics.of(PrintedArm(coriolis="repaired"), "printed, with C[1,2] repaired")

ENTRIES = wb.arms.paper_equations.compare(PRINTED_DYNAMICS, DERIVED_DYNAMICS)
WRONG = tuple(entry for entry in ENTRIES if entry.kind == "differs")
SKEW = {arm.name: wb.arms.properties.skew(arm) for arm in (PRINTED_DYNAMICS, REPAIRED_DYNAMICS, DERIVED_DYNAMICS)}
SYMMETRIC = {arm.name: wb.arms.properties.symmetric(arm) for arm in (PRINTED_DYNAMICS, DERIVED_DYNAMICS)}
DEFINITE = wb.arms.properties.positive_definite(DERIVED_DYNAMICS)


def proved_bounds() -> tuple[float, float]:
    """The bounds in kg m^2 between which all eigenvalues of M are proved to lie, at nominal parameters."""
    low, high = DEFINITE.beyond
    if low is None or high is None:
        raise ValueError("The eigenvalues of M are not proved to lie between two bounds.")
    return low, high
