"""Any loop, open, cut or closed, continuous or in a computer, as a linear system of python-control."""

import control
import numpy as np
import pytest

from workbench.blocks.loop import (
    AbstractController,
    AbstractPlant,
    AbstractReference,
    ClosedLoop,
    Instruments,
    LinearLaw,
)
from workbench.blocks.loop import LinearPlant as Linear
from workbench.core import block, layout, parameter
from workbench.design.linear import broken_loop, linearize

PERIOD = 0.1
PLANT = control.tf([1, 2], [1, 1, 3], inputs="v", outputs="omega", name="motor")
SAMPLED = control.c2d(PLANT, PERIOD, "zoh")
PI = control.tf([2.0, 3.0], [1.0, 0.0], inputs="omega", outputs="v", name="pi")
TUSTIN = control.c2d(PI, PERIOD, "tustin")
FREQUENCIES = np.array([0.3, 1.0, 5.0, 20.0])
S, Z = 1j * FREQUENCIES, np.exp(1j * FREQUENCIES * PERIOD)
CLOSE = {"rtol": 1e-10, "atol": 1e-12}  # rounding near poles a tenth away


@block
class Level(AbstractReference):
    """A speed that is wanted from the start."""

    level: float = parameter(default=1.0, unit="rad/s")
    gives = layout(omega="rad/s")

    def at(self, t):
        return {"omega": self.level}


def loop(law=PI, plant=PLANT):
    return ClosedLoop(plant, controller=LinearLaw(law, error=True), reference=Level())


def model(equations, t=0.0):
    return linearize(equations, t, np.zeros(equations.states.size))


@pytest.mark.parametrize("at", ["v", "omega"])
def test_a_loop_that_is_cut_at_one_port_has_python_controls_loop_gain(at):
    cut = loop().cut(at=at)
    assert (cut.inputs, cut.outputs.names) == (("drive",), (at,))
    np.testing.assert_allclose(broken_loop(cut, 0.0, np.zeros(3))(S), (PLANT * PI)(S), **CLOSE)


@pytest.mark.parametrize("at", ["v", "omega"])
def test_a_computers_loop_that_is_cut_has_python_controls_discrete_loop_gain(at):
    cut = model(loop(TUSTIN).digital(PERIOD, at=at))
    assert cut.dt == PERIOD
    np.testing.assert_allclose(-cut(Z), (SAMPLED * TUSTIN)(Z), **CLOSE)


def test_a_plant_in_discrete_time_is_cut_at_its_output():
    cut = loop(TUSTIN, SAMPLED).digital(PERIOD, at="omega")
    np.testing.assert_allclose(-model(cut, t=PERIOD)(Z), (SAMPLED * TUSTIN)(Z), **CLOSE)


RESPONSES = [
    ("omega", "omega_ref", lambda P, C: P * C / (1 + P * C)),
    ("omega", "v_load", lambda P, C: P / (1 + P * C)),
    ("v", "omega_noise", lambda P, C: -C / (1 + P * C)),
    ("e_omega", "omega_ref", lambda P, C: -1 / (1 + P * C)),
    ("v_applied", "v_load", lambda P, C: 1 / (1 + P * C)),
]


@pytest.mark.parametrize(("output", "source", "closed"), RESPONSES)
def test_a_closed_loop_has_the_responses_of_the_textbook(output, source, closed):
    ours = model(loop().ode(inputs=True))
    np.testing.assert_allclose(ours[output, source](S), closed(PLANT(S), PI(S)), **CLOSE)


@pytest.mark.parametrize(("output", "source", "closed"), RESPONSES)
def test_a_computers_closed_loop_has_the_responses_of_the_textbook(output, source, closed):
    ours = model(loop(TUSTIN).digital(PERIOD, inputs=True))
    np.testing.assert_allclose(ours[output, source](Z), closed(SAMPLED(Z), TUSTIN(Z)), **CLOSE)


def test_a_delay_of_one_period_is_one_more_in_the_loop_gain():
    cut = model(loop(TUSTIN).digital(PERIOD, delay=True, at="omega"))
    np.testing.assert_allclose(-cut(Z), (SAMPLED * TUSTIN)(Z) / Z, **CLOSE)


