"""The scope of a writer of C: a graph, and what the expressions of a function stand for."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from workbench.engine.kernel.graph import Graph
from workbench.engine.machines.c_real import DOUBLE, Real
from workbench.engine.machines.c_spelling import Text
from workbench.engine.machines.operations import gives_truth

ROOM = "loop_room"  # the array for the arrays of loops


@dataclass(frozen=True, eq=False)
class Scope:
    """A graph, and what the expressions of a function in C stand for.

    Attributes
    ----------
    real
        The format of values that are not among `doubles`.
    numbers
        The values of the nodes that are numbers.
    sources
        The texts of the other nodes that have no operands, as an entry of a state.
    names
        The variables of some nodes.
    fused_products
        True if products are rounded together with sums.
    doubles
        The nodes that are made in doubles whatever the format.
    room
        The array of the format in which the arrays of loops have their places.
    arrays
        The texts of arrays that no line makes.
    """

    graph: Graph
    prefix: str
    real: Real
    numbers: Mapping[int, float]
    sources: Mapping[int, Text]
    names: Mapping[int, str] = field(default_factory=dict)
    fused_products: bool = False
    doubles: Collection[int] = frozenset()
    room: str = ROOM
    arrays: Mapping[int, str] = field(default_factory=dict)

    def format_of(self, place: int) -> Real:
        """The format in which a value is made."""
        return DOUBLE if place in self.doubles else self.real

    def is_truth(self, place: int) -> bool:
        """True if a value has the type bool; one with a name is a number, 1 or 0."""
        named = place in self.names or place in self.numbers
        return not named and gives_truth(self.graph.nodes[place].op)
