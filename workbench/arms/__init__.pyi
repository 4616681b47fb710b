"""The room for editors and mypy: each of its names, and the file that it comes from."""

from workbench.arms import laws, log_regression, mechanics, observer_gains, observers, paper_equations, properties
from workbench.arms.arm_contracts import AbstractArmController, AbstractArmObserver
from workbench.arms.dynamics import AbstractArm, Dynamics, solve_definite
from workbench.arms.manipulator import DirectDrive, FirstOrderLag, Friction, Manipulator
from workbench.arms.torque_metrics import peak_torque

__all__ = [
    "AbstractArm",
    "AbstractArmController",
    "AbstractArmObserver",
    "DirectDrive",
    "Dynamics",
    "FirstOrderLag",
    "Friction",
    "Manipulator",
    "laws",
    "log_regression",
    "mechanics",
    "observer_gains",
    "observers",
    "paper_equations",
    "peak_torque",
    "properties",
    "solve_definite",
]
