"""Riccati equations in time and along states, and their gains as series."""

from workbench.design.riccati_flow.along_states import StateDependent, sdre
from workbench.design.riccati_flow.equations import fpre, rde
from workbench.design.riccati_flow.result import RiccatiFlow
from workbench.design.riccati_flow.series import Series, chebyshev, fourier

__all__ = ["RiccatiFlow", "Series", "StateDependent", "chebyshev", "fourier", "fpre", "rde", "sdre"]
