"""Figures of linear systems: margins with all crossovers, peaks of the sensitivity, each with its bounds.

The room knows arrays and systems of python-control, and no robot, law or loop by name. Read `stability_margins.py`
first, then `axis_loop.py` for the polynomials and `delay_pieces.py` for loops with a delay.
"""

from workbench.design.frequency.certified_values import CertifiedValue
from workbench.design.frequency.crossovers import Crossover
from workbench.design.frequency.stability_margins import Peak, StabilityMargins, StableMargins, stability_margins

__all__ = ["CertifiedValue", "Crossover", "Peak", "StabilityMargins", "StableMargins", "stability_margins"]
