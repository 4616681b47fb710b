"""A chemostat whose growth is inhibited by too much substrate, with its tests."""

import workbench as wb


@wb.block
class Chemostat(wb.Plant):
    """Biomass X on substrate S, diluted at the rate D, with Haldane's growth:

    X' = (mu - D) X,   S' = D (S_in - S) - mu X / Y,   mu = mu_0 S / (K_s + S + S^2 / K_i).
    """

    mu_0: float = wb.parameter(default=2e-4, unit="1/s", low=0)
    K_s: float = wb.parameter(default=1.0, unit="kg/m^3", low=0, strict=True)
    K_i: float = wb.parameter(default=20.0, unit="kg/m^3", low=0, strict=True)
    Y: float = wb.parameter(default=0.5, unit="1", low=0, strict=True)
    S_in: float = wb.parameter(default=10.0, unit="kg/m^3", low=0)
    X: float = wb.initial(default=3.0, unit="kg/m^3")
    S: float = wb.initial(default=2.0, unit="kg/m^3")

    inputs = wb.layout(D="1/s")
    outputs = wb.layout(S="kg/m^3", r="kg/(m^3 s)")

    def growth(self, x):
        return self.mu_0 * x.S / (self.K_s + x.S + x.S**2 / self.K_i)

    def rate(self, t, x, u):
        mu = self.growth(x)
        return {"X": (mu - u.D) * x.X, "S": u.D * (self.S_in - x.S) - mu * x.X / self.Y}

    def measure(self, t, x):
        return {"S": x.S, "r": self.growth(x) * x.X}


class TestChemostat(wb.testing.PlantTests):
    def plant(self):
        return Chemostat()
