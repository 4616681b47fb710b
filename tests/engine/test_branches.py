"""Branches in loops: what only a condition asks for is left out where it holds for no run, and changes no bit."""

import re

import casadi as ca
import numpy as np
import pytest

from tests.support.compilers import needs_llvmlite
from workbench.core import Entry, Layout, Ode, rk4
from workbench.core.bounded_loop import bounded_loop
from workbench.engine import simulate
from workbench.engine.kernel import native
from workbench.engine.kernel.branches import BlockBranch, schedule
from workbench.engine.kernel.graph import Graph, Node
from workbench.engine.kernel.loop_emission import MOST_REGISTERS, waits_in_loops
from workbench.engine.kernel.lowering import lower
from workbench.engine.kernel.plan import KernelPlan, graph_of

COUNT = 5


def heavy(x, k):
    """Some operations, more than a branch costs."""
    for i in range(12):
        x = x * (0.7 + 0.01 * i * k) + 0.1
    return x


def chosen(size):
    """A body that moves the first half of its carried numbers where a row is positive, and reads the others."""

    def body(c, row):
        half = size // 2
        moved = ca.vertcat(*(heavy(c[i], i) * row for i in range(half)))
        first = ca.if_else(row > 0, moved, c[:half])
        return ca.vertcat(first, c[half:] + 0.1 * ca.if_else(row > 0, heavy(c[-1], 1), 0.0)), ca.sum1(first)

    return body


def crossed(size):
    """A body whose next carried numbers each need another one."""

    def body(c, row):
        others = ca.vertcat(*(heavy(c[(i + 1) % size], i) for i in range(size)))
        return ca.if_else(row > 0, 0.3 * others, c), c[0]

    return body


def swept(size):
    """A body that moves its carried numbers by a loop where a row is positive."""

    def body(c, row):
        (end,) = bounded_loop(4, lambda e, own: (heavy(e, 1) + 0.1 * own,), c, constants=(c,))
        return ca.if_else(row > 0, end, c), ca.sum1(c)

    return body


