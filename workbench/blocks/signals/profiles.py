"""Signals from point to point: trapezoidal velocities, and way-points with the least jerk."""

import casadi as ca
import numpy as np

from workbench.blocks.signals.signal import AbstractSignal, Motion, shape_of
from workbench.core import block, parameter
from workbench.core.block import Matrix, Number, Scalar, Vector
from workbench.core.validation.refusals import Array

TINY = float(np.finfo(float).tiny)  # where there is no way to go, nothing is divided by 0


@block
class Trapezoid(AbstractSignal):
    """A motion from `start` to `goal` with a trapezoidal velocity, as fast as the limits allow.

    Each component moves by itself. For a distance D its greatest velocity v and its duration T are

        D = |goal - start|,   v = min(speed, sqrt(D acceleration)),   T = D / v + v / acceleration.

    Parameters
    ----------
    goal
        The value at the end of the motion.
    speed
        The upper limit of the absolute velocity.
    acceleration
        The absolute acceleration at the beginning and at the end of the motion.
    time
        The instant at which the motion begins.
    start
        The value of the signal before the instant `time`.

    References
    ----------
    Siciliano, Sciavicco, Villani and Oriolo (2009), Robotics: Modelling, Planning and Control, section 4.2.1.

    Examples
    --------
    >>> wb.Trapezoid("theta", "rad", goal=1.0, speed=0.5, acceleration=1.0).at(10.0).theta
    SX(1)
    """

    signal: str
    unit: str
    goal: Vector = parameter(unit="{unit}", shape=("n",), symbol="x_1")
    speed: Vector = parameter(unit="{unit_of_rate}", low=0, strict=True, shape=("n",), symbol="v_max")
    acceleration: Vector = parameter(unit="{unit_of_curvature}", low=0, strict=True, shape=("n",), symbol="a_max")
    time: Scalar = parameter(default=0.0, unit="s", low=0, symbol="t_s")
    start: Vector = parameter(default=0.0, unit="{unit}", shape=("n",), symbol="x_0")

    def motion(self, t: Number) -> Motion:
        a, way = ca.SX(self.acceleration), ca.SX(self.goal - self.start)
        distance, sense = ca.fabs(way), ca.sign(way)
        v = ca.fmin(self.speed, ca.sqrt(distance * a))
        rise = v / a
        last = rise + distance / ca.fmax(v, TINY)
        s = ca.fmin(ca.fmax(t - self.time, 0), last)
        speeding, slowing = ca.fmin(s, rise), ca.fmax(s - (last - rise), 0)
        position = a * (speeding**2 - slowing**2) / 2 + v * (s - speeding)
        velocity = ca.fmin(ca.fmin(a * s, v), a * (last - s))
        moves = (t >= self.time) * (t < self.time + last)
        up, down = t < self.time + rise, t >= self.time + last - rise
        return self.start + sense * position, sense * velocity, sense * a * moves * (up - down)


@block
class WayPoints(AbstractSignal):
    """A minimum-jerk motion through way-points, which stops at each of them.

    Between the times t_i and t_(i+1), with s = (t - t_i) / (t_(i+1) - t_i), it is

        x(t) = x_i + (x_(i+1) - x_i) (10 s^3 - 15 s^4 + 6 s^5).

    This polynomial minimises the integral of the squared jerk. The signal is constant before the first time and after
    the last.

    Parameters
    ----------
    times
        The m instants of the way-points, in increasing order.
    points
        The way-points, one row for each time. For a signal of one number, `points` may have the shape (m,).

    References
    ----------
    Flash and Hogan (1985), The coordination of arm movements, J. Neurosci. 5(7).

    Examples
    --------
    >>> path = wb.WayPoints("q", "rad", times=[0.0, 1.0, 3.0], points=[[0.0, 0.0], [1.0, 0.5], [0.0, 0.0]])
    >>> path.at(1.0).q
    SX([1, 0.5])
    """

    signal: str
    unit: str
    times: Vector = parameter(unit="s", shape=("m",), symbol="t")
    points: Matrix = parameter(unit="{unit}", shape=("m", "n"), symbol="X")

    def __post_init__(self) -> None:
        refuse_times("WayPoints(times=...)", self.times)

    @property
    def dof(self) -> int:
        shape = shape_of(self.points)
        return shape[1] if len(shape) == 2 else 1

    def motion(self, t: Number) -> Motion:
        """The sum of the segments, each zero before its time and constant after it, and its derivatives."""
        times, points = ca.SX(self.times), ca.SX(self.points).T
        x, xd, xdd = points[:, 0], ca.SX.zeros(self.dof), ca.SX.zeros(self.dof)
        for i in range(points.shape[1] - 1):
            way, span = points[:, i + 1] - points[:, i], times[i + 1] - times[i]
            s = ca.fmin(ca.fmax((t - times[i]) / span, 0), 1)
            x += way * s**3 * (10 - 15 * s + 6 * s**2)
            xd += way * 30 * s**2 * (1 - s) ** 2 / span
            xdd += way * 60 * s * (1 - s) * (1 - 2 * s) / span**2
        return x, xd, xdd


def refuse_times(call: str, times: Array) -> None:
    """Refuse times that do not increase, or fewer than two."""
    if len(times) < 2:
        raise ValueError(f"`{call}` must be at least two times, between which there is a way; got {len(times)}.")
    if len(back := np.flatnonzero(~(np.diff(times) > 0))):
        i = int(back[0])
        raise ValueError(
            f"`{call}` must increase, as a signal has one value at a time; got {times[i]:g} s and then "
            f"{times[i + 1]:g} s at [{i + 1}]."
        )
