"""A plant of one's own: a steel ball below a magnet, held by a regulator in continuous time and in a computer."""

import numpy as np

import workbench as wb


@wb.block
class Ball(wb.Plant):
    """A ball at a distance z below a magnet with the current i: m z'' = m g - c (i / z)^2."""

    m: float = wb.parameter(default=0.05, unit="kg", low=0, strict=True)
    c: float = wb.parameter(default=4.9e-5, unit="N m^2/A^2", low=0)
    g: float = wb.parameter(default=9.8, unit="m/s^2")
    z: float = wb.initial(default=0.012, unit="m")
    zd: float = wb.initial(default=0.0, unit="m/s")

    inputs = wb.layout(i="A")
    outputs = wb.layout(z="m", zd="m/s")

    def rate(self, t, x, u):
        return {"z": x.zd, "zd": self.g - self.c / self.m * (u.i / x.z) ** 2}


ball, rest, current = Ball(), [0.01, 0.0], [1.0]
linear = wb.linearize(wb.open_loop(ball), t=0.0, x=rest, u=current, at_rest=True)
design = wb.lqr(linear, Q=np.diag([1e6, 1e2]), R=[[1.0]])  # for deviations from the point of `linear`
loop = wb.ClosedLoop(ball, controller=wb.StateFeedback.of(ball, design))
computer = loop.digital(2e-3, wb.Instruments.of(ball, noise={"z": 5e-5}, limit={"i": (0.0, 3.0)}), delay=True)
runs = {
    "in continuous time": wb.simulate(loop, until=0.3),
    "in a computer": wb.simulate(computer, until=0.3, seed=1),
}
wb.plot(runs, "z", "i_applied").savefig("own_plant.png")
