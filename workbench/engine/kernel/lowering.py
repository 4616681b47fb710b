"""Lowering: a plan as LLVM IR, the time loop in native functions over vectors of runs.

A block is `width` runs side by side; whatever belongs to runs is an array of vectors, one lane a run.

    void workbench_table(i64 groups, i64 begin, ptr constants, ptr p, ptr table)
    i1 workbench_piece(i64 blocks, i64 rows, i64 stride, i64 begin, i64 row, i64 kept, i64 seed, ptr runs,
                       ptr constants, ptr p, ptr scratch, ptr table, ptr x, ptr out)

The first makes the table of what depends on time alone, for groups of `width` steps from step `begin` on: (groups, nt,
width). The second advances one block after the other by `rows` times `stride` steps, and says if a run is finite then.
`p` holds the parameters (blocks, np, width), `runs` and `seed` the keys of the noise, `x` the states (blocks, nx,
width), which it receives again; `out` (blocks, kept, nx, width) receives the rows from `row` on. `scratch` has room for
the values made once a run, and for the arrays of loops (nl, width). For a recorded step there is one argument more:
`recorded`, its numbers (steps, nd) from step `begin` on.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

from workbench.engine.kernel.emission import Emission
from workbench.engine.kernel.kept_rows import make_rows, nodes_of_steps, states_of_rows
from workbench.engine.kernel.loop_emission import Room
from workbench.engine.kernel.noise import normals_on
from workbench.engine.kernel.plan import KernelPlan
from workbench.engine.machines.llvm_spelling import declarations
from workbench.engine.machines.machine import MachineNumber

STACK = 'alignstack(64) "stackrealign"'  # of a function that is called from code with a narrower stack


def lower(plan: KernelPlan, width: int, fused_products: bool = True, stack: str = STACK) -> str:
    """The IR of a plan for vectors of `width` runs, with `fused_products` or without, and how to keep the stack."""
    truth = f"declare i1 @llvm.vector.reduce.or.v{width}i1(<{width} x i1>)"
    functions = [
        _piece(plan, width, fused_products, stack),
        *([_table(plan, width, fused_products, stack)] if plan.table else ()),
    ]
    return "\n".join([*declarations(width), truth, *functions])


PIECE = """
define i1 @workbench_piece(i64 %blocks, i64 %rows, i64 %stride, i64 %begin, i64 %row, i64 %kept, i64 %seed,
        ptr %runs, ptr %constants, ptr %p, ptr %scratch, ptr %table, ptr %x, ptr %out{recorded})
        {stack} {{
start:
  br label %block
block:                                            ; {width} runs side by side
  %b = phi i64 [ 0, %start ], [ %b1, %next ]
  %alive = phi i1 [ false, %start ], [ %alive1, %next ]
  %p_skip = mul i64 %b, {np}
  %p_here = getelementptr {vector}, ptr %p, i64 %p_skip
  %x_skip = mul i64 %b, {nx}
  %x_here = getelementptr {vector}, ptr %x, i64 %x_skip
  %key_at = getelementptr {integers}, ptr %runs, i64 %b
  %key = load {integers}, ptr %key_at
{prepare}
  br label %row_begins
row_begins:
  %j = phi i64 [ 0, %{prepared} ], [ %j1, %{kept} ]
  %past = mul i64 %j, %stride
  br label %enter
enter:
{enter}
  br label %step
step:
  %i = phi i64 [ 0, %enter ], [ %i1, %{latch} ]
{states}
  %here = add i64 %past, %i
  %k = add i64 %here, %begin
  %group = sdiv i64 %here, {width}
  %member = srem i64 %here, {width}
  %group_skip = mul i64 %group, {group_size}
  %time_skip = add i64 %group_skip, %member
  %time_here = getelementptr double, ptr %table, i64 %time_skip
{row_of_step}{body}
{segments}  %i1 = add i64 %i, 1
  %more = icmp slt i64 %i1, %stride
  br i1 %more, label %step, label %keep
keep:
  %rows_before = mul i64 %b, %kept
  %row_of_block = add i64 %rows_before, %row
  %row_at = add i64 %row_of_block, %j
  %row_skip = mul i64 %row_at, {nx}
  %out_here = getelementptr {vector}, ptr %out, i64 %row_skip
{keep}
  %j1 = add i64 %j, 1
  %again = icmp slt i64 %j1, %rows
  br i1 %again, label %row_begins, label %next
next:
{alive}
  %b1 = add i64 %b, 1
  %go = icmp slt i64 %b1, %blocks
  br i1 %go, label %block, label %end
end:
  ret i1 %alive1
}}"""

RECORDED = """  %recorded_skip = mul i64 %here, {nd}
  %recorded_here = getelementptr double, ptr %recorded, i64 %recorded_skip
