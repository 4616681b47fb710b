"""Loops tuned for limits and goals, against closed forms, exhaustive searches and differences."""

from __future__ import annotations

import control
import numpy as np
import pytest

import workbench as wb
from workbench.design.linear_loop import linear_loop
from workbench.design.matrices import DesignError
from workbench.design.structured_tuning import LoopGoal
from workbench.design.structured_tuning.loop_goals import LoopAnswer, loop_pieces
from workbench.design.structured_tuning.loop_jets import LoopJets
from workbench.study.loop_tuning import RunGoal
from workbench.study.specifications.loop_systems import LoopSystems, noise_signals
from workbench.study.specifications.point_figures import point_figure

MOTOR = wb.DCMotor()
LAW = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0)
LOOP = wb.ClosedLoop(MOTOR, controller=LAW, reference=wb.Step("omega", "rad/s", 1.0))
KNOBS = (
    wb.Knob("Kp", "controller.Kp", 1.0, 1e3, log=True),
    wb.Knob("Ki", "controller.Ki", 1.0, 1e4, log=True),
)
LOAD = LoopGoal("gain", inputs=("v_load",), outputs=("omega",))
FIGURES = (
    "Ms", "Mt", "bandwidth", "damping", "decay", "gain_margin", "phase_margin", "delay_margin", "disk_margin",
    "noise_gain", "overshoot", "settling_time", "rise_time",
)  # fmt: skip


def jets_of(loop, paths):
    linear = linear_loop(loop)
    places = tuple(tuple(linear.parameters.indices(path)) for path in paths)
    numbers = np.array([linear.p0[own[0]] for own in places])
    return linear, LoopJets(linear, places, tuple((1.0,) for _ in places), numbers / 2, 2 * numbers), numbers


@pytest.mark.parametrize("loop", [LOOP, wb.DigitalLoop(LOOP, 0.01)], ids=["continuous", "in a computer"])
def test_derivatives_of_both_matrices_are_those_of_the_linear_loop(loop):
    linear, jets, numbers = jets_of(loop, ("controller.Kp", "plant.J"))
    jet = jets(numbers)
    for k, path in enumerate(("controller.Kp", "plant.J")):
        shape, step = linear.parameters[path].shape, 1e-4 * numbers[k]
        ends = [linear_loop(loop, values={path: np.full(shape, numbers[k] + sign * step)}) for sign in (1, -1)]
        for own, of in ((jet.closed_loop, "closed_model"), (jet.cut_loop, "open_model")):
            matrices = []
            for end in ends:
                m = getattr(end.models, of)
                matrices.append(np.block([[m.A[0], m.B[0]], [m.Cy[0], m.D[0]]]))
            difference = (matrices[0] - matrices[1]) / (2 * step)
            np.testing.assert_allclose(own.slopes[k], difference, atol=1e-6 * np.abs(difference).max())


@pytest.mark.parametrize("loop", [LOOP, wb.DigitalLoop(LOOP, 0.01)], ids=["continuous", "in a computer"])
def test_each_figure_is_the_certified_one_and_its_gradient_a_difference(loop):
    linear, jets, numbers = jets_of(loop, ("controller.Kp", "controller.Ki"))
    systems = LoopSystems.of("test", linear, None, None)
    at = LoopAnswer(systems.answer, *noise_signals(linear))
    for name in FIGURES:
        certified = point_figure(name, systems).value
        if not np.isfinite(certified.value):  # no phase crossover
            continue
        goal = LoopGoal(name)
        ends = (1.0, np.inf) if goal.grows else (-np.inf, 1.0)

        def top(values, goal=goal, ends=ends):
            return max(loop_pieces(jets(values), goal, ends, at, 0.0), key=lambda one: one.value)

        piece = top(numbers)
        ours = 11 * piece.value + 1 if name == "overshoot" else np.exp(-piece.value if goal.grows else piece.value)
        sampled = linear.period is not None and name in ("settling_time", "rise_time")  # between samples
        assert ours == pytest.approx(certified.value, rel=0.1 if sampled else 1e-3), name
        steps = 1e-5 * np.diag(numbers)
        slopes = [(top(numbers + s).value - top(numbers - s).value) / (2 * np.abs(s).max()) for s in steps]
        rel = 0.03 if name in ("overshoot", "settling_time", "rise_time") else 1e-3  # the samples move with the poles
        np.testing.assert_allclose(piece.gradient, slopes, rtol=rel, atol=rel * np.abs(slopes).max(), err_msg=name)


