"""The bounds of states over all steps of a run, whichever of them are kept."""

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from workbench.core import Entry, Layout
from workbench.core.numbers import Bounds
from workbench.engine.state_bounds import StateExtremes

PERIOD = 0.1


@wb.block
class Spiking(wb.Controller):
    """v = 0; its memory is `height` at one instant alone, and zero at all others."""

    height: float = wb.parameter(default=3.0, unit="1")
    at: float = wb.parameter(default=0.3, unit="s")

    reads = wb.layout(omega="rad/s")
    drives = wb.layout(v="V")

    @property
    def memory(self):
        return Layout((Entry("spike", np.zeros(2), "1", Bounds(-1.0, 2.0)),))

    def command(self, t, z, est, ref):
        return {"v": ca.SX(0.0)}

    def update(self, t, z, est, ref):
        spike = ca.if_else(ca.fabs(t - self.at) < 1e-6, self.height, 0.0)
        return {"spike": ca.vertcat(0.0, spike)}


LOOP = wb.ClosedLoop(wb.DCMotor(), controller=Spiking())
COMPUTER = LOOP.digital(PERIOD)


def rows(heights, at=0.3):
    return COMPUTER.parameters.pack(
        {"controller.height": np.array(heights), "controller.at": np.full(len(heights), at)}
    )


@pytest.mark.parametrize("every", [0.1, 0.2, 0.5, 1.0])
@pytest.mark.parametrize(("height", "bound"), [(3.0, "2"), (-1.5, "-1")])
def test_a_state_beyond_its_bound_at_one_step_is_seen_at_any_spacing_of_kept_times(height, bound, every):
    run = wb.simulate(COMPUTER.step(1), rows([height]), until=1.0, every=every)
    assert run.x.shape[2] == COMPUTER.states.size  # the watch is no state of the run
    sentence = f"'controller.spike' of 'loop' passes its bound of {bound} at 0.4 s, and reaches {height:.3g}"
    assert run.warnings[0] == sentence
    assert sentence in repr(run)


@pytest.mark.parametrize("at", [0.0, 0.9])
def test_the_first_and_the_last_step_are_watched(at):
    run = wb.simulate(COMPUTER.step(1), rows([3.0], at), until=1.0, every=1.0)
    assert f"at {at + PERIOD:.4g} s" in run.warnings[0]


def test_a_run_within_its_bounds_is_not_flagged():
    run = wb.simulate(COMPUTER.step(1), rows([2.0, -1.0]), until=1.0, every=0.5)
    assert run.excursions == ()


def test_a_state_that_is_no_number_passes_no_bound_and_hides_none():
    heights = [np.nan, 3.0]
    x = np.zeros((2, 4, COMPUTER.states.size))
    x[:, 2, COMPUTER.states.slice("controller.spike").start] = heights
    extremes = StateExtremes.of_kept(COMPUTER.step(1), 0, 5, x)
    assert extremes.runs_beyond.tolist() == [False, True]
    assert extremes.beyond.tolist() == [[-1.0], [10.0]]
    assert extremes.high.tolist() == [[0.0], [3.0]]


def test_watching_bounds_changes_no_bit_of_a_run():
    p = rows([3.0])
    every, some = (wb.simulate(COMPUTER.step(1), p, until=1.0, every=d).x for d in (0.1, 0.5))
    np.testing.assert_array_equal(every[:, ::5], some)


def test_measure_tells_of_the_runs_that_pass_a_bound_and_keeps_no_more_states():
    heights = [0.5, 3.0, 1.0, -2.0, 4.0]
    found = wb.measure(COMPUTER, [wb.effort("omega")], rows(heights), until=1.0, every=1.0, h=PERIOD)
    assert found.trajectories.x.shape[1] == 2
    assert found.extremes.runs_beyond.tolist() == [False, True, False, True, True]
    assert found.excursions == (
        "'controller.spike' of 'loop' passes its bound of 2 in 3 of 5 runs (1, 3, 4), in run 1 first, at 0.4 s, and "
        "reaches 4",
    )
    assert found.excursions == found.trajectories.excursions
    assert set(found.excursions) <= set(found.warnings)
    assert found.only(np.array([0, 2])).excursions == ()


def test_equations_without_bounds_have_no_watch():
    motor = wb.open_loop(wb.DCMotor())
    found = wb.measure(motor, [wb.effort("omega")], until=0.1, h=0.01)
    assert found.excursions == ()
    assert found.trajectories.step.states.size == motor.states.size + 1  # the integral of the metric
