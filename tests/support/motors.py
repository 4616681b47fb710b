"""A motor with a law and a reference of one's own: a plant that is no arm, for tests."""

from workbench.blocks.loop import AbstractController, AbstractPlant, AbstractReference, ClosedLoop
from workbench.core import block, initial, layout, parameter


@block
class Motor(AbstractPlant):
    """A direct-current motor."""

    R: float = parameter(1.0, unit="ohm", low=0)
    L: float = parameter(0.5, unit="H", low=0)
    K: float = parameter(0.01, unit="N m/A")
    J: float = parameter(0.01, unit="kg m^2")
    b: float = parameter(0.1, unit="N m s/rad")
    i: float = initial(0.0, unit="A")
    omega: float = initial(0.0, unit="rad/s")

    inputs = layout(v="V")
    outputs = layout(omega="rad/s")

    def rate(self, t, x, u):
        """Current and speed."""
        di = (u.v - self.R * x.i - self.K * x.omega) / self.L
        return {"i": di, "omega": (self.K * x.i - self.b * x.omega) / self.J}


@block
class Level(AbstractReference):
    """A constant speed."""

    level: float = parameter(1.0, unit="rad/s")

    gives = layout(omega="rad/s")

    def at(self, t):
        """The level."""
        return {"omega": self.level}


@block
class PI(AbstractController):
    """v = kp e + ki z, z' = e, where e is what is wanted less what is."""

    kp: float = parameter(50.0, unit="V s/rad")
    ki: float = parameter(100.0, unit="V/rad")
    z: float = initial(0.0, unit="rad")

    reads = follows = layout(omega="rad/s")
    drives = layout(v="V")

    def command(self, t, z, est, ref):
        """The voltage."""
        return {"v": self.kp * (ref.omega - est.omega) + self.ki * z.z}

    def rate(self, t, z, est, ref):
        """The error."""
        return {"z": ref.omega - est.omega}


def motor_loop(law=None):
    """The motor under PI control, or another law."""
    return ClosedLoop(Motor(), controller=law or PI(), reference=Level())
