"""What computers do to a loop, and its margins for that: late instants, missed periods, single precision."""

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.stats import kstest

import workbench as wb
from tests.support.samples import made_sample
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import PlanarArm
from workbench.arms.mechanics.planar_arm import PointMass
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop, LinearLaw
from workbench.blocks.plants import DCMotor
from workbench.blocks.signals import Constant, SineTorque
from workbench.core import Entry, Layout, Ode, SampledSystem
from workbench.engine import simulate
from workbench.engine.factors import Space
from workbench.engine.kernel.noise import normals
from workbench.engine.metrics import rmse
from workbench.handover.single.single_precision import single_precision
from workbench.handover.single.single_precision_loop import in_single_precision, single
from workbench.study import Factor, Run, Uniform
from workbench.study.evidence.computer_margins import (
    ComputerEffect,
    computer_effects,
    computer_margins,
    computer_sweep,
    computer_table,
)

T = 0.02
MOTOR = DCMotor(omega=0.3)
LAW = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=15.0, Ki=40.0, low=-24.0, high=24.0)
LOOP = ClosedLoop(MOTOR, controller=LAW, reference=wb.Step("omega", "rad/s", 1.0))
NOISY = wb.Instruments.of(MOTOR, noise={"omega": 1e-3}, quantum={"omega": 1e-3}, limit={"v": (-20.0, 20.0)})


def bits(array):
    return np.ascontiguousarray(array).view(np.int64)


def late(jitter=0.0, missed=0.0, until=20.0, delay=False, instruments=None, substeps=1):
    digital = LOOP.digital(T, instruments, delay=delay).with_timing_faults()
    p = digital.parameters.pack({"computer.jitter": jitter, "computer.missed": missed})
    return simulate(digital.step(substeps), p, until=until, seed=3)


@pytest.mark.parametrize("delay", [0, 2])
def test_a_computer_that_is_never_late_and_misses_nothing_has_the_same_bits(delay):
    plain = LOOP.digital(T, NOISY, delay=delay)
    runs = [
        simulate(one.step(2), until=5.0, seed=1, arithmetic="portable").x for one in (plain, plain.with_timing_faults())
    ]
    assert (bits(runs[0]) == bits(runs[1][..., : plain.states.size])).all()


def test_a_late_instant_is_the_exact_flow_of_the_plant_over_its_own_span():
    run = late(jitter=0.4 * T, instruments=wb.Instruments.of(MOTOR, limit={"v": (-20.0, 20.0)}), substeps=16)
    x, t = run.x[0], run.t
    lateness = x[:, run.step.states.slice("computer.late")].ravel()
    held = x[:, run.step.states.slice("hold.v")].ravel()
    m, states = MOTOR, [run.step.states.slice(f"plant.{name}").start for name in ("omega", "i")]
    A = np.array([[-m.b / m.J, m.K / m.J, 0], [-m.K / m.L, -m.R / m.L, 1 / m.L], [0, 0, 0]])
    later = x[:, run.step.states.slice("computer.later")].ravel()
    for k in range(1, len(t) - 1):
        # row k + 1 was reached from the instant k, whose lateness row k + 1 has, in the time to the next one
        span = T + later[k + 1] - lateness[k + 1]
        theirs = (expm(A * span) @ [*x[k, states], held[k + 1]])[:2]
        np.testing.assert_allclose(x[k + 1, states], theirs, rtol=1e-7, atol=1e-9)  # RK4 at about 1 ms, poles at 10 1/s
        assert lateness[k + 1] == later[k]


def test_what_acts_in_time_acts_at_the_true_time():
    a, w, J = 0.7, 9.0, 0.8
    arm = PlanarArm((PointMass(J, 1.0),), gravity=0.0)
    free = ClosedLoop(
        Manipulator(arm, [0.0], [0.0], disturbance=SineTorque([a], [w], [0.3])),
        ArmFullState(1),
        wb.ArmPID([0.0], [0.0], [0.0]),
        Constant("q", "rad", [0.0]),
    )
    digital = free.digital(T).with_timing_faults()
    run = simulate(digital.step(8), digital.parameters.pack({"computer.jitter": 0.5 * T}), until=4.0, seed=2)
    # row k + 1 was reached at (k + 1) T and the lateness that row k + 1 has for the next instant
    t = run.t[1:] + run.x[0, 1:, run.step.states.slice("computer.later")].ravel()
    speed = run.x[0, 1:, run.step.states.slice("plant.qd")].ravel()
    np.testing.assert_allclose(np.abs(speed), np.abs(a / (J * w) * (np.cos(0.3) - np.cos(w * t + 0.3))), atol=1e-9)


