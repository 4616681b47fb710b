"""Formulas in LaTeX: well-formed whatever they hold, and in lines that fit the page."""

import re

import casadi as ca
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.mathtext import MathTextParser

from workbench.core.notation import latex
from workbench.core.notation.build import number
from workbench.core.notation.formula import Call, Cases, Matrix, Power, Product, Relation, Sum, Symbol, System, symbol
from workbench.core.notation.reader import read

x, y, q2, qd = (ca.SX.sym(name) for name in ("x", "y", "q_2", "qd_1"))
X, Y = Symbol("x"), Symbol("y")


def balanced(source):
    """Whether braces, environments and stretched parentheses are closed, each in its own cell."""
    bare = re.sub(r"\\[{}$#%&_\\]", " ", source)
    assert bare.count("{") == bare.count("}")
    depth = 0
    for character in bare:
        depth += {"{": 1, "}": -1}.get(character, 0)
        assert depth >= 0
    assert source.count(r"\begin{") == source.count(r"\end{")
    assert len(re.findall(r"\\left[^a-z]|\\left\\", source)) == len(re.findall(r"\\right[^a-z]|\\right\\", source))
    return True


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("q_1", "q_{1}"),
        ("qd_1", r"\dot{q}_{1}"),
        ("qdd_2", r"\ddot{q}_{2}"),
        ("q_hat_1", r"\hat{q}_{1}"),
        ("qd_tilde", r"\dot{\tilde{q}}"),
        ("Lambda_1", r"\Lambda_{1}"),
        ("epsilon", r"\varepsilon"),
        ("l_c1", "l_{c1}"),
        ("tau_max1", r"\tau_{\mathrm{max},1}"),
        ("q^*_1", "q_{1}^{*}"),
        ("mass", r"\mathrm{mass}"),
        ("a.b[0]", r"\text{a.b[0]}"),
    ],
)
def test_a_symbol_is_typeset_with_its_dots_accents_and_indices(name, expected):
    assert latex.emit(symbol(name)) == expected


def test_a_bold_symbol_is_bold():
    assert latex.emit(Symbol("q", dots=1, bold=True)) == r"\dot{\boldsymbol{q}}"


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (ca.sin(q2), r"\sin q_{2}"),
        (ca.sin(q2) ** 2 * x, r"x \sin^{2} q_{2}"),
        (ca.sin(x + y), r"\sin\left( x + y \right)"),
        (1 / ca.sin(q2), r"\frac{1}{\sin q_{2}}"),
        (ca.log(x) * y, r"\ln\left( x \right) y"),
        (ca.sin(x) * ca.cos(y), r"\sin x \cos y"),
        (ca.tanh(x) * ca.fabs(y), r"\tanh\left( x \right) \left| y \right|"),
        (ca.sqrt(x) + ca.floor(y), r"\sqrt{x} + \left\lfloor y \right\rfloor"),
        (ca.atan2(x, y), r"\operatorname{atan2}\left( x, y \right)"),
        (x / 2, r"\frac{1}{2} x"),
        ((x / y) ** 2, r"\left( \frac{x}{y} \right)^{2}"),
        (q2**2, "q_{2}^{2}"),
        (x**y, "x^{y}"),
        (1e-5 * x, r"10^{-5} x"),
        (1.5e-7 * x, r"1.5 \cdot 10^{-7} x"),
        (-(x + y), r"- \left( x + y \right)"),
        (ca.if_else(x <= 1, y, 2), r"\begin{cases} y & \text{if } x \leq 1 \\ 2 & \text{otherwise} \end{cases}"),
        (x * 2**y, r"x \cdot 2^{y}"),
        (9.81 * x * 3, r"3 \cdot 9.81 x"),
    ],
)
def test_an_expression_is_typeset_as_in_a_book(expression, expected):
    if expected.startswith("3"):
        assert latex.emit(Product((number(3), number(9.81), X))) == expected
    else:
        assert latex.emit(read(expression)) == expected


