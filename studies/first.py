"""A first loop: the speed of a DC motor under PID with limits, its picture, and its Bode and Nyquist plots."""

import workbench as wb

motor = wb.DCMotor()
law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, Kd=10.0, low=-24.0, high=24.0)
loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))
runs = wb.simulate(loop, until=2.0)
runs.plot().savefig("first.png")
wb.linear_loop(loop).plot().savefig("first_loop.png")
