"""Claim: what an equation is said to promise, on which hypotheses, by which source."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Any

import casadi as ca

from workbench.core.block import is_block
from workbench.validation.doors import door
from workbench.validation.words import text

Signals = Mapping[str, ca.SX]
# From signals by name to an expression (k, 1) that is nowhere negative where the claim holds.
Margin = Callable[[Signals], ca.SX]


@dataclass(frozen=True)
@door
class Claim:
    """A sentence that can be true or false, with its hypotheses and its source: data, which `verify` judges.

    Attributes
    ----------
    name
        How other claims, tables and witnesses call it.
    hypotheses
        What it rests on: claims in their turn.
    margin
        From signals by name to an expression (k, 1) that is >= 0 at every instant of a run for which the
        claim holds; None where no instant can tell. The claim of a block sees its own parameters and
        memory by their own names, all others by path, the outputs of the loop and `t`; with a prime behind
        its name (`K'`) a signal is its derivative along the run.

    Raises
    ------
    ValueError
        If a text is empty, a hypothesis is no `Claim`, or the margin no function.
    """

    name: str
    statement: str
    source: str
    hypotheses: tuple[Claim, ...] = ()
    margin: Margin | None = None

    def __post_init__(self) -> None:
        for field in ("name", "statement", "source"):
            text(f"Claim({field}=...)", getattr(self, field), empty=False)


@dataclass(frozen=True)
class Declared:
    """A claim that a block of some kind makes at a `path` (`controller.`): its own names are to be read below it."""

    claim: Claim
    path: str = ""
    kind: str = ""


def declared(block: object, path: str = "") -> tuple[Declared, ...]:
    """The claims that `block` and the blocks within it declare in their class attribute `claims`, outermost first."""
    return tuple(_declared(block, path))


def _declared(thing: Any, path: str) -> Iterator[Declared]:
    for claim in getattr(type(thing), "claims", ()):
        yield Declared(claim, path, type(thing).__name__)
    for field in fields(thing) if is_block(thing) else ():
        value = getattr(thing, field.name)
        if is_block(value):
            yield from _declared(value, f"{path}{field.name}.")
        elif isinstance(value, tuple):
            for i, part in enumerate(value):
                yield from _declared(part, f"{path}{field.name}[{i}].") if is_block(part) else ()
