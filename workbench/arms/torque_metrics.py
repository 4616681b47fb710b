"""The largest torque that acts on an arm, as a metric."""

from workbench.core.validation.signatures import check_arguments
from workbench.engine.metrics.step_metrics import Peak


@check_arguments
def peak_torque() -> Peak:
    """Largest |tau| that acts on each joint of an arm, behind the limits of its motors.

    Examples
    --------
    >>> arm = wb.paper_arm()
    >>> law = wb.ArmPID(Kp=[60.0, 40.0], Ki=[0.0, 0.0], Kd=[12.0, 8.0])
    >>> plant, rest = wb.Manipulator(arm, q=[0.2, 0.1]), wb.Constant("q", "rad", [0.0, 0.0])
    >>> loop = wb.ClosedLoop(plant, wb.ArmFullState(2), law, rest)
    >>> found = wb.measure(loop.ode(), [wb.arms.peak_torque()], until=0.5, h=1e-3)
    >>> [score.value.round(3) for score in found.scores_of("peak torque")]
    [array([12.]), array([4.212])]
    """
    return Peak("peak torque", "", "largest |tau| applied", "tau_applied")
