"""Two expressions are equal for all values of their symbols if and only if their normal forms are."""

import math
import pickle

import casadi as ca
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.core.notation import text
from workbench.core.notation.normal_form import NormalForm, NotInClass

NAMES = ("q_1", "q_2", "qd_1", "m_1", "l_1")
SYMBOLS = {name: ca.SX.sym(name) for name in NAMES}
q1, q2, qd1, m, l = SYMBOLS.values()


def same(a, b):
    return NormalForm.of(a) == NormalForm.of(b)


# CasADi folds products of constants in floating point before we see them, so these are exact in binary.
exact = st.sampled_from([-3, -1, 0.5, 2])
decimal = st.sampled_from([0.1, 9.81])
angles = st.builds(lambda i, j: i * q1 + j * q2, st.sampled_from([-2, -1, 1, 2]), st.integers(-2, 2))
shifted = st.builds(lambda angle, phase: angle + phase, angles, st.sampled_from([0.25, -1, 3]))


def grown(numbers, arguments):
    """Expressions of the class, from these numbers and angles."""
    leaves = st.one_of(
        st.sampled_from(list(SYMBOLS.values())), numbers.map(ca.SX), arguments.map(ca.sin), arguments.map(ca.cos)
    )
    return st.recursive(
        leaves,
        lambda inner: st.one_of(
            st.builds(lambda a, b: a + b, inner, inner),
            st.builds(lambda a, b: a - b, inner, inner),
            st.builds(lambda a, b: a * b, inner, inner),
            st.builds(lambda a: -a, inner),
            st.builds(lambda a: a**2, inner),
            st.builds(lambda a: a / (2 * m * l), inner),
        ),
        max_leaves=8,
    )


expressions = grown(exact, angles)
any_expressions = grown(exact | decimal, angles | shifted)
states = st.fixed_dictionaries({name: st.floats(0.5, 2.0) for name in NAMES})


def value(expression, state):
    function = ca.Function("value", [ca.vertcat(*SYMBOLS.values())], [expression])
    return float(function([state[name] for name in NAMES]))


def size(form, state):
    """The sum of absolute terms: what rounding errors are relative to."""
    powers = [math.prod(state[name] ** e for name, e in monomial) for monomial, _ in form.terms]
    return 1 + sum(abs(float(c)) * p for c, p in zip(form.terms.values(), powers, strict=True))


@given(any_expressions, states)
def test_a_normal_form_has_the_value_of_its_expression(expression, state):
    form = NormalForm.of(expression)
    # Some hundred roundings, each relative to the terms; cancellation within the expression itself can
    # lift the scale of its own terms above that of the form, for which three decades are allowed.
    assert value(form.to_casadi(SYMBOLS), state) == pytest.approx(
        value(expression, state), abs=1e-11 * size(form, state)
    )


@settings(max_examples=25)
@given(expressions, expressions)
def test_the_normal_form_of_a_sum_difference_product_is_that_of_the_forms(a, b):
    A, B = NormalForm.of(a), NormalForm.of(b)
    assert NormalForm.of(a + b) == A + B == B + A
    assert NormalForm.of(a - b) == A - B
    assert NormalForm.of(a * b) == A * B == B * A


@given(expressions)
def test_the_printed_formula_says_exactly_what_the_expression_says(expression):
    """Read back from plain text into CasADi, the textbook form has the same normal form."""
    form = NormalForm.of(expression)
    back = ca.SX(eval(text.emit(form.to_formula(), width=1e9).replace("^", "**"), SYMBOLS | vars(ca)))
    assert NormalForm.of(back) == form


@given(expressions)
def test_the_rebuilt_expression_has_the_same_normal_form(expression):
    form = NormalForm.of(expression)
    assert NormalForm.of(form.to_casadi(SYMBOLS)) == form


