"""Names become symbols, and expressions become the formulas one would write for them."""

from fractions import Fraction

import casadi as ca
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.core.notation import build, text
from workbench.core.notation.formula import (
    Call,
    Cases,
    Matrix,
    Number,
    Power,
    Product,
    Quotient,
    Relation,
    Sum,
    Symbol,
    equations,
    letters,
    name_of,
    symbol,
)
from workbench.core.notation.reader import read, read_shared

x, y, z = (ca.SX.sym(name) for name in "xyz")
X, Y, Z = Symbol("x"), Symbol("y"), Symbol("z")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("q", Symbol("q")),
        ("q_1", Symbol("q", "1")),
        ("m1", Symbol("m", "1")),
        ("qd_1", Symbol("q", "1", dots=1)),
        ("qdd_2", Symbol("q", "2", dots=2)),
        ("thetad", Symbol("theta", dots=1)),
        ("q_hat_1", Symbol("q", "1", accent="hat")),
        ("qd_hat_1", Symbol("q", "1", dots=1, accent="hat")),
        ("x_tilde", Symbol("x", accent="tilde")),
        ("q_ref_1", Symbol("q", "ref,1")),
        ("qd_r", Symbol("q", "r", dots=1)),
        ("Lambda_1", Symbol("Lambda", "1")),
        ("l_c1", Symbol("l", "c1")),
        ("tau_max1", Symbol("tau", "max,1")),
        ("q^*_1", Symbol("q", "1", mark="*")),
        ("q_star_1", Symbol("q", "1", mark="*")),
        ("Kp", Symbol("K", "p")),
        ("Kd_2", Symbol("K", "d,2")),
        ("Xi", Symbol("Xi")),
        ("gamma", Symbol("gamma")),
        ("mass", Symbol("mass")),
        ("plant.arm.links[0].mass", Symbol("plant.arm.links[0].mass")),
        ("", Symbol("")),
        ("_x", Symbol("_x")),
    ],
)
def test_a_name_is_read_as_its_symbol(name, expected):
    assert symbol(name) == expected


indices = st.lists(st.text("abcdefghijklmnopqrstuvwxyz0123456789", min_size=1, max_size=4), max_size=2)


@settings(max_examples=20)
@given(
    st.sampled_from(["q", "qd", "qdd", "tau", "phid", "M", "Kp", "word"]),
    st.sampled_from(["", "_hat", "_tilde"]),
    st.sampled_from(["", "_star"]),
    indices,
)
def test_the_name_of_a_symbol_reads_as_that_symbol(letter, accent, mark, behind):
    name = letter + accent + mark + "".join(f"_{index}" for index in behind)
    assert symbol(name_of(symbol(name))) == symbol(name)


@settings(max_examples=20)
@given(st.text())
def test_every_name_is_some_symbol(name):
    assert isinstance(symbol(name), Symbol)


def test_a_symbol_has_at_most_two_dots_and_a_known_accent():
    with pytest.raises(ValueError, match="0 to 2 dots"):
        Symbol("q", dots=3)
    with pytest.raises(ValueError, match="hat"):
        Symbol("q", accent="ring")
    with pytest.raises(ValueError, match="one of '='"):
        Relation(X, "~", Y)


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (x - y, "x - y"),
        (x + (-y), "x - y"),
        (-1 * x, "-x"),
        (x * x, "x^2"),
        (x * x * x, "x^3"),
        (x**0.5, "sqrt(x)"),
        (x**-2, "1/x^2"),
        (1 / x, "1/x"),
        (x / 3, "1/3*x"),
        (x / y / z, "x/(y*z)"),
        ((x / y) * (y / z), "x*y/(y*z)"),
        (2 * x / (4 * y), "x/(2*y)"),
        (x - (y + z), "x - (y + z)"),
        (x - (-y - z), "x + y + z"),
        (x + (y + z), "x + y + z"),
        (x * (y * z), "x*y*z"),
        ((x + y) * z, "(x + y)*z"),
        (ca.sin(x) * y, "y*sin(x)"),
        (-(x / y), "-x/y"),
        ((-x) ** 2, "x^2"),
        ((x + y) ** 2, "(x + y)^2"),
        (x**y, "x^y"),
        (2 ** (x + 1), "2^(x + 1)"),
        (ca.exp(-x), "exp(-x)"),
        (ca.fmin(ca.fmax(x / y, -1), 1), "sat(x/y)"),
        (ca.fmax(-1, ca.fmin(x, 1)), "sat(x)"),
        (ca.fmin(x, ca.fmax(y, 1)), "min(x, max(y, 1))"),
        (ca.if_else(x > 1, y, z), "y if x > 1 else z"),
        (ca.if_else(x > 0, y, ca.if_else(x < -1, z, 2)), "y if x > 0 else z if x < -1 else 2"),
        (ca.if_else(ca.logic_and(x > 0, y <= 1), x, 0), "x if (x > 0) and (y <= 1) else 0"),
        (ca.logic_not(x == y), "x != y"),
        (ca.logic_not(x), "x == 0"),
        ((x > 0) * y, "y if x > 0 else 0"),
        ((x > 0) * y / z * 2, "2*y/z if x > 0 else 0"),
        (1 + (x > 0), "1 + (1 if x > 0 else 0)"),
        (ca.fabs(x) + ca.sign(y), "abs(x) + sign(y)"),
        (x * y + x * y, "2*x*y"),
    ],
)
def test_an_expression_reads_as_one_would_write_it(expression, expected):
    assert text.emit(read(expression)) == expected


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (0.5, Fraction(1, 2)),
        (1 / 3, Fraction(1, 3)),
        (3.0, Fraction(3)),
        (0.1, 0.1),
        (9.81, 9.81),
        (1e-5, 1e-5),
        (1e20, 1e20),
        (Fraction(1, 105), Fraction(1, 105)),
    ],
)
def test_numbers_are_small_fractions_or_the_shortest_digits(value, expected):
    assert build.number(value) == Number(expected)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_printed_number_rounds_to_the_double_it_came_from(value):
    assert float(build.number(value).value) == value