def test_substeps_meet_the_exact_flow_with_the_fourth_order():
    digital = LOOP.digital(T).with_timing_faults()
    p = digital.parameters.pack({"computer.jitter": 0.5 * T})
    runs = [simulate(digital.step(n), p, until=2.0, seed=3).x[0, -1, :2] for n in (1, 2, 4, 32)]
    errors = [np.abs(run - runs[-1]).max() for run in runs[:-1]]
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.3)
    assert errors[1] / errors[2] == pytest.approx(16, rel=0.3)


def test_delays_are_uniform_and_independent():
    run = late(jitter=0.3 * T, until=100.0)
    d = run.x[0, 3:, run.step.states.slice("computer.late")].ravel()
    assert d.min() >= 0
    assert d.max() <= 0.3 * T
    assert kstest(d / (0.3 * T), "uniform").pvalue > 1e-3
    assert abs(np.corrcoef(d[1:], d[:-1])[0, 1]) < 3 / np.sqrt(len(d))


def test_so_many_periods_are_missed_and_all_that_the_computer_keeps_stays_then():
    run = late(missed=0.2, until=100.0, delay=True, instruments=NOISY)
    states = run.step.states
    own = [i for name in states.names if name.startswith(("controller.", "hold.")) for i in states.indices(name)]
    still = (run.x[0, 1:][:, own] == run.x[0, :-1][:, own]).all(axis=1)
    share, n = still.mean(), len(still)
    assert abs(share - 0.2) < 4 * np.sqrt(0.2 * 0.8 / n)
    moving = run.x[0, 1:, states.slice("plant.omega")] != run.x[0, :-1, states.slice("plant.omega")]
    assert moving[still.nonzero()[0]].mean() > 0.9  # the plant goes on


def test_a_computer_that_misses_all_never_commands():
    run = late(missed=1.0, until=1.0)
    assert not run["v"].any()


def test_a_loop_of_equations_alone_has_no_computer():
    t, k, x = ca.SX.sym("t"), ca.SX.sym("k"), ca.SX.sym("x", 1)
    flow = Ode("plain", Layout((Entry("x", np.ones(1)),)), Layout(), Layout(), t, x, ca.SX(0, 1), -x, ca.SX(0, 1))
    with pytest.raises(
        ValueError, match=r"`SampledSystem.with_timing_faults\(\)` needs a loop that `ClosedLoop.digital` has made"
    ):
        SampledSystem(flow, 0.1, k, ca.SX(0, 1), x / 2).with_timing_faults()


def test_a_plant_in_discrete_time_is_refused():
    import control

    system = control.ss([[0.9]], [[0.1]], [[1.0]], [[0.0]], T, inputs="v", outputs="omega", states="x")
    loop = ClosedLoop(
        wb.LinearPlant(system), controller=LinearLaw(control.ss([], [], [], [[-1.0]], inputs="omega", outputs="v"))
    )
    with pytest.raises(ValueError, match=r"with_timing_faults\(\)` needs a plant in continuous time; 'plant.x'"):
        loop.digital(T).with_timing_faults()


@pytest.mark.parametrize(("name", "high"), [("jitter", 0.51 * T), ("missed", 1.01)])
def test_a_range_beyond_half_of_the_period_or_all_periods_is_refused(name, high):
    digital = LOOP.digital(T).with_timing_faults()
    with pytest.raises(ValueError, match=rf"'much' goes from 0 to .*computer.{name}"):
        Space((Factor("much", (f"computer.{name}",), Uniform(0.0, high)),), digital.parameters, digital.states)


# Single precision


