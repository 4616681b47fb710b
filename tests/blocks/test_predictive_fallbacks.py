"""Predictive laws without offset, with a safe command, and with a bound of their residual."""

from functools import cache

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from workbench.core.symbolic_twin import lift
from workbench.design.linear import operating_point
from workbench.design.matrices import DesignError
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.uncertainty import MonteCarlo

LEVELS = {"h_1": 14.0, "h_2": 13.0}


@cache
def tank_design(**options):
    plant = wb.open_loop(wb.QuadrupleTank())
    point = operating_point(plant, {"h_1": 12.4, "h_2": 12.7})
    model = wb.linearize(plant, 0.0, point.x, u=point.u, at_rest=True)
    limits, own = {"v_1": (0.0, 6.0), "v_2": (0.0, 6.0)}, {"offset_free": ("h_1", "h_2")} | options
    return wb.predictive_design(model, 5.0, np.diag([1, 1, 0.01, 0.01]), 0.1 * np.eye(2), 12, limits=limits, **own)


@cache
def cart_design(**options):
    model = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    return wb.predictive_design(
        model, 0.02, np.diag([10.0, 1.0, 10.0, 1.0]), [[0.1]], 20, limits={"F": (-3.0, 3.0)}, **options
    )


def levels():
    return wb.CombinedReference(tuple(wb.Constant(name, "cm", level) for name, level in LEVELS.items()))


@pytest.mark.parametrize("delay", [0.0, 5.0])
def test_wrong_gains_of_the_pumps_leave_no_offset_of_the_levels(delay):
    design, model = tank_design(delay=delay), wb.QuadrupleTank()
    plant = wb.QuadrupleTank(k_1=2.8, k_2=3.6)  # the model has 3.33 and 3.35
    law, observer = wb.ModelPredictive.of(model, design), wb.OffsetFreeObserver.of(model, design)
    loop = wb.ClosedLoop(plant, observer=observer, controller=law, reference=levels())
    run = wb.simulate(loop.digital(5.0, delay=bool(delay)).step(20), until=1500.0)
    for name, level in LEVELS.items():
        assert run[name][0, -1, 0] == pytest.approx(level, abs=1e-6)  # as the issue of the law asks
    assert run["v_1"].max() > 5.0


def test_without_an_estimate_of_the_disturbance_wrong_gains_leave_an_offset():
    design = tank_design(offset_free=())
    model = wb.QuadrupleTank()
    law = wb.ModelPredictive.of(model, design)
    loop = wb.ClosedLoop(wb.QuadrupleTank(k_1=2.8, k_2=3.6), observer=wb.FullState.of(model), controller=law)
    run = wb.simulate(loop.digital(5.0).step(20), until=1500.0)
    assert abs(run["h_1"][0, -1, 0] - 12.4) > 0.1


def test_a_cart_on_a_slope_reaches_its_reference():
    design, plant = cart_design(offset_free=("x",)), wb.CartPole(phi=0.02)
    slope = wb.DisturbedPlant(plant, by=wb.Constant("F", "N", -0.3))  # of 0.7 kg on 2.5 degrees
    law, observer = wb.ModelPredictive.of(plant, design), wb.OffsetFreeObserver.of(plant, design)
    loop = wb.ClosedLoop(slope, observer=observer, controller=law, reference=wb.Step("x", "m", 0.1))
    run = wb.simulate(loop.digital(0.02).step(2), until=30.0)
    assert run["x"][0, -1, 0] == pytest.approx(0.1, abs=1e-6)


def test_a_period_without_a_number_gives_the_safe_command_and_keeps_the_memory():
    plant, design = wb.CartPole(), cart_design()
    guarded = _answers(wb.ModelPredictive.of(plant, design, follow=("x",), safe_command={"F": 0.5}))
    good = guarded([0.01, 0.0, 0.0, 0.0], 0.0)
    assert float(good[0]) != 0.5
    for state, reference in (([np.nan, 0, 0, 0], 0.0), ([0, 0, np.inf, 0], 0.0), ([0, 0, 0, 0], np.nan)):
        command, plan, residual = guarded(state, reference)
        assert float(command) == 0.5
        np.testing.assert_array_equal(plan.full().ravel(), 0.01)
        assert float(residual) == 0.01
    bare = _answers(wb.ModelPredictive.of(plant, design, follow=("x",)))([0.01, 0.0, 0.0, 0.0], 0.0)
    np.testing.assert_allclose(float(bare[0]), float(good[0]), rtol=0, atol=1e-12)  # the same operations


