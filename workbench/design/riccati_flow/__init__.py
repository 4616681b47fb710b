"""Differential Riccati equations, backward and forward in time, and state-dependent Riccati equations (SDRE).

This package takes matrices, and functions of time or state that give them; it knows no plant. Read `differential.py`
first; it uses `moebius.py` if coefficients are constant, and `time_varying.py` if they are not.

Examples
--------
>>> one = np.eye(1)
>>> wb.riccati_flow.rde(0 * one, one, one, one, 0 * one, np.array([0.0, 1.0])).P.shape
(2, 1, 1)
"""

from workbench.design.riccati_flow.differential import RiccatiFlow, StateDependent, fpre, rde, sdre

__all__ = ["RiccatiFlow", "StateDependent", "fpre", "rde", "sdre"]
