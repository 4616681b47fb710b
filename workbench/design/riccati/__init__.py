"""Algebraic Riccati and Lyapunov equations, and the gains that come from them, each with its certificate.

care, dare, lyapunov     the equations             given, units          what is solved, and in which units
lqr, lqe, lqg            the gains                 candidates, newton    first answers, and good ones
conditioning, diagnosis  what can be trusted, and why not
"""

from workbench.design.riccati.answers import Lqg, Lyapunov, Riccati
from workbench.design.riccati.continuous import care
from workbench.design.riccati.discrete import dare
from workbench.design.riccati.gaussian import lqg
from workbench.design.riccati.kalman import steady_kalman
from workbench.design.riccati.lyapunov import discrete_lyapunov, lyapunov
from workbench.design.riccati.regulators import lqe, lqr

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
