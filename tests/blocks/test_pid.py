"""PID: python-control's closed loop, the textbook's recursion, windup in closed form, units, and each refusal."""

import casadi as ca
import control
import numpy as np
import pytest
from scipy.linalg import expm

import workbench as wb
from tests.support.plain_plants import SPEED, VOLTAGE, Counter, Motor
from workbench.blocks.laws import PID
from workbench.blocks.loop import AbstractPlant, ClosedLoop
from workbench.blocks.plants import QuadrupleTank
from workbench.blocks.signals import Step
from workbench.core import Layout, Signals, block, initial, layout, lift, rk4
from workbench.engine import simulate

GAINS = {"Kp": 20.0, "Ki": 40.0, "Kd": 0.5, "N": 50.0, "b": 0.7, "c": 0.2}
LAW = PID(SPEED, VOLTAGE, **GAINS)
UP = Step("omega", "rad/s", 1.0)


@block
class Tank(AbstractPlant):
    """An integrator, x' = u."""

    x: float = initial(0.0, unit="m")
    inputs = layout(u="m/s")
    outputs = layout(x="m")

    def rate(self, t, x, u):
        return {"x": u.u}


@block
class Leak(AbstractPlant):
    """An integrator that leaks 0.7 m/s."""

    x: float = initial(0.0, unit="m")
    inputs = layout(u="m/s")
    outputs = layout(x="m")

    def rate(self, t, x, u):
        return {"x": u.u - 0.7}


def tank_loop(**how):
    law = PID(layout(x="m"), layout(u="m/s"), Kp=1.0, Ki=1.0, low=-0.1, high=0.1, **how)
    return ClosedLoop(Tank(), controller=law, reference=Step("x", "m", 1.0))


def test_the_loop_is_that_of_python_control():
    s, m, g = control.tf("s"), Motor(), GAINS
    P = m.K / ((m.J * s + m.b) * (m.L * s + m.R) + m.K**2)
    derivative = g["Kd"] * s / (1 + s / g["N"])
    Cr, Cy = g["Kp"] * g["b"] + g["Ki"] / s + g["c"] * derivative, g["Kp"] + g["Ki"] / s + derivative
    _, y = control.step_response(control.minreal(P * Cr / (1 + P * Cy), verbose=False), np.linspace(0, 2, 201))
    run = simulate(rk4(ClosedLoop(Motor(), controller=LAW, reference=UP).ode(), 1e-3), until=2.0, every=0.01)
    # the fastest mode is N = 50 / s: (50 h)^4 / 120 and a gain of 20
    np.testing.assert_allclose(run["omega"].ravel(), y, rtol=0, atol=1e-8)


def by_hand(h, steps):
    """The algorithm of Astrom and Hagglund, with D_k by its own recursion, and the plant by its matrix exponential."""
    m, g = Motor(), GAINS
    A = np.array([[-m.R / m.L, -m.K / m.L, 1 / m.L], [m.K / m.J, -m.b / m.J, 0], [0, 0, 0]])
    F = expm(A * h)
    x, integral, derivative, last, seen = np.zeros(2), 0.0, 0.0, 0.0, []
    for _ in range(steps):
        y, r = x[1], 1.0
        w = g["c"] * r - y
        derivative = (derivative + g["Kd"] * g["N"] * (w - last)) / (1 + g["N"] * h)
        u = g["Kp"] * (g["b"] * r - y) + integral + derivative
        seen.append([y, u])
        integral, last = integral + g["Ki"] * h * (r - y), w
        x = (F @ [*x, u])[:2]
    return np.array(seen)


@pytest.mark.parametrize("integrator", ["declared", "fine"])
def test_in_a_computer_it_is_the_algorithm_of_the_textbook(integrator):
    h = 0.02
    sampled = ClosedLoop(Motor(), controller=LAW, reference=UP).digital(h, integrator=integrator)
    run = simulate(sampled.step(20), until=2.0)
    seen = np.stack([run["omega"].ravel(), run["v"].ravel()], axis=1)
    # the plant's fastest mode is 10 / s: 20 Runge-Kutta steps a period leave (0.01)^4 / 120
    np.testing.assert_allclose(seen[:-1], by_hand(h, 100), rtol=0, atol=1e-9)
    assert "backward difference of the derivative" in sampled.methods[0]


WHILE_SATURATED = {
    # at a limit of 0.1 the level is 0.1 t and e = 1 - 0.1 t
    "none": ({}, lambda t: t - 0.05 * t**2),
    "clamping": ({}, lambda t: 0 * t),
    # I' = e + (0.1 - e - I) / Tt with Tt = 1
    "back-calculation": ({"Tt": 1.0}, lambda t: 0.1 * (1 - np.exp(-t))),
}


@pytest.mark.parametrize("how", WHILE_SATURATED)
def test_an_integral_at_a_limit_is_that_of_its_closed_form(how):
    options, expected = WHILE_SATURATED[how]
    run = simulate(rk4(tank_loop(anti_windup=how, **options).ode(), 0.01), until=5.0)
    np.testing.assert_allclose(run["u"], 0.1, rtol=0, atol=0)
    np.testing.assert_allclose(run["controller.integral"].ravel(), expected(run.t), rtol=0, atol=1e-10)  # h^4 / 120


