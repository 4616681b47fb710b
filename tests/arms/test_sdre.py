"""The state-dependent Riccati equation, in the design room and as a law in the loop."""

import numpy as np
import pytest
from scipy.linalg import block_diag, solve_continuous_are

from tests.support.oracles import closed_loop, matrices, worst_difference
from workbench.arms.laws import Sdre
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant, Sines, SineTorque
from workbench.design.matrices import DesignError
from workbench.design.riccati_flow import sdre
from workbench.engine import simulate

WEIGHTS = {"Qp": np.diag([100.0, 80.0]), "Qd": np.diag([1.0, 2.0]), "R": np.diag([0.01, 0.02])}


def loop(reference=None, **changes):
    return ClosedLoop(
        plant=Manipulator(
            paper_arm(),
            q=(0.6, -0.8),
            disturbance=SineTorque(amplitude=[0.5, 0.4], frequency=[3.0, 4.0], phase=[0.0, np.pi / 2]),
        ),
        observer=ArmFullState(2),
        controller=Sdre(paper_arm(), **(WEIGHTS | changes)),
        reference=reference or Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]),
    )


def factors(M, C):
    none, eye = np.zeros((2, 2)), np.eye(2)
    A = np.block([[none, eye], [none, -np.linalg.solve(M, C)]])
    return A, np.vstack([none, np.linalg.inv(M)])


def by_hand(p, z, q, qd, d, ref):
    M, C, G = matrices(p, "controller.model", q, qd)
    A, B = factors(M, C)
    R = p["controller.R"]
    P = solve_continuous_are(A, B, block_diag(p["controller.Qp"], p["controller.Qd"]), R)
    u = -np.linalg.solve(R, B.T @ P @ np.concatenate([q - ref[0], qd - ref[1]]))
    return M @ ref[2] + C @ ref[1] + G + u, {}


def test_the_loop_is_the_one_written_by_hand():
    ode = loop().ode()
    # SciPy's rounding, and what nine doublings leave
    assert worst_difference(ode, closed_loop(by_hand), np.random.default_rng(61)) < 1e-9


@pytest.mark.heavy
def test_along_a_run_the_equation_is_solved_to_rounding():
    run = simulate(loop().digital(2e-3).step(2), until=2.0, every=0.02)
    assert run["residual"].max() < 1e-12
    assert np.abs(run["e"][0, -1]).max() < 0.1  # the disturbance is about 0.5 N m, the stiffness about 100 N m/rad


def residual_at(speed, size):
    """At a speed in rad/s and with weights so many times heavier, or R lighter."""
    ode = loop(reference=Constant("q", "rad", [0.0, 0.0]), R=WEIGHTS["R"] / size).ode()
    x = ode.states.default.copy()
    x[ode.states.slice("plant.qd")] = [speed, -speed]
    return ode.outputs_at(0.0, x)["residual"].item()


@pytest.mark.parametrize("speed", [0.0, 5.0, 20.0])
@pytest.mark.parametrize("size", [1.0, 1e2, 1e4])
def test_the_residual_is_small_for_weights_that_act(size, speed):
    assert residual_at(speed, size) < 1e-10


def test_the_residual_tells_where_the_doublings_do_not_suffice():
    assert residual_at(100.0, 1e-4) > 1e-3


def test_one_torque_for_two_joints_is_cheap_enough_for_a_sampled_loop():
    ode = loop().ode()
    assert ode.f.n_instructions() < 12_000  # once a period; four times a step of RK4


def test_the_design_room_solves_it_at_every_state():
    def of(x):
        M, C, _ = matrices(P, "a", x[:2], x[2:])
        return factors(M, C)

    P = {f"a.links[{i}].{name}": 1.0 for i in (0, 1) for name in ("mass", "length")} | {"a.gravity": 9.81}
    states = np.random.default_rng(62).uniform(-2, 2, (20, 4))
    Q, R = block_diag(WEIGHTS["Qp"], WEIGHTS["Qd"]), WEIGHTS["R"]
    found = sdre(of, states, Q, R)
    for i, x in enumerate(states):
        A, B = of(x)
        X = solve_continuous_are(A, B, Q, R)
        np.testing.assert_allclose(found.P[i], X, rtol=1e-9, atol=1e-9)  # SciPy's rounding
        np.testing.assert_allclose(found.K[i], np.linalg.solve(R, B.T @ X), rtol=1e-8, atol=1e-8)
    assert found.decay_rate > 0
    assert max(certificate.residual for certificate in found.certificates) < 1e-14


def test_a_state_without_a_solution_is_refused_by_its_place():
    """x' = x^3 + (x - 1) u: at x = 1 no input reaches an unstable state."""
    with pytest.raises(DesignError, match=r"at state 1, \[1.0\]"):
        sdre(lambda x: ([[x[0] ** 2]], [[x[0] - 1.0]]), [[0.5], [1.0]], 1.0, 1.0)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"Qp": np.diag([1.0, 0.0])}, r"'Sdre\(Qp=...\)' must be positive definite"),
        ({"Qd": np.diag([1.0, -1.0])}, r"'Sdre\(Qd=...\)' must be positive semidefinite"),
        ({"R": np.array([[1.0, 0.5], [0.0, 1.0]])}, r"'Sdre\(R=...\)' must be symmetric"),
    ],
)
def test_weights_that_are_none_are_refused(change, says):
    with pytest.raises(ValueError, match=says):
        Sdre(paper_arm(), **(WEIGHTS | change))


def test_states_that_are_none_are_refused():
    with pytest.raises(ValueError, match="states must be finite numbers"):
        sdre(lambda x: (x, x), [[np.nan]], 1.0, 1.0)
