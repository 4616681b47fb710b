"""Formulas read from text and LaTeX."""

from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.arms.paper_equations.formula_values import CASADI, NUMPY, evaluate, expanded_size
from workbench.arms.paper_equations.grammar import parse
from workbench.arms.paper_equations.tex import tokens_of_latex
from workbench.arms.paper_equations.tokens import FormulaError, Names, tokens_of_text
from workbench.core.notation import build, latex, text
from workbench.core.notation.formula import Matrix, Number, symbol
from workbench.core.notation.normal_form import NormalForm

LETTERS = [symbol(name) for name in ["m_1", "m_2", "l_1", "l_c1", "g", "q_1", "q_2", "qd_1", "qd_2", "alpha", "s_12"]]
NAMES = Names.of(LETTERS)
VALUES = dict(zip(LETTERS, (1.3, 0.7, 1.1, 0.4, 9.81, 0.3, -0.8, 0.9, 1.7, 2.3, 0.2), strict=True))
m1, m2, l1, lc1, g, q1, q2, qd1, qd2, alpha, s12 = VALUES.values()


def read(said: str, language: str = "text"):
    return parse((tokens_of_latex if language == "latex" else tokens_of_text)(said), NAMES)


def value(said: str, language: str = "text") -> float:
    return evaluate(read(said, language), VALUES, NUMPY)


TEXT = {
    "m1*l1**2 + 2*m2": m1 * l1**2 + 2 * m2,
    "-l1^2": -(l1**2),
    "m1 - -g + +m2": m1 + g + m2,
    "m1*-g": -m1 * g,
    "2 m1 l1^2": 2 * m1 * l1**2,
    "1/2 m_1 l_1^2": m1 * l1**2 / 2,
    "m1/l1/g": m1 / l1 / g,
    "m1/l1*g": m1 / l1 * g,
    "m1/(l1*g)": m1 / (l1 * g),
    "l1^-2": l1**-2,
    "2^3^0": 2.0,
    "1.5e-1*m1 + .5": 0.15 * m1 + 0.5,
    "m1[l1 + g]": m1 * (l1 + g),
    "sin(q1)**2 + cos(q_2)^2": np.sin(q1) ** 2 + np.cos(q2) ** 2,
    "sin q_1 cos q_2": np.sin(q1) * np.cos(q2),
    "sin^2 q_1": np.sin(q1) ** 2,
    "sin 2 q_1": np.sin(2 * q1),
    "sqrt(m1) + tan(q1)": m1**0.5 + np.tan(q1),
    "q1' * q_2'": qd1 * qd2,
    "lc1 + l_c1 + l_c_1": 3 * lc1,
    "α − m₁·l₁²": alpha - m1 * l1**2,
    "sin(q1 + pi/2)": np.cos(q1),
    "m1  # the first mass": m1,
}
LATEX = {
    r"m_1 l_{1}^2 + 2m_2": m1 * l1**2 + 2 * m2,
    r"{{m}_{1}}{{l}_{1}}^{2}\sin \left( {{q}_{2}} \right){{\dot{q}}_{1}}": m1 * l1**2 * np.sin(q2) * qd1,
    r"{\dot q}_1 + {\dot { q }}_2 + { m }_1^2 + {l_1}^2": qd1 + qd2 + m1**2 + l1**2,
    r"m_{1}{l}_1 + \frac{m_1}{{l}_{1}}": m1 * l1 + m1 / l1,
    r"m_1 \ell_1^2": m1 * l1**2,
    r"\text{sin}(q_2) + \textrm{cos}^2 q_1": np.sin(q2) + np.cos(q1) ** 2,
    r"\frac{1}{2} m_1 + \frac12 m_2 + \dfrac{m_1}{l_1}": m1 / 2 + m2 / 2 + m1 / l1,
    r"m_{1}gl_{c1}\sin q_1": m1 * g * lc1 * np.sin(q1),
    r"m_1 g l_{c_1} \sin\left(q_1+q_2\right)": m1 * g * lc1 * np.sin(q1 + q2),
    r"lc_{1} qd_{2}": lc1 * qd2,
    r"l_{\mathrm{c}1} l_{c,1}": lc1**2,
    r"\dot{q}_1 + \dot q_{2} + \dot{q_1} + \dot{\mathbf{q}}_{2}": 2 * qd1 + 2 * qd2,
    r"\dot{q}_1^2 \dot{q}^{2}_{2}": qd1**2 * qd2**2,
    r"l^2_1 \cdot m_1 \times g": l1**2 * m1 * g,
    r"\sin^{2}{\left(q_{1} \right)}": np.sin(q1) ** 2,
    r"\cos{q_1} \sin 2q_2": np.cos(q1) * np.sin(2 * q2),
    r"\sin q_2 \, \dot q_1": np.sin(q2) * qd1,
    r"\bigl( m_1 + m_2 \bigr) \left\{ g \right\}": (m1 + m2) * g,
    r"\alpha \mathrm{s}_{12} \quad % a remark": alpha * s12,
    r"\operatorname{sin}(q_1) \mathrm{cos}(q_1)": np.sin(q1) * np.cos(q1),
    r"\sqrt{m_1} ~ {m_2}": m1**0.5 * m2,
}


