"""AOSMC-RGS with P solved for at every instant, against a hand-written loop and SciPy's algebraic equation."""

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from tests.support.oracles import aosmc_rgs, closed_loop, matrices, worst_difference
from workbench.arms.laws import AosmcRgs
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm, robot
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant, Sines, SineTorque
from workbench.core import rk4
from workbench.core.claim import claims_of
from workbench.engine import simulate
from workbench.proofs.claim_margins import violation, with_violations

LAW = {
    "model": paper_arm(),
    "Lambda": [6.0, 5.0],
    "phi": 0.01,
    "K": 5 * np.eye(2),
    "Q": np.diag([3.0, 2.0]),
    "R": np.diag([1.5, 1.0]),
    "riccati": "algebraic",
}


def loop(**changes):
    push = SineTorque(amplitude=[0.5, 0.4], frequency=[3.0, 4.0], phase=[0.0, np.pi / 2])
    return ClosedLoop(
        plant=Manipulator(paper_arm(), q=(0.6, -0.8), disturbance=push),
        observer=ArmFullState(2),
        controller=AosmcRgs(**(LAW | changes)),
        reference=Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]),
    )


def riccati_of(p, K, q):
    A = -np.linalg.solve(matrices(p, "controller.model", q, 0 * q)[0], K)
    return solve_continuous_are(A, np.diag(p["controller.Lambda"]), p["controller.Q"], p["controller.R"])


def by_hand(velocity, sign, shape):
    """The frozen law, its P replaced at every instant by SciPy's solution."""
    frozen = aosmc_rgs(velocity, sign, shape, riccati="frozen")

    def law(p, z, q, qd, d, ref):
        tau, rates = frozen(p, z | {"controller.P": riccati_of(p, z["controller.K"], q)}, q, qd, d, ref)
        return tau, {"controller.K": rates["controller.K"]}

    return law


@pytest.mark.parametrize("shape", ["outer", "elementwise", "diagonal", "norm"])
def test_the_loop_is_the_one_written_by_hand(shape):
    ode = loop(velocity="reference", gain_sign="raised", gain_shape=shape).ode()
    rates = closed_loop(by_hand("reference", "raised", shape))
    # K is any matrix here, so A may be far from stable: SciPy's rounding
    assert worst_difference(ode, rates, np.random.default_rng(31), cases=25) < 1e-9


def test_p_is_shown_with_its_residual_and_stays_definite():
    ode = loop(velocity="reference", gain_sign="raised", gain_shape="norm").ode()
    claims = [said for said in claims_of(loop().controller, "controller.") if said.claim.name.startswith("P stays")]
    run = simulate(rk4(with_violations(ode, claims), 1e-3), until=2.0, every=0.1)
    p = ode.parameters.unpack(ode.parameters.default)
    for i in range(len(run.t)):
        X = riccati_of(p, run["controller.K"][0, i], run["plant.q"][0, i])
        np.testing.assert_allclose(run["P"][0, i].reshape(2, 2), X, rtol=1e-9, atol=1e-12)  # SciPy's rounding
    assert run["residual"].max() < 1e-12
    assert run[violation(claims[0].claim).signal].max() < 0


def test_three_joints_are_solved_by_doubling():
    arm = robot("planar-3r")
    law = AosmcRgs(arm, 6.0, 0.01, 5 * np.eye(3), Q=np.eye(3), R=np.eye(3), velocity="reference", riccati="algebraic")
    ode = ClosedLoop(
        Manipulator(arm, q=[0.1, 0.2, 0.3]), ArmFullState(3), law, Constant("q", "rad", [0.1, 0.2, 0.3])
    ).ode()
    outputs = ode.outputs_at(0.0, ode.states.default)
    assert outputs["residual"] < 1e-12
    assert (np.linalg.eigvalsh(outputs["P"].reshape(3, 3)) > 0).all()


def test_a_start_of_p_without_effect_is_refused():
    with pytest.raises(ValueError, match="must have Q and R and no other of P, Q and R, .*; got P and Q and R"):
        AosmcRgs(**LAW, P=np.eye(2))


@pytest.mark.parametrize("riccati", ["forward", "frozen"])
def test_a_missing_start_of_p_is_refused(riccati):
    with pytest.raises(ValueError, match=rf"`AosmcRgs\(riccati='{riccati}'\)` must have P .*; got Q and R"):
        AosmcRgs(**(LAW | {"riccati": riccati}))


def test_the_algebraic_equation_needs_its_weights():
    with pytest.raises(ValueError, match="must have Q and R and no other of P, Q and R, .*; got Q"):
        AosmcRgs(**(LAW | {"R": None}))