def test_a_starred_symbol_is_raised_to_a_power_in_parentheses():
    assert latex.emit(Power(symbol("q_star"), number(2))) == r"\left( q^{*} \right)^{2}"


@settings(max_examples=25)
@given(
    st.recursive(
        st.sampled_from([x, y, q2, qd, ca.SX(2), ca.SX(0.1), ca.SX(1e-9)]),
        lambda inner: st.one_of(
            st.builds(lambda a, b: a + b, inner, inner),
            st.builds(lambda a, b: a - b, inner, inner),
            st.builds(lambda a, b: a * b, inner, inner),
            st.builds(lambda a, b: a / (2 + b**2), inner, inner),
            st.builds(lambda f, a: f(a), st.sampled_from([ca.sin, ca.exp, ca.fabs, ca.tanh, ca.sign, ca.floor]), inner),
            st.builds(lambda a: ca.sqrt(1 + a**2) ** 3, inner),
        ),
        max_leaves=12,
    )
)
def test_another_program_understands_every_formula(expression):
    source = latex.emit(read(expression), width=1e9)
    assert balanced(source)
    MathTextParser("path").parse(f"${source}$")


@given(st.text(), st.text(max_size=3))
def test_a_hostile_name_is_inert(name, index):
    source = latex.emit(Sum((Symbol(name, index), symbol(name))), width=1e9)
    assert balanced(source)
    assert "\n" not in source


@pytest.mark.parametrize(
    "name", [r"\input{/etc/passwd}", r"\write18{ls}", "}", "{", "$x$", "%", "a & b", r"a \\ b", "^^5c"]
)
def test_no_command_gets_through_a_name(name):
    source = latex.emit(Relation(Symbol(name, name, mark=name), "=", Call(name, (Symbol(name),))))
    assert balanced(source)
    known = {"text", "textbackslash", "textasciicircum", "operatorname", "left", "right"}
    assert set(re.findall(r"\\([a-zA-Z]+)", source)) <= known
    assert re.search(r"(?<!\\)[$%&]", source) is None


def test_a_long_sum_is_broken_into_aligned_lines():
    long = Sum(tuple(Product((Symbol("a", str(i)), Symbol("b", str(i)))) for i in range(60)))
    source = latex.emit(Relation(symbol("tau_1"), "=", long))
    body = source.removeprefix("\\begin{aligned}\n").removesuffix("\n\\end{aligned}").split(" \\\\\n")
    assert balanced(source)
    assert len(body) > 3
    assert body[0].startswith(r"\tau_{1} & = a_{0} b_{0} + ")
    assert all(line.startswith(r"& \quad {} + ") for line in body[1:])
    assert all(line.count("&") == 1 for line in body)


def test_a_wide_matrix_becomes_equations_for_its_entries():
    entry = Sum(tuple(Symbol("a", str(i)) for i in range(12)))
    source = latex.emit(Relation(Symbol("M"), "=", Matrix(((X, entry), (entry, Y)))))
    assert source.count(r"\\") == 3
    assert "M_{21} & = M_{12}" in source


def test_a_narrow_matrix_stays_a_matrix():
    source = latex.emit(Relation(Symbol("M"), "=", Matrix(((X, Y), (Y, X)))))
    assert source == r"M = \left[ \begin{array}{cc} x & y \\ y & x \end{array} \right]"


def test_a_system_is_aligned_at_its_signs():
    source = latex.emit(System((Relation(X, "=", Y), Relation(Y, "=", X))))
    assert source == "\\begin{aligned}\nx & = y \\\\\ny & = x\n\\end{aligned}"


def test_conditions_may_be_combined():
    both = Relation(Relation(X, "<", Y), "and", Relation(X, "!=", number(0)))
    assert r"\left( x < y \right) \land \left( x \neq 0 \right)" in latex.emit(Cases(((X, both),), Y))
