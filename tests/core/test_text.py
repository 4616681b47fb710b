"""Formulas in plain characters, for a terminal."""

import re

import casadi as ca
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from workbench.core.notation import text
from workbench.core.notation.build import condition, number
from workbench.core.notation.formula import (
    Call,
    Matrix,
    Power,
    Product,
    Quotient,
    Relation,
    Sum,
    Symbol,
    System,
    symbol,
)
from workbench.core.notation.program import identifier
from workbench.core.notation.reader import read, read_shared

NAMES = ("x", "y", "qd_1", "Lambda_1")
SYMBOLS = [ca.SX.sym(name) for name in NAMES]
x, y, qd, Lambda = SYMBOLS
X, Y = Symbol("x"), Symbol("y")

numbers = st.sampled_from([-2, -1, 0.5, 1 / 3, 3, 9.81, 1e-5]).map(ca.SX)
leaves = st.one_of(st.sampled_from(SYMBOLS), numbers)
unary = st.sampled_from(
    [
        ca.sin,
        ca.cos,
        ca.tanh,
        ca.fabs,
        ca.sign,
        ca.floor,
        ca.atan,
        ca.sinh,
        lambda a: -a,
        lambda a: a**2,
        lambda a: a**3,
    ]
    + [lambda a: ca.sqrt(1 + a**2), lambda a: ca.exp(-(a**2)), lambda a: 1 / (1 + a**2), lambda a: 2 ** ca.tanh(a)]
    + [lambda a: ca.fmin(ca.fmax(a, -1), 1)]
)
binary = st.sampled_from(
    [lambda a, b: a + b, lambda a, b: a - b, lambda a, b: a * b, lambda a, b: a / (2 + ca.cos(b)), ca.fmin, ca.fmax]
    + [ca.atan2, lambda a, b: ca.if_else(a > b, a, ca.if_else(b <= 2, 1 - b, a * b)), lambda a, b: (a < b) * a]
    + [lambda a, b: ca.if_else(ca.logic_or(a > 0, ca.logic_not(b > a)), a, b), lambda a, b: ca.fmod(a, 1 + b**2)]
)
expressions = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.builds(lambda f, a: f(a), unary, inner), st.builds(lambda f, a, b: f(a, b), binary, inner, inner)
    ),
    max_leaves=10,
).filter(lambda expression: not {"inf", "nan"} & set(re.findall("[a-z]+", str(expression))))  # of constants, by CasADi
states = st.lists(st.floats(-3, 3).filter(lambda v: abs(v) > 1e-3), min_size=4, max_size=4)


def value(expression, state):
    return float(ca.Function("value", [ca.vertcat(*SYMBOLS)], [expression])(state))


SAME = ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "abs", "sign", "floor", "ceil")
NUMPY = {name: getattr(np, name) for name in SAME}
NUMPY |= {"atan": np.arctan, "atan2": np.arctan2, "min": np.minimum, "max": np.maximum, "mod": np.fmod}
NUMPY |= {"sat": lambda x: np.clip(x, -1, 1)}


def evaluated(lines, state):
    """The value of a printed formula, read as Python but for the sign of a power."""
    source = f"({' '.join(lines.split())})".replace("^", "**")
    return float(eval(source, {**NUMPY, **dict(zip(NAMES, state, strict=True))}))


@given(expressions, states)
def test_the_printed_formula_has_the_value_of_the_expression(expression, state):
    expected = value(expression, state)
    # A formula may order operations otherwise than the code; near a jump (sign, floor, <) or a cancellation
    # that shows, so states are taken where a change of state by 1e-9 changes little.
    nearby = [value(expression, [v * (1 + d) for v in state]) for d in (-1e-9, 1e-9)]
    assume(np.isfinite(expected) and np.allclose(nearby, expected, rtol=1e-6, atol=1e-6))
    assert evaluated(text.emit(read(expression), width=1e9), state) == pytest.approx(expected, rel=1e-6, abs=1e-6)