def equation(body, size, spread=1.0):
    """x' of two states, by a loop whose rows depend on the state."""
    states = Layout((Entry("a", np.array(0.4)), Entry("b", np.array(-0.7))))
    parameters = Layout((Entry("p", np.array(0.9)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    rows = ca.horzcat(*(ca.sin(x[0] * (i + 1) + spread * p) for i in range(COUNT)))
    start = ca.vertcat(*(0.1 * i + x[1] for i in range(size)))
    end, made = bounded_loop(COUNT, body, start, rows)
    rates = {"a": -x[0] + ca.sin(ca.sum1(end)), "b": ca.cos(ca.sum2(made)) - x[1]}
    return Ode.of("branched", states, parameters, (t, x, p), rates, {})


def branches(step):
    """The branches of the loop in the first of the four stages of a step."""
    loop = next(node.loop for node in graph_of(step).nodes if node.loop is not None)
    order = schedule(loop.body, loop.body.results[: loop.carry_size])
    return [one for one in order if isinstance(one, BlockBranch)]


CASES = [(body, size) for body in (chosen, crossed) for size in (4, MOST_REGISTERS + 4)]
NAMES = [f"{body.__name__}-{size}" for body, size in CASES]


@needs_llvmlite
@pytest.mark.parametrize(("body", "size"), [*CASES, (swept, 4), (swept, 26)], ids=[*NAMES, "swept-4", "swept-26"])
@pytest.mark.parametrize("arithmetic", ["fused", "portable"])
def test_a_branch_has_the_bits_of_numpy_which_makes_both_sides(body, size, arithmetic):
    ode = equation(body(size), size)
    p = ode.parameters.pack({"p": np.linspace(-3.0, 3.0, 21)})
    span = {"until": 1.0, "every": 0.1, "arithmetic": arithmetic}
    numpy, compiled = (simulate(rk4(ode, 0.1), p, engine=engine, **span).x for engine in ("numpy", "native"))
    np.testing.assert_array_equal(numpy.view(np.uint64), compiled.view(np.uint64))
    alone = [simulate(rk4(ode, 0.1), row, **span).x[0] for row in p[::7]]
    np.testing.assert_array_equal(alone, compiled[::7])


@needs_llvmlite
def test_better_code_for_two_blocks_at_once_has_the_same_bits(monkeypatch):
    step = rk4(equation(chosen(4), 4), 0.1)
    p = step.parameters.pack({"p": np.linspace(-3.0, 3.0, 21)})
    hasty = simulate(step, p, until=1.0).x
    monkeypatch.setattr(native, "WORTH_COMPILING", 0)
    np.testing.assert_array_equal(simulate(step, p, until=1.0).x, hasty)
    assert waits_in_loops(graph_of(step))
    assert not waits_in_loops(graph_of(rk4(equation(chosen(26), 26), 0.1)))  # too many numbers for the registers


@pytest.mark.parametrize(("body", "size"), CASES, ids=NAMES)
def test_one_condition_is_one_branch_with_all_that_only_it_needs(body, size):
    (branch,) = branches(rk4(equation(body(size), size), 0.1))
    assert len(branch.places) == (size // 2 + 1 if body is chosen else size)
    assert sum(map(len, branch.inside)) > 12 * len(branch.places)


def test_a_branch_may_hold_a_loop():
    (branch,) = branches(rk4(equation(swept(4), 4), 0.1))
    graph = next(node.loop for node in graph_of(rk4(equation(swept(4), 4), 0.1)).nodes if node.loop is not None).body
    assert any(graph.nodes[i].loop for part in branch.inside for i in part)


def test_carried_numbers_stay_where_they_are_if_no_other_choice_reads_them():
    size = MOST_REGISTERS + 4
    (kept,), (crossing,) = (branches(rk4(equation(body(size), size), 0.1)) for body in (chosen, crossed))
    assert not crossing.in_place  # each is read by the choice of another
    assert not kept.in_place  # their sum is a row that the loop makes

    def alone(c, row):
        return ca.if_else(row > 0, ca.vertcat(*(heavy(c[i], i) for i in range(size))), c), c[0] + row

    (branch,) = branches(rk4(equation(alone, size), 0.1))
    assert sorted(branch.in_place.values()) == list(range(1, size))  # the first number is read by the row, too


@needs_llvmlite
def test_a_loop_inside_reads_the_carried_numbers_as_they_were():
    size = 4

    def body(c, row):
        (_, read) = bounded_loop(size, lambda none, one: (none, heavy(one, 1)), ca.SX(0, 1), c.T)
        return ca.if_else(row > 0, ca.vertcat(*(heavy(c[i], i) for i in range(size))), c), ca.sum2(read)

    ode = equation(body, size)
    p = ode.parameters.pack({"p": np.linspace(-3.0, 3.0, 21)})
    span = {"until": 1.0, "every": 0.1, "arithmetic": "fused"}
    numpy, compiled = (simulate(rk4(ode, 0.1), p, engine=engine, **span).x for engine in ("numpy", "native"))
    np.testing.assert_array_equal(numpy.view(np.uint64), compiled.view(np.uint64))
    assert not branches(rk4(ode, 0.1))[0].in_place


@needs_llvmlite
def test_kept_numbers_have_the_bits_of_numpy():
    size = MOST_REGISTERS + 4

    def alone(c, row):
        return ca.if_else(row > 0.3, ca.vertcat(*(heavy(c[i], i) for i in range(size))), c), row

    ode = equation(alone, size)
    p = ode.parameters.pack({"p": np.linspace(-3.0, 3.0, 21)})
    (branch,) = branches(rk4(ode, 0.1))
    assert len(branch.in_place) == size
    span = {"until": 1.0, "every": 0.1, "arithmetic": "fused"}
    numpy, compiled = (simulate(rk4(ode, 0.1), p, engine=engine, **span).x for engine in ("numpy", "native"))
    np.testing.assert_array_equal(numpy.view(np.uint64), compiled.view(np.uint64))


def test_the_lines_of_a_branch_are_passed_over():
    step = rk4(equation(chosen(4), 4), 0.1)
    ir = lower(KernelPlan.of_step(step, (0,)), 4)
    assert len(re.findall(r"^v_branch_\d+_end:$", ir, re.MULTILINE)) == 4  # stages of the step
    light = rk4(equation(lambda c, row: (ca.if_else(row > 0, c * row, c), row), 4), 0.1)
    assert "_branch_" not in lower(KernelPlan.of_step(light, (0,)), 4)  # it would cost more than it saves


def test_branches_that_need_each_other_are_not_both_made():
    """The second choice of each condition needs the first one of the other."""
    nodes = [Node("carried", value=4.0), *(Node("item", (0,), entry=i) for i in range(4))]

    def add(op, *operands):
        nodes.append(Node(op, operands))
        return len(nodes) - 1

    def long(place):
        for _ in range(12):
            place = add("mul", place, 1)
        return place

    p, q = add("lt", 1, 2), add("lt", 2, 3)
    a, b = (add("if_else", truth, long(place), 4) for truth, place in ((p, 1), (q, 2)))
    c, d = (add("if_else", truth, long(place), 4) for truth, place in ((p, b), (q, a)))
    graph = Graph(tuple(nodes), (c, d, a, b))
    order = schedule(graph, graph.results)
    assert sum(isinstance(one, BlockBranch) for one in order) == 1
    done = set()
    for one in order:
        assert done.issuperset(one.needs if isinstance(one, BlockBranch) else nodes[one].operands)
        done |= {*one.places, *(i for part in one.inside for i in part)} if isinstance(one, BlockBranch) else {one}
    assert done == set(range(len(nodes)))
