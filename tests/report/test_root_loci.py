"""Root loci of loops over any of their parameters."""

import numpy as np
import pytest

import workbench as wb
from tests.support.plotted_loops import CART
from workbench.report.table_text import plain


def cart_poles(m=1.0, c=0.4, k=2.0, g=1.0, T=0.2):
    """The roots of (m s^2 + c s + k) (T s + 1) + g."""
    return np.roots([m * T, m + c * T, c + k * T, k + g])


@pytest.mark.parametrize("draw", [wb.root_locus, lambda linear, path, at: linear.plot("root_locus", over={path: at})])
@pytest.mark.parametrize("path", ["plant.m", "controller.T", "controller.g"])
def test_a_root_locus_over_any_parameter_has_the_roots_of_its_polynomial(path, draw):
    values = np.linspace(0.1, 3.0, 30)
    figure = draw(CART, path, values).figure
    for value in values:
        ours = np.sort_complex([row[2] + 1j * row[3] for row in figure.numbers.rows if row[0] == value])
        np.testing.assert_allclose(ours, np.sort_complex(cart_poles(**{path[-1]: value})), atol=1e-9)


def test_a_root_locus_says_where_the_loop_loses_its_stability_and_has_a_dot_at_its_own_value():
    picture = CART.plot("root_locus", over={"controller.g": np.linspace(0.5, 10.0, 400)})
    m, c, k, T = 1.0, 0.4, 2.0, 0.2
    limit = (m + c * T) * (c + k * T) / (m * T) - k  # Hurwitz: a2 a1 = a3 a0
    assert f"at controller.g = {limit:.3g} N/m" in picture.caption
    assert any("controller.g = 1 N/m" in plain(mark.label) for mark in picture.figure.panels[0].series)


def test_values_without_a_rest_or_out_of_their_bounds_are_gaps_and_are_said():
    picture = CART.plot("root_locus", over={"plant.m": np.array([-1.0, 0.5, 1.0, 2.0])})
    assert "1 value has no poles; of the first, −1: 'plant.m' must be finite" in picture.caption
