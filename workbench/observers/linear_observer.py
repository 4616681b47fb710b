"""Luenberger's observer of any plant, in continuous time and exact in a computer."""

from __future__ import annotations

import casadi as ca

from workbench.core import Signals, block, parameter
from workbench.core.block import Matrix, Number, Vector
from workbench.core.port import ANY
from workbench.loop.contracts import AbstractPlant, Inputs, Parts, Reads
from workbench.observers.exponential import phi
from workbench.observers.model import AbstractModelObserver, jacobian, refuse_unfit, stacked


@block
class LinearObserver(AbstractModelObserver):
    """Luenberger's observer with the model x' = f(t, x, u), y = h(t, x) of any plant:

        x_hat' = f(t, x_hat, u) + L (y - h(t, x_hat))

    and where a point x_0, u_0 is given, with the linear model about it,

        x_hat' = f_0 + A (x_hat - x_0) + B (u - u_0) + L (y - h_0 - C (x_hat - x_0)),

    where A, B, C are the exact Jacobians of f and h at that point, and f_0, h_0 their values, zero rates at rest.
    Its error obeys e' = (A - L C) e beside a linear plant. With the gain of `lqe` it is the steady Kalman-Bucy filter.

    A computer that holds y and u for a period h steps it by

        x_hat+ = x_hat + h phi(h F) x_hat',        phi(M) = M^-1 (exp(M) - I),     F = A - L C at x_hat,

    which is exact for the linear model whatever the period, while h times each pole of F stays below 40 in size, and
    of second order for the other.

    Parameters
    ----------
    L
        (nx, ny), each entry in the unit of its state over that of its output, per second.
    outputs
        The outputs y that are read; all where none is named.
    x_0, u_0
        (nx,) and (nu,), the operating point; zero commands where u_0 alone is left out.

    Raises
    ------
    LookupError
        If the model has no such output.
    ValueError
        If a number has another shape than its ports, u_0 comes without x_0, or the model moves in discrete time.

    References
    ----------
    Luenberger (1971), An introduction to observers, IEEE Transactions on Automatic Control 16(6).
    Hochbruck and Ostermann (2010), Exponential integrators, Acta Numerica 19, section 2.4 (the step).

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> gain = wb.steady_kalman(wb.open_loop(motor), Q=np.eye(2), R=[[1e-4]]).K
    >>> wb.LinearObserver(motor, gain).gives.names
    ('omega', 'i')
    """

    model: AbstractPlant
    L: Matrix = parameter(unit=ANY, shape=("nx", "ny"), symbol="L")
    outputs: tuple[str, ...] = ()
    x_0: Vector = parameter(default=None, unit=ANY, shape=("k",), symbol="x_0")
    u_0: Vector = parameter(default=None, unit=ANY, shape=("nu",), symbol="u_0")

    def __post_init__(self) -> None:
        states = self.model.states
        refuse_unfit(self, L=(states, self.reads), x_0=(states,), u_0=(self.inputs,))
        if self.x_0 is None and self.u_0 is not None:
            raise ValueError(
                "`LinearObserver(u_0=...)` must come with x_0, as the two are one operating point; got u_0 alone."
            )

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The observer as it stands above."""
        del est
        return self._parts(self._rate(t, self._column(z), y, u))

    @property
    def method(self) -> str:
        """The step above."""
        return "exponential Euler, exact for a linear model"

    def advance(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs, period: float) -> Parts:
        """The observer over a period in which readings and commands are held."""
        del est
        x = self._column(z)
        rate, F = jacobian(lambda s: self._rate(t, s, y, u), x)
        return self._parts(x + period * phi(period * F) @ rate)

    def _rate(self, t: ca.SX, x: ca.SX, y: Signals, u: Signals) -> ca.SX:
        seen = stacked(y, self.reads)
        if self.x_0 is None:
            return self._f(t, x, u) + ca.SX(self.L) @ (seen - self._h(t, x))
        commands = self.inputs.flatten({name: ca.SX(u[name]) for name in self.inputs.names})
        x_0, u_0 = ca.SX(self.x_0), ca.SX.zeros(self.inputs.size) if self.u_0 is None else ca.SX(self.u_0)
        f_0, A = jacobian(lambda s: self._f(t, s, Signals(self.inputs.view(u_0))), x_0)
        _, B = jacobian(lambda s: self._f(t, x_0, Signals(self.inputs.view(s))), u_0)
        h_0, C = jacobian(lambda s: self._h(t, s), x_0)
        return f_0 + A @ (x - x_0) + B @ (commands - u_0) + ca.SX(self.L) @ (seen - h_0 - C @ (x - x_0))
