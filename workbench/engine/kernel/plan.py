"""Values of a graph that are made once a run, once a step for all runs, and in the loop; their evaluation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Generic

from workbench.core import StepMap
from workbench.engine.kernel.branches import BlockBranch, schedule
from workbench.engine.kernel.casadi_to_graph import read, read_segments
from workbench.engine.kernel.graph import ARRAYS, Graph, GraphLoop, Level, Node, length
from workbench.engine.kernel.graph_rewriting import rewrite
from workbench.engine.kernel.loop_emission import room_of
from workbench.engine.kernel.step_graph import SegmentPlaces, step_graph
from workbench.engine.machines.elementary_functions import Angle
from workbench.engine.machines.formula_table import IN_DOUBLE, QUARTERS, FormulaTable
from workbench.engine.machines.loop_machine import Adopt, BranchingMachine, LoopingMachine, LoopShape, Part, Pass
from workbench.engine.machines.machine import MachineNumber, MachineTruth, Value, select
from workbench.engine.machines.operations import OF_NUMBERS, OPERATIONS, Kind

# Numbers that stand in the code. All others are handed in, so that a step and its half are one kernel.
OF_ARRAYS = frozenset((*ARRAYS, "loop", "item"))
PLAIN = (0.0, 1.0, -1.0, 2.0, 0.5)


@dataclass(frozen=True, eq=False)
class KernelPlan:
    """The places of the nodes of a graph in the order of evaluation, by where they are evaluated."""

    graph: Graph
    numbers: tuple[int, ...]  # of the length of the step alone, that others use
    per_run: tuple[int, ...]  # of parameters too
    per_step: tuple[int, ...]  # of time and of parameters that are equal in all runs
    inside: tuple[int, ...]  # all others of a step
    aside: tuple[int, ...]  # of a segment of a step, made where a step has several
    states: int  # the first results, x+
    lanes: tuple[int, ...]  # before `inside`, made once a run, which the loop finds in memory
    table: tuple[int, ...]  # the same, made once a step
    tables: tuple[int, ...]  # the arrays of parameters that are equal in all runs, of which there is one copy
    record_size: int = 0  # numbers of a step that are recorded

    @staticmethod
    def of_step(step: StepMap, varied_parameters: tuple[int, ...], segments: bool = True) -> KernelPlan:
        """The plan of a step's graph, made once for all lengths; of `graph_of` with its segments or without."""
        return _plan_of(graph_of(step, segments), varied_parameters, step.states.size, int(step.rule.d.numel()))

    @staticmethod
    def of(
        graph: Graph, varied_parameters: Iterable[int], states: int | None = None, record_size: int = 0
    ) -> KernelPlan:
        """The plan where `varied_parameters` differ between runs; of a graph with segments, its number of `states`."""
        states = len(graph.results) if states is None else states
        moving = graph.after("p", set(varied_parameters))
        groups: dict[Level, list[int]] = {level: [] for level in Level}
        for place, level in enumerate(graph.levels):
            groups[Level.STATE if level is Level.TIME and place in moving else level].append(place)
        numbers, per_run, per_step, inside = (tuple(group) for group in groups.values())
        within, still = graph.of_segments, {i for i, n in enumerate(graph.nodes) if n.op == "p" and i not in moving}
        inside, aside = (tuple(i for i in inside if (i in within) is there) for there in (False, True))
        arrays = (i for i in inside if graph.nodes[i].op == "array")
        tables = tuple(i for i in arrays if all(j in still for j in graph.nodes[i].operands))
        moved = [i for i in inside + aside if i not in tables]
        used, needed = (
            {i for place in places for i in graph.nodes[place].operands if not _is_plain(graph.nodes[i])}
            for places in (moved, (*per_run, *per_step, *moved))
        )
        used |= {place for place in graph.results if not _is_plain(graph.nodes[place])}
        return KernelPlan(
            graph,
            tuple(i for i in numbers if i in needed | used),
            per_run,
            per_step,
            inside,
            aside,
            states,
            tuple(i for i in numbers + per_run if i in used),
            tuple(i for i in per_step if i in used),
            tables,
            record_size,
        )

    @cached_property
    def segments(self) -> SegmentPlaces | None:
        """The results of a step that may have several segments; None of any other."""
        more = self.graph.results[self.states :]
        n = (len(more) - 3) // 2
        return SegmentPlaces(more[0], more[1 : n + 1], more[n + 1], more[n + 2], more[n + 3 :]) if more else None

    @cached_property
    def scratch(self) -> int:
        """The numbers of a run that a kernel needs memory for: those made once a run, and the arrays of loops."""
        return len(self.lanes) + room_of(self.graph)

    @cached_property
    def fixed_arrays(self) -> tuple[int, ...]:
        """The arrays of numbers that are all made once a run, but tables."""
        moving, nodes = {*self.inside, *self.aside, *self.per_step}, self.graph.nodes
        arrays = (i for i in self.inside if nodes[i].op == "array" and i not in self.tables)
        return tuple(i for i in arrays if moving.isdisjoint(nodes[i].operands))

    @cached_property
    def entries_of_tables(self) -> Mapping[int, list[int]]:
        """The places of the numbers of each table among the parameters that a kernel is handed."""
        nodes = self.graph.nodes
        return {place: [self.parameters[nodes[i].entry] for i in nodes[place].operands] for place in self.tables}

    @cached_property
    def behind_table(self) -> tuple[int, ...]:
        """The nodes made once a run that the table needs."""
        return tuple(i for i in self.graph.before(self.table) if self.graph.levels[i] is Level.PARAMETERS)

    def constants(self, h: float) -> tuple[float, ...]:
        """The numbers that a kernel is handed, for steps of length h [s]."""
        values = self.graph.numbers(h)
        return tuple(values[place] for place in self.numbers)

    @cached_property
    def constant_places(self) -> Mapping[int, int]:
        """The places of the values of nodes among `constants`."""
        return {place: i for i, place in enumerate(self.numbers)}

    @cached_property
    def parameters(self) -> Mapping[int, int]:
        """The places of parameters, by their index, among those that a kernel is handed: those that the graph has."""
        return {i: place for place, i in enumerate(sorted(n.entry for n in self.graph.nodes if n.op == "p"))}


