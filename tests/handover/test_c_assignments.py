"""A graph as assignments in C: where a value gets a variable, and what a function calls."""

import pytest

from workbench.engine.kernel.graph import Graph, Node
from workbench.engine.machines.c_real import DOUBLE, SINGLE
from workbench.engine.machines.c_spelling import Text
from workbench.engine.machines.operations import OPERATIONS, Kind, Role, Tightness, with_role
from workbench.handover.c99.c_assignments import CCall, Demand, ValueForm, assignments
from workbench.handover.c99.c_scope import Scope

X = [Node("x", entry=i) for i in range(3)]
SOURCES = {i: Text("xyz"[i], Tightness.ATOM, plain=True) for i in range(3)}


def scope_of(nodes, results, numbers=None, **options):
    return Scope(Graph((*X, *nodes), results), "law", options.pop("real", DOUBLE), numbers or {}, SOURCES, **options)


def written(scope, wanted=ValueForm.TEXT):
    """The lines and the texts of the results, and the names of what they call."""
    made = assignments(scope, [Demand(scope.graph.results), Demand(scope.graph.results, wanted)])
    lines = [line for answer in made.answers for line in answer.lines]
    return lines, list(made.answers[-1].texts), [call.name for call in made.calls]


def test_a_value_that_is_used_once_stands_in_its_place():
    scope = scope_of([Node("mul", (0, 1)), Node("sub", (3, 2))], (4,))
    assert written(scope) == ([], ["(x * y) - z"], [])


def test_a_value_that_is_used_twice_gets_a_variable():
    scope = scope_of([Node("add", (0, 1)), Node("mul", (3, 3))], (4,))
    assert written(scope) == (["const double w_1 = x + y;"], ["w_1 * w_1"], [])


def test_a_value_with_a_name_gets_a_variable_of_that_name():
    scope = scope_of([Node("neg", (0,)), Node("add", (3, 1))], (4,), names={3: "e"})
    assert written(scope) == (["const double e = -x;"], ["e + y"], [])


def test_a_truth_is_a_bool_and_a_named_one_a_number():
    nodes = [Node("lt", (0, 1)), Node("if_else", (3, 0, 1)), Node("if_else", (3, 1, 2))]
    lines, texts, _ = written(scope_of(nodes, (4, 5)))
    assert (lines, texts) == (["const bool w_1 = x < y;"], ["w_1 ? x : y", "w_1 ? y : z"])
    lines, texts, _ = written(scope_of(nodes, (4, 5), names={3: "low"}))
    assert lines == ["const double low = (x < y) ? 1.0 : 0.0;"]
    assert texts[0] == "(low != 0.0) ? x : y"


def test_sine_and_cosine_of_one_angle_come_from_one_call():
    lines, texts, calls = written(scope_of([Node("sin", (0,)), Node("cos", (0,)), Node("sin", (1,))], (3, 4, 5)))
    assert lines == ["const law_pair turn_1 = law_turn(x);"]
    assert texts == ["turn_1.sine", "turn_1.cosine", "law_sin(y)"]
    assert calls == ["turn", "sin"]


def test_a_long_expression_is_broken_at_its_longest_part():
    nodes = [Node("add", (i, 0)) for i in range(2, 40)]
    lines, texts, _ = written(scope_of(nodes, (40,)))
    assert lines
    assert max(map(len, (*lines, *texts))) < 120


def test_a_result_as_a_variable_is_one_unless_it_is_plain():
    scope = scope_of([Node("const", value=-1.5), Node("add", (0, 1))], (0, 3, 4), {3: -1.5})
    assert written(scope, ValueForm.VARIABLE) == (["const double w_1 = x + y;"], ["x", "-1.5", "w_1"], [])


def test_a_number_that_is_not_finite_comes_from_its_bits():
    _, texts, calls = written(scope_of([Node("const")], (3,), {3: float("inf")}))
    assert (texts, calls) == (["law_number(0x7ff0000000000000u)"], ["number"])


def test_a_double_is_rounded_once_where_a_float_needs_it():
    nodes = [Node("mul", (0, 1)), Node("add", (3, 2)), Node("sub", (3, 2))]
    scope = scope_of(nodes, (4, 5), real=SINGLE, doubles={0, 1, 3})
    lines, texts, _ = written(scope)
    assert lines == ["const double w_1 = x * y;", "const float w_2 = (float)w_1;"]
    assert texts == ["w_2 + z", "w_2 - z"]


def test_a_fused_product_is_one_call():
    scope = scope_of([Node("fms", (0, 1, 2))], (3,), fused_products=True)
    assert written(scope) == ([], ["law_fma(x, y, -z)"], ["fma"])
    assert written(scope_of([Node("fms", (0, 1, 2))], (3,))) == ([], ["(x * y) - z"], [])


def test_a_function_is_called_in_the_format_of_its_value():
    scope = scope_of([Node("exp", (0,))], (3,), real=SINGLE)
    made = assignments(scope, [Demand((3,), ValueForm.MADE), Demand((3,), ValueForm.TEXT)])
    assert made.calls == (CCall("exp", SINGLE),)
    assert made.answers[1].texts == ("law_expf(x)",)


def test_the_same_demands_have_the_same_answers():
    scope = scope_of([Node("add", (0, 1)), Node("mul", (3, 3))], (4,))
    assert written(scope) == written(scope)


@pytest.mark.parametrize("name", with_role(Role.NODE))
def test_every_operation_of_a_graph_has_a_text(name):
    row = OPERATIONS[name]
    truths = [Node("lt", (0, 1)), Node("le", (1, 2))]
    places = [3 + i if kind is Kind.TRUTH else i for i, kind in enumerate(row.operands)]
    scope = scope_of([*truths, Node(name, tuple(places))], (5,))
    (text,) = written(scope)[1]
    assert "x" in text
