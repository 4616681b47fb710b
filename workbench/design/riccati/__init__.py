"""Algebraic Riccati and Lyapunov equations, and the gains that come from them, each with its certificate."""

from workbench.design.riccati.answers import Lqg, Lyapunov, Riccati
from workbench.design.riccati.continuous import care
from workbench.design.riccati.discrete import dare
from workbench.design.riccati.lyapunov import discrete_lyapunov, lyapunov

__all__ = [
    "Lqg",
    "Lyapunov",
    "Riccati",
    "care",
    "dare",
    "discrete_lyapunov",
    "lyapunov",
]
