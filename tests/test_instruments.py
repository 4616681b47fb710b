"""What a computer reads and what it can ask for."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.core import Signals, lift
from workbench.loop.instruments import quantised
from workbench.plants import ArmInstruments

X, B = ca.SX.sym("x"), ca.SX.sym("b")
QUANTISED = ca.Function("quantised", [X, B], [quantised(X, B)])
positions = st.floats(-100, 100)
quanta = st.floats(1e-5, 10)


def read(q, qd, w, **numbers):
    y = ArmInstruments(2, **numbers).read(Signals(q=ca.SX(q), qd=ca.SX(qd), d=ca.SX([7.0, 8.0])), ca.SX(w))
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


def test_one_number_stands_for_all_joints_and_every_number_is_a_parameter():
    layout = lift(ArmInstruments(3, noise_q=1e-3, limit=5.0), "instruments.").layout
    np.testing.assert_array_equal(layout["instruments.noise_q"].default, [1e-3] * 3)
    assert {entry.name: entry.unit for entry in layout.entries} == {
        "instruments.noise_q": "rad",
        "instruments.noise_qd": "rad/s",
        "instruments.quantum_q": "rad",
        "instruments.quantum_qd": "rad/s",
        "instruments.limit": "N m",
    }
    assert "instruments.limit" not in lift(ArmInstruments(3), "instruments.").layout


@pytest.mark.parametrize("limit", [None, 2.0])
def test_a_torque_is_limited_where_there_is_a_limit(limit):
    limited = ArmInstruments(3, limit=limit).limited(Signals(tau=ca.SX([-3.0, 1.5, 2.5])))
    assert set(limited) == (set() if limit is None else {"tau"})
    if limit is not None:
        np.testing.assert_array_equal(np.array(ca.evalf(limited.tau)).ravel(), [-2.0, 1.5, 2.0])


@pytest.mark.parametrize(
    ("numbers", "says"),
    [
        ({"noise_q": -1e-3}, r"`ArmInstruments\(noise_q=...\)` must be finite, with 0 <= value \[rad\]"),
        ({"noise_qd": np.nan}, r"`ArmInstruments\(noise_qd=...\)` must be finite"),
        ({"quantum_q": [0.1, -0.1]}, r"`ArmInstruments\(quantum_q=...\)` must be finite, with 0 <= value"),
        ({"quantum_qd": np.inf}, r"`ArmInstruments\(quantum_qd=...\)` must be finite"),
        ({"limit": 0.0}, r"`ArmInstruments\(limit=...\)` must be finite, with 0 < value \[N m\]; got \[0., 0.\]"),
        (
            {"limit": [1.0, 2.0, 3.0]},
            r"`ArmInstruments\(limit=...\)` must be an array of shape \(n = 2\); got shape \(3,\)",
        ),
    ],
)
def test_a_number_that_no_instrument_has_is_refused(numbers, says):
    with pytest.raises(ValueError, match=says):
        ArmInstruments(2, **numbers)


@pytest.mark.parametrize("joints", [0, -1])
def test_instruments_for_no_joint_are_refused(joints):
    with pytest.raises(ValueError, match="needs at least one joint"):
        ArmInstruments(joints)


@pytest.mark.parametrize("joints", [True, 1.5, "2", None])
def test_a_number_of_joints_that_is_none_is_refused(joints):
    with pytest.raises(ValueError, match=r"`ArmInstruments\(joints=...\)` must be a whole number; got"):
        ArmInstruments(joints)


def test_a_row_with_a_negative_noise_is_refused():
    parameters = lift(ArmInstruments(2), "instruments.").layout
    with pytest.raises(ValueError, match=r"'instruments.noise_q\[1\]' must be finite, with 0 <= value \[rad\]; got -1"):
        parameters.pack({"instruments.noise_q": [0.0, -1.0]})
