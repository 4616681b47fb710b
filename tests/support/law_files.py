"""A file with a loop that a user exports."""

FILE = """
import workbench as wb

motor = wb.DCMotor()
law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, low=-24.0, high=24.0)
loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
computer = loop.digital(0.01, wb.Instruments.of(motor, limit={"v": (-12.0, 12.0)}), delay=True)
case = wb.Case("speed", "PI", wb.Run(loop, (wb.rmse(),), until=1.0, h=1e-3))
study = wb.Study("mine", "T", "Q?", "M.", sections=lambda results: [], cases=(case,))
"""
