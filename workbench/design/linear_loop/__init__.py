"""Linear responses of closed loops: L, S and T at a cut, and from any signal to any other, for one loop or many.

The function `wb.linear_loop` makes a `LinearLoop`, and `LinearLoop.rows` makes many at once. This package takes
equations that can be closed and cut; it knows no robot, law or plant by name. Read `loop_linearization.py` first, then
`linear_loop.py` for the responses, `loop_rows.py` for many rows, and `point_model.py` for the Jacobians.

Examples
--------
>>> motor = wb.DCMotor()
>>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
>>> linear = wb.linear_loop(wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)))
>>> isinstance(linear, wb.linear_loops.LinearLoop), linear.corner_signals
(True, ())
"""

from workbench.design.linear_loop.frequency_answers import BodeData, FrequencyResponse
from workbench.design.linear_loop.linear_loop import LinearLoop
from workbench.design.linear_loop.loop_linearization import linear_loop
from workbench.design.linear_loop.loop_rows import LinearRows

__all__ = ["BodeData", "FrequencyResponse", "LinearLoop", "LinearRows", "linear_loop"]
