"""Algebraic Riccati and Lyapunov equations, and the gains that come from them, each with its certificate."""

from workbench.design.riccati.answers import Lqg, Lyapunov, Riccati
from workbench.design.riccati.continuous import care, lyapunov
from workbench.design.riccati.discrete import dare, discrete_lyapunov
from workbench.design.riccati.regulators import lqe, lqg, lqr

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
]
