"""The stable part of a system with integrators and unstable modes, and the reduction of such a system."""

import control
import numpy as np
import pytest

import workbench as wb
from workbench.design.matrices import DesignError


def mixed_system(dt=0):
    """Five lags, an oscillator, an integrator and an unstable mode in states that hide them."""
    rng = np.random.default_rng(4)
    modes = np.diag([-1.0, -2.0, -3.0, -20.0, -30.0, 0.0, 0.0, 0.0, 0.5])
    modes[5:7, 5:7] = [[0.0, 3.0], [-3.0, 0.0]]
    if dt:
        modes = np.diag([0.9, 0.5, -0.3, 0.1, 0.05, 1.0, -1.0, 1.2, 1.5])
    T = np.linalg.qr(rng.normal(size=(9, 9)))[0] @ np.diag(np.linspace(1, 2, 9))
    B, C = rng.normal(size=(9, 2)), rng.normal(size=(2, 9))
    return control.ss(T @ modes @ np.linalg.inv(T), T @ B, C @ np.linalg.inv(T), [[0.1, 0], [0, 0]], dt)


@pytest.mark.parametrize("dt", [0, 0.5])
def test_both_parts_add_up_to_the_system_and_have_its_poles(dt):
    system = mixed_system(dt)
    parts = wb.reduction.stable_part(system)
    assert (parts.stable.nstates, parts.rest.nstates) == (5, 4)
    for s in (0.3j, 1.7 + 0.2j, -0.8 + 2j):
        assert parts.stable(s) + parts.rest(s) == pytest.approx(system(s), rel=1e-10)
        assert parts.join(parts.stable)(s) == pytest.approx(system(s), rel=1e-10)
    found = np.concatenate([parts.stable.poles(), parts.rest.poles()])
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(system.poles()), abs=1e-9)


def test_the_error_of_the_reduced_sum_is_within_the_bound_of_the_stable_part():
    system = mixed_system()
    parts = wb.reduction.stable_part(system)
    model = wb.reduction.balanced_truncation(parts.stable, 3)
    whole = parts.join(model.system)
    assert whole.nstates == 7
    assert model.within_bound
    gains = [np.linalg.norm(system(1j * w) - whole(1j * w), 2) for w in np.geomspace(1e-2, 1e3, 101)]
    assert max(gains) <= model.error.gain.high * (1 + 1e-9)
    assert max(gains) >= 0.5 * model.error.gain.low


def test_a_stable_system_and_one_without_stable_modes_have_an_empty_part():
    lag, integrator = control.ss(-1.0, 1.0, 2.0, 3.0), control.ss(0.0, 1.0, 1.0, 0.0)
    parts = wb.reduction.stable_part(lag)
    assert (parts.rest.nstates, parts.join(parts.stable)(1j)) == (0, lag(1j))
    assert wb.reduction.stable_part(integrator).stable.nstates == 0


def test_modes_that_rounding_cannot_part_and_models_of_other_shape_are_refused():
    near = control.ss([[-1e-7, 1e6], [0.0, 0.0]], [[0.0], [1.0]], [[1.0, 0.0]], 0.0)
    assert wb.reduction.stable_part(near).stable.nstates == 0  # both modes lie at the limit, relative to A
    tight = control.ss([[-2e-8, 1.0], [0.0, 0.0]], [[0.0], [1.0]], [[1.0, 0.0]], 0.0)
    with pytest.raises(DesignError, match="rounding decides which modes"):
        wb.reduction.stable_part(tight)
    parts = wb.reduction.stable_part(mixed_system())
    with pytest.raises(ValueError, match=r"the model must have 2 inputs, 2 outputs and period 0; got 1, 1 and 0"):
        parts.join(control.ss(-1.0, 1.0, 1.0, 0.0))
