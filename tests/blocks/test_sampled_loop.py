"""A loop that a computer closes, against loops written by hand, exact discretisation, and continuous time."""

import numpy as np
import pytest

from tests.support.arms import arm_instruments
from tests.support.marches import marched
from tests.support.oracles import (
    disturbance,
    flat,
    full_state,
    luenberger,
    matrices,
    nonlinear_disturbance_observer,
    pid,
    sliding_mode,
    super_twisting,
    wanted,
    with_disturbance,
)
from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.laws import ArmPID, SlidingMode, SuperTwisting
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import (
    ArmFullState,
    Luenberger,
    NonlinearDisturbanceObserver,
    OracleFilter,
    StateAndDisturbanceObserver,
)
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines, SineTorque
from workbench.core import Layout, block, rk4
from workbench.engine import simulate

ARM = paper_arm()
GAINS = {"Kp": [60.0, 40.0], "Ki": [20.0, 10.0], "Kd": [10.0, 8.0]}
SURFACE = {"model": ARM, "Lambda": [6.0, 5.0]}
COPY = {"model": ARM, "L1": 40 * np.eye(2), "L2": 300 * np.eye(2), "q_hat": [0.5, -0.7]}
ROUGH = {"noise_q": [1e-3, 2e-3], "noise_qd": [1e-2, 2e-2], "quantum_q": [2e-3, 0.0], "quantum_qd": [0.0, 5e-3]}


def loop(controller=None, observer=None):
    return ClosedLoop(
        plant=Manipulator(
            ARM, q=[0.6, -0.8], qd=[0.1, -0.2], disturbance=SineTorque([0.5, 0.4], [3.0, 4.0], [0.1, 1.5])
        ),
        observer=observer or ArmFullState(2),
        controller=controller or ArmPID(**GAINS),
        reference=Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]),
    )


def by_hand(loop, law, observer, period, substeps, noise, limit=np.inf, delay=False):
    """The states of the plant, of observer and law, and the torque held, instant by instant: plain NumPy."""
    p, z = loop.parameters.unpack(loop.parameters.default), loop.states.unpack(loop.states.default)
    waiting, rows = np.zeros(2), []

    def rate(t, x, tau):
        M, C, G = matrices(p, "plant.arm", x[:2], x[2:])
        return np.concatenate([x[2:], np.linalg.inv(M) @ (tau - C @ x[2:] - G - disturbance(t, p))])

    def read(x, w, name):
        sensor = f"instruments.sensors[{('q', 'qd').index(name)}]"
        x, b = x + p[f"{sensor}.noise"] * w, p[f"{sensor}.quantum"]
        return np.array([xi if bi == 0 else np.floor(xi / bi + 0.5) * bi for xi, bi in zip(x, b, strict=True)])

    for k, w in enumerate(noise):
        t = k * period
        q, qd = read(z["plant.q"], w[:2], "q"), read(z["plant.qd"], w[2:], "qd")
        (q_hat, qd_hat, d_hat), observer_rates = observer(p, z, q, qd, disturbance(t, p))
        tau, law_rates = law(p, z, q_hat, qd_hat, d_hat, wanted(t, p))
        tau = np.clip(tau, -limit, limit)
        tau, waiting = (waiting, tau) if delay else (tau, waiting)
        for name, slope in (observer_rates(tau) | law_rates).items():
            z[name] = z[name] + period * slope
        x, h = np.concatenate([z["plant.q"], z["plant.qd"]]), period / substeps
        for i in range(substeps):
            ti = t + i * h
            k1 = rate(ti, x, tau)
            k2 = rate(ti + h / 2, x + h / 2 * k1, tau)
            k3 = rate(ti + h / 2, x + h / 2 * k2, tau)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(ti + h, x + h * k3, tau))
        z["plant.q"], z["plant.qd"] = x[:2], x[2:]
        z |= {"hold.tau": tau, "hold.q_hat": q_hat, "hold.qd_hat": qd_hat, "hold.d_hat": d_hat}
        z |= {"hold.next": waiting} if delay else {}
        rows.append({**z})
    return rows


LAWS = [
    (ArmPID(**GAINS), ArmFullState(2), pid(), full_state),
    (SlidingMode(**SURFACE, K=[4.0, 3.0], phi=0.1), Luenberger(**COPY), sliding_mode(), luenberger),
    (
        SuperTwisting(**SURFACE, k1=[8.0, 9.0], k2=[20.0, 25.0], phi=0.1),
        StateAndDisturbanceObserver(Luenberger(**COPY), NonlinearDisturbanceObserver(ARM, 5.0)),
        super_twisting(),
        with_disturbance(nonlinear_disturbance_observer, "luenberger"),
    ),
]


