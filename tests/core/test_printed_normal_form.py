"""Normal forms as they are printed: terms in the order of textbooks, in every process."""

import subprocess
import sys
from fractions import Fraction

import casadi as ca
import pytest

from workbench.core.notation import text
from workbench.core.notation.formula import Matrix, Number, symbol
from workbench.core.notation.normal_form import normal_forms, to_formula

NAMES = ("q_1", "q_2", "qd_1", "m_1", "l_1")
SYMBOLS = {name: ca.SX.sym(name) for name in NAMES}
q1, q2, qd1, m, l = SYMBOLS.values()


def columns(n):
    """The symbols q and qd of n joints."""
    return [ca.vertcat(*[ca.SX.sym(f"{letter}_{i + 1}") for i in range(n)]) for letter in ("q", "qd")]


def arm(q, qd):
    """M, C (Christoffel) and G of a hanging chain of point masses, from their Cartesian velocities."""
    n, g = q.numel(), ca.SX.sym("g")
    position, T, U = ca.SX(2, 1), ca.SX(0), ca.SX(0)
    for i in range(n):
        angle, mass = ca.sum1(q[: i + 1]), ca.SX.sym(f"m_{i + 1}")
        position += ca.SX.sym(f"l_{i + 1}") * ca.vertcat(ca.sin(angle), -ca.cos(angle))
        T += mass * ca.sumsqr(ca.jtimes(position, q, qd)) / 2
        U += mass * g * position[1]
    M = ca.hessian(T, qd)[0]
    C = ca.SX(n, n)
    for i in range(n):
        for j in range(n):
            for k in range(n):
                terms = ca.jacobian(M[i, j], q[k]) + ca.jacobian(M[i, k], q[j]) - ca.jacobian(M[j, k], q[i])
                C[i, j] += terms * qd[k] / 2
    return M, C, ca.gradient(U, q)


def lines(matrix):
    return [text.emit(entry) for row in to_formula(matrix).rows for entry in row]


def test_the_two_link_arm_prints_as_in_a_textbook():
    M, C, G = arm(*columns(2))
    assert lines(M) == [
        "m_1*l_1^2 + m_2*(l_1^2 + l_2^2 + 2*l_1*l_2*cos(q_2))",
        "m_2*(l_2^2 + l_1*l_2*cos(q_2))",
        "m_2*(l_2^2 + l_1*l_2*cos(q_2))",
        "m_2*l_2^2",
    ]
    assert lines(C) == [
        "-m_2*l_1*l_2*qd_2*sin(q_2)",
        "-m_2*l_1*l_2*(qd_1 + qd_2)*sin(q_2)",
        "m_2*l_1*l_2*qd_1*sin(q_2)",
        "0",
    ]
    assert lines(G) == [
        "(m_1 + m_2)*g*l_1*sin(q_1) + m_2*g*l_2*sin(q_1 + q_2)",
        "m_2*g*l_2*sin(q_1 + q_2)",
    ]


def test_m_dot_minus_two_c_is_proved_skew_and_a_misprint_is_not():
    q, qd = columns(2)
    M, C, _ = arm(q, qd)
    N = ca.reshape(ca.jtimes(ca.vec(M), q, qd), 2, 2) - 2 * C
    assert all(form.is_zero for row in normal_forms(N + N.T) for form in row)
    C[0, 1] = M[0, 1]  # the paper's slip
    N = ca.reshape(ca.jtimes(ca.vec(M), q, qd), 2, 2) - 2 * C
    assert not all(form.is_zero for row in normal_forms(N + N.T) for form in row)


@pytest.mark.heavy
def test_four_links_are_expanded_exactly():
    q, qd = columns(4)
    M, C, G = arm(q, qd)
    N = ca.reshape(ca.jtimes(ca.vec(M), q, qd), 4, 4) - 2 * C
    assert all(form.is_zero for row in normal_forms(N + N.T) for form in row)
    to_formula(ca.horzcat(M, C, G))


@pytest.mark.parametrize(
    ("expression", "printed"),
    [
        (q1**2 + 2 * q1 * q2 + q2**2, "q_1^2 + 2*q_1*q_2 + q_2^2"),
        (m * q1 + m * q2, "m_1*(q_1 + q_2)"),
        (3 - q1, "-q_1 + 3"),
        (0.1 * q1 + 9.81, "0.1*q_1 + 9.81"),
        (q1 / 3 + q2 / 3, "1/3*q_1 + 1/3*q_2"),
        (m * (q1 + q2) / 2, "1/2*m_1*(q_1 + q_2)"),
        (ca.sin(q1 - q2), "sin(q_1 - q_2)"),
        (ca.sin(q2 - q1), "-sin(q_1 - q_2)"),
        (ca.sin(q1) * ca.sin(q2), "1/2*cos(q_1 - q_2) - 1/2*cos(q_1 + q_2)"),
        (m * qd1 / l, "m_1*qd_1/l_1"),
        ((m + 1) * ca.sin(q1) / l, "(m_1 + 1)*sin(q_1)/l_1"),
        ((m + 2 * l) * (qd1 + q1) * ca.cos(q2), "(m_1*q_1 + m_1*qd_1 + 2*l_1*q_1 + 2*l_1*qd_1)*cos(q_2)"),
        (ca.SX(0), "0"),
        (m * l**2 * (1 + ca.cos(q1)), "m_1*(l_1^2 + l_1^2*cos(q_1))"),
    ],
)
def test_terms_stand_in_the_order_of_textbooks(expression, printed):
    assert text.emit(to_formula(expression)) == printed


def test_an_angle_in_time_prints_frequency_before_time():
    omega, theta, t, a = (ca.SX.sym(name) for name in ("omega_1", "theta_1", "t", "a_1"))
    assert text.emit(to_formula(a * ca.sin(omega * t + theta))) == "a_1*sin(omega_1*t + theta_1)"


def test_names_that_would_be_printed_alike_are_refused_across_a_matrix():
    with pytest.raises(ValueError, match="printed q_1"):
        to_formula(ca.vertcat(q1, q2), {"q_1": symbol("q_1"), "q_2": symbol("q_1")})


def test_a_matrix_has_a_formula_for_each_entry():
    assert to_formula(ca.diag(ca.vertcat(q1, q2))) == Matrix(
        ((symbol("q_1"), Number(Fraction(0))), (Number(Fraction(0)), symbol("q_2")))
    )


PRINT_IN_ANOTHER_PROCESS = """
import casadi as ca
from workbench.core.notation import text
from workbench.core.notation.normal_form import to_formula
a, b, c, d = (ca.SX.sym(x) for x in ("m_1", "l_c1", "q_1", "qd_10"))
print(text.emit(to_formula((a + b + c * d) ** 3 * ca.cos(c) * ca.sin(2 * d + a) + a * b * (c + d))))
"""


@pytest.mark.heavy
def test_the_order_of_terms_is_the_same_in_every_process():
    outputs = {
        subprocess.run(
            [sys.executable, "-c", PRINT_IN_ANOTHER_PROCESS],
            env={"PYTHONHASHSEED": seed, "PATH": "", "PYTHONPATH": ":".join(filter(None, sys.path))},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(outputs) == 1
    assert "sin(m_1 - q_1 + 2*qd_10)" in outputs.pop()