def test_a_number_is_rounded_as_ieee_754_rounds_it_to_32_bits():
    x, unit = ca.SX.sym("x"), ca.SX.sym("unit")
    rounded = ca.Function("rounded", [x, unit], [single(x, unit)])
    rng = np.random.default_rng(5)
    wide = rng.normal(size=100_000) * 10.0 ** rng.uniform(-30, 30, 100_000)
    near = rng.integers(2**23, 2**24, 100_000) + rng.choice([0.5, 0.25, 0.75, 0.5 - 2**-27], 100_000)  # ties, and close
    for numbers in (wide, near, np.array([0.0, 1.0, -1.0])):
        ours = np.array(rounded(numbers[np.newaxis], 1.0)).ravel()
        assert (ours == numbers.astype(np.float32)).all()


def test_a_law_in_single_precision_is_that_of_floats_one_operation_after_the_other():
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=15.3, Ki=40.7)
    digital = ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.1)).digital(T)
    run = simulate(in_single_precision(digital, digital.law()).step(1), until=4.0, arithmetic="portable")
    x, names = run.x[0], run.step.states
    omega, v = (x[:, names.slice(name)].ravel() for name in ("plant.omega", "hold.v"))
    z = x[:, names.slice("controller.integral")].ravel()
    e = np.float32(1.1) - omega[:-1].astype(np.float32)
    own = np.float32(15.3) * e + z[:-1].astype(np.float32)
    # the law's own order of the terms may round once more or less
    np.testing.assert_allclose(v[1:], own, rtol=0, atol=4 * np.spacing(np.float32(30)))
    assert (z == z.astype(np.float32)).all()
    assert (v == v.astype(np.float32)).all()
    plain = simulate(digital.step(1), until=4.0).x[0][:, names.slice("hold.v")].ravel()
    assert 0 < np.abs(plain - v).max() < 1e-3


def test_a_law_in_single_precision_has_the_bits_of_the_other_road_to_it():
    digital = LOOP.digital(T, NOISY, delay=True)
    law, n = digital.law(), 400
    loop = in_single_precision(digital, law)
    run = simulate(loop.step(1), until=n * T, arithmetic="portable", seed=4)
    x, k = run.x[0], np.arange(n)
    names = run.step.states
    symbols = [loop.k, loop.flow.x, loop.flow.p, loop.w]
    taken = ca.Function("taken", symbols, [ca.vertcat(*(loop.computer_input_values[f"{port}.omega"] for port in "yr"))])
    p = np.tile(loop.parameters.default[:, np.newaxis], (1, n))
    w = normals(4, np.array([0]), k, loop.w.numel())[0].T
    y, r = np.array(taken.map(n)(k[np.newaxis], x[:-1].T, p, w))
    z = np.concatenate([x[:, names.slice(name)] for name in law.memory.names], axis=1)
    after, _ = single_precision(law, k, z[:-1], y[:, np.newaxis], r[:, np.newaxis])
    assert (z[1:] == after.astype(float)).all()
    assert np.ptp(z, axis=0).all()


# Margins of a synthetic sample


def effects():
    return (
        ComputerEffect("a", ("a",), (1.0, 2.0, 4.0), 2.0),
        ComputerEffect("b", ("b",), (0.5, 1.0), 1.0, "s"),
    )


def sample_of(values):
    """Two draws a kind, one metric of two numbers."""
    values = np.asarray(values, float)
    n = len(values)
    columns = (("error", 0, "rad"), ("error", 1, "rad"))
    empty = np.empty((0, 1, 2))
    return made_sample(
        "s", ("a", "b"), columns, np.ones(1), 0.1, 0, "", np.zeros((n, 2)), values[:, np.newaxis], np.empty(0, int),
        empty, np.empty(0), np.full(n, np.nan),
    )  # fmt: skip


def kinds(*ratios):
    """Runs of errors 1 and 2, and 2 and 4 in the second draw, the second number times the ratio of the kind."""
    rows = []
    for ratio in ratios:
        rows += [[1.0, 2.0 * ratio], [2.0, 4.0 * ratio]]
    return np.array(rows)


def test_margins_are_the_levels_up_to_which_no_run_is_worse():
    found = computer_margins(sample_of(kinds(1.0, 1.05, 1.2, 1.01, 1.0, 1.09, 3.0)), effects(), "error")
    a, b = found.each
    assert (a.largest(1.1), a.largest(1.3), a.largest(1.0)) == (1.0, 4.0, 0.0)
    assert not a.is_unbounded(1.1)
    assert a.is_unbounded(1.2)
    assert b.largest(1.1) == 1.0
    assert b.is_unbounded(1.1)
    assert a.loss == pytest.approx(0.2)
    assert b.loss == pytest.approx(0.09)
    assert (found.declared_values / found.without).max() == pytest.approx(3.0)