def test_two_limits_are_reached_and_the_load_is_rejected_best():
    tuned = wb.tune(LOOP, KNOBS, wb.Specification(Ms=1.4, decay=2.5), (LOAD,), starts=1)
    assert tuned.holds
    assert tuned.active_goals == ("Ms <= 1.4", "decay >= 2.5 1/s", LOAD.words)
    # an exhaustive search over the numbers, through linear loops that share no code with the search
    Kp, Ki = (one.ravel() for one in np.meshgrid(np.linspace(20, 60, 81), np.linspace(40, 160, 81)))
    rows = linear_loop(LOOP).rows({"controller.Kp": Kp[:, np.newaxis], "controller.Ki": Ki[:, np.newaxis]})
    load = np.abs(rows.response(np.geomspace(0.1, 100, 100), "closed", "v_load", "omega").values).max(axis=(1, 2, 3))
    allowed = rows.stable & (rows.margins.Ms[:, 0] <= 1.4) & (rows.poles.real.max(axis=1) <= -2.5)
    reached = tuned.goals[2].value.value
    assert reached <= load[allowed].min() * (1 + 1e-3)  # the peak of a load lies between two frequencies
    assert reached == pytest.approx(load[allowed].min(), rel=0.03)  # the grid is that coarse
    assert tuned.loop.controller.Kp[0] == pytest.approx(tuned.values["Kp"], rel=1e-12)
    assert tuned.equations.parameters["controller.Ki"].default[0] == pytest.approx(tuned.values["Ki"], rel=1e-12)


def test_several_plants_are_served_by_one_setting():
    light = {"plant.J": 0.3 * float(MOTOR.J)}
    tuned = wb.tune(LOOP, KNOBS, wb.Specification(phase_margin=60.0), (LOAD,), plants=(light,), starts=1)
    assert tuned.holds
    assert len(tuned.verdicts) == 2
    margins = [one.margins()["v"].phase_margin.value for one in tuned.linear]
    assert min(margins) == pytest.approx(60.0, rel=1e-4)
    assert min(margins) >= 60.0
    assert tuned.goals[0].plant == int(np.argmin(margins))


def test_without_a_soft_goal_the_limits_have_as_much_room_as_possible():
    tuned = wb.tune(LOOP, KNOBS, wb.Specification(Ms=2.0, settling_time=1.5), starts=1)
    assert tuned.holds
    room = [np.log(limit / one.value.value) for limit, one in zip((2.0, 1.5), tuned.goals, strict=True)]
    assert room[0] > 0.05
    assert room[1] > 0.05


def test_a_goal_of_a_run_is_made_small_in_the_loop_itself():
    goal = RunGoal(wb.rmse(), until=1.0, h=5e-3)
    knobs = (wb.Knob("Kp", "controller.Kp", 20.0, 100.0),)
    tuned = wb.tune(LOOP, knobs, wb.Specification(Ms=1.75), (goal,), starts=1)
    grid = np.linspace(20, 100, 41)
    shape = LOOP.ode("loop").parameters.default
    p = np.tile(shape, (len(grid), 1))
    p[:, LOOP.ode("loop").parameters.indices("controller.Kp")] = grid[:, np.newaxis]
    values = goal.values(LOOP.ode("loop"), p)
    linear = linear_loop(LOOP).rows({"controller.Kp": grid[:, np.newaxis]})
    best = values[linear.margins.Ms[:, 0] <= 1.75].min()
    assert tuned.goals[1].estimate <= best * (1 + 1e-6)
    assert tuned.holds


def test_a_loop_of_a_computer_is_tuned_too():
    tuned = wb.tune(wb.DigitalLoop(LOOP, 0.02), KNOBS, wb.Specification(Ms=1.6), (LOAD,), starts=1)
    assert tuned.holds
    assert tuned.linear[0].margins()["v"].Ms.gain.value == pytest.approx(1.6, rel=1e-4)
    assert tuned.loop.loop.controller.Kp[0] == pytest.approx(tuned.values["Kp"], rel=1e-12)


def test_limits_in_conflict_are_named():
    with pytest.raises(DesignError, match=r"all limits: Ms <= 1\.1 and rise_time <= 0\.1 s are passed by .* %"):
        wb.tune(LOOP, KNOBS, wb.Specification(Ms=1.1, rise_time=0.1), starts=1)


def test_a_structure_that_nothing_stabilises_is_refused_with_the_least_growth():
    plant = wb.LinearPlant(control.ss([[2.0]], [[1.0]], [[1.0]], 0, inputs=["u"], outputs=["y"], name="fast"))
    law = wb.PID(plant.outputs, plant.inputs, Kp=0.5)
    loop = wb.ClosedLoop(plant, controller=law, reference=wb.Step("y", "", 1.0))
    with pytest.raises(DesignError, match=r"the least growth of the slowest pole is 1 1/s"):
        wb.tune(loop, (wb.Knob("Kp", "controller.Kp", 0.1, 1.0),), wb.Specification(Ms=2.0), starts=2)


def test_a_knob_that_turns_nothing_is_refused_with_the_nearest_name():
    with pytest.raises(LookupError, match="Did you mean 'controller.Kp'"):
        wb.tune(LOOP, (wb.Knob("Kp", "controller.Kpp", 1.0, 2.0),), wb.Specification(Ms=2.0))
