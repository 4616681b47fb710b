"""Specifications of a loop as claims: limits on its figures, checked at a point or over a box of its parameters.

The room knows linear loops, systems of python-control and boxes of parameters, and no robot, law or plant by name.
Read `specification.py` first, then `limit_verdicts.py`; `box_verdicts.py` has the search and the proofs, and
`draw_check.py` the shares of draws.
"""

from workbench.study.specifications.draw_check import DrawVerdicts
from workbench.study.specifications.limit_verdicts import LimitVerdict, SpecificationVerdicts
from workbench.study.specifications.specification import Specification

__all__ = ["DrawVerdicts", "LimitVerdict", "Specification", "SpecificationVerdicts"]
