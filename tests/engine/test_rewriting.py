"""From CasADi's operations to a graph with less work in it."""

import casadi as ca
import numpy as np
import pytest

from tests.support.equations import decay, oscillator
from workbench.arms.mechanics.arm_catalogue import planar
from workbench.core import Entry, Layout, Ode, rk4
from workbench.engine.kernel.casadi_to_graph import read
from workbench.engine.kernel.graph import Graph, Level, Node, Nodes
from workbench.engine.kernel.graph_rewriting import expand_angle_sums, fuse_products
from workbench.engine.kernel.plan import graph_of


def equation(*rates):
    """x' = the rates, functions of (t, x, p) with two parameters."""
    states, parameters = Layout((Entry("x", np.ones(len(rates))),)), Layout((Entry("p", np.ones(2)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    return Ode.of("probe", states, parameters, (t, x, p), {"x": ca.vertcat(*[r(t, x, p) for r in rates])}, {"e": x})


def ops(graph):
    return [node.op for node in graph.nodes]


def test_a_graph_holds_every_operation_once_and_nothing_without_use():
    graph = graph_of(rk4(oscillator(), 0.01))
    assert len(set(graph.nodes)) == len(graph.nodes)
    used = {i for node in graph.nodes for i in node.operands} | set(graph.results)
    assert used == set(range(len(graph.nodes)))


def test_divisions_by_one_number_share_its_reciprocal():
    graph = read(rk4(equation(lambda t, x, p: x[0] / p[0], lambda t, x, p: x[1] / p[0]), 0.1))
    assert ops(graph).count("inv") == 1
    assert graph.levels[ops(graph).index("inv")] is Level.PARAMETERS


def test_a_product_used_once_in_a_sum_of_its_level_is_rounded_with_it():
    # x + h/2 (-3 x) in the second stage: product and sum change with the state
    graph = graph_of(rk4(decay(), 0.1))
    assert {"fma", "fnma"} & set(ops(graph))
    # p0 p1 is a product of parameters: it stays alone, as it is made once and not in the loop
    graph = graph_of(rk4(equation(lambda t, x, p: x[0] * x[0] + p[0] * p[1]), 0.1))
    products = [i for i, node in enumerate(graph.nodes) if node.op == "mul" and graph.levels[i] is Level.PARAMETERS]
    assert products


def test_what_is_fused_computes_the_same():
    nodes = Nodes()
    x, y, z = (nodes.add("x", entry=i) for i in range(3))
    product = nodes.add("mul", (x, y))
    results = [nodes.add(*pair) for pair in (("add", (product, z)), ("sub", (nodes.add("mul", (y, z)), x)))]
    results.append(nodes.add("sub", (x, nodes.add("mul", (x, z)))))
    graph = Graph(tuple(nodes.nodes), tuple(results))
    assert sorted(op for op in ops(fuse_products(graph)) if op != "x") == ["fma", "fms", "fnma"]
    # a product that two sums use stays, and is made once
    graph = Graph((*nodes.nodes, Node("add", (product, x))), (*results, len(nodes.nodes)))
    assert ops(fuse_products(graph)).count("mul") == 1


def test_the_sine_of_a_sum_comes_from_those_of_its_parts_where_both_are_needed():
    both = equation(lambda t, x, p: ca.sin(x[0] + x[1]) + ca.sin(x[0]), lambda t, x, p: ca.cos(x[1]))
    before, after = read(rk4(both, 0.1)), expand_angle_sums(read(rk4(both, 0.1)))
    angles = [len({n.operands[0] for n in g.nodes if n.op in ("sin", "cos")}) for g in (before, after)]
    assert angles[0] - angles[1] == 1
    alone = read(rk4(equation(lambda t, x, p: ca.sin(x[0] + x[1]), lambda t, x, p: ca.cos(x[1])), 0.1))
    assert ops(expand_angle_sums(alone)) == ops(alone)


@pytest.mark.parametrize("links", [2, 4, 7])
def test_an_arm_of_n_links_needs_no_more_angles_than_links_in_its_mass_matrix(links):
    arm = planar(links)
    states = Layout((Entry("q", np.ones(links)),))
    q = states.symbols()
    M = ca.vec(arm.mass_matrix(q))
    G = arm.gravity_vector(q)
    total = ca.sum1(M) + ca.sum1(G)
    ode = Ode.of("arm", states, Layout(), (ca.SX.sym("t"), q, ca.SX(0, 1)), {"q": total * ca.DM.ones(links)}, {"e": q})
    graph = expand_angle_sums(read(rk4(ode, 0.1)))
    first = {n.operands[0] for n in graph.nodes if n.op in ("sin", "cos")}
    assert len(first) <= 4 * links


def test_a_choice_is_one_operation():
    graph = graph_of(rk4(equation(lambda t, x, p: ca.if_else(x[0] > 0, x[0], p[0])), 0.1))
    assert ops(graph).count("if_else") == 4  # one a stage
    assert "not" not in ops(graph)


def test_an_unknown_operation_is_named_with_the_state_that_needs_it():
    step = rk4(equation(lambda t, x, p: x[0], lambda t, x, p: ca.erf(x[1])), 0.1)
    with pytest.raises(
        ValueError, match=r"The step of 'probe' has the operation ERF, which the batch engine does not know; 'x\[1\]'"
    ):
        read(step)
