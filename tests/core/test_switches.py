"""Switches that are known before a run are met, whatever the step: no pulse is missed, and each row is by itself."""

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import workbench as wb
from workbench.blocks.signals import SquareWave
from workbench.core import Entry, Layout, Ode, SampledSystem, rk4
from workbench.core.switches import find_switches
from workbench.engine import simulate
from workbench.study.case_runs import run

ENGINES = ("native", "numpy", "casadi")


def lag(force, **numbers):
    """x' = force(t, x, p) - x with the named numbers as parameters."""
    t, x = ca.SX.sym("t"), ca.SX.sym("x")
    parameters = Layout(tuple(Entry(name, np.asarray(float(value))) for name, value in numbers.items()))
    p = parameters.symbols()
    names = dict(zip(numbers, ca.vertsplit(p), strict=True)) if numbers else {}
    state = Layout((Entry("x", np.zeros(())),))
    return Ode("lag", state, parameters, Layout((Entry("y", np.zeros(())),)), t, x, p, force(t, x, **names) - x, x)


def pulse_answer(level, begin, width, until):
    """x(until) of x' = u - x from rest, with u = level from begin for a width."""
    return level * (np.exp(-(until - begin - width)) - np.exp(-(until - begin)))


def pulse(t, x, begin, width, level):
    return ca.if_else(ca.logic_and(t >= begin, t < begin + width), level, 0)


def needs(engine):
    if engine == "native":
        pytest.importorskip("llvmlite")


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("h", [1.0, 0.1, 0.03125])
def test_a_pulse_shorter_than_the_step_cannot_be_missed(engine, h):
    needs(engine)
    ode = lag(pulse, begin=0.0512, width=1e-3, level=10.0)
    end = simulate(rk4(ode, h), until=1.0, engine=engine).x[0, -1, 0]
    # RK4 of x' = -x: what is wrong is the decay of 0.95 s, by less than h^4 / 100 of the value
    assert end == pytest.approx(pulse_answer(10.0, 0.0512, 1e-3, 1.0), rel=max(0.03 * h**4, 1e-9))


def test_a_measure_finds_the_pulses_of_a_disturbance():
    train = wb.PulseTrain("y", "1", level=10.0, period=0.1, width=0.001, time=0.0512)
    ode = lag(lambda t, x: train.at(t)["y"] * 10)
    found = wb.measure(ode, [], until=1.0, tolerance=1e-3)
    pulses = [pulse_answer(100.0, 0.0512 + 0.1 * i, 0.001, 1.0) for i in range(10)]
    assert found.trajectories.x[0, -1, 0] == pytest.approx(sum(pulses), rel=1e-3)


@pytest.mark.parametrize("computer", [False, True])
def test_a_measure_and_a_case_see_pulses_that_the_loop_does_not_follow(computer):
    motor = wb.DCMotor()
    idle = wb.PID(motor.outputs, motor.inputs, Kp=1e-6, Ki=0.0)
    train = wb.PulseTrain("omega", "rad/s", level=10, period=0.1, width=0.001, time=0.0512)
    loop = wb.ClosedLoop(motor, controller=idle, reference=train)
    equation = loop.digital(0.01) if computer else loop.ode()
    truth = 1.0  # the root of 10^2 0.001 s / 0.1 s, as the motor stands
    found = wb.measure(equation, [wb.rmse()], until=10.0, tolerance=1e-3)
    assert found.score("RMSE").value[0] == pytest.approx(truth, rel=1e-6)
    case = wb.Case("pulses", "idle", wb.Run(equation, (wb.rmse(),), until=10.0, tolerance=1e-3))
    [outcome] = run(wb.Study("s", "T", "Q?", "M.", lambda results: [], cases=(case,))).outcomes
    assert outcome.score("RMSE").pair[0] == pytest.approx(truth, rel=1e-6)


@pytest.mark.parametrize("interpolation", ["linear", "hold"])
def test_a_spike_of_a_table_is_met_in_a_plant_that_is_disturbed_by_it(interpolation):
    ends = []
    for begin in np.linspace(0.1, 0.9, 4) + 0.0123:
        times, values = [0.0, begin, begin + 5e-4, begin + 1e-3, 2.0], [0.0, 0.0, 1000.0, 0.0, 0.0]
        table = wb.Table("v", "V", times=np.array(times), values=np.array(values), interpolation=interpolation)
        motor = wb.DisturbedPlant(wb.DCMotor(), by=table)
        runs = simulate(rk4(wb.open_loop(motor), 0.01), until=1.0)
        fine = simulate(rk4(wb.open_loop(motor), 1e-4), until=1.0, every=1.0)
        ends.append(runs["omega"][0, -1] / fine["omega"][0, -1])
    # RK4 at h = 10 ms and the modes of the motor, of 2 and 10 per second, are within 1e-4 of each other
    np.testing.assert_allclose(ends, 1.0, rtol=1e-4)


