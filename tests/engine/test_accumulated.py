"""The step of an equation with its metrics beside it."""

import casadi as ca
import numpy as np
import pytest

from tests.support.equations import decay
from workbench.core import SampledSystem
from workbench.engine import simulate
from workbench.engine.metrics import ise, sampled_rmse, step_with_metrics, total_variation
from workbench.engine.metrics.accumulators import final_values
from workbench.engine.metrics.measured_equation import common_grid

TIME = ca.SX.sym("time")


def test_an_integral_has_the_order_of_the_method_that_carries_it():
    a, T = 3.0, 2.0
    exact = (1 - np.exp(-2 * a * T)) / (2 * a)
    errors = []
    for h in (0.05, 0.025):
        runs = simulate(step_with_metrics(decay(a), (ise(),), h), until=T, every=T)
        errors.append(abs(final_values(runs, (ise(),))["ISE"][0, 0] - exact))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.3)


def test_a_sampled_loop_has_its_own_substeps():
    k, ode = ca.SX.sym("k"), decay()
    sampled = SampledSystem(ode, 0.1, k, ca.SX(0, 1), ode.x)
    assert step_with_metrics(sampled, (ise(),), 0.05).substeps == 2


@pytest.mark.parametrize(
    ("samples", "times", "grid"),
    [((), (1.0,), None), ((1e-3,), (50.0,), 1e-3), ((4e-3, 6e-3), (12.0,), 2e-3), ((0.3,), (1.0,), 0.1)],
)
def test_the_grid_of_several_metrics_is_their_longest_common_divisor(samples, times, grid):
    metrics = [sampled_rmse(sample, name=f"{sample}") for sample in samples]
    assert common_grid([ise(), *metrics], *times) == (grid and pytest.approx(grid, rel=1e-12))


def test_sample_times_without_a_common_divisor_are_refused():
    with pytest.raises(ValueError, match=r"that one step divides; got 0.1 s, 0.314159 s"):
        common_grid([total_variation(0.1)], np.pi / 10)