def test_several_signals_are_cut_together():
    cut = loop().cut(at=("omega", "v"))
    ours = model(cut)
    np.testing.assert_allclose(ours(S)[0, 1], PLANT(S), **CLOSE)
    np.testing.assert_allclose(ours(S)[1, 0], -PI(S), **CLOSE)


@block
class Pendulum(AbstractPlant):
    """One that a torque drives, about which a period has no linear flow."""

    states = outputs = layout(q="rad", w="rad/s")
    inputs = layout(tau="N m")

    def rate(self, t, x, u):
        from casadi import sin

        return {"q": x.w, "w": -sin(x.q) - 0.1 * x.w + u.tau}


@block
class Damper(AbstractController):
    """A gain on the speed, or its sign."""

    relay: bool = False
    reads = layout(w="rad/s")
    drives = layout(tau="N m")

    def command(self, t, z, est, ref):
        from casadi import sign

        return {"tau": -sign(est.w) if self.relay else -0.4 * est.w}


def test_the_model_of_a_period_is_the_derivative_of_the_step():
    sampled = ClosedLoop(Pendulum(), controller=Damper()).digital(0.05, inputs=True)
    step, x, d = sampled.step(64), np.array([0.7, -0.3, 0.0, 0.0, 0.0]), 1e-5
    x = np.concatenate([x, np.zeros(sampled.states.size - 5)])
    p = sampled.parameters.default
    ours = linearize(sampled, 0.0, x)
    ends = [np.array(step.F(0, x + d * e, p, []) - step.F(0, x - d * e, p, [])) for e in np.eye(len(x))]
    A = np.column_stack(ends) / (2 * d)
    np.testing.assert_allclose(ours.A, A, rtol=0, atol=1e-9)  # central differences: d^2, and rounding over d
    place = sampled.parameters.indices("tau_load")[0]
    more, less = p.copy(), p.copy()
    more[place], less[place] = d, -d
    B = np.array(step.F(0, x, more, []) - step.F(0, x, less, [])) / (2 * d)
    np.testing.assert_allclose(ours.B[:, :1], B, rtol=0, atol=1e-9)


def test_a_period_at_rest_is_told_from_one_that_moves():
    sampled = ClosedLoop(Pendulum(), controller=Damper()).digital(0.05, inputs=True)
    rest = np.zeros(sampled.states.size)
    assert linearize(sampled, 0.0, rest, at_rest=True).dt == 0.05
    with pytest.raises(ValueError, match=r"'plant.[qw]' changes from 1 to"):
        linearize(sampled, 0.0, rest + 1.0, at_rest=True)


def relay(**more):
    return ClosedLoop(Pendulum(), controller=Damper(relay=True)).digital(0.05, inputs=True, **more)


def stairs():
    plant = Pendulum()
    gauges = Instruments.of(plant, quantum={"q": 0.1})
    return ClosedLoop(plant, controller=Damper()).digital(0.05, gauges, inputs=True)


def slow():
    return ClosedLoop(Pendulum(), controller=Damper().run_every(0.1)).digital(0.05, inputs=True)


REFUSED = [
    (lambda: model(relay()), "jumps by 2 as .* at this state"),
    (lambda: model(stairs()), r"reads in steps \(floor\), between which its slope is zero"),
    (lambda: model(slow()), "a block of 'loop' runs every few periods"),
    (lambda: model(loop(TUSTIN, SAMPLED).digital(PERIOD, at="omega")), "from the second instant on"),
    (lambda: model(loop(TUSTIN).digital(PERIOD, at="v"), t=0.03), r"t=...\)` must be a multiple of the period 0.1 s"),
    (lambda: loop(TUSTIN, SAMPLED).digital(PERIOD, at="v"), "`LinearPlant` moves in discrete time. Cut the loop at an"),
    (lambda: loop(TUSTIN, Linear(SAMPLED)).digital(PERIOD, inputs=True), "add signals to the inputs of a plant"),
]


@pytest.mark.parametrize(("make", "message"), REFUSED)
def test_a_period_without_a_linear_model_is_refused_with_the_reason(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_cut_where_no_signal_is_is_refused():
    with pytest.raises(LookupError, match=r"no 'omega_hat' among the 2 inputs and outputs of the plant. Did you mean"):
        loop().cut(at="omega_hat")
    with pytest.raises(ValueError, match=r"`ClosedLoop.cut\(at=...\)` must be a tuple of at least 1 `str`; got none"):
        loop().cut(at=())