@pytest.mark.parametrize(("controller", "observer", "law", "watcher"), LAWS)
@pytest.mark.parametrize(("delay", "limit"), [(False, None), (True, 30.0)])
def test_the_loop_is_the_one_written_by_hand(controller, observer, law, watcher, delay, limit):
    """With noise, quantisation, limits and delay, from numbers that this test draws."""
    digital = loop(controller, observer).digital(5e-3, arm_instruments(2, limit=limit, **ROUGH), delay=delay)
    noise = np.random.default_rng(5).standard_normal((60, 4))
    theirs = by_hand(digital, law, watcher, 5e-3, 3, noise, limit or np.inf, delay)
    ours = marched(digital.step(3), noise)
    names = [name for name in digital.states.names if name != "hold.s"]
    for x, z in zip(ours, theirs, strict=True):
        parts = digital.states.unpack(x)
        # rounding, which the loop's gains raise by a few hundred; no reading is that near to the edge of a quantum
        np.testing.assert_allclose(flat(parts, names), flat(z, names), rtol=0, atol=1e-10)


def test_with_a_short_period_the_loop_comes_near_to_that_in_continuous_time_at_first_order():
    law = SlidingMode(**SURFACE, K=[4.0, 3.0], phi=0.5, saturation="tanh")
    limit = simulate(rk4(loop(law).ode(), 1e-3), until=1.0, every=1.0)
    periods, errors = np.array([4e-3, 2e-3, 1e-3]), []
    for period in periods:
        run = simulate(loop(law).digital(period).step(2), until=1.0, every=1.0)
        errors.append(np.abs(run["plant.q"] - limit["plant.q"])[0, -1].max())
    assert np.polyfit(np.log(periods), np.log(errors), 1)[0] == pytest.approx(1, abs=0.1)


@block
class Clockwork(AbstractArmController):
    """tau = q_ref(t), whatever the arm does."""

    joints: int = 2
    extra: str = ""

    @property
    def dof(self):
        return self.joints

    @property
    def memory(self):
        return Layout()

    def torque(self, t, z, est, ref):
        return ref.q

    def rate(self, t, z, est, ref):
        return {}

    def signals(self, z, est, ref):
        return {self.extra: 0 * est.q} if self.extra else {}


@pytest.mark.parametrize("delay", [False, True])
def test_a_delay_holds_each_torque_back_by_one_period(delay):
    run = simulate(loop(Clockwork()).digital(0.02, delay=delay).step(2), until=0.4)
    t = run.t[:, np.newaxis]
    prompt = np.array([1.0, 0.5]) * np.sin(np.array([2.0, 3.0]) * t)
    theirs = np.vstack([np.zeros((1, 2)), prompt[:-1]]) if delay else prompt
    np.testing.assert_allclose(run["tau"][0], theirs, rtol=1e-13, atol=1e-15)  # rounding of t


def test_the_outputs_are_those_that_hold_from_the_instant_on():
    step = loop().digital(0.01, arm_instruments(2, noise_q=1e-3)).step(2)
    x, w = step.states.default, np.array([1.0, -2.0, 0.0, 0.0])
    y = step.outputs.unpack(np.array(step.y(7, x, step.parameters.default, w)).ravel())
    after = step.states.unpack(np.array(step.F(7, x, step.parameters.default, w)).ravel())
    np.testing.assert_array_equal(y["tau"], after["hold.tau"])
    np.testing.assert_allclose(y["q_error"], [-1e-3, 2e-3], rtol=1e-12)  # true minus estimated
    np.testing.assert_array_equal(y["q"], [0.6, -0.8])  # the arm itself knows of no noise
    np.testing.assert_allclose(y["q_ref"], [np.sin(0.14), 0.5 * np.sin(0.21)], rtol=1e-14)


def test_noise_moves_the_torque_by_its_gains_and_nothing_else_at_once():
    step = loop().digital(0.01, arm_instruments(2, noise_q=1e-3, noise_qd=2e-2)).step()
    p, x, w = step.parameters.default, step.states.default, np.array([0.3, -1.2, 0.7, 2.0])
    quiet, noisy = (step.outputs.unpack(np.array(step.y(0, x, p, v)).ravel()) for v in (0 * w, w))
    kick = -(np.array(GAINS["Kp"]) * 1e-3 * w[:2] + np.array(GAINS["Kd"]) * 2e-2 * w[2:])
    np.testing.assert_allclose(noisy["tau"] - quiet["tau"], kick, rtol=1e-10)  # rounding of torques of 50 N m
    for name in ("q", "qd", "e", "ed", "q_ref", "d"):
        np.testing.assert_array_equal(noisy[name], quiet[name])


