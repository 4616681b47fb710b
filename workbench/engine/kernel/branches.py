"""Branches of the body of a loop: what only choices by one condition need is made only if it holds for some run.

A choice is `if_else(condition, new, old)`. Where the condition does not hold, no bit of it depends on `new`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from workbench.engine.kernel.graph import Graph
from workbench.engine.machines.operations import OPERATIONS

LEAST = 6  # operations that a branch may save, beside one for each of its choices
MANY = 100  # times as many of a loop that it saves
CHOICE = "if_else"


@dataclass(frozen=True)
class BlockBranch:
    """Some choices by one condition.

    Attributes
    ----------
    condition
        The place of the condition.
    choices
        The places of choices between a new value and an old one.
    in_place
        Choices that are a next carried number and nothing else, whose old value is the carried one: the entries of
        these numbers by the places of the choices. No new value of another choice reads them.
    array
        The place of the array of the carried numbers; -1 if no choice is in place.
    inside
        The places that only the new values need, in order, for each choice those that no earlier one needs.
    needs
        The places that the branch needs from outside.
    """

    condition: int
    choices: tuple[int, ...]
    in_place: Mapping[int, int]
    array: int
    inside: tuple[tuple[int, ...], ...]
    needs: tuple[int, ...]

    @property
    def places(self) -> tuple[int, ...]:
        """The places of all choices."""
        return (*self.choices, *self.in_place)


@lru_cache(maxsize=128)
def schedule(graph: Graph, next_carried: tuple[int, ...]) -> tuple[int | BlockBranch, ...]:
    """The nodes of the body of a loop and its branches in an order of evaluation, without the nodes inside a branch.

    Parameters
    ----------
    next_carried
        The places of the next carried numbers, if all of them are numbers.
    """
    branches = list(_branches(graph, next_carried))
    while True:
        ends = {place: branch for branch in branches for place in branch.places}
        order = _order(graph, ends)
        if not isinstance(order, BlockBranch):
            return order
        branches.remove(order)  # it needs its own choices, by way of other branches


def _branches(graph: Graph, next_carried: Sequence[int]) -> Iterator[BlockBranch]:
    """The branches that are worth it, the largest groups of choices first."""
    users: list[list[int]] = [[] for _ in graph.nodes]
    for place, node in enumerate(graph.nodes):
        for operand in node.operands:
            users[operand].append(place)
    taken = set[int]()
    for choices in _groups(graph):
        if taken.isdisjoint(choices):
            branch = _branch(graph, users, choices, next_carried, taken)
            inside = {i for part in branch.inside for i in part}
            saved = sum(LEAST * MANY if graph.nodes[i].loop else graph.nodes[i].op in OPERATIONS for i in inside)
            if saved >= LEAST + len(branch.choices):
                taken.update(inside, branch.places)
                yield branch


def _groups(graph: Graph) -> list[list[int]]:
    """Choices by one condition, none of which needs another one of the same group; the largest groups first."""
    by_condition: dict[int, list[int]] = {}
    for place, node in enumerate(graph.nodes):
        if node.op == CHOICE:
            by_condition.setdefault(node.operands[0], []).append(place)
    groups = list[list[int]]()
    for choices in by_condition.values():
        groups.append([])
        for place in choices:
            if not set(groups[-1]).isdisjoint(graph.before(graph.nodes[place].operands)):
                groups.append([])
            groups[-1].append(place)
    return sorted(groups, key=len, reverse=True)


def _branch(
    graph: Graph,
    users: Sequence[Sequence[int]],
    choices: Sequence[int],
    next_carried: Sequence[int],
    taken: Collection[int],
) -> BlockBranch:
    in_place = {
        place: entry
        for entry, place in enumerate(next_carried)
        if place in choices
        and graph.results.count(place) == 1
        and not users[place]
        and _carried_entry(graph, graph.nodes[place].operands[2]) == entry
    }
    if any(node.op == "carried" and not _has_items_alone(graph, users[i]) for i, node in enumerate(graph.nodes)):
        in_place = {}  # a loop inside reads the array, before the branch or behind it
    inside = _inside(graph, users, choices, in_place, taken)
    while bound := _read_elsewhere(graph, in_place, choices, inside):
        in_place = {place: entry for place, entry in in_place.items() if place not in bound}
        inside = _inside(graph, users, choices, in_place, taken)
    array = graph.nodes[graph.nodes[next(iter(in_place))].operands[2]].operands[0] if in_place else -1
    others = tuple(place for place in choices if place not in in_place)
    condition = graph.nodes[choices[0]].operands[0]
    ends = [graph.nodes[i].operands[1] for i in choices] + [graph.nodes[i].operands[2] for i in others]
    operands = [condition, *ends, *(j for i in inside for j in graph.nodes[i].operands)]
    needs = tuple(dict.fromkeys(i for i in operands if i not in inside))  # the array among them
    parts = list[tuple[int, ...]]()
    for place in (*others, *in_place):
        parts.append(tuple(i for i in graph.before([graph.nodes[place].operands[1]]) if i in inside))
        inside = inside.difference(parts[-1])
    return BlockBranch(condition, others, in_place, array, tuple(parts), needs)


def _read_elsewhere(
    graph: Graph, in_place: Mapping[int, int], choices: Sequence[int], inside: Collection[int]
) -> set[int]:
    """The choices in place whose carried number is read by more than their own new value, so that it must stay."""
    read = {place: set(graph.before([graph.nodes[place].operands[1]])) for place in choices}
    own = {place: graph.nodes[place].operands[2] for place in in_place}
    return {
        place
        for place, number in own.items()
        if number not in inside or any(number in read[other] for other in choices if other != place)
    }


def _inside(
    graph: Graph,
    users: Sequence[Sequence[int]],
    choices: Sequence[int],
    in_place: Mapping[int, int],
    taken: Collection[int],
) -> set[int]:
    """The places that only the new values of choices need, and the carried numbers that only those in place need."""
    inside, results = set[int](), set(graph.results)

    def is_value(user: int, place: int) -> bool:
        condition, _, old = graph.nodes[user].operands
        return place != condition and (place != old or user in in_place)

    for place in reversed(graph.before(i for choice in choices for i in graph.nodes[choice].operands[1:])):
        node = graph.nodes[place]
        is_source = not node.operands and node.loop is None
        if is_source or place in results or place in taken or place in choices:
            continue
        if all(user in inside or (user in choices and is_value(user, place)) for user in users[place]):
            inside.add(place)
    return inside


def _has_items_alone(graph: Graph, users: Sequence[int]) -> bool:
    """True if an array with these users is read number by number."""
    return all(graph.nodes[i].op == "item" for i in users)


def _carried_entry(graph: Graph, place: int) -> int | None:
    """The entry of a carried number; None of any other value."""
    node = graph.nodes[place]
    return node.entry if node.op == "item" and graph.nodes[node.operands[0]].op == "carried" else None


def _order(graph: Graph, ends: Mapping[int, BlockBranch]) -> tuple[int | BlockBranch, ...] | BlockBranch:
    """All places and branches behind what they need; or a branch that needs itself."""
    order, done, open_ = list[int | BlockBranch](), set[int](), set[int]()
    stack: list[tuple[int, bool]] = [(place, False) for place in reversed(_outer(graph, ends))]
    while stack:
        place, is_ready = stack.pop()
        if place in done:
            continue
        branch = ends.get(place)
        own: Iterable[int] = branch.places if branch else (place,)
        if is_ready:
            order.append(branch or place)
            done.update(own)
            continue
        if branch and place in open_:
            return branch
        open_.update(own)
        stack.append((place, True))
        needs = branch.needs if branch else graph.nodes[place].operands
        stack += [(i, False) for i in reversed(needs) if i not in done]
    return tuple(order)


def _outer(graph: Graph, ends: Mapping[int, BlockBranch]) -> list[int]:
    """The places that are not inside a branch, in order."""
    inside = {place for branch in ends.values() for part in branch.inside for place in part}
    return [place for place in range(len(graph.nodes)) if place not in inside]
