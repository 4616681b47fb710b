"""The search for a minimum: what ends it without an answer."""

import numpy as np

from workbench.identification.estimation.least_squares import least_squares


def _without_slopes_beyond(z_end):
    """Residuals z - 3 whose derivatives are no numbers beyond z_end."""

    def linearize(z):
        return z - 3.0, np.array([[1.0 if z[0] <= z_end else np.inf]])

    return (lambda z: z - 3.0), linearize


def test_a_search_that_arrives_where_there_are_no_derivatives_has_no_minimum():
    ends = (np.array([-9.0]), np.array([9.0]))
    assert least_squares(*_without_slopes_beyond(1.5), np.array([1.0]), *ends) is None
    minimum = least_squares(*_without_slopes_beyond(9.0), np.array([1.0]), *ends)
    assert minimum is not None
    assert abs(minimum.z[0] - 3.0) < 1e-9  # the sum of squares is flat to rounding within 1e-8 of its minimum
