"""Robot arms: from the description of an arm to M, C and G, and to its plant, laws and observers.

No other package depends on arms, except `cli`, `testing`, the studies and `workbench` itself. `paper_equations`
compares the equations of a paper with those of an arm. Read `mechanics` first, then `manipulator.py` and `laws`.

Examples
--------
>>> wb.arms.Dynamics.of(wb.paper_arm()).matrices((0.0, 0.0), (0.0, 0.0))[0].shape
(2, 2)
"""

from workbench.core.lazy_names import lazy_names

_FILES = {
    "": "laws log_regression mechanics observer_gains observers paper_equations properties",
    "arm_contracts": "AbstractArmController AbstractArmObserver",
    "dynamics": "AbstractArm Dynamics solve_definite",
    "manipulator": "DirectDrive FirstOrderLag Friction Manipulator",
    "torque_metrics": "peak_torque",
}
__all__, __getattr__, __dir__ = lazy_names(__name__, _FILES)