def test_what_is_not_finite_is_not_written():
    with pytest.raises(ValueError, match="finite"):
        read(x * ca.inf)


def test_an_operation_without_a_formula_is_named():
    with pytest.raises(ValueError, match="ERFINV"):
        read(ca.erfinv(x))


def test_a_matrix_is_read_with_its_structural_zeros():
    assert read(ca.diag(ca.vertcat(x, y))) == Matrix(((X, build.ZERO), (build.ZERO, Y)))
    assert read(ca.vertcat(x, 2)) == Matrix(((X,), (Number(Fraction(2)),)))
    with pytest.raises(ValueError, match="entries"):
        read(ca.SX(0, 1))


def test_symbols_are_printed_as_they_are_mapped():
    assert read(x * y, {"x": Symbol("q", "1", dots=1)}) == Product((Symbol("q", "1", dots=1), Y))


def test_two_names_that_would_be_printed_alike_are_refused():
    with pytest.raises(ValueError, match=r"'x' and 'y' would both be printed m_1"):
        read(x + y, {"x": symbol("m_1"), "y": symbol("m_1")})
    with pytest.raises(ValueError, match="called 'x'"):
        read(x + ca.SX.sym("x"))


def test_a_shared_part_is_not_written_again_and_again():
    tower = x
    for _ in range(200):
        tower = ca.sin(tower) * tower + ca.cos(tower)
    with pytest.raises(ValueError, match="read_shared"):
        read(tower)
    definitions, formula = read_shared(tower)
    assert len(definitions) > 100
    assert all(len(list(letters(d.right))) < 10 for d in definitions)
    assert len(list(letters(formula))) < 10


def test_a_part_that_occurs_twice_is_defined_once():
    shared = ca.sin(x * y + z)
    expression = ca.vertcat(shared**2 + shared * x, 1 / (shared + z))
    definitions, formula = read_shared(expression)
    assert [text.emit(d) for d in definitions] == ["w_1 = sin(x*y + z)"]
    assert text.emit(formula) == "[[w_1^2 + w_1*x], [1/(w_1 + z)]]"


def test_the_letter_of_definitions_is_one_that_is_free():
    w = ca.SX.sym("w_3")
    part = ca.sin(w * x + y)
    definitions, _ = read_shared(part + ca.exp(part))
    assert definitions[0].left == Symbol("z", "1")


def test_a_long_sum_is_flat_and_a_deep_nest_is_refused():
    chain = sum((ca.SX.sym(f"x_{i}") * ca.sin(ca.SX.sym(f"y_{i}")) for i in range(500)), ca.SX(0))
    formula = read(chain)
    assert isinstance(formula, Sum)
    assert len(formula.terms) == 500
    nest = x
    for _ in range(200):
        nest = ca.sin(nest + 1)
    with pytest.raises(ValueError, match="deep"):
        read(nest)


def test_the_deepest_formula_that_is_read_can_also_be_written():
    nest = x
    for _ in range(75):
        nest = ca.sin(nest + 1)
    assert text.emit(read(nest)).replace("\n", "").replace(" ", "").count("sin(") == 75


def test_a_matrix_as_equations_says_once_what_it_says_twice():
    entry = Sum((X, Y))
    matrix = Matrix(((Z, entry), (entry, build.ZERO)))
    assert [text.emit(e) for e in equations(Symbol("M"), matrix)] == [
        "M_11 = z",
        "M_12 = x + y",
        "M_21 = M_12",
        "M_22 = 0",
    ]
    assert [text.emit(e) for e in equations(Symbol("G"), Matrix(((X,), (Y,))))] == ["G_1 = x", "G_2 = y"]
    assert equations(Symbol("q", "r", dots=1), Matrix(((X,),)))[0].left == Symbol("q", "r,1", dots=1)


def test_indices_beyond_nine_are_told_apart_by_a_comma():
    labels = [e.left.index for e in equations(Symbol("A"), Matrix(((X,) * 11,) * 11))]
    assert len(set(labels)) == 121
    assert labels[-1] == "11,11"


def test_cases_are_kept_as_cases():
    assert read(ca.if_else(x > 0, y, z)) == Cases(((Y, Relation(X, ">", build.ZERO)),), Z)


def test_builders_keep_the_value_and_tidy_the_form():
    two = Number(Fraction(2))
    assert build.power(build.power(X, two), two) == Power(X, Number(Fraction(4)))
    assert build.quotient(X, build.quotient(Y, Z)) == Quotient(Product((X, Z)), Y)
    assert build.negative(build.negative(X)) == X
    assert build.total([]) == build.ZERO
    assert text.emit(build.product([Number(0.1), X, Number(-0.3)])) == "-0.1*0.3*x"
    assert build.call("min", X, Y) == Call("min", (X, Y))
