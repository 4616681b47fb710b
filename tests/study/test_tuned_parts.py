"""Tunings of a cascade, of the gains of an observer, and of a saturated loop, against grids and runs."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from workbench.design.structured_tuning import LoopGoal

FREQUENCIES = np.geomspace(0.3, 1e3, 300)


def peak(rows, source, target):
    """The largest gain on the grid of frequencies of each row (N,)."""
    return np.abs(rows.response(FREQUENCIES, "closed", source, target).values).max(axis=(1, 2, 3))


def test_both_laws_of_a_cascade_are_tuned_for_the_least_noise():
    motor = wb.DCMotor.position()
    gain = wb.steady_kalman(wb.open_loop(motor), Q=np.eye(3), R=[[1e-4]]).K
    outer = wb.PID(wb.layout(theta="rad"), wb.layout(omega="rad/s"), Kp=5.0, Ki=1.0)
    inner = wb.PID(wb.layout(omega="rad/s"), motor.inputs, Kp=0.05, Ki=0.5)
    loop = wb.ClosedLoop(
        motor,
        observer=wb.LinearObserver(motor, gain),
        controller=wb.Cascade(outer=outer, inner=inner),
        reference=wb.Step("theta", "rad", 1.0),
    )
    paths = ("controller.outer.Kp", "controller.inner.Kp")
    knobs = (wb.Knob("outer", paths[0], 1.0, 100.0, log=True), wb.Knob("inner", paths[1], 0.005, 1.0, log=True))
    noise = LoopGoal("gain", inputs=("theta_noise",), outputs=("v",))
    tuned = wb.tune(loop, knobs, wb.Specification(Ms=1.08), (noise,), starts=1)
    assert tuned.holds
    assert tuned.active_goals[0] == "Ms <= 1.08"
    # an exhaustive search, through linear loops that share no code with the search
    Kp, own = (one.ravel() for one in np.meshgrid(np.geomspace(1.0, 4.0, 9), np.geomspace(0.05, 1.0, 9)))
    rows = wb.linear_loop(loop).rows({paths[0]: Kp[:, np.newaxis], paths[1]: own[:, np.newaxis]})
    noises, reached = peak(rows, "theta_noise", "v"), tuned.goals[1].value.value
    better = rows.stable & (noises < reached * (1 - 1e-3))
    assert 1 < better.sum() < len(Kp)
    for i in np.flatnonzero(better & (rows.margins.Ms[:, 0] <= 1.08)):  # by a grid of frequencies, so at most too small
        exact = wb.linear_loop(loop, values={paths[0]: np.array([Kp[i]]), paths[1]: np.array([own[i]])})
        assert exact.margins()["v"].Ms.gain.low > 1.08
    assert tuned.loop.controller.inner.Kp[0] == pytest.approx(tuned.values["inner"], rel=1e-12)


def test_both_gains_of_an_observer_are_tuned_for_noise_and_load():
    motor = wb.DCMotor()
    gain = wb.steady_kalman(wb.open_loop(motor), Q=np.eye(2), R=[[1e-2]]).K
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(
        motor, observer=wb.LinearObserver(motor, gain), controller=law, reference=wb.Step("omega", "rad/s", 1.0)
    )
    knobs = tuple(
        wb.Knob(name, f"observer.L[{k},0]", 0.1, 1000.0, log=True) for k, name in enumerate(("speed", "current"))
    )
    load = LoopGoal("gain", inputs=("v_load",), outputs=("omega",), limit=0.05)
    tuned = wb.tune(loop, knobs, None, (LoopGoal("noise_gain"), load), starts=1)
    assert tuned.holds
    assert tuned.at_edge == ()
    first, second = (one.ravel() for one in np.meshgrid(np.geomspace(0.1, 1.0, 15), np.geomspace(15.0, 25.0, 25)))
    gains = np.stack([first, second], axis=1).reshape(len(first), *np.shape(gain))
    rows = wb.linear_loop(loop).rows({"observer.L": gains})
    kept = rows.stable & (peak(rows, "v_load", "omega") <= 0.05)
    found = peak(rows, "omega_noise", "v")[kept].min()
    assert tuned.goals[0].value.value <= found * (1 + 1e-3)
    assert tuned.goals[0].value.value == pytest.approx(found, rel=0.05)
    np.testing.assert_allclose(tuned.loop.observer.L.ravel(), [tuned.values["speed"], tuned.values["current"]])


def run_of_ki(motor, Ki, most):
    """The speed loop with a voltage within +-most."""
    law = wb.PID(motor.outputs, motor.inputs, Kp=40.0, Ki=Ki, low=-most, high=most, anti_windup="clamping")
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))


def test_a_goal_of_a_run_is_that_of_the_saturated_loop():
    motor, most = wb.DCMotor(), 12.0
    knob = wb.Knob("Ki", "controller.Ki", 20.0, 800.0, log=True)
    follow = wb.loop_tuning.RunGoal(wb.rmse(), until=2.0, h=5e-3)
    tuned = wb.tune(run_of_ki(motor, 100.0, most), (knob,), wb.Specification(Ms=2.5), (follow,), starts=1)
    assert tuned.holds
    assert tuned.at_edge == ()

    def rmse(Ki):  # by runs of their own, whose step is chosen
        run = wb.simulate(run_of_ki(motor, Ki, most), until=2.0, every=5e-3, tolerance=1e-4)
        return np.sqrt(np.mean((run["omega"][0, :, 0] - 1.0) ** 2))

    best = rmse(tuned.values["Ki"])
    assert best == pytest.approx(tuned.goals[1].estimate, rel=2e-2)
    for Ki in (100.0, 150.0, 300.0, 500.0):
        assert best < rmse(Ki)
    # at 75 V s/rad per s the loop without limits is at its best, and the saturated one is not
    assert tuned.values["Ki"] > 150
