"""RISE against a hand-written loop, and the error that its theorem takes to zero under a disturbance."""

import numpy as np
import pytest

from tests.support.oracles import closed_loop, integrate, matrices, sat, worst_difference
from workbench.arms.laws import Rise
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm, robot
from workbench.arms.mechanics.planar_arm import PlanarArm, PointMass
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant, Sines, SineTorque
from workbench.core import rk4
from workbench.core.claim import claims_of
from workbench.engine import simulate
from workbench.proofs.falsify import Budget, RunSearch

ARM = paper_arm()
LAW = {"Lambda": [6.0, 5.0], "alpha": [4.0, 3.0], "ks": [60.0, 25.0], "beta": [12.0, 9.0], "phi": 0.1, "model": ARM}


def loop(**changes):
    return ClosedLoop(
        Manipulator(ARM, q=[0.6, -0.8], disturbance=SineTorque([0.5, 0.4], [3.0, 4.0], [0.0, np.pi / 2])),
        ArmFullState(2),
        Rise(**(LAW | changes)),
        Sines("q", "rad", [1.0, 0.5], [2.0, 3.0]),
    )


def rise(kind, feedforward):
    def law(p, z, q, qd, d, ref):
        e2 = (ref[1] - qd) + p["controller.Lambda"] * (ref[0] - q)  # of the authors
        gain = p["controller.ks"] + 1
        M, C, G = matrices(p, "controller.model", ref[0], ref[1]) if feedforward else (np.zeros((2, 2)),) * 2 + (0.0,)
        tau = M @ ref[2] + C @ ref[1] + G + gain * e2 - z["controller.w"]
        grows = gain * p["controller.alpha"] * e2 + p["controller.beta"] * sat(e2 / p["controller.phi"], kind)
        return tau, {"controller.w": -grows}

    return law


@pytest.mark.parametrize("model", [None, ARM], ids=["alone", "feedforward"])
@pytest.mark.parametrize("kind", ["clip", "tanh"])
def test_the_loop_is_the_one_written_by_hand(kind, model):
    rates = closed_loop(rise(kind, model is not None))
    ode = loop(saturation=kind, model=model).ode()
    assert worst_difference(ode, rates, np.random.default_rng(62)) < 1e-12  # rounding


@pytest.mark.heavy
def test_the_motion_is_that_of_another_integrator():
    ode = loop(saturation="tanh", phi=1.0).ode()
    ours = simulate(rk4(ode, 1e-4), until=0.5, every=0.5).x[0, -1]
    # RK4 at 0.1 ms on modes of about 60 1/s: (h lambda)^4 is 1e-9, and the error a fraction of it
    np.testing.assert_allclose(ours, integrate(ode, closed_loop(rise("tanh", True)), 0.5), rtol=0, atol=1e-9)


def test_from_the_start_of_the_authors_the_torque_begins_with_the_feedforward():
    ode = loop().ode()
    y = ode.outputs_at(0.0, ode.states.default)
    begun = loop(w=-(np.array(LAW["ks"]) + 1) * y["s"]).ode()
    _, C, G = matrices(
        begun.parameters.unpack(begun.parameters.default), "plant.arm", np.zeros(2), np.array([2.0, 1.5])
    )
    feedforward = C @ np.array([2.0, 1.5]) + G  # at q_ref = 0, where qdd_ref = 0
    np.testing.assert_allclose(begun.outputs_at(0.0, begun.states.default)["tau"], feedforward, atol=1e-12)


@pytest.mark.parametrize(("beta", "ends"), [(12.0, True), (1.7, True), (1.2, False), (0.0, False)])
def test_the_sign_takes_the_error_to_zero_once_beta_exceeds_the_slope_of_the_disturbance(beta, ends):
    """Without a layer, under a D that keeps moving, with slopes of 1.5 and 1.6 N m/s; the model leaves nothing else.

    The theorem asks for more, D'' / alpha besides; no smaller beta than the slope can hold s at zero. What is left
    beyond is the step's: 0.1 ms beta of w from step to step.
    """
    run = simulate(rk4(loop(saturation="sign", beta=beta).ode(), 1e-4), until=8.0, every=1e-2)
    late = np.abs(run["e"][0, run.t > 6.0]).max(axis=0)
    assert (late < 1e-6).all() if ends else (late > 1e-4).all()


@pytest.mark.parametrize(("share", "rests"), [(0.7, False), (1.5, True)])
def test_below_the_gain_of_the_describing_function_a_limit_cycle_stays(share, rests):
    """A pendulum of 1 kg m^2 hanging still: the sign comes to rest where ks + 1 > Lambda M, and not below."""
    pendulum = PlanarArm((PointMass(1.0, 1.0),), 9.81)
    law = Rise([6.0], [1.0], [share * 6.0 - 1], [5.0], 1.0, saturation="sign")
    closed = ClosedLoop(Manipulator(pendulum, q=[0.3]), ArmFullState(1), law, Constant("q", "rad", [0.0]))
    late = np.abs(simulate(rk4(closed.ode(), 1e-4), until=30.0, every=1e-2)["e"][0, -500:]).max()
    assert late < 1e-5 if rests else late > 1e-3


def test_the_layer_leaves_what_its_slope_and_the_integral_balance():
    """Quasi-statically s is w' over (ks + 1) alpha + beta / phi, and w the same unknown torque whatever phi is."""
    late = [
        np.abs(simulate(rk4(loop(phi=phi).ode(), 2e-4), until=6.0, every=1e-2)["e"][0, -200:]).max(axis=0)
        for phi in (0.2, 0.02)
    ]
    slopes = [(np.array([61.0, 26.0]) * [4.0, 3.0] + np.array([12.0, 9.0]) / phi) for phi in (0.2, 0.02)]
    np.testing.assert_allclose(late[0] / late[1], slopes[1] / slopes[0], rtol=0.25)  # D moves, and the joints push


def test_no_run_breaks_what_it_promises():
    kept = loop()
    box = {"plant.q": (-2.0, 2.0), "plant.qd": (-2.0, 2.0)}
    assert RunSearch(kept.ode(), claims_of(kept)[-1], box, 0.5, 5e-4).search(1, Budget(16, 3, 0)).kind == "not refuted"


def test_a_model_of_another_arm_is_refused():
    with pytest.raises(ValueError, match="a model of 3 joints and 2 numbers"):
        Rise(**(LAW | {"model": robot("planar-3r")}))
