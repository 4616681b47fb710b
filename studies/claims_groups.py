"""Whose claim it is: the paper's own, one of ours about its repair, or what a block promises of itself."""

from collections.abc import Mapping

import claims_paper as paper
from claims_law import DEFINITE_P, RAISED
from claims_observers import SWINGING
from claims_others import PROMISES

from workbench.verify.claims import Ledger

PAPER, OURS, BLOCKS = "The paper's claims", "Our repairs and readings", "Promises of the blocks"
OF_OURS = tuple(
    claim.name
    for claim in (
        paper.ASSUMPTION_3_DERIVED,
        paper.NEAR_ZERO,
        paper.REPAIRED_RATE,
        RAISED,
        DEFINITE_P,
        SWINGING,
    )
)
OF_BLOCKS = tuple(block for block, _, _ in PROMISES.values())


def grouped(ledger: Ledger) -> Mapping[str, Ledger]:
    """The ledger in three: each line in one of them, in its order."""
    return {
        PAPER: _kept(ledger, tuple(name for name in ledger.names if name not in (*OF_OURS, *OF_BLOCKS))),
        OURS: _kept(ledger, OF_OURS),
        BLOCKS: _kept(ledger, OF_BLOCKS),
    }


def _kept(ledger: Ledger, names: tuple[str, ...]) -> Ledger:
    return Ledger(tuple(line for line in ledger if line.claim.name in names))
