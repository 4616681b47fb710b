"""Algebraic Riccati and Lyapunov equations, and the gains that come from them, each with its certificate.

The room knows matrices and linear systems, and no plant. Read `regulators.py` first (CARE, DARE, LQR and the Kalman
filter), then `stabilisation.py`: first answers, refined by Newton's method and then judged.
"""

from workbench.design.riccati.lqg import Lqg, lqg, steady_kalman
from workbench.design.riccati.lyapunov_equation import Lyapunov, discrete_lyapunov, lyapunov
from workbench.design.riccati.regulators import care, dare, lqe, lqr
from workbench.design.riccati.stabilisation import Riccati

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
