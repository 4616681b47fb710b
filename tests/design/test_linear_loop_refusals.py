"""What a linear loop cannot answer is refused in one sentence, or said by name."""

import control
import numpy as np
import pytest

import workbench as wb
from workbench.design.linear_loop import linear_loop
from workbench.design.matrices import DesignError

MOTOR = wb.DCMotor()
LAW = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0)
STEP = wb.Step("omega", "rad/s", 1.0)
LOOP = wb.ClosedLoop(MOTOR, controller=LAW, reference=STEP)
LINEAR, COMPUTER = linear_loop(LOOP), linear_loop(wb.DigitalLoop(LOOP, 0.01))


@wb.block
class Pendulum(wb.Plant):
    """q'' = - w^2 sin q + u."""

    w: float = wb.parameter(default=3.0, unit="rad/s")
    q: float = wb.initial(default=0.1, unit="rad")
    qd: float = wb.initial(default=0.0, unit="rad/s")
    inputs, outputs = wb.layout(u="rad/s^2"), wb.layout(q="rad", qd="rad/s")

    def rate(self, t, x, u):
        return {"q": x.qd, "qd": u.u - self.w**2 * np.sin(x.q)}


@wb.block
class Push(wb.Controller):
    """u = a + k |q| - d qd."""

    a: float = wb.parameter(default=0.0, unit="rad/s^2")
    k: float = wb.parameter(default=0.0, unit="1/s^2")
    d: float = wb.parameter(default=1.0, unit="1/s")
    reads, drives = wb.layout(q="rad", qd="rad/s"), wb.layout(u="rad/s^2")

    def command(self, t, z, est, ref):
        return {"u": self.a + self.k * abs(est.q) - self.d * est.qd}

    def signals(self, z, est, ref):
        return {"size": abs(est.q)}


@wb.block
class Swing(wb.Reference):
    """q_ref = a sin t."""

    a: float = wb.parameter(default=0.1, unit="rad")
    gives = wb.layout(q="rad")

    def at(self, t):
        return {"q": self.a * np.sin(t)}


def pushed(**numbers):
    return wb.ClosedLoop(Pendulum(), controller=Push(**numbers))


DISCRETE_PLANT = control.ss(0.9, 0.1, 1.0, 0.0, 0.1, inputs=["u"], outputs=["w"], states=["a"])
DISCRETE_LAW = control.ss([], [], [], -0.5, 0.1, inputs=["w"], outputs=["u"])
DISCRETE = wb.ClosedLoop(DISCRETE_PLANT, controller=DISCRETE_LAW)
DIFFERENTIATOR = control.tf([1, 0, 0], [1, 1])

REFUSALS = [
    (lambda: linear_loop(DISCRETE), ValueError, "`LinearPlant` moves in discrete time.*where both are discrete"),
    (lambda: linear_loop(wb.DigitalLoop(DISCRETE, 0.1)), ValueError, r"moves in discrete time.*P \* C"),
    (lambda: LINEAR.step_info(), ValueError, r"inputs=...\).*must name one number.*take one of omega_ref"),
    (lambda: LINEAR.step_info("v_load"), ValueError, r"outputs=...\).*must name one number"),
    (lambda: LINEAR.bandwidth("L"), DesignError, "has an integrator"),
    (lambda: LINEAR.bandwidth("U"), ValueError, "one of 'L', 'S', 'T', 'closed', 'open'"),
    (lambda: linear_loop(LOOP, delays={"v": 0.1}).bandwidth(), DesignError, "infinitely many"),
    (lambda: linear_loop(pushed()).step_info("u_load", "size"), DesignError, "'size' has a corner"),
    (lambda: wb.bode(control.tf([1], [1, 1]), [1.0, np.inf]), ValueError, "must be finite frequencies"),
    (lambda: wb.bode(control.tf([1], [1, 1]), []), ValueError, "at least one frequency"),
    (lambda: wb.bode(control.tf([1], [1, 0.5], 0.1), [40.0]), ValueError, "Nyquist's frequency pi / h = 31.4159"),
    (lambda: wb.bode(control.tf([1], [1, np.nan])), ValueError, r"`bode\(system\)` must have finite numbers"),
    (lambda: wb.step_response(DIFFERENTIATOR), ValueError, "must be proper; the numerator of 'sys.*' has degree 2"),
    (lambda: wb.nyquist(DIFFERENTIATOR), ValueError, "must be proper"),
    (lambda: linear_loop(3), ValueError, "must be a `ClosedLoop`, a `DigitalLoop`"),
    (lambda: linear_loop(LOOP, "omgea"), LookupError, "must name a port.*'omgea' is none of v, omega.*'omega'"),
    (lambda: linear_loop(LOOP, delays={"w": 1.0}), LookupError, "must name a port"),
    (lambda: linear_loop(LOOP, delays={"v": -1.0}), ValueError, "at least 0"),
    (lambda: linear_loop(wb.DigitalLoop(LOOP, 0.01), delays={"v": 0.1}), ValueError, r"`DigitalLoop\(delay=...\)`"),
    (lambda: linear_loop(LOOP, values={"plant.JJ": 1.0}), LookupError, "no 'plant.JJ'"),
    (lambda: linear_loop(LOOP, values={"plant.J": -1.0}), ValueError, "plant.J"),
    (lambda: linear_loop(LOOP, values={"plant.J": [0.01, 0.02]}), ValueError, r"take `linear_loop\(...\).rows"),
    (lambda: linear_loop(LOOP, freeze=("plant.w",)), LookupError, "plant.w"),
    (lambda: linear_loop(LOOP.ode()), ValueError, "at least one input"),
    (lambda: linear_loop(LOOP.ode(inputs=True), "v"), ValueError, "knows its ports"),
    (lambda: linear_loop(wb.DigitalLoop(LOOP, 0.01), t=0.004), ValueError, "multiple of the period"),
    (lambda: linear_loop(pushed(a=10.0)), DesignError, "Newton's method found none: 'plant"),
    (lambda: linear_loop(pushed(k=1.0)), ValueError, "corner"),
    (lambda: LINEAR.response([]), ValueError, "at least one frequency.*empty range"),
    (lambda: LINEAR.response([2.0, 1.0]), ValueError, "must rise.*falls, from 2 to 1"),
    (lambda: LINEAR.response([-1.0, 1.0]), ValueError, "from zero on; got -1"),
    (lambda: LINEAR.response([1.0, np.nan]), ValueError, "finite"),
    (lambda: LINEAR.response([0.0, 1.0]), DesignError, "pole at 0 rad/s"),
    (lambda: COMPUTER.response([1.0, 400.0]), ValueError, "Nyquist's frequency pi / h = 314.159 rad/s"),
    (lambda: LINEAR.response([1.0], "H"), ValueError, "one of 'L', 'S', 'T', 'closed', 'open'"),
    (lambda: LINEAR.response([1.0], "closed", "omega"), LookupError, "no 'omega' among the 3 inputs"),
    (lambda: LINEAR.response([1.0], "closed", None, "speed"), LookupError, "no 'speed'"),
    (lambda: LINEAR.response([1.0], "closed")["omega", "v"], LookupError, "no 'v'"),
    (lambda: linear_loop(LOOP, delays={"v": 0.1}).poles, DesignError, "infinitely many"),
    (lambda: linear_loop(LOOP, delays={"v": 0.1}).system("S"), DesignError, "infinitely many"),
    (lambda: linear_loop(LOOP, "omega", delays={"v": 0.1}).margins(), ValueError, "without delays elsewhere"),
    (lambda: LINEAR.rows({"plant.J": np.full(3, np.nan)}), ValueError, "plant.J"),
    (lambda: LINEAR.rows({"plant.J": [1.0, 2.0], "plant.b": [1.0, 2.0, 3.0]}), ValueError, "one number of runs"),
    (lambda: linear_loop(pushed()).response([1.0], "closed", None, "size"), DesignError, "'size' has a corner"),
]


