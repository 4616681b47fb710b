"""How far a run can be trusted: the step that is chosen, the step that is named, and what every view says of it."""

import re

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import workbench as wb
from tests.support.equations import decay, explosion
from workbench.report.live.loop_study import loop_study
from workbench.study import case_runs

MOTOR = wb.DCMotor()
TOO_LONG = r"the step of 50 ms is beyond its stability limit of 27\.9 ms"


def first_loop():
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0, Kd=10.0, low=-24.0, high=24.0)
    return wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))


def smooth_loop():
    """A PI loop from rest to a reference of 1 from the start: nothing switches."""
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=20.0, Ki=40.0)
    return wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0))


def oracle(ode, until):
    """The state at the end by an eighth-order method of SciPy, to twelve digits."""
    start, p = ode.states.default, ode.parameters.default
    solution = solve_ivp(lambda t, x: ode.rate_at(t, x, p), (0, until), start, "DOP853", rtol=1e-12, atol=1e-12)
    return solution.y[:, -1]


@wb.block
class Escape(wb.Plant):
    """x' = x^2 + u from 1, which is infinite at 1 s."""

    x: float = wb.initial(default=1.0, unit="m")
    inputs, outputs = wb.layout(u="m/s"), wb.layout(x="m")

    def rate(self, t, x, u):
        return {"x": x.x**2 + u.u}


@wb.block
class Idle(wb.Controller):
    """u = 0."""

    reads, drives = wb.layout(x="m"), wb.layout(u="m/s")

    def command(self, t, z, est, ref):
        return {"u": 0.0 * est.x}


@wb.block
class Runaway(wb.Plant):
    """x' = -x + u beside y' = y^3 from 1: x is calm, y is infinite at 0.5 s."""

    x: float = wb.initial(default=1.0, unit="m")
    y: float = wb.initial(default=1.0, unit="m")
    inputs, outputs = wb.layout(u="m/s"), wb.layout(x="m", y="m")

    def rate(self, t, x, u):
        return {"x": u.u - x.x, "y": x.y**3}


def lost_runs():
    return wb.simulate(wb.rk4(wb.open_loop(Escape()), 1e-3), until=4.0)


@pytest.mark.parametrize("given", ["loop", "ode"])
def test_a_loop_is_run_at_a_step_that_keeps_the_tolerance(given):
    loop = smooth_loop()
    ode = loop.ode()
    runs = wb.simulate(loop if given == "loop" else ode, until=2.0, tolerance=1e-6)
    exact = oracle(ode, 2.0)
    # the change to half the step is fifteen sixteenths of the error of a smooth solution, and the size of a state is
    # at most a few times what it is at the end
    np.testing.assert_allclose(runs.x[0, -1], exact, atol=1e-5 * np.abs(exact).max())
    assert runs.check.is_chosen
    assert runs.check.change <= 1e-6
    assert re.search(r"step of .* ms chosen for a tolerance of 1e-06 \(half of it changes a state by \d", repr(runs))


def test_a_tighter_tolerance_has_a_shorter_step_and_as_many_times():
    rough, fine = (wb.simulate(decay(), until=1.0, tolerance=t) for t in (1e-3, 1e-13))
    assert fine.step.h < rough.step.h
    assert len(rough.t) == len(fine.t) == 1001
    assert fine["x"][0, -1, 0] == pytest.approx(np.exp(-3), rel=1e-12)


@pytest.mark.heavy
def test_a_loop_in_a_computer_has_its_substeps_chosen():
    computer = first_loop().digital(0.1)
    runs, exact = wb.simulate(computer, until=2.0), wb.simulate(computer.step(256), until=2.0)
    assert runs.step.substeps > 1
    assert len(runs.t) == 21
    # the tolerance of 1e-3 is of each state's largest value
    np.testing.assert_allclose(runs["omega"], exact["omega"], atol=1e-3 * np.abs(exact["omega"]).max())
    assert "chosen for a tolerance of 0.001" in repr(runs)


def test_every_row_of_a_batch_is_run_at_the_step_that_its_pilots_choose():
    ode = decay()
    rates = np.linspace(1.0, 300.0, 40)[:, np.newaxis]
    runs = wb.simulate(ode, rates, until=1.0, every=0.1)
    assert runs.x.shape == (40, 11, 1)
    np.testing.assert_allclose(runs["x"][:, -1, 0], np.exp(-rates[:, 0]), atol=1e-3)  # the tolerance
    assert runs.step.h <= 2.785 / 300  # the end of RK4's stability interval


