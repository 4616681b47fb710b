"""Algebraic Riccati and Lyapunov equations, and the gains that come from them, each with its certificate.

This package takes matrices and linear systems; it knows no plant. Read `regulators.py` and `kalman_gains.py` first,
then `stabilising_solution.py` (CARE and DARE): a first solution, refined by Newton's method and then judged.

Examples
--------
>>> wb.riccati.care(np.zeros((1, 1)), np.eye(1), np.eye(1), np.eye(1)).X
array([[1.]])
"""

from workbench.design.riccati.kalman_gains import lqe, steady_kalman
from workbench.design.riccati.lyapunov_equation import Lyapunov, discrete_lyapunov, lyapunov
from workbench.design.riccati.regulators import Lqg, lqg, lqr
from workbench.design.riccati.stabilising_solution import Riccati, care, dare

__all__ = [
    "Lqg",
    "Lyapunov",
    "Riccati",
    "care",
    "dare",
    "discrete_lyapunov",
    "lqe",
    "lqg",
    "lqr",
    "lyapunov",
    "steady_kalman",
]