def test_anti_windup_takes_the_overshoot_that_windup_makes():
    over = {
        how: simulate(rk4(tank_loop(anti_windup=how, **options).ode(), 0.01), until=40.0)["x"].max() - 1
        for how, (options, _) in WHILE_SATURATED.items()
    }
    assert over["none"] > 0.5
    assert max(over["clamping"], over["back-calculation"]) < 0.1


@pytest.mark.parametrize("how", WHILE_SATURATED)
def test_anti_windup_in_a_computer_is_that_of_the_recursion(how):
    h, x, integral, levels = 0.1, 0.0, 0.0, []
    for _ in range(300):
        v = (1 - x) + integral
        u = min(max(v, -0.1), 0.1)
        winds = (v > 0.1 and x < 1) or (v < -0.1 and x > 1)
        more = {"none": 1 - x, "clamping": 0.0 if winds else 1 - x, "back-calculation": 1 - x + (u - v) / 1.0}[how]
        levels.append(x)
        x, integral = x + h * u, integral + h * more
    run = simulate(tank_loop(anti_windup=how, **WHILE_SATURATED[how][0]).digital(h).step(), until=30.0)
    np.testing.assert_allclose(run["x"].ravel()[:-1], levels, rtol=0, atol=1e-12)  # 300 sums of numbers near 1


def test_a_law_that_takes_over_at_rest_leaves_the_plant_there():
    law = PID(layout(x="m"), layout(u="m/s"), Kp=1.0, Kd=2.0, Ki=1.0, N=50.0, c=0.3, u0=0.7, y0=3.0)
    run = simulate(rk4(ClosedLoop(Leak(x=3.0), controller=law, reference=Step("x", "m", 3.0)).ode(), 0.01), until=5.0)
    np.testing.assert_allclose(run["u"], 0.7, rtol=0, atol=1e-12)
    np.testing.assert_allclose(run["x"], 3.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("y0", "first"), [(3.0, -3.0), (0.0, -3.0 - 2.0 * 50.0 * 3.0)])
def test_the_derivative_counts_from_the_output_where_the_law_takes_over(y0, first):
    law = PID(layout(x="m"), layout(u="m/s"), Kp=1.0, Kd=2.0, N=50.0, c=0.0, y0=y0)
    ode = ClosedLoop(Tank(x=3.0), controller=law, reference=Step("x", "m", 0.0)).ode()
    assert ode.outputs_at(0.0, ode.states.default)["u"] == pytest.approx(first, rel=1e-12)


def test_a_limit_may_be_on_one_side():
    law = PID(layout(x="m"), layout(u="m/s"), Kp=1.0, Ki=1.0, high=0.1)
    run = simulate(rk4(ClosedLoop(Tank(x=3.0), controller=law, reference=Step("x", "m", 1.0)).ode(), 0.01), until=20.0)
    assert run["u"].max() == 0.1
    assert run["u"].min() < -1.9


def test_numbers_of_a_signal_are_governed_one_by_one():
    port, drives = layout(q=("rad, m", [0, 0])), layout(u=("N m, N", [0, 0]))
    rows = {"Kp": (1.0, 2.0), "Ki": (3.0, 4.0), "Kd": (5.0, 6.0), "low": (-1.0, -20.0), "high": (1.0, 20.0)}
    both = PID(port, drives, **{name: list(pair) for name, pair in rows.items()})
    z = both.memory.view(ca.SX([0.1, 0.2, 0.3, 0.4]))
    est, ref = Signals(q=ca.SX([1.0, 2.0])), Signals(q=ca.SX([3.0, 5.0]))
    t = ca.SX.sym("t")
    u, rate = both.command(t, z, est, ref)["u"], both.rate(t, z, est, ref)
    for i in range(2):
        one = PID(layout(q="rad"), layout(u="N m"), **{name: pair[i] for name, pair in rows.items()})
        part = {name: column[i] for name, column in z.items()}
        alone = (Signals(q=est.q[i]), Signals(q=ref.q[i]))
        assert float(one.command(t, part, *alone)["u"]) == float(u[i])
        assert float(one.rate(t, part, *alone)["integral"]) == float(rate["integral"][i])


def test_two_loops_of_a_plant_are_one_law_with_a_gain_for_each():
    """A decentralised pair on four tanks, against two laws that are each asked alone, in both directions of a pair."""
    tanks = QuadrupleTank()
    pumps, levels = tanks.inputs, tanks.outputs
    gains = {"Kp": (3.0, 2.7), "Ki": (0.1, 0.07), "low": (0.0, 0.0), "high": (10.0, 8.0), "u0": (3.0, 3.0)}
    both = PID(levels, pumps, **{name: list(pair) for name, pair in gains.items()})
    z = both.memory.view(ca.SX([0.1, 0.2, 0.3, 0.4]))
    est, ref = ({name: ca.SX(value + i) for i, name in enumerate(levels.names)} for value in (12.0, 13.5))
    t = ca.SX.sym("t")
    u, rate = both.command(t, z, Signals(est), Signals(ref)), both.rate(t, z, Signals(est), Signals(ref))
    for i, (level, pump) in enumerate(zip(levels.entries, pumps.entries, strict=True)):
        one = PID(Layout((level,)), Layout((pump,)), **{name: pair[i] for name, pair in gains.items()})
        part = {name: column[i] for name, column in z.items()}
        alone = Signals({level.name: est[level.name]}), Signals({level.name: ref[level.name]})
        assert float(one.command(t, part, *alone)[pump.name]) == float(u[pump.name])
        assert float(one.rate(t, part, *alone)["integral"]) == float(rate["integral"][i])