def _answers(law):
    """The command, the plan and the residual after a period from a memory of 0.01, as functions of x and r."""
    twin = lift(law)
    z = {entry.name: ca.SX(entry.default + 0.01) for entry in law.memory.entries}
    x, r = ca.SX.sym("x", 4), ca.SX.sym("r")
    est, ref = wb.Signals(law.states.view(x)), wb.Signals({"x": r})
    after = twin.block.update(0.0, z, est, ref)
    answers = [twin.block.command(0.0, z, est, ref)["F"], after["plan"], after["residual"]]
    function = ca.Function("f", [x, r, twin.symbols], answers)
    return lambda state, reference: function(state, reference, twin.layout.default)


@wb.block
class Basin(wb.Plant):
    h: float = wb.initial(default=1.0, unit="m")
    fails: float = wb.parameter(default=1e9, unit="s")
    inputs, outputs = wb.layout(w="m/s"), wb.layout(h="m")

    def rate(self, t, x, u):
        return {"h": u["w"] - 0.5 * x["h"]}

    def measure(self, t, x):
        lost = ca.logic_and(t >= self.fails, t < self.fails + 0.35)
        return {"h": ca.if_else(lost, np.nan, x["h"])}


def test_lost_readings_are_passed_over_by_the_observer():
    plant = Basin()
    model = wb.linearize(wb.open_loop(plant), 0.0, [1.0], u=[0.5], at_rest=True)
    design = wb.predictive_design(model, 0.1, [[1.0]], [[0.1]], 10, limits={"w": (0.0, 1.0)}, offset_free=("h",))
    law, observer = wb.ModelPredictive.of(plant, design), wb.OffsetFreeObserver.of(plant, design)
    loop = wb.ClosedLoop(Basin(fails=0.5), observer=observer, controller=law, reference=wb.Step("h", "m", 1.4))
    run = wb.simulate(loop.digital(0.1).step(4), until=10.0)
    assert not run.has_diverged.any()
    assert run.x[0, -1, 0] == pytest.approx(1.4, abs=1e-6)


def test_a_reference_beyond_the_limits_winds_nothing_up():
    plant, times = Basin(), []
    model = wb.linearize(wb.open_loop(plant), 0.0, [1.0], u=[0.5], at_rest=True)
    design = wb.predictive_design(model, 0.1, [[1.0]], [[0.1]], 10, limits={"w": (0.0, 1.0)}, offset_free=("h",))
    for level in (1.9, 5.0):  # the highest level that the limit allows is 2
        loop = wb.ClosedLoop(
            plant,
            observer=wb.OffsetFreeObserver.of(plant, design),
            controller=wb.ModelPredictive.of(plant, design),
            reference=wb.Step("h", "m", 1.0, time=15.0, start=level),
        )
        run = wb.simulate(loop.digital(0.1).step(4), until=30.0)
        assert not run.has_diverged.any()
        flags = [text for text in run.warnings if "'controller.rest_beyond_limits' of 'loop' passes its bound" in text]
        assert len(flags) == (level > 2.0)
        times.append(run.t[np.flatnonzero(np.abs(run["h"][0, :, 0] - 1.0) > 0.01)[-1]] - 15.0)
    assert times[1] < times[0] + 0.3  # it starts 5 % higher, and comes down as fast


