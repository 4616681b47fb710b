"""Plants without an arm for tests: a motor, a turntable, and a counter in discrete time."""

from __future__ import annotations

from workbench.blocks.loop import AbstractPlant
from workbench.core import block, initial, layout, parameter

SPEED, VOLTAGE = layout(omega="rad/s"), layout(v="V")


@block
class Motor(AbstractPlant):
    """A DC motor: L i' = v - R i - K omega, J omega' = K i - b omega."""

    R: float = parameter(1.0, unit="ohm", low=0)
    L: float = parameter(0.5, unit="H", low=0)
    K: float = parameter(0.01, unit="N m/A")
    J: float = parameter(0.01, unit="kg m^2")
    b: float = parameter(0.1, unit="N m s/rad")
    i: float = initial(0.0, unit="A")
    omega: float = initial(0.0, unit="rad/s")
    inputs = VOLTAGE
    outputs = SPEED

    def rate(self, t, x, u):
        return {
            "i": (u.v - self.R * x.i - self.K * x.omega) / self.L,
            "omega": (self.K * x.i - self.b * x.omega) / self.J,
        }


@block
class Turntable(AbstractPlant):
    """A driven turntable with friction: theta' = omega, omega' = a v - omega."""

    a: float = parameter(2.0, unit="rad/(s^2 V)")
    theta: float = initial(0.0, unit="rad")
    omega: float = initial(0.0, unit="rad/s")
    inputs = VOLTAGE
    outputs = layout(theta="rad", omega="rad/s")

    def rate(self, t, x, u):
        return {"theta": x.omega, "omega": self.a * u.v - x.omega}


@block
class Counter(AbstractPlant):
    """A plant in discrete time: n becomes n + v once a period."""

    n: float = initial(0.0, unit="V")
    inputs = VOLTAGE
    outputs = layout(n="V")
    period = 0.1

    def update(self, t, x, u):
        return {"n": x.n + u.v}