def test_its_gains_have_the_units_of_its_ports():
    units = {e.name: e.unit for e in lift(PID(SPEED, VOLTAGE, 1.0, low=-1, high=1)).layout.entries}
    assert [units[name] for name in ("Kp", "Ki", "Kd", "N", "low")] == ["V s/rad", "V/rad", "V s^2/rad", "1/s", "V"]
    law = PID(layout(q=("rad, m", [0, 0])), layout(u=("N m, N", [0, 0])), 1.0)
    assert {e.name: e.units for e in lift(law).layout.entries}["Ki"] == ("N m/(rad s)", "N/(m s)")


def test_its_actions_can_be_left_out():
    parts = LAW.without()
    assert parts.keys() == {"integral action", "derivative action"}
    assert parts["integral action"].Ki == 0
    assert PID(SPEED, VOLTAGE, 1.0).without() == {}


def test_a_law_with_a_period_runs_in_a_computer_alone():
    loop = ClosedLoop(Motor(), controller=LAW.run_every(0.1), reference=UP)
    with pytest.raises(ValueError, match="only a computer runs"):
        loop.ode()
    assert simulate(loop.digital(0.05).step(2), until=1.0)["omega"].max() > 0


def test_it_drives_a_plant_in_discrete_time():
    law = PID(layout(n="V"), VOLTAGE, Kp=0.5)
    run = simulate(ClosedLoop(Counter(), controller=law, reference=Step("n", "V", 1.0)).digital(0.1).step(), until=1.0)
    np.testing.assert_allclose(run["n"].ravel(), 1 - 0.5 ** np.arange(11), rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: PID(), r"`PID\(reads=...\)` must be a layout of signals.*it has none"),
        (lambda: PID(SPEED, layout(a="V", b="V"), 1.0), r"reads 1 \('omega'\) and drives 2 \('a', 'b'\)"),
        (lambda: PID(SPEED, layout(v=("V", [0, 0])), 1.0), r"reads 1 \('omega'\) and drives 2 \('v'\)"),
        (lambda: PID(SPEED, VOLTAGE, 1.0, low=1.0, high=0.0), "must leave room between them"),
        (lambda: PID(SPEED, VOLTAGE, 1.0, anti_windup="back-calculation"), "needs limits and the time Tt"),
        (lambda: PID(SPEED, VOLTAGE, 1.0, high=1.0, anti_windup="back-calculation"), "and Tt = None"),
        (lambda: PID(SPEED, VOLTAGE, 1.0, anti_windup="clamp"), "Did you mean 'clamping'"),
        (lambda: PID(SPEED, VOLTAGE, [1.0, 2.0]), r"`PID\(Kp=...\)` must be an array of shape \(n = 1\)"),
        (lambda: PID(SPEED, VOLTAGE, 1.0, N=0.0), r"`PID\(N=...\)`"),
    ],
)
def test_a_pid_that_cannot_be_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()


def test_a_law_without_integral_and_derivative_is_a_gain_without_states():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=5.0, Ki=None, Kd=None)
    assert law.memory.size == 0
    reference = wb.Constant("omega", "rad/s", 1.0)
    linear, integral = (
        wb.linear_loop(wb.ClosedLoop(motor, reference=reference, controller=one))
        for one in (law, wb.PID(motor.outputs, motor.inputs, Kp=5.0, Kd=None))
    )
    assert linear.stable
    assert not integral.stable  # its integral rests on any value
    assert len(linear.poles) == len(integral.poles) - 1


def test_a_law_without_an_integral_and_with_a_derivative_is_that_of_a_zero_gain():
    motor, reference = wb.DCMotor(), wb.Constant("omega", "rad/s", 1.0)
    runs = [
        wb.simulate(
            wb.rk4(
                wb.ClosedLoop(
                    motor, reference=reference, controller=wb.PID(motor.outputs, motor.inputs, 5.0, Ki, 0.1)
                ).ode(),
                1e-3,
            ),
            until=0.5,
        )
        for Ki in (None, 0.0)
    ]
    np.testing.assert_array_equal(runs[0]["omega"], runs[1]["omega"])


def test_back_calculation_without_an_integral_is_refused():
    with pytest.raises(ValueError, match="needs an integral"):
        wb.PID(wb.layout(y="m"), wb.layout(u="N"), 1.0, None, high=1.0, Tt=1.0, anti_windup="back-calculation")