@pytest.mark.parametrize(
    ("safe", "message"),
    [
        ({"F": 5.0}, r"must keep the limits of 'F', -3 and 3; got 5"),
        ({}, r"must name each input; 'F' is missing"),
        ({"F": 0.0, "v": 1.0}, r"There is no 'v' among the 1 inputs"),
        ({"F": np.nan}, r"must be a finite number"),
    ],
)
def test_a_safe_command_that_is_none_is_refused(safe, message):
    with pytest.raises((ValueError, LookupError), match=message):
        wb.ModelPredictive.of(wb.CartPole(), cart_design(), safe_command=safe)


def test_a_design_without_an_observer_has_none():
    with pytest.raises(ValueError, match=r"must be the result of `predictive_design\(\.\.\., offset_free"):
        wb.OffsetFreeObserver.of(wb.CartPole(), cart_design())
    with pytest.raises(ValueError, match=r"follow=...\)` must be left out"):
        wb.ModelPredictive.of(wb.CartPole(), cart_design(offset_free=("x",)), follow=("x",))
    with pytest.raises(DesignError, match="cannot hold 2 outputs"):
        cart_design(offset_free=("x", "phi"))


def test_a_run_beyond_the_sample_of_its_design_is_flagged_at_any_spacing_of_kept_times():
    plant, design = wb.CartPole(phi=0.05), cart_design()
    law = wb.ModelPredictive.of(plant, design, follow=("x",))

    def run(step):
        reference = wb.Step("x", "m", step)
        loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law, reference=reference)
        spacings = (0.02, 0.1, 1.0)
        return loop.digital(0.02), [wb.simulate(loop.digital(0.02).step(1), until=1.0, every=d) for d in spacings]

    assert [one.warnings for one in run(0.3)[1]] == [()] * 3
    computer, far = run(8.0)
    bound, largest = law.residual_bounds.high, far[0]["controller.residual"].max()
    assert far[2]["controller.residual"].max() < largest  # which no kept time has
    sentence = f"'controller.residual' of 'loop' passes its bound of {bound:.3g} at 0.02 s, and reaches {largest:.3g}"
    assert [one.warnings for one in far] == [(sentence,)] * 3
    assert sentence in wb.measure(computer, [wb.settling_time()], until=1.0, h=0.01).warnings


def test_runs_beyond_the_sample_of_their_design_are_named_among_many():
    plant, design = wb.CartPole(phi=0.05), cart_design()
    law = wb.ModelPredictive.of(plant, design, follow=("x",))
    loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law, reference=wb.Step("x", "m", 0.3))
    computer = loop.digital(0.02)

    def residuals(levels):
        """The residual (B, N) of every period, from runs that keep all states."""
        p = computer.parameters.pack({"reference.level": levels[:, np.newaxis]})
        return p, wb.simulate(computer.step(1), p, until=1.0)["controller.residual"].reshape(len(levels), -1)

    p, every = residuals(np.array([0.1, 0.3, 8.0, 0.2, 9.0]))
    beyond = (every > law.residual_bounds.high).any(axis=1)
    assert beyond.tolist() == [False, False, True, False, True]
    found = wb.measure(computer, [wb.settling_time()], p, until=1.0, every=1.0, h=0.01)
    assert found.extremes.runs_beyond.tolist() == beyond.tolist()
    assert f"in 2 of 5 runs (2, 4), in run 2 first, at 0.02 s, and reaches {every.max():.3g}" in found.warnings[0]
    assert found.only(np.array([0, 1, 3])).warnings == ()

    run = wb.Run(computer, (wb.settling_time(),), until=1.0, h=0.01)
    level = wb.Factor("level", ("reference.level",), wb.Uniform(0.1, 9.0))
    sweep = compile_sweep(wb.Sweep("levels", run, (level,), MonteCarlo(1, 16)))
    sample = sweep.sample([sweep.chunk(0, 9), sweep.chunk(9, 16)])
    beyond = (residuals(sample.factor_values[:, 0])[1] > law.residual_bounds.high).any(axis=1)
    assert 0 < beyond.sum() < 16
    assert sample.measurement.extremes.runs_beyond.tolist() == beyond.tolist()
    assert f"passes its bound of {law.residual_bounds.high:.3g} in {beyond.sum()} of 16 runs" in sample.note
