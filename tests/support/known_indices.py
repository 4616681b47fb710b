"""Functions whose sensitivity indices have closed forms."""

import numpy as np

from tests.support.sensitivity_functions import Exact, ishigami, ishigami_exact, linear, sobol_g, sobol_g_exact

A = np.array([0.0, 1.0, 4.5, 9.0, 99.0])
C = np.array([1.0, -2.0, 3.0, 0.0])
SQUARES = C**2 / (C @ C)
KNOWN = [
    (3, ishigami, (), ishigami_exact()),
    (5, sobol_g, (A,), sobol_g_exact(A)),
    (4, linear, (C,), Exact(SQUARES, SQUARES, {}, float(C @ C) / 12)),
]