@pytest.mark.parametrize("said", TEXT)
def test_text_has_the_value_that_a_reader_gives_it(said):
    assert value(said) == pytest.approx(TEXT[said], rel=1e-14)  # a few roundings


@pytest.mark.parametrize("said", LATEX)
def test_latex_has_the_value_that_a_reader_gives_it(said):
    assert value(said, "latex") == pytest.approx(LATEX[said], rel=1e-14)  # a few roundings


MATRICES = [
    ("[[m1, 0], [2*g, l1]]", "text"),
    ("[m1, 0; 2*g, l1]", "text"),
    (r"\begin{bmatrix} m_1 & 0 \\ 2g & l_1 \end{bmatrix}", "latex"),
    (r"\left[\begin{array}{cc} m_1 & 0 \\[2pt] 2g & l_1 \\ \end{array}\right]", "latex"),
    (r"\begin{pmatrix} m_1 & 2g \\ 0 & l_1 \end{pmatrix}^{\top}", "latex"),
    (r"\frac{1}{2}\left(\begin{matrix} 2m_1 & 0 \\ 4g & 2l_1 \end{matrix}\right)", "latex"),
    (r"\begin{bmatrix} m_1 & 0 \\ 0 & 0 \end{bmatrix} + \begin{bmatrix} 0 & 0 \\ 2g & l_1 \end{bmatrix}", "latex"),
]


@pytest.mark.parametrize(("said", "language"), MATRICES)
def test_a_matrix_is_its_rows(said, language):
    formula = read(said, language)
    assert isinstance(formula, Matrix)
    assert [[evaluate(entry, VALUES, NUMPY) for entry in row] for row in formula.rows] == [[m1, 0], [2 * g, l1]]


def formulas():
    whole = st.integers(-9, 9).filter(bool).map(lambda n: Number(Fraction(n)))
    ratio = st.builds(lambda n, d: Number(Fraction(n, d)), st.integers(1, 9), st.integers(1, 9))
    leaf = st.sampled_from(LETTERS) | whole | ratio
    return st.recursive(
        leaf,
        lambda part: (
            st.lists(part, min_size=2, max_size=3).map(build.total)
            | st.lists(part, min_size=2, max_size=3).map(build.product)
            | st.builds(lambda a, n: build.power(a, Number(Fraction(n))), st.sampled_from(LETTERS), st.integers(2, 3))
            | st.builds(build.quotient, part, st.sampled_from(LETTERS))
            | st.builds(build.call, st.sampled_from(["sin", "cos"]), part)
        ),
        max_leaves=8,
    )


@given(formulas())
def test_what_the_house_prints_it_reads_back(formula):
    wanted = evaluate(formula, VALUES, NUMPY)
    for language, emitted in (("text", text.emit(formula)), ("latex", latex.emit(formula, width=10_000))):
        # values reach 1e9 and cancel; a misread sign or bracket shows in the first digits
        assert value(emitted, language) == pytest.approx(wanted, rel=1e-9, abs=1e-6), emitted