@pytest.mark.parametrize(
    ("engine", "arithmetic"),
    [("native", "fused"), ("numpy", "fused"), ("numpy", "portable"), ("casadi", "casadi")],
)
def test_the_bits_of_a_row_do_not_depend_on_its_company(engine, arithmetic):
    needs(engine)
    draws = np.random.default_rng(3)
    step = rk4(lag(pulse, begin=0.0, width=0.1, level=1.0), 0.1)
    begins = np.concatenate([[0.0, -1.0, 0.3, 0.30000000000000004], draws.uniform(0, 1, 17)])
    rows = step.parameters.pack({"begin": begins, "width": 10 ** draws.uniform(-6, 0, 21)})
    together = simulate(step, rows, until=1.0, engine=engine, arithmetic=arithmetic).x
    for i in range(len(rows)):
        alone = simulate(step, rows[i : i + 1], until=1.0, engine=engine, arithmetic=arithmetic).x[0]
        np.testing.assert_array_equal(alone, together[i])
    order = draws.permutation(len(rows))
    shuffled = simulate(step, rows[order], until=1.0, engine=engine, arithmetic=arithmetic).x
    np.testing.assert_array_equal(shuffled, together[order])


def test_the_compiled_march_and_numpy_have_the_same_bits_across_switches():
    needs("native")
    draws = np.random.default_rng(4)
    train = wb.PulseTrain("u", "1", level=1.0, period=0.37, width=0.05, time=0.21)
    ode = lag(
        lambda t, x, begin, width, level: pulse(t, x, begin, width, level) * ca.sin(9 * t) + train.at(t)["u"],
        begin=0.1,
        width=0.1,
        level=1.0,
    )
    for step in (rk4(ode, 0.1), SampledSystem(ode, 0.2, ca.SX.sym("k"), ca.SX(0, 1), ca.SX(0, 1)).step(2)):
        rows = step.parameters.pack({"begin": draws.uniform(0, 1, 9)})
        for arithmetic in ("fused", "portable"):
            a, b = (simulate(step, rows, until=2.0, engine=e, arithmetic=arithmetic).x for e in ("native", "numpy"))
            np.testing.assert_array_equal(a, b)
        c = simulate(step, rows, until=2.0, engine="casadi").x
        np.testing.assert_allclose(c, b, atol=1e-13)  # sums of 20 steps of size 1, each rounded otherwise


def test_a_step_across_switches_is_of_fourth_order():
    train = SquareWave("u", "1", [1.0], frequency=1.7)
    ode = lag(lambda t, x: train.at(t)["u"] + x**2 / 4)
    edges = np.arange(0, 3 * 1.7 + 1) / 1.7
    x = 0.0
    for i, (a, b) in enumerate(zip(edges[:-1], np.minimum(edges[1:], 2.0), strict=True)):
        if b > a:
            u = 1.0 - i % 2
            x = solve_ivp(lambda t, y, u=u: u + y**2 / 4 - y, (a, b), [x], rtol=1e-13, atol=1e-15).y[0, -1]
    errors = [abs(simulate(rk4(ode, h), until=2.0).x[0, -1, 0] - x) for h in (0.1, 0.05, 0.025)]
    # the segments of two steps are not halves of one another, so that the order is that of two halvings
    assert np.log2(errors[0] / errors[2]) / 2 > 3.5
    assert errors[2] < 1e-9


def test_the_substeps_of_a_computer_meet_the_disturbance_of_its_plant():
    ode = lag(pulse, begin=0.0512, width=1e-3, level=10.0)
    k = ca.SX.sym("k")
    for substeps in (1, 3):
        digital = SampledSystem(ode, 0.1, k, ca.SX(0, 1), ca.SX(0, 1))
        for engine in ("numpy", "casadi"):
            end = simulate(digital.step(substeps), until=1.0, engine=engine).x[0, -1, 0]
            assert end == pytest.approx(pulse_answer(10.0, 0.0512, 1e-3, 1.0), rel=1e-5)  # h^4 / 120 of the decay


def test_a_duty_that_a_computer_holds_is_met_too():
    """Where a steady state says when it switches, as the command of a pulse width does."""
    t, x, k = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("k")
    states = Layout((Entry("duty", np.zeros(())), Entry("x", np.zeros(()))))
    rate = ca.vertcat(0, ca.if_else(ca.fmod(t, 0.1) < 0.1 * x[0], 1, 0))
    ode = Ode("pwm", states, Layout(), Layout(), t, x, ca.SX.sym("p", 0), rate, ca.SX(0, 1))
    pwm = SampledSystem(ode, 0.1, k, ca.SX.sym("w", 0), 0.123 + 0.05 * k)
    runs = simulate(pwm.step(), until=1.0)
    assert runs["x"][0, -1] == pytest.approx(0.1 * sum(0.123 + 0.05 * i for i in range(10)), abs=1e-13)


