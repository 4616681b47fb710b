"""Normal forms of formulas as they were read: nothing rounded, quarter turns taken off."""

import math
from fractions import Fraction

import casadi as ca
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.arms.paper_equations.formula_values import CASADI, NUMPY, at_numbers, evaluate, normal_form
from workbench.arms.paper_equations.grammar import parse
from workbench.arms.paper_equations.tokens import Names, tokens_of_text
from workbench.core.notation import build
from workbench.core.notation.formula import Formula, Number, name_of, symbol
from workbench.core.notation.normal_form import NormalForm, NotInClass

LETTERS = [symbol(name) for name in ("a", "b", "q_1", "q_2")]
NAMES = {letter: name_of(letter) for letter in LETTERS}
VALUES = {"a": 1.3, "b": 0.7, "q_1": 0.4, "q_2": -1.1, "π": 3.141592653589793}


def read(said: str) -> Formula:
    return parse(tokens_of_text(said), Names.of(LETTERS))


def form(said: str) -> NormalForm:
    return normal_form(read(said), NAMES)


def value_of(normal: NormalForm) -> float:
    """The value of a normal form at VALUES, from its terms: rational x monomial x sine or cosine of an angle."""

    def power(monomial):
        return math.prod(VALUES[name] ** exponent for name, exponent in monomial)

    def wave(kind, angle):
        return getattr(math, kind)(math.fsum(float(c) * power(monomial) for monomial, c in angle))

    return math.fsum(float(c) * power(m) * wave(kind or "cos", angle) for (m, (kind, angle)), c in normal.terms.items())


def angles():
    """Sums of joints and quarter turns, of which some are halved."""
    whole = st.integers(-3, 3)
    return st.tuples(whole, whole, st.integers(-9, 9), st.sampled_from([2, 4])).map(
        lambda c: f"({c[0]}*q_1 + {c[1]}*q_2 + {c[2]}*pi/{c[3]})"
    )


@given(st.sampled_from(["sin", "cos"]), angles(), st.sampled_from(["sin", "cos"]), angles())
def test_turns_change_no_value(first, one, second, other):
    said = f"a^2*{first}{one}*{second}{other}/3 + b*{first}{other}"
    wanted = evaluate(read(said), {letter: VALUES[name] for letter, name in NAMES.items()}, NUMPY)
    assert value_of(form(said)) == pytest.approx(wanted, abs=1e-13)  # of terms that are at most 1.7


@given(angles(), st.integers(-4, 4))
def test_an_angle_has_one_form_however_it_is_turned(angle, k):
    assert form(f"sin{angle}") == form(f"-sin(-1*{angle} + 4*pi)") == form(f"cos({angle} - pi/2)")
    assert form(f"cos{angle}") == form(f"cos(-1*{angle})") == form(f"sin({angle} + pi/2)")
    assert form(f"cos({angle} + {k}*pi)") == form(f"({(-1) ** k})*cos{angle}")


SAME = ["(a + b)^3*sin(q_1)", "a/(2*b) - 7*a^2/b", "cos(q_1 + 2*q_2)^2*sin(a*q_1)", "(a*b)^-2", "sin(q_1)*cos(q_1) - b"]


@pytest.mark.parametrize("said", SAME)
def test_it_is_the_normal_form_of_the_expression_that_casadi_holds(said):
    symbols = {letter: ca.SX.sym(name) for letter, name in NAMES.items()}
    assert form(said) == NormalForm.of(evaluate(read(said), symbols, CASADI))


def test_a_number_is_the_fraction_that_it_is_printed_as():
    assert form("0.1*0.3 + 1e-30").number == Fraction(3, 100) + Fraction(1, 10**30)
    assert form("sqrt(9/4) + sin(pi/2) + cos(2*pi)").number == Fraction(7, 2)
    assert form("sin(pi/4)").number is form("pi").number is form("a").number is None


def test_numbers_take_the_place_of_symbols_in_coefficients_and_angles():
    numbers = {"a": Fraction(1, 10), "b": Fraction(0)}
    assert at_numbers(form("a^2*q_1*cos(q_2 + b) + b*sin(q_1)"), numbers) == form("q_1*cos(q_2)/100")
    assert at_numbers(form("cos(10*a*q_1) - cos(q_1)"), numbers).is_zero
    assert at_numbers(form("sin(b*q_1)*a"), numbers).is_zero


OUTSIDE = ["tan(q_1)", "sqrt(a)", "sqrt(2)", "sqrt(-1)", "1/(a + b)", "sin(cos(q_1))", "1/sin(q_1)"]


@pytest.mark.parametrize("said", OUTSIDE)
def test_what_has_no_normal_form_is_named(said):
    with pytest.raises(NotInClass, match="normal form"):
        form(said)


def test_a_divisor_that_is_zero_at_the_numbers_is_no_proof():
    with pytest.raises(NotInClass, match="DIV has no value where a = 0"):
        at_numbers(form("q_1/a"), {"a": Fraction(0)})


@pytest.mark.heavy
def test_an_expansion_that_would_take_minutes_is_given_up():
    wide = build.power(build.total([*LETTERS, Number(Fraction(1))]), Number(Fraction(16)))
    with pytest.raises(NotInClass, match="too long to expand"):
        normal_form(build.product([wide, build.total([wide, LETTERS[0]])]), NAMES)
