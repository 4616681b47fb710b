"""Observers of any plant with a constant gain: Luenberger's, and the Kalman filter as it settles."""

from __future__ import annotations

import casadi as ca

from workbench.blocks.loop.contracts import AbstractPlant, Inputs, Parts, Reads
from workbench.blocks.observers.observer_model import (
    MOST_SUBSTEPS,
    AbstractModelObserver,
    jacobian,
    phi,
    point_of_model,
    refuse_unfit,
    stack_signals,
    start_layout,
)
from workbench.core import Layout, Signals, block, initial, parameter
from workbench.core.block import Matrix, Number, Vector
from workbench.core.methods import runge_kutta
from workbench.core.units import ANY
from workbench.core.validation.refusals import seconds, whole


@block
class LinearObserver(AbstractModelObserver):
    """A Luenberger observer with a constant gain L, for any plant x' = f(t, x, u), y = h(t, x) as its model:

        x_hat' = f(t, x_hat, u) + L (y - h(t, x_hat))

    With an operating point (x_0, u_0) it uses the linear model about that point instead:

        x_hat' = f_0 + A (x_hat - x_0) + B (u - u_0) + L (y - h_0 - C (x_hat - x_0)).

    A, B and C are the exact Jacobians of f and h at the point; f_0 and h_0 are their values. For a linear plant the
    error obeys e' = (A - L C) e. With the gain of `wb.steady_kalman` it is the steady Kalman-Bucy filter.

    A computer holds y and u for a period T and moves the estimate by

        x_hat+ = x_hat + T phi(T F) x_hat',        phi(M) = M^-1 (exp(M) - I),     F = A - L C at x_hat.

    For the linear model this is exact, while T |s| < 40 for each pole s of F. For the nonlinear model it is of second
    order.

    Parameters
    ----------
    L
        Gain. Each entry is in the unit of its state over that of its output, per second.
    x_0
        State (nx,) at the operating point, or None for the nonlinear model.
    u_0
        Input at the operating point. The default is zero.
    start
        Initial estimate of the state, (nx,). The default is the initial state of the model.

    Raises
    ------
    LookupError
        If the model has no such output.
    ValueError
        If an array has the wrong shape, u_0 is given without x_0, or the model is in discrete time.

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
    start: Vector = initial(default=None, unit=ANY, shape=("k",))

    def __post_init__(self) -> None:
        states = self.model.states
        refuse_unfit(self, L=(states, self.reads), x_0=(states,), u_0=(self.inputs,), start=(states,))
        if self.x_0 is None and self.u_0 is not None:
            raise ValueError(
                "`LinearObserver(u_0=...)` must come with x_0, as the two are one operating point; got u_0 alone."
            )

    @staticmethod
    def of(model: AbstractPlant, design: object, outputs: tuple[str, ...] = ()) -> LinearObserver:
        """The observer with the gain of a design, linear about its operating point. The estimate begins at that point.

        Parameters
        ----------
        model
            The model: a plant in continuous time.
        design
            The result of `steady_kalman` without a period, or the estimator of `lqg`, for the linearised model.
        outputs
            Names of the outputs that the observer reads. The default is those of the design.

        Raises
        ------
        ValueError
            If the design has no operating point, is for another model, or its point is no equilibrium.
        """
        L, point = point_of_model("LinearObserver.of", model, design)
        names = outputs or point.outputs.names
        return LinearObserver(model, L, names, x_0=point.x0, u_0=point.u0, start=point.x0)

    @property
    def memory(self) -> Layout:
        return start_layout(self.model.states, self.start)

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        return self._parts(self._rate(t, self._column(z), y, u))

    @property
    def method(self) -> str:
        return "exponential Euler, exact for a linear model"

    def advance(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs, period: float) -> Parts:
        x = self._column(z)
        rate, F = jacobian(lambda s: self._rate(t, s, y, u), x)
        return self._parts(x + period * phi(period * F) @ rate)

    def _rate(self, t: ca.SX, x: ca.SX, y: Signals, u: Signals) -> ca.SX:
        seen = stack_signals(y, self.reads)
        if self.x_0 is None:
            return self._f(t, x, u) + ca.SX(self.L) @ (seen - self._h(t, x))
        commands = self.inputs.flatten({name: ca.SX(u[name]) for name in self.inputs.names})
        x_0, u_0 = ca.SX(self.x_0), ca.SX.zeros(self.inputs.size) if self.u_0 is None else ca.SX(self.u_0)
        f_0, A = jacobian(lambda s: self._f(t, s, Signals(self.inputs.view(u_0))), x_0)
        _, B = jacobian(lambda s: self._f(t, x_0, Signals(self.inputs.view(s))), u_0)
        h_0, C = jacobian(lambda s: self._h(t, s), x_0)
        return f_0 + A @ (x - x_0) + B @ (commands - u_0) + ca.SX(self.L) @ (seen - h_0 - C @ (x - x_0))


@block
class SteadyKalmanFilter(AbstractModelObserver):
    """A Kalman filter with a constant gain L, for any plant x' = f(t, x, u) + w, y_k = h(t_k, x) + v_k as its model:

        at t_k        x_hat+ = x_hat + L (y_k - h(t_k, x_hat))
        to t_(k+1)    x_hat' = f(t, x_hat, u)

    It runs in a computer, which holds u for a period. The law gets x_hat+ at t_k. With the gain of `wb.steady_kalman`
    it is, near the operating point of the design, the Kalman filter of the linearised plant in its steady state.

    Parameters
    ----------
    L
        Gain. Each entry is in the unit of its state over that of its output.
    period
        Period of the computer in s.
    substeps
        Number of Runge-Kutta steps in a period.
    start
        Initial estimate of the state, (nx,). The default is the initial state of the model.

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
    start: Vector = initial(default=None, unit=ANY, shape=("k",))

    def __post_init__(self) -> None:
        refuse_unfit(self, L=(self.model.states, self.reads), start=(self.model.states,))
        seconds("SteadyKalmanFilter(period=...)", self.period)
        whole("SteadyKalmanFilter(substeps=...)", self.substeps, most=MOST_SUBSTEPS)

    @staticmethod
    def of(model: AbstractPlant, design: object, period: float, outputs: tuple[str, ...] = ()) -> SteadyKalmanFilter:
        """The filter with the gain of a design. The estimate begins at the operating point of the design.

        Parameters
        ----------
        model
            The model: a plant in continuous time.
        design
            The result of `steady_kalman(..., period=period)` for the linearised model.
        period
            Period of the computer in s.
        outputs
            Names of the outputs that the filter reads. The default is those of the design.

        Raises
        ------
        ValueError
            If the design has no operating point, is for another model, or its point is no equilibrium.
        """
        L, point = point_of_model("SteadyKalmanFilter.of", model, design)
        return SteadyKalmanFilter(model, L, period, outputs or point.outputs.names, start=point.x0)

    @property
    def memory(self) -> Layout:
        return start_layout(self.model.states, self.start)

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        return self._estimates(t, self._correct(t, z, y))

    def update(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The estimate before the readings of the next instant."""
        x, step = self._correct(t, z, y), self.period / self.substeps
        for i in range(self.substeps):
            x = runge_kutta(self._f, t + i * step, x, u, step)
        return self._parts(x)

    def _correct(self, t: ca.SX, z: Parts, y: Signals) -> ca.SX:
        x = self._column(z)
        return x + ca.SX(self.L) @ (stack_signals(y, self.reads) - self._h(t, x))