def test_the_chooser_sees_the_pulses_of_every_pilot():
    ode = lag(pulse, begin=0.0512, width=1e-3, level=10.0)
    begins = np.linspace(0.05, 0.93, 12)
    found = wb.measure(ode, [], ode.parameters.pack({"begin": begins}), until=1.0, tolerance=1e-3)
    truth = pulse_answer(10.0, begins, 1e-3, 1.0)
    np.testing.assert_allclose(found.trajectories.x[:, -1, 0], truth, rtol=1e-3)


def test_more_switches_in_a_step_than_it_can_be_divided_at_are_refused():
    ode = lag(lambda t, x, P: ca.if_else(ca.fmod(t, P) < P / 2, 1, 0), P=1e-6)
    with pytest.raises(ValueError, match=r"switches every 1e-06 s and the step is 0.1 s"):
        simulate(rk4(ode, 0.1), until=1.0)
    assert wb.measure(ode, [], until=2e-3, tolerance=1e-3).trajectories.x[0, -1, 0] == pytest.approx(1e-3, rel=1e-2)


@pytest.mark.parametrize(
    ("force", "instants", "lattices"),
    [
        (lambda t, a, b: t >= a, [2.0], []),
        (lambda t, a, b: ca.sign(b - 2 * t), [1.5], []),
        (lambda t, a, b: ca.fmax(0, 1 - ca.fabs(t - a) / b), [-1.0, 2.0, 5.0], []),
        (lambda t, a, b: ca.fmin(t, b), [3.0], []),
        (lambda t, a, b: ca.fmod(t, a) < b / 4, [], [(0.0, 2.0), (0.75, 2.0)]),
        (lambda t, a, b: t - b * ca.floor(t / b) < a, [], [(0.0, 3.0), (2.0, 3.0)]),
        (lambda t, a, b: ca.ceil(t / a + b), [], [(-6.0, 2.0)]),
        (lambda t, a, b: (t > a) * (t < b) * ca.sin(t), [2.0, 3.0], []),
        (lambda t, a, b: ca.sin(a * t) + t**2, [], []),
    ],
)
def test_switches_are_read_from_the_equations(force, instants, lattices):
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p", 2)
    found = find_switches(force(t, *ca.vertsplit(p)) + 0 * t - x, t, x, p)
    values = ca.Function("f", [p], [found.instants, found.firsts, found.spacings])([2.0, 3.0])
    single, first, spacing = (np.array(part).ravel() for part in values)
    assert sorted(single) == pytest.approx(instants)
    found_lattices = sorted(zip(first, spacing, strict=True))
    np.testing.assert_allclose(np.reshape(found_lattices, (-1, 2)), np.reshape(lattices, (-1, 2)), atol=1e-12)
    assert not found.unknown_operations


def test_what_switches_at_instants_that_are_not_known_is_said():
    ode = lag(lambda t, x: ca.sign(ca.sin(7 * t)))
    assert ode.switches.unknown_operations == ("sign",)
    case = wb.Case("wave", "none", wb.Run(ode, (), until=1.0, h=0.01))
    [outcome] = run(wb.Study("s", "T", "Q?", "M.", lambda results: [], cases=(case,))).outcomes
    assert any("not known before" in note for note in outcome.notes)


def test_a_rate_without_time_keeps_its_expression():
    ode = wb.open_loop(wb.DCMotor())
    assert ca.is_equal(ode.switches.rate, ode.rate, 50)
    assert rk4(ode, 0.1).rule.segments is None


def test_a_page_on_which_a_pulse_is_turned_has_the_bits_of_the_portable_arithmetic():
    needs("native")
    pytest.importorskip("wasmtime")
    from tests.support.wasm_runs import Kernel, unpacked
    from workbench.report.live.marches import Modules, march

    train = wb.PulseTrain("v", "V", level=6.0, period=0.31, width=1e-3, time=0.2)
    motor = wb.DisturbedPlant(wb.DCMotor(), by=train)
    law = wb.PID(motor.outputs, motor.inputs, Kp=10.0, Ki=20.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.0123))
    draws = np.random.default_rng(8)
    for step in (rk4(loop.ode(), 0.01), loop.digital(0.02).step(2)):
        modules = Modules()
        plain = march(step, 10, modules)
        kernel = Kernel(unpacked(next(iter(modules.packed_modules.values()))), plain, 10)
        turned = {
            "plant.by.time": draws.uniform(0, 1, 8),
            "plant.by.width": 10 ** draws.uniform(-5, -1, 8),
            "plant.by.period": draws.uniform(0.15, 1, 8),
            "reference.time": draws.uniform(0, 1, (8, 1)),
        }
        rows = step.parameters.pack(turned)
        until = 100 * step.h
        wanted = simulate(step, rows, until=until, every=until / 10, arithmetic="portable").x[:, 1:]
        for row, run_of_row in zip(rows, wanted, strict=True):
            np.testing.assert_array_equal(kernel.run(row, step.states.default, rows=10), run_of_row)