def graph_of(step: StepMap, segments: bool = True) -> Graph:
    """The graph of a step as every kernel evaluates it, made once for all lengths; refused as by `read`.

    Without its segments it serves runs that have no switch within a step, with the same bits.
    """
    parts = read_segments(step) if segments else None
    parts = None if parts is None else _rewrite(parts)
    return _step_graph(pass_of(step), int(step.rule.rate.numel()), parts, step.rule.method)


def pass_of(step: StepMap) -> Graph:
    """The graph of a step's rates and updates, as every stage of it evaluates them; refused as by `read`."""
    return _rewrite(read(step))


_rewrite = lru_cache(maxsize=128)(rewrite)
_step_graph = lru_cache(maxsize=128)(step_graph)


@lru_cache(maxsize=128)
def _plan_of(graph: Graph, varied_parameters: tuple[int, ...], states: int, record_size: int) -> KernelPlan:
    return KernelPlan.of(graph, varied_parameters, states, record_size)


def _is_plain(node: Node) -> bool:
    return node.op == "const" and node.value in PLAIN


class Evaluation(Generic[Value]):
    """The evaluation of nodes in their order; a value that is not made here is loaded when it is first needed."""

    def __init__(
        self,
        graph: Graph,
        machine: LoopingMachine[Value],
        load: Callable[[int], Value],
        functions: FormulaTable = IN_DOUBLE,
    ) -> None:
        self.graph = graph
        self.machine = machine
        self.load = load
        self.functions = functions
        self.numbers: dict[int, MachineNumber[Value]] = {}
        self.truths: dict[int, MachineTruth[Value]] = {}
        self.angles: dict[int, Angle[Value]] = {}
        self.arrays: dict[int, Value] = {}
        self.loops: dict[int, Sequence[Value]] = {}  # the arrays at the end of each loop

    def make(self, places: Iterable[int]) -> None:
        """The values of these nodes, whose operands are made before them or loaded."""
        for place in places:
            if place not in self.arrays:
                self._make(place, self.graph.nodes[place])

    def make_body(self, loop: GraphLoop) -> None:
        """The values of the body of a loop, with its branches where the machine has them."""
        if not isinstance(self.machine, BranchingMachine):
            self.make(range(len(loop.body.nodes)))
            return
        is_of_numbers = loop.parts[0] == loop.carry_size
        for one in schedule(loop.body, loop.body.results[: loop.carry_size] if is_of_numbers else ()):
            if isinstance(one, BlockBranch):
                self._make_branch(self.machine, one)
            else:
                self._make(one, self.graph.nodes[one])

    def _make_branch(self, machine: BranchingMachine[Value], branch: BlockBranch) -> None:
        """The choices of a branch; what is made inside of it is not known outside."""
        nodes = self.graph.nodes
        condition = self.truth(branch.condition).value
        old = [self.value(nodes[place].operands[2]) for place in branch.choices]
        in_place = [(self.arrays[branch.array], entry) for entry in branch.in_place.values()]
        known = dict(self.numbers), dict(self.truths), dict(self.angles)

        def new() -> Iterator[Value]:
            for place, inside in zip(branch.places, branch.inside, strict=True):
                self.make(inside)
                yield self.value(nodes[place].operands[1])

        values = machine.branch(condition, old, in_place, new)
        self.numbers, self.truths, self.angles = known
        for place, value in zip(branch.places, values, strict=True):
            self.numbers[place] = MachineNumber(self.machine, value)

    def value(self, place: int) -> Value:
        """The machine's own object for a value."""
        return self.number(place).value

    def number(self, place: int) -> MachineNumber[Value]:
        """A value as a number: 1 or 0 for a truth."""
        node = self.graph.nodes[place]
        if node.op == "const" and node.value in PLAIN:
            return MachineNumber(self.machine, self.machine.constant(node.value))
        if place not in self.numbers:
            truth = self.truths.get(place)
            made = select(truth, 1.0, 0.0) if truth else MachineNumber(self.machine, self.load(place))
            self.numbers[place] = made
        return self.numbers[place]

    def truth(self, place: int) -> MachineTruth[Value]:
        """A value as a truth: nonzero is true."""
        if place not in self.truths:
            self.truths[place] = self.number(place).compare("ne", 0.0)
        return self.truths[place]

    def _make(self, place: int, node: Node) -> None:
        op, operands = node.op, node.operands
        if op in OF_ARRAYS or length(node):
            self._make_of_arrays(place, node)
        elif not operands:
            self.number(place)
        elif op in QUARTERS:
            if operands[0] not in self.angles:
                self.angles[operands[0]] = self.functions.reduce_angle(self.number(operands[0]))
            self.numbers[place] = self.functions.sine_or_cosine(self.angles[operands[0]], QUARTERS[op])
        else:
            given = map(self.number, operands) if op in OF_NUMBERS else self._operands(op, operands)
            made = self.functions.formulas[op](*given)
            if isinstance(made, MachineNumber):
                self.numbers[place] = made
            else:
                assert isinstance(made, MachineTruth)
                self.truths[place] = made

    def _make_of_arrays(self, place: int, node: Node) -> None:
        """A loop, an array, or an entry of one."""
        machine, operands = self.machine, node.operands
        match node.op:
            case "loop":
                self.loops[place] = self._loop(node)
            case "loop_end":
                self.arrays[place] = self.loops[operands[0]][0]
            case "loop_rows":
                self.arrays[place] = self.loops[operands[0]][1 + node.entry]
            case "item":
                self.numbers[place] = MachineNumber(machine, machine.item(self.part(operands[0]).value, node.entry))
            case "slice":
                self.arrays[place] = machine.slice(self.part(operands[0]).value, node.entry, length(node))
            case "array":
                self.arrays[place] = machine.array([self.part(i) for i in operands])
            case _:
                self.arrays[place] = self.load(place)

    def part(self, place: int) -> Part[Value]:
        """A value as a part of an array: a number, or an array with its length."""
        size = length(self.graph.nodes[place])
        return Part(self.arrays[place] if size else self.value(place), size)

    def _loop(self, node: Node) -> Sequence[Value]:
        loop, parts = node.loop, [self.part(i) for i in node.operands]
        assert loop is not None
        first, last = node.entry, node.entry + len(loop.row_sizes)
        rows, shared = [part.value for part in parts[first:last]], parts[last:]

        def body(machine: LoopingMachine[Value], own: Sequence[Value], adopt: Adopt[Value]) -> Pass[Value]:
            def load(place: int) -> Value:
                op, _, _, entry, _ = loop.body.nodes[place]
                return adopt(shared[entry]) if op == "shared" else own[0 if op == "carried" else 1 + entry]

            inner = Evaluation(loop.body, machine, load, self.functions)
            inner.make_body(loop)
            return loop.split([inner.part(place) for place in loop.body.results])

        shape = LoopShape(
            loop.count, loop.backward, loop.carry_size, loop.row_sizes, loop.result_sizes, loop.carries_items
        )
        return self.machine.loop(shape, parts[:first], rows, body)

    def _operands(self, op: str, places: Sequence[int]) -> Iterator[MachineNumber[Value] | MachineTruth[Value]]:
        kinds = zip(places, OPERATIONS[op].operands, strict=True)
        return (self.truth(i) if kind is Kind.TRUTH else self.number(i) for i, kind in kinds)