@pytest.mark.parametrize(("call", "kind", "words"), REFUSALS)
def test_bad_input_is_refused_in_one_sentence(call, kind, words):
    with pytest.raises(kind, match=words) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_a_reference_that_moves_is_named_as_the_reason_why_a_loop_does_not_rest():
    law = wb.PID(wb.layout(q="rad"), Pendulum.inputs, Kp=5.0, Kd=1.0)
    moving = wb.ClosedLoop(Pendulum(), controller=law, reference=Swing())
    still = linear_loop(wb.ClosedLoop(Pendulum(), controller=law, reference=Swing(a=0.0)))
    assert still.point.at_rest
    np.testing.assert_allclose(still.x0, 0, atol=1e-12)
    with pytest.raises(DesignError, match="moves in time"):
        linear_loop(wb.DigitalLoop(moving, 0.01))
    with pytest.raises(DesignError, match="moves in time"):
        linear_loop(moving)
    assert "frozen" in " ".join(linear_loop(pushed(a=0.5), at_rest=False).remarks)


def test_an_improper_system_is_refused_where_it_becomes_a_block():
    with pytest.raises(ValueError, match="proper"):
        wb.ClosedLoop(control.tf([1, 0, 0], [1, 1], inputs="v", outputs="omega"), controller=LAW, reference=STEP)


def test_a_side_of_a_corner_gives_the_loop_of_that_side():
    for sign, name in ((1, "above"), (-1, "below")):
        linear = linear_loop(pushed(k=1.0), side=name)
        assert linear.response([0.0]).values[0, 0, 0] == pytest.approx(-sign / 9.0, rel=1e-9)  # -k sign / w^2


def test_modes_that_the_cut_does_not_see_and_poles_on_the_axis_are_named():
    linear = linear_loop(LOOP)
    (hidden,) = linear.remarks
    assert hidden == (
        "The loop gain at the cut does not show the mode -100 1/s of controller.filter, which cannot be observed there."
    )
    free = linear_loop(wb.ClosedLoop(Pendulum(), controller=Push(d=0.0)))
    assert not free.stable
    assert any("imaginary axis" in remark and "plant.q" in remark for remark in free.remarks)
    with pytest.raises(DesignError, match="asymptotically stable"):
        _ = free.disk_margin
    pulled = linear_loop(wb.ClosedLoop(Pendulum(), controller=Push(d=-1.0)))
    assert any("not stable" in remark for remark in pulled.remarks)
    assert pulled.margins()["u"].margins is None
    with pytest.raises(DesignError, match="ask `stable` first"):
        _ = pulled.margins()["u"].phase_margin
    assert np.isinf(free.hinf_norm("closed", "u_load", "q").gain.value)
