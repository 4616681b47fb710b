"""Linear systems of python-control as an Ode, and back."""

import control
import numpy as np
import pytest

from workbench.core import rk4
from workbench.design.linear import from_control, linearize, to_control
from workbench.simulate import simulate

NAMES = {"states": ["q[0]", "q[1]", "z"], "inputs": ["tau[0]", "tau[1]"], "outputs": ["y"]}


def random_system(seed=0):
    rng = np.random.default_rng(seed)
    A, B, C, D = (rng.normal(size=shape) for shape in ((3, 3), (3, 2), (1, 3), (1, 2)))
    return control.ss(A - 3 * np.eye(3), B, C, D, name="random", **NAMES)


def test_the_round_trip_keeps_every_bit_and_every_name():
    system = random_system()
    again = linearize(from_control(system), 0.0, np.ones(3))
    for letter in "ABCD":
        np.testing.assert_array_equal(getattr(again, letter), getattr(system, letter))
    for names in ("state_labels", "input_labels", "output_labels", "name"):
        assert getattr(again, names) == getattr(system, names)


def test_labels_that_count_become_one_quantity():
    ode = from_control(random_system())
    assert ode.states.names == ("q", "z")
    assert ode.states["q"].shape == (2,)
    assert ode.inputs == ("tau",)
    ode.parameters.pack({"tau": [1.0, 2.0], "random.A": np.zeros((3, 3))})


def test_matrices_and_odd_labels_keep_their_order():
    labels = ["K[0,0]", "K[1,0]", "K[0,1]", "K[1,1]", "a[1]", "a[0]"]
    system = control.ss(-np.eye(6), np.ones((6, 1)), np.ones((1, 6)), 0, states=labels)
    ode = from_control(system)
    assert list(ode.states.labels) == labels
    assert ode.states.names == ("K", "a[1]", "a[0]")


def test_the_step_response_is_python_controls():
    system, t = random_system(3), np.linspace(0, 2, 21)
    ode = from_control(system)
    ours = simulate(rk4(ode, 1e-3), ode.parameters.pack({"tau": [1.0, 0.0]}), until=2.0, every=0.1)
    theirs = control.step_response(system, t, input=0).states[:, 0, :].T
    # RK4 at 1 ms on rates of a few 1/s: 1e-12; theirs is a matrix exponential
    np.testing.assert_allclose(ours.x[0], theirs, rtol=0, atol=1e-11)


@pytest.mark.parametrize(
    ("system", "message"),
    [
        (to_control(from_control(random_system())), "a nonlinear system.*holds Python functions"),
        (control.tf([1], [1, 1], name="lag"), r"`StateSpace`, which has states; got TransferFunction 'lag'"),
        (control.ss(0.5, 1, 1, 0, 0.1, name="sampled"), "continuous time.*'sampled' moves in steps of 0.1"),
        (control.ss(np.inf, 1, 1, 0, name="odd"), "A of 'odd' is not"),
        (np.eye(2), "must be a `StateSpace` of python-control; got"),
    ],
)
def test_what_is_no_linear_system_in_continuous_time_is_refused(system, message):
    with pytest.raises(ValueError, match=message):
        from_control(system)
