"""The bounded loops of an equation as nodes of a graph, with all that does not change in a loop moved before it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate

from workbench.core.bounded_loop import LoopBody
from workbench.engine.kernel.graph import LOOP_SOURCES, Graph, GraphLoop, Node, Nodes, length
from workbench.engine.kernel.graph_rewriting import expand_angle_sums, fuse_products, order_nodes

CARRIED, ROW, SHARED = LOOP_SOURCES


@dataclass(frozen=True, eq=False)
class ReadLoop:
    """A loop, and what stands before it.

    `before` are the nodes that change in no pass, of which "shared" is a value that the call hands over, and
    `places` those among them that the body shares, in its order.
    """

    loop: GraphLoop
    before: tuple[Node, ...]
    places: tuple[int, ...]


def body_source(loop: LoopBody, nodes: Nodes, part: int, entry: int) -> int:
    """The place of an entry of the carried values, of a row, or of the shared values of a body."""
    if part > len(loop.row_sizes):
        return nodes.add(SHARED, entry=entry)
    if part == 0:
        return nodes.add("item", (nodes.add(CARRIED, value=float(loop.carry_size)),), entry=entry)
    row = nodes.add(ROW, value=float(loop.row_sizes[part - 1]), entry=part - 1)
    return nodes.add("item", (row,), entry=entry)


def read_loop(loop: LoopBody, nodes: Nodes, results: Sequence[int]) -> ReadLoop:
    """A loop from the nodes of its body as they are read, and the places of the next carried values and of the rows."""
    sizes = (loop.carry_size, *loop.result_sizes)
    parts = [_parts(nodes, own, hazard=CARRIED) for own in _split(results, sizes)]
    needed = Graph(tuple(nodes.nodes), ()).before(i for part in parts for i in part)
    moving = set[int]()
    for place in needed:
        node = nodes[place]
        if node.op in (CARRIED, ROW) or not moving.isdisjoint(node.operands):
            moving.add(place)
    before, earlier, captured = list[Node](), dict[int, int](), dict[int, int]()
    body, new = list[Node](), dict[int, int]()

    def inside(place: int) -> int:
        """The place in the body of an operand."""
        node = nodes[place]
        if place not in new:
            if node.op != "const" or node.value not in (0.0, 1.0):
                shared = captured.setdefault(earlier[place], len(captured))
                node = Node(SHARED, value=float(length(node)), entry=shared)
            new[place] = len(body)
            body.append(node)
        return new[place]

    for place in needed:
        node = nodes[place]
        if place not in moving:
            earlier[place] = len(before)
            before.append(node._replace(operands=tuple([earlier[i] for i in node.operands])))
            continue
        operands = tuple([inside(i) for i in node.operands])
        new[place] = len(body)
        body.append(node._replace(operands=operands))
    ends = tuple(inside(i) for part in parts for i in part)
    graph = order_nodes(fuse_products(expand_angle_sums(Graph(tuple(body), ends))))
    counts = tuple(map(len, parts))
    whole = GraphLoop(loop.count, loop.backward, loop.carry_size, loop.row_sizes, loop.result_sizes, graph, counts)
    return ReadLoop(whole, tuple(before), tuple(captured))


def add_loop(nodes: Nodes, read: ReadLoop, values: Sequence[int]) -> list[int]:
    """The places of the results of a loop that is handed some values: the carried ones at its end, and all rows."""
    loop = read.loop
    start, *rows, shared = _split(
        values, (loop.carry_size, *(size * loop.count for size in loop.row_sizes), len(values))
    )
    places = list[int]()
    for op, inner, value, entry, own in read.before:
        operands = [places[i] for i in inner]
        if op == SHARED and not value:
            places.append(shared[entry])
        elif op == "array":  # of numbers that may be there as an array already
            places.append(_array(nodes, operands))
        else:
            places.append(nodes.add(op, tuple(operands), value, entry, own))
    first = _parts(nodes, start)
    arrays = [_array(nodes, part) for part in rows]
    captured = [places[i] for i in read.places]
    place = nodes.add("loop", (*first, *arrays, *captured), entry=len(first), loop=loop)
    results = list[int]()
    for i, size in enumerate((loop.carry_size, *(size * loop.count for size in loop.result_sizes))):
        if size:
            array = nodes.add("loop_end", (place,), float(size)) if i == 0 else None
            array = nodes.add("loop_rows", (place,), float(size), i - 1) if array is None else array
            results += [nodes.add("item", (array,), entry=k) for k in range(size)]
    return results


def _split(places: Sequence[int], sizes: Sequence[int]) -> list[Sequence[int]]:
    """The places in groups of these sizes; the last has what is left."""
    ends = list(accumulate(sizes))
    return [places[end - size : end] for end, size in zip(ends, sizes, strict=True)]


def _array(nodes: Nodes, places: Sequence[int]) -> int:
    """The array of some numbers: one that is there already, or a new one."""
    parts = _parts(nodes, places)
    whole = len(parts) == 1 and length(nodes[parts[0]])
    return parts[0] if whole else nodes.add("array", tuple(parts), float(len(places)))


def _parts(nodes: Nodes, places: Sequence[int], hazard: str = "") -> list[int]:
    """The parts of which an array of some numbers is put together: whole parts of arrays, and single numbers.

    Numbers of the source `hazard` stay single: a loop reads all of them before it writes the first.
    """
    parts = list[int]()
    for run in _runs(nodes, places):
        node = nodes[run[0]]
        if len(run) == 1 or nodes[node.operands[0]].op == hazard:
            parts += run
            continue
        (array,) = node.operands
        whole = length(nodes[array]) == len(run)
        parts.append(array if whole else nodes.add("slice", (array,), float(len(run)), node.entry))
    return parts


def _runs(nodes: Nodes, places: Sequence[int]) -> Iterator[list[int]]:
    """The places in groups: numbers that stand one behind the other in one array, or a single one."""
    run = list[int]()
    for place in places:
        node, last = nodes[place], nodes[run[-1]] if run else None
        if last and node.op == last.op == "item" and (node.operands, node.entry) == (last.operands, last.entry + 1):
            run.append(place)
            continue
        if run:
            yield run
        run = [place]
    if run:
        yield run