def test_a_step_of_a_computer_without_a_number_is_chosen_and_one_that_is_named_is_kept():
    computer = first_loop().digital(0.1)
    assert computer.step().substeps == wb.simulate(computer, until=10.0).step.substeps
    assert computer.step(1).substeps == 1


def words(page):
    """The text of a page, which has no-break spaces before units, with plain ones."""
    return page.text.replace("\N{NO-BREAK SPACE}", " ")


def test_the_first_loop_of_the_readme_at_too_long_a_step_says_so_in_every_view():
    runs = wb.simulate(wb.rk4(first_loop().ode(), 0.05), until=2.0)
    assert runs["omega"][0, -1, 0] < 0.1  # wrong: 1.002
    assert not runs.check.is_passed
    figure = runs.plot()
    for view in (repr(runs), runs._repr_html_(), str(runs.warnings), " ".join(runs.to_frame().attrs["warnings"])):
        assert re.search(TOO_LONG, view)
    assert re.search(TOO_LONG, figure.axes[0].get_title(loc="left"), re.IGNORECASE)
    assert re.search(TOO_LONG, words(wb.live(first_loop(), until=2.0, h=0.05)))
    assert re.search(TOO_LONG, words(runs.live()))
    assert "changes by" in repr(runs)


def test_the_same_loop_at_a_short_step_warns_of_nothing():
    runs = wb.simulate(wb.rk4(first_loop().ode(), 2e-4), until=2.0)
    assert runs.warnings == ()
    assert repr(runs) == "<1 run of 'loop' at 10001 times to 2 s>"
    assert runs.plot().axes[0].get_title(loc="left") == ""
    assert "At the baseline," not in words(wb.live(first_loop(), until=2.0, h=2e-4))


def test_a_step_within_its_limit_that_changes_the_result_says_by_how_much():
    ode = decay(1.0)
    runs = wb.simulate(wb.rk4(ode, 2.0), until=10.0)
    assert runs.check.limit.holds
    ratio, half = (sum((-h) ** k / factorial for k, factorial in enumerate((1, 1, 2, 6, 24))) for h in (2.0, 1.0))
    n = np.arange(6)
    assert runs.check.change == pytest.approx(np.abs(ratio**n - half ** (2 * n)).max(), rel=1e-9)
    assert re.search(r"at half the step of 2 s 'x(\[0\])?' changes by \d+ %", repr(runs))
    assert wb.simulate(wb.rk4(ode, 2.0), until=10.0, tolerance=0.5).warnings == ()


@pytest.mark.heavy
def test_a_computer_with_too_few_substeps_says_so():
    @wb.block
    class Fast(wb.Plant):
        """x' = 200 (u - x)."""

        x: float = wb.initial(default=0.0, unit="m")
        inputs, outputs = wb.layout(u="m"), wb.layout(x="m")

        def rate(self, t, x, u):
            return {"x": 200.0 * (u.u - x.x)}

    law = wb.PID(Fast.outputs, Fast.inputs, Kp=0.1, Ki=1.0)
    computer = wb.ClosedLoop(Fast(), controller=law, reference=wb.Step("x", "m", 1.0)).digital(0.1)
    one = wb.simulate(computer.step(1), until=0.5)
    assert re.search(r"step of 100 ms is beyond its stability limit of 13\.9 ms", repr(one))  # 2.785 / 200
    assert wb.simulate(computer, until=0.5).warnings == ()
    assert wb.simulate(computer.step(), until=0.5).warnings == ()


def test_a_run_whose_state_only_a_longer_step_loses_says_that_half_the_step_does_not():
    t_end, rate = 2.0, 10.0
    states = wb.layout(x=("1", 1.0))
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX(0, 1)
    cubic = wb.Ode("cubic", states, wb.layout(), wb.layout(e="1"), t, x, p, -rate * x**3, x)
    runs = wb.simulate(wb.rk4(cubic, 0.4), until=t_end)
    assert runs.has_diverged[0]
    assert "the divergence comes, goes or moves" in repr(runs)
    assert wb.simulate(cubic, until=t_end)["x"][0, -1] == pytest.approx(1 / np.sqrt(1 + 2 * rate * t_end), rel=1e-3)


def test_an_escape_in_finite_time_is_a_flagged_run_and_no_error():
    runs = wb.simulate(explosion(), until=2.0)
    assert runs.diverged_at[0] == pytest.approx(1.0, abs=2e-3 * 2.0)  # the tolerance, of the horizon
    assert "1 diverged" in repr(runs)


