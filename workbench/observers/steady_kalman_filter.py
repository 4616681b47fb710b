"""The Kalman filter of any plant with a steady gain, as a discrete algebraic Riccati equation gives it."""

from __future__ import annotations

import casadi as ca

from workbench.core import Signals, block, parameter
from workbench.core.block import Matrix, Number
from workbench.core.port import ANY
from workbench.core.step import runge_kutta
from workbench.loop.contracts import AbstractPlant, Inputs, Parts, Reads
from workbench.observers.kalman_filter import MOST_SUBSTEPS
from workbench.observers.model import AbstractModelObserver, refuse_unfit, stacked
from workbench.validation.refusals import seconds, whole


@block
class SteadyKalmanFilter(AbstractModelObserver):
    """The Kalman filter of x' = f(t, x, u) + w, y_k = h(t_k, x) + v_k with a constant gain, for `model` any plant:

        at t_k        x_hat+ = x_hat + L (y_k - h(t_k, x_hat))
        to t_(k+1)    x_hat' = f(t, x_hat, u)

    It runs in a computer, which holds u; the law is given x_hat+ at t_k. With the gain of `steady_kalman` it is what
    the Kalman filter of the linearised plant settles at, where the design point is.

    Parameters
    ----------
    L
        (nx, ny), each entry in the unit of its state over that of its output.
    period
        Between two instants, in s.
    outputs
        The outputs y that are read; all where none is named.
    substeps
        Runge-Kutta steps a period.

    Raises
    ------
    LookupError
        If the model has no such output.
    ValueError
        If L has another shape than (nx, ny), or the model moves in discrete time.

    References
    ----------
    Simon (2006), Optimal State Estimation, section 7.3.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> gain = wb.steady_kalman(wb.open_loop(motor), Q=np.eye(2), R=[[1e-4]], period=0.01).K
    >>> wb.SteadyKalmanFilter(motor, gain, period=0.01).gives.names
    ('omega', 'i')
    """

    model: AbstractPlant
    L: Matrix = parameter(unit=ANY, shape=("nx", "ny"), symbol="L")
    period: float
    outputs: tuple[str, ...] = ()
    substeps: int = 1

    def __post_init__(self) -> None:
        refuse_unfit(self, L=(self.model.states, self.reads))
        seconds("SteadyKalmanFilter(period=...)", self.period)
        whole("SteadyKalmanFilter(substeps=...)", self.substeps, most=MOST_SUBSTEPS)

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        """The states after the readings of this instant, and the outputs there."""
        return self._estimates(t, self._corrected(t, z, y))

    def update(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The states before the readings of the next instant."""
        del est
        x, step = self._corrected(t, z, y), self.period / self.substeps
        for i in range(self.substeps):
            x = runge_kutta(self._f, t + i * step, x, u, step)
        return self._parts(x)

    def _corrected(self, t: ca.SX, z: Parts, y: Signals) -> ca.SX:
        x = self._column(z)
        return x + ca.SX(self.L) @ (stacked(y, self.reads) - self._h(t, x))
