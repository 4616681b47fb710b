"""Rest points: found, proved, told apart by what happens near them; modes counted exactly."""

from fractions import Fraction

import casadi as ca
import numpy as np
import pytest

from workbench.core import Entry, Layout, Ode, rk4
from workbench.engine import simulate
from workbench.proofs.rest_points import growing_modes, rest_point


def pendulum(damping: float = 0.5, torque: float = 0.5, driven: bool = False) -> Ode:
    """q'' = u - d q' - sin q: at rest where sin q = u, hanging or upright."""
    states = Layout((Entry("q", 0.0), Entry("w", 0.0)))
    parameters = Layout((Entry("d", damping), Entry("u", torque)))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    push = ca.sin(t) if driven else 0
    rates = {"q": x[1], "w": p[1] - p[0] * x[1] - ca.sin(x[0]) + push}
    return Ode.of("pendulum", states, parameters, (t, x, p), rates, {})


def test_a_rest_point_is_found_and_proved_where_the_closed_form_has_it():
    found = rest_point(pendulum(), np.array([0.4, 0.1]))
    assert found.radius is not None
    assert found.radius < 1e-6
    np.testing.assert_allclose(found.x, [np.pi / 6, 0.0], atol=1e-12)  # sin q = 1/2


def test_the_hanging_pendulum_attracts_and_the_upright_one_does_not():
    assert rest_point(pendulum(), np.array([0.5, 0.0])).attracts
    upright = rest_point(pendulum(), np.array([2.6, 0.0]))
    assert upright.radius is not None
    assert not upright.attracts
    assert upright.modes.real.max() > 0


def test_a_linear_equation_is_at_rest_where_its_matrix_says():
    states = Layout((Entry("x", np.zeros(2)),))
    t, x = ca.SX.sym("t"), states.symbols()
    A, b = np.array([[-1.0, 2.0], [0.5, -3.0]]), np.array([1.0, -2.0])
    ode = Ode.of("linear", states, Layout(), (t, x, ca.SX(0, 1)), {"x": A @ x + b}, {})
    found = rest_point(ode, np.ones(2))
    np.testing.assert_allclose(found.x, -np.linalg.solve(A, b), rtol=1e-12)
    assert found.radius is not None
    assert found.attracts


def test_where_no_interval_is_known_nothing_is_proved():
    states = Layout((Entry("x", 1.0),))
    t, x = ca.SX.sym("t"), states.symbols()
    ode = Ode.of("gamma", states, Layout(), (t, x, ca.SX(0, 1)), {"x": 0.5 - ca.erf(x)}, {})
    found = rest_point(ode, np.array([0.4]))
    np.testing.assert_allclose(found.x, 0.4769362762044699, rtol=1e-12)  # erf of it is a half
    assert (found.radius, found.attracts) == (None, False)
    assert "ERF" in found.why


def test_parameters_are_not_rounded_before_the_proof():
    states, parameters = Layout((Entry("x", 0.0),)), Layout((Entry("a", 1e16),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    rate = -((p[0] - 1) - p[0] + 0.5) * x[0]  # it is x / 2, which grows; doubles make it -x / 2
    ode = Ode.of("swallowed", states, parameters, (t, x, p), {"x": rate}, {})
    assert growing_modes(ode) == 1
    assert not rest_point(ode, np.array([0.1])).attracts


def alone(rate) -> Ode:
    """x' = f(x)."""
    states = Layout((Entry("x", 1.0),))
    t, x = ca.SX.sym("t"), states.symbols()
    return Ode.of("alone", states, Layout(), (t, x, ca.SX(0, 1)), {"x": rate(x[0])}, {})


def test_a_rate_that_jumps_over_zero_has_no_proved_rest_point():
    # from 1e-14 to -1e-14 at 0: Newton's method takes it for zero
    found = rest_point(alone(lambda x: -x - 1e-14 * ca.if_else(x > 0, 1, -1)), np.array([1.0]))
    assert (found.radius, found.attracts) == (None, False)
    assert "only of a function without jumps; this one holds" in found.why


def test_a_rest_point_that_is_double_is_refused_in_a_sentence():
    with pytest.raises(ValueError, match="at which df/dx is regular"):
        rest_point(alone(lambda x: x**2), np.array([0.0]))
    near = rest_point(alone(lambda x: x**2), np.array([0.1]))
    assert near.radius is None
    assert near.why


def test_without_damping_nothing_is_proved_to_attract():
    assert not rest_point(pendulum(damping=0.0), np.array([0.5, 0.0])).attracts


def test_what_is_proved_to_attract_does_so_in_a_simulation():
    found = rest_point(pendulum(), np.array([0.5, 0.0]))
    start = found.x + [0.05, -0.05]
    run = simulate(rk4(pendulum(), 0.01), x0=start[np.newaxis], until=60.0, every=60.0)
    np.testing.assert_allclose(run.x[0, -1], found.x, atol=1e-6)  # the slowest mode decays like exp(-t / 4)


def test_where_there_is_no_rest_point_none_is_found():
    with pytest.raises(ValueError, match="found no rest point of 'pendulum'"):
        rest_point(pendulum(torque=2.0), np.array([0.4, 0.0]))


def test_an_equation_in_time_has_no_rest_point():
    with pytest.raises(ValueError, match="must have a rate that does not depend on time"):
        rest_point(pendulum(driven=True), np.array([0.4, 0.0]))


def test_growing_modes_are_counted_exactly():
    assert growing_modes(pendulum(torque=0.0)) == 0
    assert growing_modes(pendulum(damping=-0.5, torque=0.0)) == 2


def test_numbers_can_be_given_as_fractions():
    ode = pendulum(torque=0.0)
    assert growing_modes(ode, {"d": Fraction(-1, 10**30)}) == 2  # no float could tell
    assert growing_modes(ode, {"d": Fraction(0)}) is None


def test_a_state_that_moves_is_no_rest_point():
    with pytest.raises(ValueError, match="must be a rest point of 'pendulum'"):
        growing_modes(pendulum(torque=0.5))