@given(expressions, states, st.integers(20, 60))
def test_broken_lines_have_the_same_value(expression, state, width):
    expected = evaluated(text.emit(read(expression), width=1e9), state)
    broken = evaluated(text.emit(read(expression), width=width), state)
    nearby = [value(expression, [v * (1 + d) for v in state]) for d in (-1e-9, 1e-9)]
    assume(np.isfinite(expected) and np.allclose(nearby, expected, rtol=1e-6, atol=1e-6))
    assert broken == pytest.approx(expected, rel=1e-6, abs=1e-6)


def test_definitions_and_a_formula_over_them_have_the_value_of_the_expression():
    part = ca.sin(x * y + qd)
    expression = part**2 + part * x + 1 / (part + 3)
    definitions, formula = read_shared(expression)
    scope = {**NUMPY, "x": 1.1, "y": 0.7, "qd_1": -0.3}
    exec(text.emit(System((*definitions, Relation(Symbol("f"), "=", formula)))).replace("^", "**"), scope)
    # One rounding for each of a dozen operations.
    assert scope["f"] == pytest.approx(value(expression, [1.1, 0.7, -0.3, 0.0]), rel=1e-14)


def test_a_matrix_is_written_row_by_row():
    written = text.emit(Relation(Symbol("M"), "=", read(ca.diag(ca.vertcat(x, 2)))))
    assert written == "M = [[x, 0], [0, 2]]"


@pytest.mark.parametrize(
    ("formula", "expected"),
    [
        (Power(Power(X, Y), X), "(x^y)^x"),
        (Power(X, Power(Y, X)), "x^(y^x)"),
        (Power(number(-2), X), "(-2)^x"),
        (Power(Sum((X, Y)), number(0.5)), "(x + y)^(1/2)"),
        (Product((X, Quotient(X, Y))), "x*(x/y)"),
        (Quotient(X, Product((X, Y))), "x/(x*y)"),
        (Quotient(Quotient(X, Y), X), "x/y/x"),
        (Quotient(X, Quotient(X, Y)), "x/(x/y)"),
        (Product((number(-1), Sum((X, Y)))), "-(x + y)"),
        (Sum((X, Product((number(-2), Y)))), "x - 2*y"),
        (Sum((X, Sum((X, Y)))), "x + (x + y)"),
        (Product((X, number(-1))), "x*(-1)"),
        (Product((Relation(X, "<", Y), X)), "(x < y)*x"),
    ],
)
def test_parentheses_stand_where_they_must_and_nowhere_else(formula, expected):
    assert text.emit(formula) == expected


@pytest.mark.parametrize("name", ["lambda", "1x", "a b", "__import__('os')", "x;y", "é", "", "plant.arm.links[0].mass"])
def test_every_symbol_becomes_an_identifier(name):
    assert identifier(symbol(name)).isidentifier()


@given(st.text())
def test_plain_text_is_printable_ascii_whatever_the_names(name):
    written = text.emit(Sum((Symbol(name), Call("sin", (symbol(name),)))), width=1e9)
    assert written.isascii()
    assert written.isprintable()


def test_no_line_of_text_is_wider_than_asked():
    terms = [ca.SX.sym(f"a_{i}") * ca.cos(ca.SX.sym(f"b_{i}")) for i in range(40)]
    long = sum(terms, ca.SX(0))
    for expression in (long, x * long, ca.exp(long), long**3, 1 / long, x / long, long / x, -long, ca.sin(x * long)):
        for width in (40, 60, 100):
            lines = text.emit(Relation(symbol("tau_1"), "=", read(expression)), width=width).splitlines()
            assert len(lines) > 1
            assert max(map(len, lines)) <= width


def test_a_wide_matrix_is_written_entry_by_entry():
    entry = Sum(tuple(Symbol("a", str(i)) for i in range(12)))
    written = text.emit(Relation(Symbol("M"), "=", Matrix(((X, entry), (entry, Y)))))
    assert [line.split(" = ")[0] for line in written.splitlines()] == ["M_11", "M_12", "M_21", "M_22"]
    assert "M_21 = M_12" in written


def test_a_condition_is_written_as_a_condition():
    assert text.emit(condition(number(0), "<", X)) == "x > 0"
