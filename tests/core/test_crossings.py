"""Crossings: values that one part of an equation hands to the next as numbers, across which nothing is simplified."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.digital_laws import kalman_law, motor_law
from workbench.core import Entry, Layout, Ode, StepMap, StepRule
from workbench.core.crossing import Crossing, without_crossings
from workbench.engine.kernel.casadi_to_graph import read
from workbench.engine.kernel.graph import Graph, Node
from workbench.engine.kernel.graph_rewriting import BARRIER, join_parts, without_barriers
from workbench.engine.kernel.plan import graph_of


def recursion(handed, update, size=1):
    """x+ = update(v, x, k), where v is handed over as handed(x, k)."""
    x, k, none = ca.SX.sym("x", size), ca.SX.sym("k"), ca.SX(0, 1)
    crossing = Crossing.of({"v": ca.SX(handed(x, k))})
    new = ca.densify(ca.SX(update(crossing.symbols, x, k)))
    rule = StepRule(ca.SX.sym("h"), k, ca.SX.sym("t"), x, none, none, none, new, none, (crossing,))
    states = Layout((Entry("x", np.full(size, 1.5)),))
    still = Ode("by hand", states, Layout(), Layout(), rule.t, x, none, ca.SX.zeros(size, 1), none)
    return StepMap(0.1, states, Layout(), Layout(), rule, still, (1.0,))


def after(step, steps=1, **options):
    return wb.simulate(step, until=0.1 * steps, **options).x[0, -1]


@pytest.mark.parametrize("engine", ["numpy", "native"])
@pytest.mark.parametrize("arithmetic", ["portable", "fused"])
def test_a_zero_that_is_handed_over_is_computed_with_as_any_number(engine, arithmetic):
    """Folded, -0 would be 0."""
    step = recursion(lambda x, k: 0.0, lambda v, x, k: ca.vertcat(-v, ca.atan2(-v, -1)), 2)
    x = after(step, engine=engine, arithmetic=arithmetic)
    assert np.signbit(x).all()
    np.testing.assert_array_equal(x, [0, -np.pi])
    assert any(node.op == BARRIER for node in graph_of(step).nodes)


@pytest.mark.parametrize("engine", ["numpy", "native"])
def test_a_gain_is_not_merged_with_one_on_the_other_side(engine):
    x = after(recursion(lambda x, k: 3.3 * x, lambda v, x, k: 4.7 * v), engine=engine, arithmetic="portable")
    assert x[0] == 4.7 * (3.3 * 1.5) != (4.7 * 3.3) * 1.5


def test_each_part_opens_its_own_sums_of_angles():
    """The sines of the parts of a sum are on the other side, and no business of this one."""
    step = recursion(lambda x, k: ca.sin(x) + ca.sin(k), lambda v, x, k: v + ca.sin(x + k))
    assert sum(node.op == "sin" for node in graph_of(step).nodes) == 3


def test_an_operation_that_no_kernel_knows_is_named_with_the_state_behind_the_crossing():
    step = recursion(lambda x, k: ca.erf(x), lambda v, x, k: 2 * v)
    with pytest.raises(ValueError, match=r"has the operation .* 'x.*' needs it"):
        read(step)


def test_derivatives_and_casadi_see_through_a_crossing():
    step = recursion(lambda x, k: 3.3 * ca.sin(x) + k, lambda v, x, k: v * x)
    x = step.rule.x
    slope = ca.Function("slope", [step.rule.k, x], [ca.jacobian(step.rule.next, x)])
    assert float(slope(2, 0.7)) == pytest.approx(3.3 * np.cos(0.7) * 0.7 + 3.3 * np.sin(0.7) + 2, rel=1e-14)
    assert float(step.F(2, 0.7, [], [])) == pytest.approx((3.3 * np.sin(0.7) + 2) * 0.7, rel=1e-15)


def test_plain_replaces_the_symbols_of_all_crossings_one_after_the_other():
    x = ca.SX.sym("x")
    first = Crossing.of({"a": x + 1})
    second = Crossing.of({"b": 2 * first.symbols})
    value = without_crossings((first, second), second.symbols * first.symbols)
    assert float(ca.Function("f", [x], [value])(3.0)) == 32.0


def test_crossings_keep_the_shapes_of_their_values():
    parts = {"K": ca.SX.ones(2, 3), "q": ca.SX.ones(2), "v": ca.SX(1)}
    assert {name: part.shape for name, part in Crossing.of(parts).parts.items()} == {
        "K": (2, 3),
        "q": (2, 1),
        "v": (1, 1),
    }


def test_a_value_that_comes_later_is_refused():
    step = recursion(lambda x, k: x, lambda v, x, k: v)
    early = Crossing.of({"w": step.rule.crossings[0].symbols})
    with pytest.raises(ValueError, match="nothing else gets a value"):
        replace(step.rule, crossings=(early, *step.rule.crossings))
    with pytest.raises(ValueError, match=r"`Crossing\(values=...\)` must have shape"):
        Crossing(early.layout, early.symbols, ca.SX.zeros(2, 1))


def test_without_barriers_a_graph_has_its_operations_alone():
    part = Graph((Node("x"), Node("sin", (0,))), (1,))
    both = join_parts(Graph((Node("v"), Node("neg", (0,))), (1,), (part,)))
    assert [node.op for node in both.nodes] == ["x", "sin", BARRIER, "neg"]
    bare = without_barriers(both)
    assert ([node.op for node in bare.nodes], bare.results) == (["x", "sin", "neg"], (2,))


@pytest.mark.parametrize("make", [motor_law, kalman_law])
def test_the_fingerprint_of_a_loop_tells_what_crosses(make):
    sampled = make()
    joint = replace(sampled, crossings=(), crossing_jump=None)
    assert joint.fingerprint != sampled.fingerprint
    parts = {str(step.rule.parts) for step in (sampled.step(), joint.step())}
    assert len(parts) == 2
    symbols = [sampled.k, sampled.flow.x, sampled.flow.p, sampled.w]
    both = ca.Function("both", symbols, [sampled.jump, without_crossings(sampled.crossings, sampled.crossing_jump)])
    now, then = both(3, sampled.states.default + 0.1, sampled.parameters.default, 0.3)
    np.testing.assert_array_equal(np.array(now), np.array(then))
