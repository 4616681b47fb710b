"""One road: a run has one value and one error, to the last bit, whoever asks for it, and whatever runs beside it."""

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from workbench.engine import simulate
from workbench.engine.arithmetic import default_for
from workbench.engine.distributions import Uniform
from workbench.engine.factors import Factor
from workbench.engine.metrics.accumulators import final_values, step_with_metrics
from workbench.study import case_runs
from workbench.study.compiled_sweep import compile_case, compile_sweep
from workbench.study.run_and_sweep import Run, Sweep
from workbench.study.study import Case, Study
from workbench.study.tuning import Trial, Tuning, tune
from workbench.study.uncertainty import ListedPoints, MonteCarlo

MOTOR, UNTIL, H = wb.DCMotor(), 2.0, 0.01
LAW = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0)
LOOP = wb.ClosedLoop(MOTOR, controller=LAW, reference=wb.Step("omega", "rad/s", 1.0))
NOISY = wb.Instruments.of(MOTOR, noise={"omega": 0.01})
LOOPS = {
    "continuous": LOOP,
    "computer": wb.DigitalLoop(LOOP, 0.02),
    "noisy computer": wb.DigitalLoop(LOOP, 0.02, NOISY, delay=True),
}
METRICS = (wb.rmse(), wb.effort(), wb.settling_time(), wb.total_variation(0.02))
GAIN = Factor("Kp", ("controller.Kp",), Uniform(50.0, 150.0))
OWN = np.array([[0.5]])  # the point at which Kp is 100 again
SEED = 3


def asked(loop):
    return Run(loop, METRICS, UNTIL, h=H, seed=SEED)


def equation(loop):
    return loop.ode("loop") if hasattr(loop, "ode") else loop


def pairs(found):
    """The value and the error of each score of the first run, by metric."""
    return {score.metric: score.pair for score in found.scores}


def by_measure(loop):
    return pairs(wb.measure(equation(loop), METRICS, until=UNTIL, h=H, seed=SEED))


def by_simulate(loop):
    """The values of the measured step, and twice their change to the step of half the length."""
    found = []
    for h in (H, H / 2):
        runs = simulate(step_with_metrics(equation(loop), METRICS, h), until=UNTIL, seed=SEED)
        found.append({name: float(value[0, 0]) for name, value in final_values(runs, METRICS).items()})
    least = {"settling time": step_with_metrics(equation(loop), METRICS, H).h}
    errors = {name: max(2 * abs(v - found[1][name]), least.get(name, 0.0)) for name, v in found[0].items()}
    return {name: (v, 0.0 if np.isinf([v, found[1][name]]).all() else errors[name]) for name, v in found[0].items()}


def by_case(loop):
    (outcome,) = case_runs.run(Study("s", "t", "q", "m", lambda r: (), cases=(Case("S", "law", asked(loop)),))).outcomes
    return pairs(outcome.measurement)


def by_case_of_a_ledger(loop):
    made = compile_case(asked(loop), equation(loop))
    again = compile_case(asked(loop), equation(loop))
    return pairs(again.sample([made.chunk(0, 1)]).measurement)


def by_sweep(loop):
    made = compile_sweep(Sweep("s", asked(loop), (GAIN,), ListedPoints(OWN)))
    return pairs(made.sample([made.chunk(0, 1)]).measurement)


ROADS = {
    "measure": by_measure,
    "simulate": by_simulate,
    "case": by_case,
    "case of a ledger": by_case_of_a_ledger,
    "sweep of one row": by_sweep,
}


# A computer with noise is a computer, too; the one without it runs with all tests only.
each_loop = pytest.mark.parametrize(
    "loop",
    [pytest.param(loop, id=name, marks=[pytest.mark.heavy] * (name == "computer")) for name, loop in LOOPS.items()],
)


@each_loop
def test_every_road_gives_one_value_and_one_error_to_the_last_bit(loop):
    found = {road: ask(loop) for road, ask in ROADS.items()}
    assert all(one == found["measure"] for one in found.values()), found
    value, error = found["measure"]["RMSE"]
    assert 0 < error < 1e-3 * value
    time, off = found["measure"]["settling time"]
    assert off >= H or np.isinf(time)