def test_a_run_that_diverged_is_beyond_every_margin_and_never_averaged_away():
    values = kinds(1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
    values[5] = np.nan  # the second draw of the level 2 of a
    a, _ = computer_margins(sample_of(values), effects(), "error").each
    assert a.largest(1e6) == 1.0
    assert np.isinf(a.loss)
    rows = computer_table("t", "T.", [("loop", computer_margins(sample_of(values), effects(), "error"))]).rows
    assert rows[0][3] == "lost"
    assert rows[0][4] == "1"
    assert rows[1][4] == "≥ 1e+03 ms"


def test_a_sample_of_other_effects_is_refused():
    with pytest.raises(ValueError, match=r"needs the sample of `computer_sweep` for the effects a, b; got 's' of a, b"):
        computer_margins(sample_of(kinds(1.0, 1.0, 1.0)), effects(), "error")
    with pytest.raises(LookupError, match="There is no metric 'speed' among error"):
        computer_margins(sample_of(kinds(*[1.0] * 7)), effects(), "speed")


@pytest.mark.parametrize(("levels", "declared"), [((), 0.0), ((2.0, 1.0), 1.0), ((0.0, 1.0), 1.0), ((1.0, 2.0), 1.5)])
def test_levels_rise_and_the_declared_one_is_among_them(levels, declared):
    with pytest.raises(ValueError, match=r"levels that rise from `least`, with the declared one among them"):
        ComputerEffect("a", ("a",), levels, declared)


def test_a_sweep_has_each_effect_by_itself_and_all_that_is_declared():
    digital = LOOP.digital(T, NOISY).with_timing_faults()
    own = computer_effects(digital, jitter=0.1 * T, missed_share=0.05)
    assert [effect.name for effect in own] == ["coarser readings", "jitter", "missed periods"]
    start = Factor("omega", ("plant.omega",), Uniform(0.0, 0.1))
    sweep = computer_sweep("own", Run(digital, (rmse(),), 1.0, h=T), own, (start,), draws=3)
    p, x0 = Space(sweep.factors, digital.parameters, digital.states).rows(sweep.design.points())
    labels = [f"instruments.sensors[0].{name}" for name in ("quantum",)] + ["computer.jitter", "computer.missed"]
    held = np.stack([p[:, digital.parameters.slice(label).start] for label in labels], axis=1)
    np.testing.assert_allclose(held[:3], np.tile([1e-3, 0.0, 0.0], (3, 1)), rtol=1e-12)
    np.testing.assert_allclose(held[-3:], np.tile([1e-3, 0.1 * T, 0.05], (3, 1)), rtol=1e-12)
    off = np.abs(held[3:-3] / [1e-3, T, 1.0] - [1.0, 0.0, 0.0]) > 1e-9
    assert (off.sum(axis=1) == 1).all()
    starts = x0[:, digital.states.slice("plant.omega").start].reshape(-1, 3)
    assert len(np.unique(starts[0])) == 3
    assert (starts == starts[0]).all()


def test_a_sweep_needs_an_effect_and_a_loop_that_is_disturbed():
    digital = LOOP.digital(T, NOISY)
    with pytest.raises(LookupError, match="computer.jitter"):
        computer_effects(digital, 0.0, 0.0)
    with pytest.raises(ValueError, match="at least one effect"):
        computer_sweep("own", Run(digital, (rmse(),), 1.0, h=T), ())


def test_a_number_that_stays_zero_has_not_grown_and_one_that_leaves_zero_has_grown_without_bound():
    assert wb.evidence.worst_ratio(np.array([[0.0, 3.0]]), np.array([0.0, 2.0])).tolist() == [1.5]
    assert wb.evidence.worst_ratio(np.array([[1.0, 3.0]]), np.array([0.0, 2.0])).tolist() == [np.inf]
    assert wb.evidence.worst_ratio(np.array([[np.nan, 3.0]]), np.array([1.0, 2.0])).tolist() == [np.inf]
