"""Branches of a graph in C: choices by one condition are made together, and what one side alone needs, on that side."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from workbench.engine.kernel.graph import Graph
from workbench.engine.machines.operations import OPERATIONS

LEAST = 4  # operations on both sides, for which a branch is written
CHOICE = "if_else"


@dataclass(frozen=True)
class Branch:
    """Some choices by one condition, whose values are made together.

    Attributes
    ----------
    choices
        The places of the choices.
    condition
        The place of their condition.
    sides
        The places that only their first values need, and those that only their second values need, in order.
    needs
        The places from outside that the choices and both sides need.
    kept_numbers
        The choices whose second value is a carried number, which so stays as it is: the entries of these numbers.
    """

    choices: tuple[int, ...]
    condition: int
    sides: tuple[tuple[int, ...], tuple[int, ...]]
    needs: tuple[int, ...]
    kept_numbers: Mapping[int, int]

    def is_direct(self, graph: Graph) -> bool:
        """True if each kept number can be written before the next one is computed, which does not read it."""
        entries = set(self.kept_numbers.values())
        read = {
            place: {_carried_entry(graph, i) for i in graph.before([graph.nodes[place].operands[1]])} & entries
            for place in self.kept_numbers
        }
        return all(read[place] <= {entry} for place, entry in self.kept_numbers.items())


def branches_of(graph: Graph, ends: Sequence[int], outer_places: Collection[int] = ()) -> dict[int, Branch]:
    """The branches of the body of a loop by the places of their choices.

    Parameters
    ----------
    ends
        The places of the next carried numbers, where all of them are numbers.
    outer_places
        Places that no side has.
    """
    users = _users(graph)
    branches, taken = dict[int, Branch](), set[int]()
    for choices in _groups(graph):
        if not taken.isdisjoint(choices):
            continue
        outside = {*outer_places, *branches, *taken}
        numbers = _kept_numbers(graph, users, choices, ends)
        branch = _branch(graph, users, choices, outside, numbers)
        if not _is_safe(graph, users, branch):
            branch = _branch(graph, users, choices, outside, {})
        inside = {place for side in branch.sides for place in side}
        if sum(
            LEAST if graph.nodes[i].loop else graph.nodes[i].op in OPERATIONS for i in inside
        ) >= LEAST and not _is_circular(graph, branches, branch):
            branches |= dict.fromkeys(choices, branch)
            taken |= inside
    return branches


def evaluation_order(graph: Graph, branches: Mapping[int, Branch], available: Collection[int]) -> list[int]:
    """All places behind what they need, of a branch its first choice alone; not those in `available`."""
    order, done = list[int](), set(available)
    stack = [(place, False) for place in sorted(set(graph.results), reverse=True)]
    while stack:
        place, is_ready = stack.pop()
        if place in done:
            continue
        if is_ready:
            order.append(place)
            done.update(branches[place].choices if place in branches else (place,))
        else:
            stack.append((place, True))
            stack += [(i, False) for i in sorted(_needs(graph, branches, place), reverse=True)]
    return order


def _needs(graph: Graph, branches: Mapping[int, Branch], place: int) -> tuple[int, ...]:
    return branches[place].needs if place in branches else graph.nodes[place].operands


def _is_circular(graph: Graph, branches: Mapping[int, Branch], branch: Branch) -> bool:
    """True if a branch needs one of its own choices, by way of other branches."""
    seen, stack = set[int](), list(branch.needs)
    while stack:
        place = stack.pop()
        if place in branch.choices:
            return True
        if place not in seen:
            seen.add(place)
            stack.extend(_needs(graph, branches, place))
    return False


def _users(graph: Graph) -> dict[int, list[int]]:
    """The places that use a place as an operand, for all that the results need."""
    users: dict[int, list[int]] = {place: [] for place in graph.before(graph.results)}
    for place in users:
        for operand in graph.nodes[place].operands:
            users[operand].append(place)
    return users


def _groups(graph: Graph) -> list[list[int]]:
    """Choices by one condition, none of which needs another one of the same group; the largest groups first."""
    by_condition: dict[int, list[int]] = {}
    for place in graph.before(graph.results):
        if graph.nodes[place].op == CHOICE:
            by_condition.setdefault(graph.nodes[place].operands[0], []).append(place)
    groups = list[list[int]]()
    for choices in by_condition.values():
        groups.append([])
        for place in choices:
            if not set(groups[-1]).isdisjoint(graph.before(graph.nodes[place].operands)):
                groups.append([])
            groups[-1].append(place)
    return sorted(groups, key=len, reverse=True)


def _kept_numbers(
    graph: Graph, users: Mapping[int, list[int]], choices: Sequence[int], ends: Sequence[int]
) -> dict[int, int]:
    """The choices that are next carried numbers and nothing else, with the same carried number as second value."""
    return {
        place: entry
        for entry, place in enumerate(ends)
        if place in choices
        and graph.results.count(place) == 1
        and not users[place]
        and _carried_entry(graph, graph.nodes[place].operands[2]) == entry
    }


def _carried_entry(graph: Graph, place: int) -> int | None:
    node = graph.nodes[place]
    is_carried = node.op == "item" and graph.nodes[node.operands[0]].op == "carried"
    return node.entry if is_carried else None


def _is_safe(graph: Graph, users: Mapping[int, list[int]], branch: Branch) -> bool:
    """True if carried numbers that are kept may be written within the branch: nothing reads them elsewhere."""
    arrays = {graph.nodes[graph.nodes[i].operands[2]].operands[0] for i in branch.kept_numbers}
    readers = {user for array in arrays for user in users[array] if graph.nodes[user].op != "item"}
    kept = all(set(users[graph.nodes[i].operands[2]]) <= {*branch.sides[0], i} for i in branch.kept_numbers)
    return kept and readers <= set(branch.sides[0])


def _branch(
    graph: Graph,
    users: Mapping[int, list[int]],
    choices: Sequence[int],
    outside: Collection[int],
    numbers: Mapping[int, int],
) -> Branch:
    """The branch of some choices."""
    first, second = (tuple(_side(graph, users, choices, side, outside, numbers)) for side in (0, 1))
    inside, olds = {*first, *second}, {graph.nodes[place].operands[2] for place in numbers}
    operands = [i for place in (*choices, *first, *second) for i in graph.nodes[place].operands if i not in inside]
    used = {i for place in first for i in graph.nodes[place].operands}
    needs = tuple(dict.fromkeys(i for i in operands if i not in olds or i in used))
    return Branch(tuple(choices), graph.nodes[choices[0]].operands[0], (first, second), needs, numbers)


def _side(
    graph: Graph,
    users: Mapping[int, list[int]],
    choices: Sequence[int],
    side: int,
    outside: Collection[int],
    numbers: Mapping[int, int],
) -> Iterable[int]:
    """The places that only one side of some choices needs, in order."""
    ends, own = set(graph.results), set[int]()

    def is_inside(user: int, place: int) -> bool:
        operands = graph.nodes[user].operands
        uses = [i for i, operand in enumerate(operands) if operand == place]
        is_value = user in choices and (uses == [1 + side] or (side == 0 and user in numbers and uses == [2]))
        return user in own or is_value

    roots = [graph.nodes[place].operands[1 + side] for place in choices if side == 0 or place not in numbers]
    for place in reversed(graph.before(roots)):
        node = graph.nodes[place]
        is_made_outside = place in outside or place in ends
        if node.operands and not is_made_outside and all(is_inside(user, place) for user in users[place]):
            own.add(place)
    return sorted(own)


def branch_lines(type_: str, names: Iterable[str], condition: str, sides: Sequence[Sequence[str]]) -> Iterator[str]:
    """The lines of a branch that sets some variables, for the lines of both sides."""
    yield from (f"{type_} {name};" for name in names)
    first, second = sides
    yield f"if ({condition}) {{"
    yield from (f"    {line}" for line in first)
    if second:
        yield "} else {"
        yield from (f"    {line}" for line in second)
    yield "}"
