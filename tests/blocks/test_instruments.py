"""What a computer reads and what it can ask for."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.arms import arm_instruments
from workbench.blocks.loop.quantisation import quantise
from workbench.core import Signals

X, B = ca.SX.sym("x"), ca.SX.sym("b")
QUANTISED = ca.Function("quantised", [X, B], [quantise(X, B)])
positions = st.floats(-100, 100)
quanta = st.floats(1e-5, 10)


def read(q, qd, w, **numbers):
    y = arm_instruments(2, **numbers).read(Signals(q=ca.SX(q), qd=ca.SX(qd), d=ca.SX([7.0, 8.0])), ca.SX(w))
    return [np.array(ca.evalf(part)).ravel() for part in (y.q, y.qd)]


@given(positions, quanta)
def test_a_reading_is_a_multiple_of_its_quantum_and_at_most_half_of_one_away(x, quantum):
    y = float(QUANTISED(x, quantum))
    # a quotient of up to 1e7 is rounded to 1e-9 of a quantum
    assert abs(y - x) <= (0.5 + 1e-8) * quantum
    assert y / quantum == pytest.approx(np.rint(y / quantum), abs=1e-8)


@given(positions, quanta)
def test_a_reading_that_is_read_again_is_the_same(x, quantum):
    once = float(QUANTISED(x, quantum))
    assert float(QUANTISED(once, quantum)) == once


@pytest.mark.parametrize(
    ("x", "y"), [(0.25, 0.5), (-0.25, 0.0), (0.75, 1.0), (-0.75, -0.5), (0.24, 0.0), (-0.26, -0.5)]
)
def test_half_a_quantum_is_rounded_up(x, y):
    assert float(QUANTISED(x, 0.5)) == y


@given(positions)
def test_a_quantum_of_zero_is_no_quantum(x):
    assert float(QUANTISED(x, 0.0)) == x


def test_each_noise_has_its_own_number_and_size_and_comes_before_the_rounding():
    q, qd = read(
        [0.1, 0.2],
        [0.3, 0.4],
        [1.0, -2.0, 3.0, -4.0],
        noise_q=[0.01, 0.02],
        noise_qd=[0.1, 0.2],
        quantum_qd=[0.0, 0.25],
    )
    np.testing.assert_allclose(q, [0.1 + 0.01, 0.2 - 0.04], rtol=1e-15)
    np.testing.assert_allclose(qd, [0.3 + 0.3, -0.5], rtol=1e-15)  # 0.4 - 0.8 = -0.4 is nearer to -0.5 than to -0.25


@pytest.mark.parametrize("limit", [None, 2.0])
def test_a_torque_is_limited_where_there_is_a_limit(limit):
    limited = arm_instruments(3, limit=limit).limit_commands(Signals(tau=ca.SX([-3.0, 1.5, 2.5])))
    assert set(limited) == (set() if limit is None else {"tau"})
    if limit is not None:
        np.testing.assert_array_equal(np.array(ca.evalf(limited.tau)).ravel(), [-2.0, 1.5, 2.0])
