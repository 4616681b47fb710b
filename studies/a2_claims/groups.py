"""Four groups of claims: the paper's own, its comparisons under the numbers of a1, ours on its repair, the blocks'."""

from collections.abc import Mapping

from studies.a2_claims import statements as paper
from studies.a2_claims.comparisons import AS_READ, PROMISES, UNDER
from studies.a2_claims.law import DEFINITE_P, RAISED
from studies.a2_claims.observers import SWINGING
from workbench.claims.verdicts import Ledger

PAPER, ASSUMED = "The paper's claims", "The paper's comparisons under the numbers of a1"
OURS, BLOCKS = "Our repairs and readings", "Promises of the blocks"
OF_OURS = tuple(
    claim.name
    for claim in (
        paper.ASSUMPTION_3_DERIVED,
        paper.NEAR_ZERO,
        paper.REPAIRED_RATE,
        paper.OPTIMAL_LOOP,
        paper.BOUNDED_ABOVE,
        RAISED,
        DEFINITE_P,
        SWINGING,
        AS_READ,
    )
)
OF_A1 = tuple(claim.name for claim in UNDER.values())
OF_BLOCKS = tuple(block for block, _, _ in PROMISES.values())


def grouped(ledger: Ledger) -> Mapping[str, Ledger]:
    """The ledger in four: each line in one of them, in its order."""
    return {
        PAPER: _kept(ledger, tuple(name for name in ledger.names if name not in (*OF_A1, *OF_OURS, *OF_BLOCKS))),
        ASSUMED: _kept(ledger, OF_A1),
        OURS: _kept(ledger, OF_OURS),
        BLOCKS: _kept(ledger, OF_BLOCKS),
    }


def _kept(ledger: Ledger, names: tuple[str, ...]) -> Ledger:
    return Ledger(tuple(line for line in ledger if line.claim.name in names))