def test_a_picture_of_a_diverged_run_marks_it_and_keeps_the_whole_horizon():
    figure = lost_runs().plot()
    for ax in figure.axes:
        assert ax.get_xlim() == (0.0, 4.0)
        assert any(line.get_marker() == "X" for line in ax.lines)
        assert np.abs(ax.get_ylim()).max() < 20.0  # where it begins, and ten times that
    title = figure.axes[0].get_title(loc="left")
    at = lost_runs().diverged_at[0]
    assert f"The run diverged at {at:.4g} s in 'x'" in title


def test_a_calm_signal_of_a_diverged_run_is_drawn_to_its_end():
    runs = wb.simulate(wb.rk4(wb.open_loop(Runaway()), 1e-3), until=2.0)
    ax = runs.plot("x").axes[0]
    assert ax.get_xlim() == (0.0, 2.0)
    cross = next(line for line in ax.lines if line.get_marker() == "X")
    assert cross.get_xdata()[0] == pytest.approx(0.5, abs=0.01)
    assert "'y'" in ax.get_title(loc="left")


def test_tables_and_displays_of_diverged_runs_have_the_time_and_the_state():
    runs = lost_runs()
    at = f"{runs.diverged_at[0]:.4g}"
    frame = runs.to_frame()
    assert (frame["diverged at [s]"] == runs.diverged_at[0]).all()
    assert f"diverged at {at} s in 'x'" in frame.attrs["warnings"][0]
    assert f"diverged at {at} s in &#x27;x&#x27;" in runs._repr_html_()
    assert "diverged at [s]" not in wb.simulate(decay(), until=1.0).to_frame()


def test_outcomes_measurements_and_pages_of_diverged_runs_say_so():
    loop = wb.ClosedLoop(Escape(), controller=Idle())
    (outcome,) = case_runs.run(loop_study(loop, 4.0, 1e-3)).outcomes
    for view in (repr(outcome), outcome._repr_html_(), repr(outcome.measurement), outcome.measurement._repr_html_()):
        assert re.search(r"the run diverged at 1\.0\d* s in", view)
    assert re.search(r"At the baseline, the run diverged at 1\.0\d* s in", words(wb.live(loop, until=4.0, h=1e-3)))


@pytest.mark.parametrize("closed", ["in continuous time", "by a computer"])
def test_the_picture_of_a_regulator_shows_its_plant_and_its_command(closed):
    plant = wb.CartPole(phi=0.1)
    observer = wb.LinearObserver(plant, np.ones((4, 2)))
    loop = wb.ClosedLoop(plant, observer, wb.StateFeedback.of(plant, [[-70.0, -38.0, 105.0, 21.0]]))
    runs = wb.simulate(loop if closed == "in continuous time" else loop.digital(0.01), until=0.2)
    assert [ax.get_ylabel() for ax in runs.plot().axes] == ["x [m]", "phi [rad]", "F_applied [N]"]


def test_what_follows_a_reference_is_shown_beside_it_and_alone():
    figure = wb.simulate(first_loop(), until=0.5).plot()
    assert [ax.get_ylabel() for ax in figure.axes] == ["omega [rad/s]", "v_applied [V]"]
    assert {line.get_label() for line in figure.axes[0].lines} >= {"reference"}


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (
            lambda: wb.simulate("loop", until=1.0),
            "`simulate(step=...)` must be a `StepMap`, an `Ode`, a `SampledSystem`, or a loop",
        ),
        (
            lambda: wb.simulate(decay(), until=1.0, every=0.3),
            "`simulate(until=...)` must be a multiple of `every`, 0.3 s",
        ),
        (lambda: wb.simulate(decay(), until=1.0, tolerance=0.0), "`simulate(tolerance=...)` must be a positive"),
        (lambda: wb.simulate(first_loop().digital(0.3), until=1.0), "a multiple of the sampling period 0.3 s"),
        (lambda: wb.simulate(decay(), until=1.0, tolerance=1e-30), "No step `h` keeps the tolerance of 1e-30"),
    ],
)
def test_what_cannot_be_run_is_refused_in_the_name_of_simulate(call, says):
    with pytest.raises(ValueError, match=re.escape(says)):
        call()


@pytest.mark.heavy
def test_a_page_of_runs_at_a_chosen_step_has_that_step_or_half_of_an_odd_one():
    assert wb.simulate(first_loop(), until=0.5).live().text.startswith("<!DOCTYPE html>")
    odd = wb.simulate(smooth_loop(), until=0.3, every=0.1, tolerance=0.05)  # 102 steps at most
    assert odd.live().text.startswith("<!DOCTYPE html>")
    third = wb.simulate(smooth_loop(), until=0.5, every=0.1, tolerance=0.5)
    assert (third.t[-1] / third.page_step) % 2 == pytest.approx(0, abs=1e-9)
