"""The extended Kalman filter of any plant, continuous in its model and discrete in its readings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

import casadi as ca

from workbench.core import Signals, block, initial, parameter
from workbench.core.block import Matrix
from workbench.core.port import ANY
from workbench.core.step import runge_kutta
from workbench.loop.contracts import AbstractPlant
from workbench.observers.kalman_filter import AbstractKalmanFilter, gain, refuse_unfit_filter, symmetric
from workbench.observers.model import jacobian


@block
class ExtendedKalmanFilter(AbstractKalmanFilter):
    """The extended Kalman filter of x' = f(t, x, u) + w, y_k = h(t_k, x) + v_k, for `model` any plant:

        at t_k        K = P H' (H P H' + R)^-1
                      x_hat+ = x_hat + K (y_k - h(t_k, x_hat)),      P+ = (I - K H) P (I - K H)' + K R K'
        to t_(k+1)    x_hat' = f(t, x_hat, u),                       P' = A P + P A' + Q

    where A and H are the exact Jacobians of f and h at x_hat, w is white noise of intensity Q and v_k a noise of
    covariance R. It runs in a computer, which holds u; the law is given x_hat+ at t_k.

    The state `observer.pivot` is the least pivot of P and of H P H' + R so far as a share of the variance: one below
    zero by more than rounding (1e-12) says that P was lost, as in Runge-Kutta steps that are too long for the model,
    and nothing that came later is to be trusted. Where H P H' + R is no covariance, nothing is corrected.

    Parameters
    ----------
    Q, R
        (nx, nx) per second and (ny, ny), in the units of the states and of the outputs that are read.
    P
        (nx, nx), the covariance of the start, which is that of `model`, before the first reading.
    period
        Between two instants, in s.
    outputs
        The outputs y that are read; all where none is named.
    every
        For an output that is not read at each instant, after how many it is new: {"p": 10}.
    substeps
        Runge-Kutta steps a period.

    Raises
    ------
    LookupError
        If the model has no such output, or `every` names one that is not read.
    ValueError
        If a number has another shape than its ports, Q or P is not symmetric and positive semidefinite, R not
        symmetric and positive definite, or the model moves in discrete time.

    References
    ----------
    Gelb (1974), Applied Optimal Estimation, table 6.1-1.
    Simon (2006), Optimal State Estimation, section 13.2.3.

    Examples
    --------
    >>> plant = wb.CartPole()
    >>> observer = wb.ExtendedKalmanFilter(plant, 1e-2 * np.eye(4), 1e-6 * np.eye(2), P=1e-2 * np.eye(4), period=0.01)
    >>> observer.reads.names, observer.gives.names
    (('x', 'phi'), ('x', 'xd', 'phi', 'phid'))
    """

    model: AbstractPlant
    Q: Matrix = parameter(unit=ANY, symmetric=True, definite="semi", shape=("nx", "nx"), symbol="Q")
    R: Matrix = parameter(unit=ANY, symmetric=True, definite="positive", shape=("ny", "ny"), symbol="R")
    P: Matrix = initial(unit=ANY, shape=("k", "k"))
    period: float
    outputs: tuple[str, ...] = ()
    every: Mapping[str, int] = field(default_factory=dict)
    substeps: int = 1

    def __post_init__(self) -> None:
        refuse_unfit_filter(self)

    def _corrected(self, t: ca.SX, x: ca.SX, P: ca.SX, y: ca.SX, R: ca.SX, new: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        h, H = jacobian(lambda s: self._h(t, s), x)
        H = ca.diag(new) @ H
        K, least = gain(P @ H.T, H @ P @ H.T + R)
        rest = ca.SX.eye(x.numel()) - K @ H
        return x + K @ (new * (y - h)), rest @ P @ rest.T + K @ R @ K.T, least

    def _moved(self, t: ca.SX, x: ca.SX, P: ca.SX, u: Signals, step: float) -> tuple[ca.SX, ca.SX]:
        n = x.numel()

        def rates(time: ca.SX, v: ca.SX, held: Signals) -> ca.SX:
            f, A = jacobian(lambda s: self._f(time, s, held), v[:n])
            flow = A @ symmetric(ca.reshape(v[n:], n, n))
            return ca.vertcat(f, ca.vec(flow + flow.T + self.Q))

        v = runge_kutta(rates, t, ca.vertcat(x, ca.vec(P)), u, step)
        return v[:n], symmetric(ca.reshape(v[n:], n, n))
