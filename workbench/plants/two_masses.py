from workbench.core import block, initial, layout, parameter
from workbench.core.block import Number, Scalar, States
from workbench.loop.contracts import AbstractPlant, Inputs, Parts


@block
class TwoMasses(AbstractPlant):
    """Two bodies on a line without friction, joined by a spring: u pushes the first, the second is watched.

        m_1 x_1'' = -k (x_1 - x_2) + u
        m_2 x_2'' =  k (x_1 - x_2)

    From u to x_2 it is k / (s^2 (m_1 m_2 s^2 + k (m_1 + m_2))): sensor and actuator stand on different bodies. The
    benchmark asks for a law that is stable for 0.5 < k < 2.

    References
    ----------
    Wie and Bernstein (1992), Benchmark problems for robust control design, Journal of Guidance, Control, and Dynamics
    15, 1057-1059; its numbers have no units.

    Examples
    --------
    >>> wb.linearize(wb.open_loop(wb.TwoMasses()), 0.0, np.zeros(4)).poles().imag.max().round(4)
    np.float64(1.4142)
    """

    m_1: Scalar = parameter(default=1.0, unit="kg", low=0, strict=True)
    m_2: Scalar = parameter(default=1.0, unit="kg", low=0, strict=True)
    k: Scalar = parameter(default=1.0, unit="N/m", low=0, strict=True)
    x_1: Scalar = initial(default=0.0, unit="m")
    x_2: Scalar = initial(default=0.0, unit="m")
    x_1d: Scalar = initial(default=0.0, unit="m/s")
    x_2d: Scalar = initial(default=0.0, unit="m/s")

    inputs = layout(u="N")
    outputs = layout(x_2="m")

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        spring = self.k * (x["x_1"] - x["x_2"])
        return {
            "x_1": x["x_1d"],
            "x_2": x["x_2d"],
            "x_1d": (u["u"] - spring) / self.m_1,
            "x_2d": spring / self.m_2,
        }
