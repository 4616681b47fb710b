"""A plant to fill in, with its tests: `pytest plant.py` runs them. Nothing is registered anywhere."""

import casadi as ca

import workbench as wb


@wb.block
class MyPlant(wb.Plant):
    """The plant as its book prints it:

    m l^2 th'' = u - b th' - m g l sin(th).
    """

    # Numbers, each with its unit and its bounds. A number without a default must be given.
    m: float = wb.parameter(default=0.5, unit="kg", low=0, strict=True)
    l: float = wb.parameter(default=0.3, unit="m", low=0, strict=True)
    b: float = wb.parameter(default=0.01, unit="N m s/rad", low=0)
    g: float = wb.parameter(default=9.81, unit="m/s^2")

    # States, each with its start.
    th: float = wb.initial(default=0.2, unit="rad")
    om: float = wb.initial(default=0.0, unit="rad/s")

    # Ports: the inputs that drive it, and the outputs that instruments read. An output that is no state needs a method
    # `measure(self, t, x)`, which returns each output. `power` names an input and an output whose product is the power
    # that flows into the plant.
    inputs = wb.layout(u="N m")
    outputs = wb.layout(th="rad", om="rad/s")
    power = ("u", "om")

    def rate(self, t, x, u):
        """The derivative of each state, as an expression."""
        torque = u.u - self.b * x.om - self.m * self.g * self.l * ca.sin(x.th)
        return {"th": x.om, "om": torque / (self.m * self.l**2)}


class TestMyPlant(wb.testing.PlantTests):
    """The tests of every plant of the workbench, for this one."""

    def plant(self):
        """The plant with usual numbers."""
        return MyPlant()

    # Leave this method out if no energy is known. `lossless = True` says that no energy is lost.
    def stored_energy(self, plant, x):
        """The energy that grows by no more than the power u om."""
        return plant.m * (plant.l * x.om) ** 2 / 2 - plant.m * plant.g * plant.l * ca.cos(x.th)
