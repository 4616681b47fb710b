"""A study of one's own: a tank, the computer that holds its level, and the number that decides how well it is held."""

import workbench as wb


@wb.block
class Tank(wb.Plant):
    """A tank that a pump fills at the voltage v; h is the level above its outlet: h' = k v - a sqrt(2 g h)."""

    k: float = wb.parameter(default=1.2e-3, unit="m/(s V)", low=0)
    a: float = wb.parameter(default=2.5e-3, unit="1", low=0)
    g: float = wb.parameter(default=9.81, unit="m/s^2")
    h: float = wb.initial(default=0.1, unit="m")
    inputs, outputs = wb.layout(v="V"), wb.layout(h="m")

    def rate(self, t, x, u):
        return {"h": self.k * u.v - self.a * (2 * self.g * x.h) ** 0.5}


law = wb.PID(Tank.outputs, Tank.inputs, Kp=100.0, Ki=2.0, low=0.0, high=10.0)
loop = wb.ClosedLoop(Tank(), controller=law, reference=wb.Step("h", "m", 0.12, time=20.0, start=0.1))
computer = loop.digital(1.0, wb.Instruments.of(loop.plant, noise={"h": 1e-3}, limit={"v": (0.0, 10.0)}), delay=2)
outlet = wb.Factor("outlet", ("plant.a",), wb.Uniform(2e-3, 3e-3))
gain = wb.Factor("gain", ("controller.Kp",), wb.LogUniform(50.0, 200.0))
noise = wb.Factor("noise", ("instruments.sensors[0].noise",), wb.Uniform(0.0, 5e-3))
run = wb.Run(computer, (wb.rmse(),), until=200.0)
sweep = wb.Sweep("tank", run, (outlet, gain, noise), wb.SobolDesign(dimensions=3, base=256))


def sections(results):
    runs = results.sample("tank")
    indices = wb.sobol(runs.design, runs.score("RMSE").value, ["RMSE of the level"], factors=runs.factors)
    return [wb.Section("What decides", (wb.sobol_bars("indices", "Sobol indices", indices, runs.source("RMSE")),))]


title, question = "What decides how well a level is held?", "Outlet, gain or noise: which of them decides the error?"
method = "The loop runs in a computer with noise, delay and limits. Sobol indices cover the whole ranges."
study = wb.Study("own_study", title, question, method, sections, sweeps=(sweep,))
