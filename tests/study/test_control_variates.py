"""Sensitivity indices with a control variate: narrower intervals that hold the truth as often as they say."""

import numpy as np
import pytest

from tests.support.cases import heavy_but
from tests.support.known_indices import KNOWN
from tests.support.sensitivity_functions import over
from workbench.study.uncertainty import SobolDesign, sobol

A = np.array([0.0, 1.0, 4.5, 9.0, 99.0])
C = np.array([1.0, -2.0, 3.0, 0.0])
SQUARES = C**2 / (C @ C)


@pytest.mark.parametrize("control", heavy_but([False, True], False))
def test_the_intervals_of_all_pairs_hold_together(control):
    # a sum of 12 terms, the first of them bent: all of the 66 S2 are 0, and by themselves some intervals would miss
    held = []
    for seed in range(40):
        design = SobolDesign(12, 64, True, seed=seed)
        u = design.points()
        found = sobol(design, u @ np.arange(1.0, 13.0) + np.exp(3 * u[:, 0]), ["y"], control_variate=control)["y"]
        assert found.S2 is not None
        assert found.remarks == ()
        held.append(bool((np.abs(found.S2.value) <= found.S2.half).all()))
    # of 40 at 95 %, 36 or more with a probability of 95 %; Bonferroni's are wider than they need be
    assert sum(held) >= 36


def test_of_a_quadratic_function_a_control_variate_leaves_nothing_to_estimate():
    design = SobolDesign(3, 64, True)
    x, y, z = design.points().T - 0.5
    found = sobol(design, 2 * x + 3 * y + 6 * y * z + 1.0 * x**2, ["y"], control_variate=True)["y"]
    # variances of the line, the parabola and the product: 1/12, 1/180 and 1/144
    alone, pair = np.array([4 / 12 + 1 / 180, 9 / 12, 0.0]), 36 / 144
    total = alone + [0, pair, pair]
    whole = alone.sum() + pair
    np.testing.assert_allclose(found.S1.value, alone / whole, rtol=0, atol=1e-12)  # rounding
    np.testing.assert_allclose(found.ST.value, total / whole, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.S2.value, [0, 0, pair / whole], rtol=0, atol=1e-12)
    assert max(part.half.max() for part in (found.S1, found.ST, found.S2)) < 1e-11


@pytest.mark.parametrize("second_order", heavy_but([False, True], False))
def test_intervals_with_a_control_variate_hold_the_truth_as_often_as_they_say(second_order):
    d, function, numbers, exact = KNOWN[0]  # far from quadratic: what is left is most of it
    held = []
    for seed in range(60):
        design = SobolDesign(d, 512, second_order, seed)
        found = sobol(design, over(design, function, *numbers), ["y"], control_variate=True)["y"]
        for order in ("S1", "ST"):
            one, want = getattr(found, order), getattr(exact, order)
            held += list((np.abs(one.value - want) <= one.half)[want > 0.01])
    # as those without one: what the workbench promises at 512, with the scatter of this share
    assert 0.90 <= np.mean(held) <= 0.995


@pytest.mark.parametrize("second_order", [False, True])
def test_a_control_variate_narrows_the_intervals_of_what_is_nearly_quadratic(second_order):
    design = SobolDesign(12, 64, second_order)
    u = design.points()
    y = u @ np.arange(1.0, 13.0) + np.sin(2 * u[:, 0] * u[:, 1])
    plain, found = sobol(design, y), sobol(design, y, control_variate=True)
    # the polynomial leaves less than a hundredth of the standard deviation
    assert found.ST.half.max() < 0.1 * plain.ST.half.max()
    assert found.S1.half.max() < 0.1 * plain.S1.half.max()


def test_a_polynomial_with_more_coefficients_than_the_runs_can_bear_is_refused():
    design = SobolDesign(12, 8)
    with pytest.raises(ValueError, match=r"at least 4 runs for each of 91 coefficients of its polynomial; got 112"):
        sobol(design, design.points()[:, 0], control_variate=True)
