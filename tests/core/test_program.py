"""Programs without branches: what they compute, how they name things, and what they refuse."""

import keyword
import math
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.core.notation.program import FUNCTIONS, Dialect, straight_line

x, y, z = SYMBOLS = [ca.SX.sym(name) for name in "xyz"]
PYTHON = Dialect({"fmin": "min", "fmax": "max"}, frozenset([*FUNCTIONS.values(), *keyword.kwlist]), width=60)

expressions = st.recursive(
    st.sampled_from([x, y, z, ca.SX(0.1), ca.SX(-2.5), ca.SX(3)]),
    lambda inner: st.one_of(
        st.builds(lambda f, a: f(a), st.sampled_from([ca.sin, ca.cos, ca.tanh, ca.fabs, ca.sign, lambda a: -a]), inner),
        st.builds(lambda f, a: f(a), st.sampled_from([lambda a: a**2, lambda a: 1 / (1 + a**2), ca.atan]), inner),
        st.builds(lambda a, b: a + b, inner, inner),
        st.builds(lambda a, b: a - b, inner, inner),
        st.builds(lambda a, b: a * b, inner, inner),
        st.builds(lambda a, b: a / (2 + ca.cos(b)), inner, inner),
        st.builds(ca.fmin, inner, inner),
    ),
    max_leaves=15,
)
states = st.lists(st.floats(-3, 3), min_size=3, max_size=3)


def computed(program, state):
    """The entries by Python's own arithmetic."""
    scope = {"min": min, "max": max, **{name: getattr(math, name, None) for name in FUNCTIONS.values()}}
    scope |= {variable: state["xyz".index(name)] for variable, name in program.inputs}
    exec("\n".join(f"{variable} = {text}" for variable, text in program.lines), scope)
    return {letter: [[eval(cell, scope) for cell in row] for row in rows] for letter, rows in program.entries.items()}


@given(st.lists(expressions, min_size=4, max_size=4), states)
def test_a_program_gives_the_bits_of_the_expression(entries, state):
    matrix, vector = ca.blockcat([entries[:2], entries[1:3]]), ca.vertcat(*entries[2:])
    theirs = computed(straight_line({"A": matrix, "b": vector}, {}, PYTHON), state)
    function = ca.Function("f", [ca.vertcat(*SYMBOLS)], [ca.densify(matrix), ca.densify(vector)], {"cse": True})
    for ours, rows in zip(function(state), theirs.values(), strict=True):
        # the same operations on the same numbers: no rounding is left to differ
        np.testing.assert_array_equal(np.array(ours), np.array(rows))


@given(st.lists(expressions, min_size=2, max_size=2))
def test_no_line_is_much_wider_than_asked_and_no_variable_is_given_twice(entries):
    program = straight_line({"b": ca.vertcat(*entries)}, {}, PYTHON)
    assert all(len(text) <= PYTHON.width for _, text in program.lines)
    names = [name for name, _ in (*program.inputs, *program.lines)]
    assert len(set(names)) == len(names)


def test_equal_entries_are_computed_once_and_constants_stand_as_they_are():
    program = straight_line({"M": ca.blockcat([[x + 1, x * y], [x * y, 2.5]])}, {}, PYTHON)
    assert program.lines == (("M_11", "x + 1.0"), ("M_12", "x*y"))
    assert program.entries["M"] == (("M_11", "M_12"), ("M_12", "2.5"))


def test_the_entries_of_a_large_matrix_are_told_apart():
    outer = ca.vertcat(*[x + k for k in range(1, 12)]) @ ca.horzcat(*[y + k for k in range(1, 12)])
    program = straight_line({"A": outer}, {}, PYTHON)
    assert "A_1_11" in dict(program.lines)
    assert "A_11_1" in dict(program.lines)


def test_letters_that_clash_with_words_or_with_each_other_get_other_variables():
    program = straight_line({"f": x * y + ca.sin(z)}, {"x": "lambda", "y": "f_1", "z": "lambda"}, PYTHON)
    variables = [variable for variable, _ in program.inputs]
    assert sorted(variables) == ["f_1", "lambda_", "lambda__"]
    assert [name for name, _ in program.lines] == ["f_1_"]


def test_the_functions_that_are_called_are_listed_as_they_are_spelled():
    program = straight_line({"f": ca.sin(x) + ca.fmin(x, ca.sqrt(y))}, {}, PYTHON)
    assert program.functions == ("min", "sin", "sqrt")


@pytest.mark.parametrize(("expression", "word"), [(ca.erf(x), "ERF"), (ca.if_else(x > 0, y, z), "IF_ELSE_ZERO|LT")])
def test_a_branch_and_an_unknown_function_are_refused_by_name(expression, word):
    with pytest.raises(ValueError, match=word):
        straight_line({"f": expression}, {}, PYTHON)


TRUTHS = {"lt": "{} < {}", "le": "{} <= {}", "eq": "{} == {}", "ne": "{} != {}"}
LOGIC = {"and": "{} and {}", "or": "{} or {}", "not": "not {}", "if_else_zero": "{1} if {0} else 0.0"}


@given(states)
def test_a_language_that_says_how_writes_truths_and_what_is_chosen_by_them(state):
    language = replace(PYTHON, choices=TRUTHS | LOGIC)
    between = ca.logic_and(x < y, ca.logic_or(x == 0, ca.logic_not(z <= y)))
    expressions = [ca.if_else(between, y, -z), ca.floor(x) + ca.fmod(y, 0.7), (x != y) * 2.0 + ca.if_else(x < 1, z, 0)]
    theirs = computed(straight_line({"b": ca.vertcat(*expressions)}, {}, language), state)
    ours = ca.Function("f", [ca.vertcat(*SYMBOLS)], expressions)(state)
    np.testing.assert_array_equal([float(value) for value in ours], [float(row[0]) for row in theirs["b"]])


def test_a_constant_that_is_not_finite_is_refused():
    with pytest.raises(ValueError, match="finite"):
        straight_line({"f": x * ca.inf}, {}, PYTHON)
