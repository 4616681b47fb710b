"""The unscented Kalman filter of any plant, continuous in its model and discrete in its readings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from functools import partial

import casadi as ca

from workbench.core import Signals, block, initial, parameter
from workbench.core.block import Matrix, Scalar
from workbench.core.port import ANY
from workbench.core.step import runge_kutta
from workbench.loop.contracts import AbstractPlant
from workbench.observers.kalman_filter import AbstractKalmanFilter, cholesky, gain, refuse_unfit_filter, symmetric


@block
class UnscentedKalmanFilter(AbstractKalmanFilter):
    """The unscented Kalman filter of x' = f(t, x, u) + w, y_k = h(t_k, x) + v_k, for `model` any plant.

    With sigma points about x_hat, columns g_i of the Cholesky factor of P = G G', and their weights,

        X_0 = x_hat,    X_i = x_hat + sqrt(c) g_i,    X_(n+i) = x_hat - sqrt(c) g_i,      c = alpha^2 (n + kappa)
        W_0 = 1 - n / c  of means,    W_0 + 1 - alpha^2 + beta  of covariances,            W_i = 1 / (2 c)  of both

        at t_k        y_hat = sum W_i h(X_i),    S = sum W_i (h(X_i) - y_hat)(h(X_i) - y_hat)' + R
                      K = sum W_i (X_i - x_hat)(h(X_i) - y_hat)' S^-1
                      x_hat+ = x_hat + K (y_k - y_hat),      P+ = P - K S K'
        to t_(k+1)    X_i' = f(t, X_i, u),    x_hat = sum W_i X_i,    P = sum W_i (X_i - x_hat)(X_i - x_hat)' + noise

    where w is white noise of intensity Q and v_k a noise of covariance R. In each of the `substeps` the points move by
    a Runge-Kutta step to its middle and, drawn anew, by another to its end; the noise Q h comes in by Simpson's rule.
    So P stays positive semidefinite where no weight is negative, and x_hat and P tend to the solution of Sarkka's
    equations as the steps get shorter.

    alpha = 1, beta = 0, kappa = 0 is the cubature rule, which has no negative weight; alpha = 1, beta = 0,
    kappa = 3 - n is Julier and Uhlmann's, alpha = 1e-3, beta = 2, kappa = 0 Wan and van der Merwe's.

    It runs in a computer, which holds u; the law is given x_hat+ at t_k. The state `observer.pivot` is that of
    `ExtendedKalmanFilter`, of P and S. Where S is no covariance, nothing is corrected.

    Parameters
    ----------
    Q, R, P, period, outputs, every
        As of `ExtendedKalmanFilter`.
    substeps
        Steps a period, each of two Runge-Kutta steps.

    Raises
    ------
    LookupError, ValueError
        As `ExtendedKalmanFilter` does; or if kappa is not above -n.

    References
    ----------
    Julier and Uhlmann (1997), A new extension of the Kalman filter to nonlinear systems, AeroSense.
    Wan and van der Merwe (2000), The unscented Kalman filter for nonlinear estimation, AS-SPCC.
    Sarkka (2007), On unscented Kalman filtering for state estimation of continuous-time nonlinear systems, IEEE
    Transactions on Automatic Control 52(9).

    Examples
    --------
    >>> plant = wb.CartPole()
    >>> observer = wb.UnscentedKalmanFilter(plant, 1e-2 * np.eye(4), 1e-6 * np.eye(2), P=1e-2 * np.eye(4), period=0.01)
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
    alpha: Scalar = parameter(default=1.0, unit="", low=0, strict=True, symbol="alpha")
    beta: Scalar = parameter(default=0.0, unit="", symbol="beta")
    kappa: Scalar = parameter(default=0.0, unit="", symbol="kappa")

    def __post_init__(self) -> None:
        refuse_unfit_filter(self)
        if not self.model.states.size + self.kappa > 0:
            raise ValueError(
                f"`UnscentedKalmanFilter(kappa=...)` must be above -n = {-self.model.states.size}, as the sigma points "
                f"lie sqrt(n + kappa) deviations away; got {self.kappa:g}."
            )

    def _corrected(self, t: ca.SX, x: ca.SX, P: ca.SX, y: ca.SX, R: ca.SX, new: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        y_hat, dX, dY, weights = self._spread(x, P, lambda s: self._h(t, s))
        dY = ca.diag(new) @ dY
        S = dY @ weights @ dY.T + R
        K, least = gain(dX @ weights @ dY.T, S)
        return x + K @ (new * (y - y_hat)), P - K @ S @ K.T, least

    def _moved(self, t: ca.SX, x: ca.SX, P: ca.SX, u: Signals, step: float) -> tuple[ca.SX, ca.SX]:
        """The moments of the sigma points after two halves of a step, between which Q comes in by Simpson's rule."""
        half, Q = step / 2, step * ca.SX(self.Q)
        P = P + Q / 6
        for time, share in ((t, 2 / 3), (t + half, 1 / 6)):
            x, _, dX, weights = self._spread(x, P, partial(self._flown, time, u, half))
            P = symmetric(dX @ weights @ dX.T) + share * Q
        return x, P

    def _flown(self, t: ca.SX, u: Signals, h: float, x: ca.SX) -> ca.SX:
        return runge_kutta(self._f, t, x, u, h)

    def _spread(self, x: ca.SX, P: ca.SX, function: Callable[[ca.SX], ca.SX]) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """The mean of a function, deviations of the points (n, 2n + 1) and of their images, weights on a diagonal."""
        n = x.numel()
        c = self.alpha**2 * (n + self.kappa)
        G = ca.sqrt(c) * ca.densify(cholesky(P)[0])
        dX = ca.horzcat(ca.SX.zeros(n), G, -G)
        images = ca.horzcat(*(function(x + dX[:, i]) for i in range(2 * n + 1)))
        # W_0 Y_0 + sum W_i Y_i with sum W_i = 1 - W_0: without a difference of large numbers where c is small
        mean = images[:, 0] + ca.sum2(images[:, 1:] - images[:, 0]) / (2 * c)
        weights = ca.vertcat(2 - n / c - self.alpha**2 + self.beta, ca.SX.ones(2 * n) / (2 * c))
        return mean, dX, images - mean, ca.diag(weights)
