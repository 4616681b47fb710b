"""A law of one's own, beside a transfer function of python-control: `workbench run own_law.py` writes the report."""

import control

import workbench as wb


@wb.block
class PI(wb.Controller):
    """v = kp e + ki z,  z' = e,  with e = omega_ref - omega."""

    kp: float = wb.parameter(unit="V s/rad")
    ki: float = wb.parameter(unit="V/rad")
    z: float = wb.initial(default=0.0, unit="rad")

    reads = follows = wb.layout(omega="rad/s")
    drives = wb.layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": self.kp * (ref.omega - est.omega) + self.ki * z.z}

    def rate(self, t, z, est, ref):
        return {"z": ref.omega - est.omega}


def case(name, law):
    loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    metrics = wb.rmse(), wb.overshoot(), wb.settling_time(), wb.effort()
    return wb.Case("speed", name, wb.Run(loop, metrics, until=5.0, h=1e-3))  # scenario, law, run


lead = control.tf([50, 600, 1000], [1, 20, 0], inputs="omega", outputs="v", name="lead")
study = wb.Study(
    name="own_law",
    title="How should the motor be driven?",
    question="What does a lead added to a PI buy, and what does it cost?",
    method="Both laws on one motor and one step. RK4 at 1 ms, and again at half of it for the numerical errors.",
    cases=(case("PI", PI(30.0, 50.0)), case("lead", wb.LinearLaw(lead, error=True))),
    sections=lambda results: [wb.Section("Speed", (wb.side_by_side("metrics", "Both laws", results.outcomes),))],
)
