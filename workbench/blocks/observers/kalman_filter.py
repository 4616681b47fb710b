"""The Kalman filters of any plant, continuous in its model and discrete in its readings: extended and unscented."""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import field
from functools import partial

import casadi as ca
import numpy as np

from workbench.blocks.loop.contracts import AbstractPlant, Inputs, Parts, Reads
from workbench.blocks.observers.observer_model import (
    MOST_SUBSTEPS,
    AbstractModelObserver,
    jacobian,
    refuse_unfit,
    stack_signals,
    with_hats,
)
from workbench.core import Entry, Layout, Signals, block, initial, parameter
from workbench.core.block import Matrix, Number, Scalar
from workbench.core.methods import runge_kutta
from workbench.core.numbers import Bounds
from workbench.core.units import ANY
from workbench.core.validation.refusals import known_name, seconds, whole
from workbench.core.validation.signatures import check_arguments

COVARIANCE, PIVOT = "P", "pivot"  # beside the estimated states in the memory


class AbstractKalmanFilter(AbstractModelObserver):
    """The base class of Kalman filters, which correct x_hat and P by the readings of each instant.

    Parameters
    ----------
    Q
        Intensity of the process noise w: E w(t) w(s)' = Q delta(t - s).
    R
        Covariance of the noise v_k of the readings.
    P
        Covariance of the initial estimate, with a row for each of the nx states, before the first reading.
    period
        Period of the computer in s. It must be given.
    every
        Outputs with a new reading only once in several periods, as {"p": 10}.
    substeps
        Number of steps in a period.
    """

    Q: Matrix
    R: Matrix
    P: Matrix
    period: float
    every: Mapping[str, int]
    substeps: int

    @property
    def memory(self) -> Layout:
        """The estimated states and P before the readings of the next instant, and the smallest pivot of P so far."""
        P = Entry(COVARIANCE, self.P, ANY, Bounds(symmetric=True, definite="semi"))
        return with_hats(self.model.states) + Layout((P, Entry(PIVOT, np.array(1.0))))

    @check_arguments
    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        return self._estimates(t, self._correct_by_reading(t, z, y)[0])

    @check_arguments
    def update(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The estimate and P before the readings of the next instant, and the smallest pivot of P so far."""
        x, P, pivot = self._correct_by_reading(t, z, y)
        step = self.period / self.substeps
        for i in range(self.substeps):
            x, P = self._predict(t + i * step, x, P, u, step)
        P = symmetric(P)
        return {**self._parts(x), COVARIANCE: P, PIVOT: ca.fmin(ca.fmin(z[PIVOT], pivot), cholesky(P)[1])}

    def _correct_by_reading(self, t: ca.SX, z: Parts, y: Signals) -> tuple[ca.SX, ca.SX, ca.SX]:
        """The correction of a memory by `_corrected`, from which a reading that is not new is left out exactly."""
        new = self._new(t)
        R = ca.SX(self.R) * (new @ new.T) + ca.diag(1 - new)
        x, P, pivot = self._correct(t, self._column(z), symmetric(z[COVARIANCE]), stack_signals(y, self.reads), R, new)
        return x, symmetric(P), pivot

    def _new(self, t: ca.SX) -> ca.SX:
        """1 for each number that is read anew at a time, else 0, (ny, 1)."""
        k = ca.floor(t / self.period + 0.5)
        each = [(self.every.get(entry.name, 1), entry.size) for entry in self.reads.entries]
        parts = [ca.SX(1) if n == 1 else ca.if_else(ca.fmod(k, n) == 0, 1, 0) for n, size in each for _ in range(size)]
        return ca.vertcat(*parts)

    @abstractmethod
    def _correct(self, t: ca.SX, x: ca.SX, P: ca.SX, y: ca.SX, R: ca.SX, new: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """x_hat and P after readings y, and their least pivot; a reading with 0 in `new` has a row of I in R."""

    @abstractmethod
    def _predict(self, t: ca.SX, x: ca.SX, P: ca.SX, u: Signals, step: float) -> tuple[ca.SX, ca.SX]:
        """x_hat and P after a step in s."""


def symmetric(P: ca.SX) -> ca.SX:
    """The symmetric matrix that has the upper triangle of P."""
    return ca.triu2symm(ca.triu(ca.densify(P)))


def cholesky(P: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The factor G of P = G G', lower triangular, and the least of its pivots as a share of the diagonal of P.

    The share is 1 for a diagonal matrix, 0 where P is singular and negative where P is indefinite. A pivot that is not
    positive makes a column of zeros, so that G is always a number.
    """
    n = P.shape[0]
    G, least = ca.SX(n, n), ca.SX(1)
    for j in range(n):
        rest = P[j:, j] - (G[j:, :j] @ G[j, :j].T if j else 0)
        positive, size = rest[0] > 0, ca.fabs(P[j, j])
        least = ca.fmin(least, rest[0] / ca.if_else(size > 0, size, 1))
        root = ca.sqrt(ca.if_else(positive, rest[0], 1))  # nothing is ever divided by 0
        G[j, j] = ca.if_else(positive, root, 0)
        for i in range(1, n - j):
            G[j + i, j] = ca.if_else(positive, rest[i] / root, 0)
    return G, least


def gain(across: ca.SX, S: ca.SX) -> tuple[ca.SX, ca.SX]:
    """K = across S^-1 and the least pivot of S; where that is not positive S is no covariance, and K is 0."""
    G, least = cholesky(S)
    G = ca.if_else(least > 0, G, ca.SX.eye(S.shape[0]))
    return ca.if_else(least > 0, ca.solve(G.T, ca.solve(G, across.T)).T, 0), least


def refuse_unfit_filter(observer: AbstractKalmanFilter) -> None:
    """Refuse numbers of a filter that do not fit its model, and a P that is no covariance."""
    name, states = type(observer).__name__, observer.model.states
    refuse_unfit(observer, Q=(states, states), R=(observer.reads, observer.reads), P=(states, states))
    semi, positive = Bounds(symmetric=True, definite="semi"), Bounds(symmetric=True, definite="positive")
    for letter, bounds in (("Q", semi), ("R", positive), ("P", semi)):
        bounds.refuse_unsymmetric(f"{name}({letter}=...)", getattr(observer, letter)[np.newaxis])
    seconds(f"{name}(period=...)", observer.period)
    whole(f"{name}(substeps=...)", observer.substeps, most=MOST_SUBSTEPS)
    for output, count in observer.every.items():
        known_name(output, observer.reads.names, f"outputs that `{name}` reads")
        whole(f"{name}(every=...)", count, of=f" of instants for '{output}'")


@block
class ExtendedKalmanFilter(AbstractKalmanFilter):
    """The extended Kalman filter for any plant x' = f(t, x, u) + w, y_k = h(t_k, x) + v_k as its model:

        at t_k        K = P H' (H P H' + R)^-1
                      x_hat+ = x_hat + K (y_k - h(t_k, x_hat)),      P+ = (I - K H) P (I - K H)' + K R K'
        to t_(k+1)    x_hat' = f(t, x_hat, u),                       P' = A P + P A' + Q

    A and H are the exact Jacobians of f and h at x_hat. The filter runs in a computer, which holds u for a period; each
    of the `substeps` is one Runge-Kutta step. The law gets x_hat+ at t_k. The state `observer.pivot` is the smallest
    pivot so far of the Cholesky factors of P and of H P H' + R, each divided by the diagonal entry of its matrix. If it
    is negative by more than rounding (1e-12), P is no covariance any more, and later estimates cannot be trusted. At an
    instant at which H P H' + R is not positive definite, nothing is corrected.

    Raises
    ------
    LookupError
        If the model has no such output, or `every` names an output that the filter does not read.
    ValueError
        If an array has the wrong shape, Q, R or P is no covariance, or the model is in discrete time.

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
    P: Matrix = initial(unit=ANY, shape=("n", "n"))
    period: float
    outputs: tuple[str, ...] = ()
    every: Mapping[str, int] = field(default_factory=dict)
    substeps: int = 1

    def __post_init__(self) -> None:
        refuse_unfit_filter(self)

    def _correct(self, t: ca.SX, x: ca.SX, P: ca.SX, y: ca.SX, R: ca.SX, new: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        h, H = jacobian(lambda s: self._h(t, s), x)
        H = ca.diag(new) @ H
        K, least = gain(P @ H.T, H @ P @ H.T + R)
        rest = ca.SX.eye(x.numel()) - K @ H
        return x + K @ (new * (y - h)), rest @ P @ rest.T + K @ R @ K.T, least

    def _predict(self, t: ca.SX, x: ca.SX, P: ca.SX, u: Signals, step: float) -> tuple[ca.SX, ca.SX]:
        n = x.numel()

        def rates(time: ca.SX, v: ca.SX, inputs: Signals) -> ca.SX:
            f, A = jacobian(lambda s: self._f(time, s, inputs), v[:n])
            flow = A @ symmetric(ca.reshape(v[n:], n, n))
            return ca.vertcat(f, ca.vec(flow + flow.T + self.Q))

        v = runge_kutta(rates, t, ca.vertcat(x, ca.vec(P)), u, step)
        return v[:n], symmetric(ca.reshape(v[n:], n, n))


@block
class UnscentedKalmanFilter(AbstractKalmanFilter):
    """The unscented Kalman filter for any plant x' = f(t, x, u) + w, y_k = h(t_k, x) + v_k as its model.

    Its sigma points and weights are, with the columns g_i of the Cholesky factor G of P = G G',

        X_0 = x_hat,    X_i = x_hat + sqrt(c) g_i,    X_(n+i) = x_hat - sqrt(c) g_i,      c = alpha^2 (n + kappa) > 0
        W_0 = 1 - n / c  of means,    W_0 + 1 - alpha^2 + beta  of covariances,            W_i = 1 / (2 c)  of both

        at t_k        y_hat = sum W_i h(X_i),    S = sum W_i (h(X_i) - y_hat)(h(X_i) - y_hat)' + R
                      K = sum W_i (X_i - x_hat)(h(X_i) - y_hat)' S^-1
                      x_hat+ = x_hat + K (y_k - y_hat),      P+ = P - K S K'
        to t_(k+1)    X_i' = f(t, X_i, u),    x_hat = sum W_i X_i,    P = sum W_i (X_i - x_hat)(X_i - x_hat)' + noise

    Each of the `substeps` is two Runge-Kutta steps: the sigma points move to the middle of the step, new ones are
    chosen there, and these move to its end. The noise Q h of a step of h seconds is added by Simpson's rule. So P stays
    positive semidefinite if no weight is negative, and the steps converge to Sarkka's equations.

    alpha = 1, beta = 0, kappa = 0 is the cubature rule, which has no negative weight. alpha = 1, beta = 0,
    kappa = 3 - n is the choice of Julier and Uhlmann; alpha = 1e-3, beta = 2, kappa = 0 that of Wan and van der Merwe.

    The filter runs in a computer as `ExtendedKalmanFilter` does, with the same `observer.pivot`, of P and S.

    Parameters
    ----------
    alpha, beta, kappa
        Constants of the sigma points and of their weights, with kappa > -n.

    References
    ----------
    Julier and Uhlmann (1997), A new extension of the Kalman filter to nonlinear systems, AeroSense.
    Wan and van der Merwe (2000), The unscented Kalman filter for nonlinear estimation, AS-SPCC.
    Sarkka (2007), On unscented Kalman filtering for ... continuous-time nonlinear systems, IEEE TAC 52(9).

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
    P: Matrix = initial(unit=ANY, shape=("n", "n"))
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

    def _correct(self, t: ca.SX, x: ca.SX, P: ca.SX, y: ca.SX, R: ca.SX, new: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        y_hat, dX, dY, weights = self._unscented_transform(x, P, lambda s: self._h(t, s))
        dY = ca.diag(new) @ dY
        S = dY @ weights @ dY.T + R
        K, least = gain(dX @ weights @ dY.T, S)
        return x + K @ (new * (y - y_hat)), P - K @ S @ K.T, least

    def _predict(self, t: ca.SX, x: ca.SX, P: ca.SX, u: Signals, step: float) -> tuple[ca.SX, ca.SX]:
        """The moments of the sigma points after two halves of a step, between which Q comes in by Simpson's rule."""
        half, Q = step / 2, step * ca.SX(self.Q)
        P = P + Q / 6
        for time, share in ((t, 2 / 3), (t + half, 1 / 6)):
            x, _, dX, weights = self._unscented_transform(x, P, partial(runge_kutta, self._f, time, p=u, h=half))
            P = symmetric(dX @ weights @ dX.T) + share * Q
        return x, P

    def _unscented_transform(
        self, x: ca.SX, P: ca.SX, function: Callable[[ca.SX], ca.SX]
    ) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
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