"""

# The part of a step in which some run has several segments: one segment of all runs after the other.
SEGMENTS = """  br i1 {several}, label %segment, label %whole
segment:
{phis}
{body}
  br i1 {more}, label %segment, label %segmented
segmented:
{chosen}
  br label %whole
whole:
{ends}
"""

TABLE = """
define void @workbench_table(i64 %groups, i64 %begin, ptr %constants, ptr %p, ptr %table)
            {stack} {{
start:
{prepare}
  br label %group
group:                                            ; {width} steps side by side
  %g = phi i64 [ 0, %start ], [ %g1, %group ]
  %past = mul i64 %g, {width}
  %first = add i64 %past, %begin
  %alone = insertelement {integers} poison, i64 %first, i64 0
  %same = shufflevector {integers} %alone, {integers} poison, <{width} x i32> zeroinitializer
  %steps = add {integers} %same, {counting}
  %time = sitofp {integers} %steps to {vector}
  %table_skip = mul i64 %g, {nt}
  %table_here = getelementptr {vector}, ptr %table, i64 %table_skip
{body}
  %g1 = add i64 %g, 1
  %go = icmp slt i64 %g1, %groups
  br i1 %go, label %group, label %end
end:
  ret void
}}"""


def _piece(plan: KernelPlan, width: int, fused_products: bool, stack: str) -> str:
    graph = plan.graph
    lane, row = ({place: i for i, place in enumerate(places)} for places in (plan.lanes, plan.table))

    def outside(e: Emission, place: int) -> str:
        if place in plan.constant_places:
            return e.broadcast("%constants", plan.constant_places[place])
        return e.lane("%p_here", plan.parameters[graph.nodes[place].entry])

    def inside(e: Emission, place: int) -> str:
        node = graph.nodes[place]
        if place in lane:
            return e.lane("%scratch", lane[place])
        if place in row:
            return e.broadcast("%time_here", row[place] * width)
        if node.op in ("x", "d"):
            return f"%x{node.entry}" if node.op == "x" else e.broadcast("%recorded_here", node.entry)
        steps = e.splat("%k", "i64")
        return _noise(e, place, steps) if node.op == "w" else e.do("signed", steps)

    room = Room("%scratch", len(plan.lanes))
    before = Emission(graph, width, fused_products, "u", outside, "block", room)
    body = Emission(graph, width, fused_products, "v", inside, "step", room)
    _make_per_run(plan, before, body)
    body.evaluation.make(nodes_of_steps(plan))
    of_rows, (keep, ends) = states_of_rows(plan), make_rows(plan, body, inside)
    latch, segments, ends = _segments(plan, body, ends) if plan.segments else (body.block, "", ends)
    enter, last = (Emission(graph, width, fused_products, prefix, inside) for prefix in ("s", "w"))
    for base in ("%x_here", "%out_here"):
        keep.store(base, ends)
    _any_finite(last, ends)
    moved = [(i, enter.lane("%x_here", i), end) for i, end in enumerate(ends) if i not in of_rows]
    states = (f"  %x{i} = phi {body.type} [ {a}, %enter ], [ {b}, %{latch} ]" for i, a, b in moved)
    return PIECE.format(
        stack=stack,
        vector=body.type,
        integers=body.integers,
        **_sizes(plan, width),
        **_recorded_parts(plan),
        states="\n".join(states),
        prepare=before,
        prepared=before.block,
        enter=enter,
        body=body,
        segments=segments,
        latch=latch,
        keep=keep,
        kept=keep.block,
        alive=last,
    )


def _make_per_run(plan: KernelPlan, before: Emission, body: Emission) -> None:
    """The numbers and arrays that are made once a run, and found by the body in memory."""
    before.evaluation.make(plan.per_run)
    before.store("%scratch", map(before.evaluation.value, plan.lanes))
    before.evaluation.make(plan.fixed_arrays)
    before.evaluation.arrays |= {i: before.table("%p_here", own) for i, own in plan.entries_of_tables.items()}
    body.evaluation.arrays |= before.evaluation.arrays


def _sizes(plan: KernelPlan, width: int) -> dict[str, int]:
    """The lengths of the rows in memory."""
    return {"width": width, "np": len(plan.parameters), "nx": plan.states, "group_size": len(plan.table) * width}


def _recorded_parts(plan: KernelPlan) -> dict[str, str]:
    """The argument of the recorded numbers, and the lines that find those of a step; empty if there are none."""
    if not plan.record_size:
        return {"recorded": "", "row_of_step": ""}
    return {"recorded": ", ptr %recorded", "row_of_step": RECORDED.format(nd=plan.record_size)}


def _segments(plan: KernelPlan, step: Emission, ends: Sequence[str]) -> tuple[str, str, list[str]]:
    """The loop over the segments of a step, behind its other operations, which make the states `ends`.

    The block in which it ends, its lines, and the states behind it.
    """
    assert plan.segments is not None
    graph, places, width, number = plan.graph, plan.segments, step.width, step.type
    within = graph.of_segments

    def load(e: Emission, place: int) -> str:
        node = graph.nodes[place]
        if place not in within:
            return str(step.evaluation.value(place))  # in lines before the loop, which so are done once
        return "%s" if node.op == "s" else f"%z{node.entry}"

    e, chosen = (
        Emission(graph, width, step.fused_products, "q", load, "segment", step.room),
        Emission(graph, width, step.fused_products, "c", load),
    )
    begins = [step.evaluation.value(place) for place in places.start]
    several = step.evaluation.truth(places.several).value
    e.evaluation.make(plan.aside)
    end, z = e.evaluation.value(places.end), [e.evaluation.value(place) for place in places.ends]
    more = _some(e, e.evaluation.truth(places.more).value)
    phis = [f"  %s = phi {number} [ {step.constant(0.0)}, %{step.block} ], [ {end}, %{e.block} ]"]
    phis += [f"  %z{i} = phi {number} [ {begins[i]}, %{step.block} ], [ {z[i]}, %{e.block} ]" for i in range(len(z))]
    picked = [chosen.do("select", several, new, old) for new, old in zip(z, ends, strict=False)]
    joined = (
        f"  %whole{i} = phi {number} [ {ends[i]}, %{step.block} ], [ {picked[i]}, %segmented ]" for i in range(len(z))
    )
    text = SEGMENTS.format(
        several=_some(step, several), phis="\n".join(phis), body=e, more=more, chosen=chosen, ends="\n".join(joined)
    )
    return "whole", text, [*(f"%whole{i}" for i in range(len(z))), *ends[len(z) :]]


def _some(e: Emission, truths: str) -> str:
    """The instruction that says if a truth holds in any lane."""
    return e.line(f"call i1 @llvm.vector.reduce.or.v{e.width}i1({e.flags} {truths})")


def _noise(e: Emission, place: int, steps: str) -> str:
    """A normal number at some steps, made together with all others of these steps."""
    noise = {i: node.entry for i, node in enumerate(e.evaluation.graph.nodes) if node.op == "w"}
    names: list[str] = normals_on(e, e.splat("%seed", "i64"), "%key", steps, 1 + max(noise.values()))
    e.evaluation.numbers |= {i: MachineNumber(e, names[entry]) for i, entry in noise.items()}
    return names[noise[place]]


def _any_finite(e: Emission, states: list[str]) -> None:
    """The line that says if this or an earlier block has a run with finite states: of a finite number, x - x is 0."""
    total = reduce(MachineNumber.__add__, [MachineNumber(e, x) - MachineNumber(e, x) for x in states])
    some = _some(e, total.compare("eq", total).value)
    e.lines.append(f"  %alive1 = or i1 %alive, {some}")


def _table(plan: KernelPlan, width: int, fused_products: bool, stack: str) -> str:
    graph = plan.graph

    def outside(e: Emission, place: int) -> str:
        node = graph.nodes[place]
        if place in plan.constant_places:
            return e.broadcast("%constants", plan.constant_places[place])
        return e.broadcast("%p", plan.parameters[node.entry] * width)

    def inside(e: Emission, place: int) -> str:
        return "%time" if graph.nodes[place].op == "k" else before.evaluation.value(place)

    before, body = (
        Emission(graph, width, fused_products, "u", outside),
        Emission(graph, width, fused_products, "v", inside),
    )
    before.evaluation.make(plan.behind_table)
    body.evaluation.make(plan.per_step)
    body.store("%table_here", map(body.evaluation.value, plan.table))
    return TABLE.format(
        stack=stack,
        width=width,
        vector=body.type,
        integers=body.integers,
        counting=f"<{', '.join(f'i64 {i}' for i in range(width))}>",
        nt=len(plan.table),
        prepare=before,
        body=body,
    )
