"""How long a step may be."""

import numpy as np
import pytest

from tests.support.equations import decay, explosion, oscillator, root
from workbench.arms.laws import SlidingMode
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines
from workbench.core import rk4, with_quadrature
from workbench.engine import simulate, step_limit
from workbench.engine.metrics import effort, energy, measure, rmse
from workbench.engine.stability import longest_steps, modes_at

RK4 = (1 / 24, 1 / 6, 1 / 2, 1.0, 1.0)


def test_the_limit_of_a_real_mode_is_the_known_end_of_the_stability_interval():
    # Hairer and Wanner (1996), Solving Ordinary Differential Equations II, section IV.2: 2.785
    assert longest_steps(np.array([-1.0 + 0j]), RK4)[0] == pytest.approx(2.785, abs=1e-3)


def test_the_limit_of_a_nearly_undamped_mode_is_two_root_two():
    assert longest_steps(np.array([-1e-9 + 1j]), RK4)[0] == pytest.approx(2 * np.sqrt(2), abs=3e-3)


def test_a_growing_mode_sets_no_limit():
    assert np.isinf(longest_steps(np.array([0.5 + 1j, 0.0 + 0j]), RK4)).all()


@pytest.mark.parametrize(("share", "stays"), [(0.98, True), (1.02, False)])
def test_a_run_decays_within_the_limit_and_grows_beyond_it(share, stays):
    rate = 100.0
    h = share * 2.785 / rate
    runs = simulate(rk4(decay(rate), h), until=2000 * h)
    assert (abs(runs["x"][0, -1, 0]) < 1) == stays
    limit = step_limit(runs)
    assert limit.holds == stays
    assert limit.eigenvalue == pytest.approx(-rate)


def test_the_limit_says_how_many_states_it_looked_at():
    limit = step_limit(simulate(rk4(oscillator(), 0.01), until=10.0), points=50)
    assert limit.checked_states == 50


def test_a_state_without_a_finite_jacobian_is_not_counted_and_with_none_left_no_step_holds():
    limit = step_limit(simulate(rk4(root(), 0.1), until=1.0))
    assert limit.checked_states == 0
    assert np.isnan(limit.limit)
    assert not limit.holds


def test_a_run_that_diverges_has_the_limit_of_its_finite_part():
    limit = step_limit(simulate(rk4(explosion(), 1e-3), until=2.0))
    assert limit.checked_states > 0
    assert np.isinf(limit.limit)  # 2 x > 0: it only grows


def test_a_loop_whose_jacobian_overflows_as_it_diverges_is_a_flagged_row():
    loop = ClosedLoop(
        Manipulator(paper_arm(), q=[2.0, 1.0]),
        ArmFullState(2),
        SlidingMode(paper_arm(), [10.0, 10.0], [500.0, 500.0], 0.001),
        Sines("q", "rad", [1.0, 0.5], [1.0, 2.0]),
    )
    result = measure(loop.ode(), [effort(), energy(), rmse()], until=20.0, h=0.1)
    assert result.trajectories.has_diverged[0]
    assert all(np.isnan(score.value).all() for score in result.scores)
    assert not result.limit.holds


def test_the_modes_of_an_oscillator_are_its_frequency_and_an_integral_adds_none():
    ode = oscillator()
    ode = with_quadrature(ode, {"ise": ode.x[0] ** 2})
    modes = modes_at(ode, np.zeros(2), np.ones((2, 3)), np.array([[2.0], [5.0]]))
    np.testing.assert_allclose(np.sort_complex(modes), [[-2j, 2j], [-5j, 5j]], atol=1e-14)
