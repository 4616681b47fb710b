"""Cases of a motor whose speed a law holds."""

import workbench as wb
from workbench.study.study import Case

MOTOR = wb.DCMotor()
METRICS = (wb.rmse(), wb.effort(), wb.peak_error())


def case(law, Kp=100.0, scenario="speed"):
    controller = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=Kp, Ki=200.0, low=-24.0, high=24.0)
    loop = wb.ClosedLoop(MOTOR, controller=controller, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))
    return Case(scenario, law, wb.Run(loop, METRICS, until=1.0, every=0.01, h=1e-3))
