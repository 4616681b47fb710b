"""Inverse dynamics from a log: the base parameters, frictions and drives of an arm by regression of its torques.

This package reads datasets and uses the equations of an arm. Read `regressed_joints.py` and `prepared_motion.py` first,
then `regression.py`; `rigid_bodies.py` asks whether any rigid bodies have the numbers.
"""

from workbench.arms.log_regression.inverse_dynamics import fit_inverse_dynamics
from workbench.arms.log_regression.inverse_dynamics_fit import InverseDynamicsFit
from workbench.arms.log_regression.prepared_motion import PreparedMotion, prepare_motion
from workbench.arms.log_regression.regressed_joints import JointTerms
from workbench.arms.log_regression.rigid_bodies import RigidBodies, pseudo_inertias

__all__ = [
    "InverseDynamicsFit",
    "JointTerms",
    "PreparedMotion",
    "RigidBodies",
    "fit_inverse_dynamics",
    "prepare_motion",
    "pseudo_inertias",
]