REFUSED = [
    ("1,5*m1", "text", "line 1, column 2: ',' cannot stand here; a number, a name or an opening bracket can, and the"),
    ("m1*(1,5)", "text", "the sign of decimals is '.'"),
    (r"1{,}5 m_1", "latex", "','"),
    ("m1 +\n * g", "text", "line 1, column 5"),
    ("m1.real", "text", "A formula is no program"),
    ("m1..real", "text", "'.' cannot stand here"),
    ("m3*l1", "text", "there is no 'm3' among the names of this robot, nor is it declared here."),
    ("c_12*m1", "text", "declare it: `c_12 = cos(q_1 + q_2)`"),
    ("(m1", "text", "column 1: '(' is never closed"),
    ("m1)", "text", "column 3: ')' closes nothing"),
    ("(m1]", "text", "closes nothing"),
    ("m1*", "text", "breaks off after '*'"),
    ("m1/l1 g", "text", "what is divided by"),
    ("m1/0", "text", "divides by zero"),
    ("0^0", "text", "zero has no such power"),
    ("9^9^9", "text", "at most 16"),
    ("m1^q1", "text", "got a formula"),
    ("m1^1000", "text", "at most 16"),
    ("((m1^9)^9)", "text", "powers of powers, go up to 16"),
    ("1e999*m1", "text", "between 1e-99 and 1e99"),
    ("1" * 100, "text", "at most 80 characters"),
    ("(" * 60 + "m1" + ")" * 60, "text", "nested more than 50 deep"),
    ("2^" * 5000 + "1", "text", "more than 100 parts are nested"),
    (r"\frac1" * 5000 + "m1", "latex", "more than 100 parts are nested"),
    ("1/(1 + " * 40 + "1/(2 + sin(1 + " * 5 + "q1" + ")" * 50, "text", "more than 100 operations are nested"),
    ("\\" + "a" * 40_000, "latex", "'\\" + "a" * 39 + "...' is not read here"),
    (r"\begin{" + "a" * 40_000 + "}", "latex", "environment '" + "a" * 40 + "...'"),
    (r"m_" + "1" * 40_000, "latex", "'_" + "1" * 40 + "...' prints only its first digit"),
    (r"m^" + "1" * 40_000, "latex", "'^" + "1" * 40 + "...' prints 1 above"),
    ("sin", "text", "what 'sin' is taken of"),
    ("sin q_1^2", "text", "where does 'sin' end"),
    ("sin(q1)'", "text", "only a symbol has a rate"),
    ("[[m1, 1], [g]]", "text", "equally long; these have 2, 1"),
    ("[m1, [g, 1; 1, g]]", "text", "no matrix"),
    ("[m1, g]*[m1, g]", "text", "product of two matrices"),
    ("[m1, g] + m1", "text", "one shape"),
    ("m1 | g", "text", "no sign of a formula"),
    ("m1 + 'x'", "text", "cannot stand here"),
    (r"\input{/etc/passwd}", "latex", "no macro is run, no file is read"),
    (r"\write18{ls}", "latex", r"'\write18' is not read here"),
    (r"m_{\input{x}}", "latex", r"'\input' is not read here"),
    (r"\begin{tikzpicture}", "latex", "environment 'tikzpicture'"),
    (r"l_12", "latex", "write '_{12}'"),
    (r"m_1^12", "latex", "write '^{12}'"),
    (r"\ddot{q}_1", "latex", "no 'qdd_1'"),
    (r"\dot" * 60 + "q", "latex", "50 macros"),
    ("m_1 \\", "latex", "ends with a backslash"),
    (r"m_{1", "latex", "index is made of"),
]


@pytest.mark.parametrize(("said", "language", "why"), REFUSED)
def test_what_is_no_formula_is_refused_with_its_place(said, language, why):
    with pytest.raises(FormulaError, match=r"^line \d+, column \d+: ") as refusal:
        read(said, language)
    assert why in str(refusal.value)


def test_letters_side_by_side_are_the_longest_names_that_are_known():
    names = Names.of([symbol(name) for name in ("a", "ab", "b", "c_1")])
    assert parse(tokens_of_latex("abc_1"), names) == build.product([symbol("ab"), symbol("c_1")])
    many = Names.of([symbol("a" * k) for k in range(1, 9)])
    with pytest.raises(FormulaError, match="there is no"):
        parse(tokens_of_latex("a" * 70 + "_1"), many)  # in one pass, not in 2^70


def normal_form(said: str) -> NormalForm:
    symbols = {letter: ca.SX.sym(str(i)) for i, letter in enumerate(LETTERS)}
    return NormalForm.of(evaluate(read(said), symbols, CASADI))


def test_a_third_stays_exactly_one_in_the_expression():
    assert normal_form("1/3*m1*l1") == normal_form("m1*l1/3")


@pytest.mark.parametrize("said", ["(m1 + g)^3*(l1 + m2)", "(sin(q1) + cos(q2))^3", "sin(q1)*cos(q2)*sin(q1 + q2)*m1"])
def test_the_size_of_an_expansion_is_never_underestimated(said):
    assert expanded_size(read(said)) >= len(normal_form(said).terms) > 1
