"""How long a step may be."""

import numpy as np
import pytest
from equations import decay, oscillator

from workbench.core import rk4
from workbench.simulate import simulate, step_limit
from workbench.simulate.schedule import longest_steps

RK4 = (1 / 24, 1 / 6, 1 / 2, 1.0, 1.0)


def test_the_limit_of_a_real_mode_is_the_known_end_of_the_stability_interval():
    # Hairer and Wanner (1996), Solving Ordinary Differential Equations II, section IV.2: 2.785
    assert longest_steps(np.array([-1.0 + 0j]), RK4)[0] == pytest.approx(2.785, abs=2e-3)


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
    assert limit.checked == 50