@settings(max_examples=25)
@given(angles, angles)
def test_products_of_sines_and_cosines_become_sums_exactly(a, b):
    assert NormalForm.of(ca.sin(a) ** 2 + ca.cos(a) ** 2 - 1).is_zero
    assert same(2 * ca.sin(a) * ca.cos(b), ca.sin(a + b) + ca.sin(a - b))
    assert same(2 * ca.cos(a) * ca.cos(b), ca.cos(a - b) + ca.cos(a + b))
    assert same(2 * ca.sin(a) * ca.sin(b), ca.cos(a - b) - ca.cos(a + b))
    assert same(ca.sin(a + b), ca.sin(a) * ca.cos(b) + ca.cos(a) * ca.sin(b))
    assert same(ca.sin(-a), -ca.sin(a))
    assert same(ca.cos(-a), ca.cos(a))


@pytest.mark.parametrize(
    ("a", "b"),
    [
        ((q1 + q2) ** 3, q1**3 + 3 * q1**2 * q2 + 3 * q1 * q2**2 + q2**3),
        (4 * ca.cos(q1) ** 3 - 3 * ca.cos(q1), ca.cos(3 * q1)),
        (2 * ca.sin(q1 / 2) ** 2, 1 - ca.cos(q1)),
        ((m * l**2 + m) / (m * l), l + 1 / l),
        (m**-2 * m**3, m),
        (ca.sin(m * q1 + l) * 2 * ca.cos(m * q1 + l), ca.sin(2 * m * q1 + 2 * l)),
        (ca.sin(q1 + 0.25) ** 2, 0.5 - ca.cos(2 * q1 + 0.5) / 2),
        (ca.sin(ca.SX(0) * q1), ca.SX(0)),
        (q1 * 0.1 + q1 * 0.2, q1 * 0.1 + 0.2 * q1),
    ],
)
def test_known_identities_hold(a, b):
    assert same(a, b)


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (ca.sin(q1), ca.cos(q1)),
        (ca.sin(q1 + q2), ca.sin(q1 - q2)),
        (ca.sin(q1 + 0.25), ca.sin(q1)),
        (0.1 * q1 + 0.2 * q1, 0.3 * q1),  # doubles are the fractions that they are: 0.1 + 0.2 is not 0.3
        (q1 / 3, (1 / 3) * q1),  # nor is the double 1/3 a third
        (ca.sin(q1 + math.pi / 2), ca.cos(q1)),  # nor the double pi
        (m / l, l / m),
    ],
)
def test_what_is_not_identical_is_not_called_so(a, b):
    assert not NormalForm.of(a - b).is_zero
    assert not same(a, b)


@pytest.mark.parametrize(
    ("expression", "word"),
    [
        (ca.exp(q1), "EXP"),
        (ca.fabs(q1), "FABS"),
        (ca.sqrt(m), "SQRT"),
        (m**1.5, "POW"),
        (m**q1, "POW"),
        (q1 / (m + l), "DIV"),
        (q1 / ca.cos(q1), "DIV"),
        (1 / ca.sin(q1), "DIV"),
        (ca.sin(ca.cos(q1)), "SIN"),
        (ca.cos(q1 * ca.sin(q2)), "COS"),
        (ca.if_else(q1 > 0, m, l), "LT"),
        (q1 * ca.inf, "inf"),
        (q1 + ca.SX.sym("q_1"), "q_1"),
        ((q1 + q2 + m + l) ** 64, "too long"),
        pytest.param(math.prod([q1 + q2 + m + l] * 60), "terms on the way: too long", marks=pytest.mark.heavy),
    ],
)
def test_what_is_outside_the_class_is_refused_by_name(expression, word):
    with pytest.raises(NotInClass, match=word):
        NormalForm.of(expression)


def test_one_normal_form_is_of_one_expression():
    with pytest.raises(ValueError, match="normal_forms"):
        NormalForm.of(ca.vertcat(q1, q2))


def test_forms_of_different_symbols_with_one_name_are_compared_by_name():
    assert same(ca.sin(q1), ca.sin(ca.SX.sym("q_1")))
    assert NormalForm.of(q1) != NormalForm.of(q2)
    assert NormalForm.of(q1) != "q_1"


def test_a_normal_form_survives_a_journey_to_another_process():
    form = NormalForm.of(m * ca.cos(q1) + m + ca.sin(q2) ** 2)
    back = pickle.loads(pickle.dumps(form))
    assert back == form
    assert back * back == form * form
