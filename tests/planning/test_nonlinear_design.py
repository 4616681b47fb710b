"""The design of a nonlinear predictive law: the law behind the horizon, soft limits by name, and bad arguments."""

import numpy as np
import pytest

import workbench as wb
from workbench.design.matrices import DesignError


@wb.block
class Mass(wb.Plant):
    """A mass that a force moves, of which position and kinetic energy are measured."""

    x: float = wb.initial(default=0.0, unit="m")
    v: float = wb.initial(default=0.0, unit="m/s")

    inputs = wb.layout(F="N")
    outputs = wb.layout(x="m", energy="J")

    def measure(self, t, x):
        return {"x": x.x, "energy": x.v**2 / 2}

    def rate(self, t, x, u):
        return {"x": x.v, "v": u.F}


def mass():
    return wb.linearize(wb.open_loop(Mass()), t=0.0, x=np.zeros(2), at_rest=True)


def test_the_cost_behind_the_horizon_solves_its_riccati_equation():
    design = wb.nonlinear_predictive_design(mass(), 0.1, np.eye(2), [[0.1]], 10, steps=3)
    A, B, P, R = design.A, design.B, design.P, design.R
    G = B.T @ P @ A
    residual = np.eye(2) + A.T @ P @ A - G.T @ np.linalg.solve(R + B.T @ P @ B, G) - P
    assert np.abs(residual).max() < 1e-12 * np.abs(P).max()
    np.testing.assert_allclose(np.linalg.solve(R + B.T @ P @ B, G), design.K, rtol=0, atol=1e-12)
    np.testing.assert_allclose(A, [[1.0, 0.1], [0.0, 1.0]], rtol=0, atol=1e-15)  # the steps of a mass are exact
    np.testing.assert_allclose(B, [[0.005], [0.1]], rtol=0, atol=1e-15)


def test_a_soft_limit_of_an_output_holds_along_a_run():
    peaks = []
    for weight in (None, 1e4):
        limits = {"F": (-5.0, 5.0)} | ({} if weight is None else {"energy": (-1.0, 0.5)})
        design = wb.nonlinear_predictive_design(
            mass(), 0.1, np.diag([10.0, 0.1]), [[0.1]], 20, limits=limits, soft_weight=weight, sweeps=10, iterations=5
        )
        law = wb.NonlinearPredictive.of(Mass(), design, follow=("x",))
        loop = wb.ClosedLoop(Mass(), observer=wb.FullState.of(Mass()), controller=law, reference=wb.Step("x", "m", 3.0))
        run = wb.simulate(loop.digital(0.1).step(1), until=6.0)
        peaks.append(run["energy"].max())
        assert abs(run["x"][0, -1, 0] - 3.0) < 0.01
    assert peaks[0] > 2.0
    assert peaks[1] < 0.505  # the weight is finite


def test_soft_weights_come_by_name_and_are_all_there():
    limits = {"v": (-1.0, 1.0), "energy": (-1.0, 0.5)}
    design = wb.nonlinear_predictive_design(
        mass(), 0.1, np.eye(2), [[0.1]], 5, limits=limits, soft_weight={"v": 10.0, "energy": 20.0}
    )
    assert design.limits.row_names == ("v", "energy")
    assert design.limits.row_weight.tolist() == [10.0, 20.0]
    assert repr(design).startswith("<NonlinearPredictiveDesign: 5 stages of 0.1 s, limits on none, soft on v, energy,")
    with pytest.raises(ValueError, match="must have a weight for the limit of 'energy'"):
        wb.nonlinear_predictive_design(mass(), 0.1, np.eye(2), [[0.1]], 5, limits=limits, soft_weight={"v": 10.0})


def test_other_systems_are_refused():
    with pytest.raises(DesignError, match="must be in continuous time, as the law integrates the plant itself"):
        wb.nonlinear_predictive_design(wb.c2d(mass(), 0.1), 0.1, np.eye(2), [[0.1]], 5)
    with pytest.raises(ValueError, match="must be a linear plant, as `linearize` returns it"):
        wb.nonlinear_predictive_design(np.eye(2), 0.1, np.eye(2), [[0.1]], 5)


def test_a_given_weight_of_the_end_has_the_gain_of_its_last_stage():
    design = wb.nonlinear_predictive_design(mass(), 0.1, np.eye(2), [[0.1]], 5, P=2 * np.eye(2))
    B = np.array([[0.005], [0.1]])
    gain = 2 * B.T @ np.array([[1.0, 0.1], [0.0, 1.0]]) / (0.1 + 2 * float((B.T @ B)[0, 0]))
    np.testing.assert_allclose(design.K, gain, rtol=0, atol=1e-14)
