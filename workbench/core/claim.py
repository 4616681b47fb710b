"""Claim: a promise of an equation, with its hypotheses and its source."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields

import casadi as ca

from workbench.core.block import is_block
from workbench.core.validation.refusals import text
from workbench.core.validation.signatures import check_arguments

SignalValues = Mapping[str, ca.SX]
Margin = Callable[[SignalValues], ca.SX]


@dataclass(frozen=True)
@check_arguments
class Claim:
    """A statement that can be true or false, with its hypotheses and its source: data, which `proofs` judges.

    The margin maps signals by name to an expression (k, 1) that is >= 0 at every instant of a run for which the claim
    holds; it is None where no instant can tell. The claim of a block sees its own parameters and memory by their own
    names, all others by path, the outputs of the loop and `t`; a signal with a prime (`K'`) is its derivative along the
    run.

    Examples
    --------
    >>> from workbench.core import Claim
    >>> Claim("it stays", "x stays below 2.", "a book", (), lambda signals: 2 - signals["x"]).margin({"x": 0.5})
    1.5
    """

    name: str
    statement: str
    source: str
    hypotheses: tuple[Claim, ...] = ()
    margin: Margin | None = None

    def __post_init__(self) -> None:
        for field in ("name", "statement", "source"):
            text(f"Claim({field}=...)", getattr(self, field))


@dataclass(frozen=True)
@check_arguments
class BlockClaim:
    """A claim of a block, with the `path` of the block (`controller.`) and the name of its class, `kind`.

    Examples
    --------
    >>> claim = wb.core.Claim("it stays", "x stays below 2.", "a book", (), lambda signals: 2 - signals["x"])
    >>> wb.core.BlockClaim(claim, "controller.").path
    'controller.'
    """

    claim: Claim
    path: str = ""
    kind: str = ""


def claims_of(block: object, path: str = "") -> tuple[BlockClaim, ...]:
    """The claims that `block` and the blocks within it declare in their class attribute `claims`, outermost first."""
    claims = [BlockClaim(claim, path, type(block).__name__) for claim in getattr(type(block), "claims", ())]
    for field in fields(block) if is_block(block) else ():
        value = getattr(block, field.name)
        several = isinstance(value, tuple)
        for i, part in enumerate(value if several else (value,)):
            if is_block(part):
                claims += claims_of(part, f"{path}{field.name}{f'[{i}]' if several else ''}.")
    return tuple(claims)
