"""A control law to fill in, with its tests: `pytest law.py` runs them. Nothing is registered anywhere."""

import workbench as wb


@wb.block
class MyLaw(wb.Controller):
    """The law as its book prints it:

    v = kp e + ki z,    z' = e,    with e = omega_ref - omega.
    """

    # Numbers, each with its unit and its bounds. Each of them can be varied, differentiated and exported.
    kp: float = wb.parameter(unit="V s/rad", low=0)
    ki: float = wb.parameter(unit="V/rad", low=0)
    z: float = wb.initial(default=0.0, unit="rad")  # the start of the law's memory; leave it out if there is none

    # Ports: the estimates that it reads, the references that it follows, and the inputs that it drives.
    reads = follows = wb.layout(omega="rad/s")
    drives = wb.layout(v="V")

    def command(self, t, z, est, ref):
        """The commands, as expressions: `ca.sin` and `ca.if_else` of CasADi in place of `math.sin` and `if`."""
        return {"v": self.kp * (ref.omega - est.omega) + self.ki * z.z}

    def rate(self, t, z, est, ref):
        """The derivative of each number of the memory."""
        return {"z": ref.omega - est.omega}


class TestMyLaw(wb.testing.LawTests):
    """The tests of every law of the workbench, for this one."""

    def law(self):
        """The law with usual numbers."""
        return MyLaw(kp=30.0, ki=50.0)

    # Without this method the signals of its ports come from a bench.
    def loop(self):
        """A loop that the law is for."""
        return wb.ClosedLoop(wb.DCMotor(), controller=self.law(), reference=wb.Step("omega", "rad/s", 1.0))