def test_the_torque_stays_within_its_limit_and_reaches_it():
    step = loop().digital(5e-3, arm_instruments(2, limit=[20.0, 6.0], **ROUGH)).step()
    tau = marched(step, np.random.default_rng(6).standard_normal((200, 4)))[:, step.states.slice("hold.tau")]
    np.testing.assert_array_equal(np.abs(tau).max(axis=0), [20.0, 6.0])


def test_names_and_outputs_are_those_of_the_loop_in_continuous_time():
    law = SlidingMode(**SURFACE, K=[4.0, 3.0], phi=0.1)
    ode, digital = loop(law).ode(), loop(law).digital(1e-3, arm_instruments(2, limit=1.0), delay=True)
    assert digital.outputs.names == ode.outputs.names
    assert [entry.unit for entry in digital.outputs.entries] == [entry.unit for entry in ode.outputs.entries]
    assert digital.parameters.names[: len(ode.parameters.names)] == ode.parameters.names
    assert [name for name in digital.parameters.names[len(ode.parameters.names) :] if "instruments." not in name] == []
    assert "hold.next" in digital.states
    assert digital.states["hold.q_hat"].unit == "rad"
    assert loop(law).digital(1e-3).step().noises == 0
    assert digital.step().noises == 4


def test_an_observer_that_uses_the_truth_is_told_of_in_a_sampled_loop_too():
    honest, oracle = loop(), loop(observer=StateAndDisturbanceObserver(ArmFullState(2), OracleFilter(2, 50.0)))
    assert honest.digital(1e-3).notes == ()
    assert any("the true signal d" in note for note in oracle.digital(1e-3).notes)


# What is refused


@pytest.mark.parametrize("period", [0.0, -1e-3, np.nan, np.inf])
def test_a_period_that_is_no_positive_number_is_refused(period):
    with pytest.raises(ValueError, match=r"`ClosedLoop.digital\(period=...\)` must be a positive, finite number"):
        loop().digital(period).step(2)


@pytest.mark.parametrize("period", [None, "1 ms", True, [1e-3]])
def test_a_period_that_is_no_number_is_refused(period):
    with pytest.raises(
        ValueError,
        match=r"`ClosedLoop.digital\(period=...\)` must be a .*number.*; got",
    ):
        loop().digital(period)


@pytest.mark.parametrize("substeps", [0, -1, 1.5, 2.0, True, None, "2"])
def test_substeps_that_are_no_positive_whole_number_are_refused(substeps):
    with pytest.raises(ValueError, match=r"substeps=...\)` must be a whole number.*; got "):
        loop().digital(1e-3).step(substeps)


def test_instruments_for_other_joints_are_refused():
    with pytest.raises(
        ValueError, match=r"`Instruments` reads 'q' as 3 numbers, where `Manipulator` gives it as 2 numbers"
    ):
        loop().digital(1e-3, arm_instruments(3))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            {"instruments": "x"},
            r"`ClosedLoop.digital\(instruments=...\)` must be an `AbstractInstruments` or None; got 'x'\.",
        ),
        ({"delay": "no"}, r"`ClosedLoop.digital\(delay=...\)` must be True or False or a number.*; got 'no'\."),
    ],
)
def test_arguments_of_another_kind_are_refused(options, words):
    with pytest.raises(ValueError, match=words):
        loop().digital(1e-3, **options)


@pytest.mark.parametrize("name", ["tau", "e", "tau_applied", "q_hat", "qd_hat", "d_hat", "next", "d_error"])
def test_a_signal_of_a_law_takes_no_name_that_is_the_loops_own(name):
    """It would take the place of the loop's quantity: 'tau' would drive the arm, and a score be of 'e'."""
    odd, words = (
        loop(Clockwork(extra=name)),
        rf"`Clockwork.signals\(...\)` must not use the name '{name}', which is the",
    )
    with pytest.raises(ValueError, match=words):
        odd.ode()
    with pytest.raises(ValueError, match=words):
        odd.digital(1e-3, delay=True).step()
    assert "mine" in loop(Clockwork(extra="mine")).digital(1e-3).outputs
