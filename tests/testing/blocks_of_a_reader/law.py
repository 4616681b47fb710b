"""A super-twisting law for the speed of a motor, with its tests."""

import casadi as ca

import workbench as wb


@wb.block
class SuperTwisting(wb.Controller):
    """Levant's super-twisting: v = k1 |s|^(1/2) sign(s) + z,  z' = k2 sign(s),  s = omega_ref - omega."""

    k1: float = wb.parameter(unit="V s^0.5/rad^0.5", low=0)
    k2: float = wb.parameter(unit="V/s", low=0)
    z: float = wb.initial(default=0.0, unit="V")

    reads = follows = wb.layout(omega="rad/s")
    drives = wb.layout(v="V")

    def command(self, t, z, est, ref):
        s = ref.omega - est.omega
        return {"v": self.k1 * ca.sqrt(ca.fabs(s)) * ca.sign(s) + z.z}

    def rate(self, t, z, est, ref):
        return {"z": self.k2 * ca.sign(ref.omega - est.omega)}


class TestSuperTwisting(wb.testing.LawTests):
    def law(self):
        return SuperTwisting(k1=20.0, k2=30.0)

    def loop(self):
        return wb.ClosedLoop(wb.DCMotor(), controller=self.law(), reference=wb.Step("omega", "rad/s", 1.0))