@each_loop
def test_a_trial_of_a_tuning_and_its_finalist_have_the_value_of_measure_and_the_finalist_its_error(loop):
    search = Tuning("t", (Trial("one", asked(loop)),), (GAIN,), lambda runs: runs["one"].score("RMSE").value, 8, 8)
    found = tune(search)
    ode = equation(loop)
    for trial, finalist in zip(found.finalists.tolist(), range(len(found.finalists)), strict=True):
        p = ode.parameters.pack({"controller.Kp": found.numbers[trial, [0]]})
        wanted = wb.measure(ode, METRICS, p, until=UNTIL, h=H, seed=SEED)
        for score in wanted.scores:
            name = score.metric
            assert found.samples["one"].score(name).value[trial] == score.value[0]
            final = found.final_samples["one"].score(name)
            assert (final.value[finalist], final.error[finalist]) == score.pair
    assert np.isnan(found.samples["one"].score("RMSE").error).all()  # no trial is looked at


@each_loop
def test_a_run_has_the_bits_that_it_has_alone_in_a_thousand_and_in_a_sweep_of_them(loop):
    ode, design = equation(loop), MonteCarlo(1, 1536, seed=1)
    made = compile_sweep(Sweep("s", asked(loop), (GAIN,), design, common=True, half_step_every=64))
    sweep = made.sample([made.chunk(*ends) for ends in made.chunks])
    p = ode.parameters.pack({"controller.Kp": sweep.factor_values[:, [0]]})
    for i in (0, 64, 1000):
        alone = wb.measure(ode, METRICS, p[[i]], until=UNTIL, h=H, seed=SEED)
        for score in alone.scores:
            found = sweep.score(score.metric)
            assert found.value[i] == score.value[0]
            assert np.isnan(found.error[i]) if i % 64 else found.error[i] == score.error[0]


def test_the_arithmetic_follows_from_the_step_and_not_from_the_number_of_runs(monkeypatch):
    from workbench.engine import arithmetic

    step = step_with_metrics(LOOP.ode(), METRICS, H)
    for most in (arithmetic.MOST_COMPILED, 1):
        monkeypatch.setattr(arithmetic, "MOST_COMPILED", most)
        p = np.tile(step.parameters.default, (100, 1))
        assert {simulate(step, rows, until=H).arithmetic for rows in (p[:1], p)} == {default_for(step)}


def test_a_signal_is_named_by_its_label_or_its_number():
    arm = wb.ClosedLoop(
        wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]),
        controller=wb.SlidingMode(model=wb.paper_arm(), Lambda=[6.0, 6.0], K=[40.0, 20.0], phi=0.1),
        reference=wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0]),
    )
    found = wb.measure(arm.ode(), [wb.rmse()], until=1.0, h=1e-3)
    one, other = found.score("RMSE", "joint 2"), found.score("RMSE", 1)
    assert (one.label, one.unit, one.pair) == ("joint 2", "rad", other.pair)
    with pytest.raises(LookupError, match=r"'RMSE' has no signal 'joint 3': it has 0 \('joint 1'\), 1 \('joint 2'\)"):
        found.score("RMSE", "joint 3")
    with pytest.raises(LookupError, match=r"There is no metric 'RMSF' among RMSE. Did you mean 'RMSE'\?"):
        found.score("RMSF")


def test_the_error_is_infinite_where_half_of_the_step_alone_gives_no_value_and_not_known_of_a_run_not_looked_at():
    made = compile_sweep(Sweep("s", asked(LOOP), (GAIN,), MonteCarlo(1, 4, seed=1), half_step_every=4))
    found = made.sample([made.chunk(0, made.size)]).measurement
    assert np.isnan(found.score("RMSE").error[1:4]).all()
    lost = replace(found, errors=found.errors * np.nan, half_diverged_at=np.full(len(found.looked_at), 1.0))
    assert np.isinf(lost.score("RMSE").error[found.looked_at]).all()
    assert np.isinf(lost.score("RMSE").largest_error)


def test_a_sweep_warns_of_pulses_that_a_metric_may_miss_as_a_case_does():
    pulses = wb.PulseTrain("omega", "rad/s", level=10.0, period=0.1, width=0.001, time=0.0512)
    loop = wb.ClosedLoop(MOTOR, controller=LAW, reference=pulses)
    run = Run(loop, (wb.peak_error(),), 1.0, h=0.02)
    made = compile_sweep(Sweep("s", run, (GAIN,), MonteCarlo(1, 4, seed=1)))
    sweep = made.sample([made.chunk(0, made.size)])
    assert "looks at the ends of steps" in sweep.note
    (outcome,) = case_runs.run(Study("s", "t", "q", "m", lambda r: (), cases=(Case("S", "law", run),))).outcomes
    assert any("looks at the ends of steps" in note for note in outcome.notes)
