"""Proofs over boxes of parameters of a loop that is linear at its rest: gains, decay and damping of all its draws.

The room knows linear loops and boxes of their numbers, and no robot, law or plant by name. Read `parameter_box.py`
first, then `loop_family.py` for the matrices over a box, and `box_proof.py` for the proofs.
"""

from workbench.design.loop_boxes.box_proof import BoxProof, prove_over_box
from workbench.design.loop_boxes.loop_family import LoopFamily
from workbench.design.loop_boxes.parameter_box import ParameterBox
from workbench.design.loop_boxes.quadratic_conditions import DampingAbove, DecayAbove, GainBelow

__all__ = ["BoxProof", "GainBelow", "LoopFamily", "ParameterBox", "DampingAbove", "DecayAbove", "prove_over_box"]
