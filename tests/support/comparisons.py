"""A loop whose equation is stated."""


class Given:
    """A loop whose equation is given."""

    def __init__(self, ode):
        self.equation = ode

    def ode(self, name="loop"):
        return self.equation
