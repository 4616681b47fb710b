"""Signals from point to point: trapezoidal velocities, way-points with the least jerk, and tables of numbers."""

import casadi as ca
import numpy as np

from workbench.core import block, option, parameter
from workbench.core.block import Matrix, Number, Scalar, Vector
from workbench.signals.signal import AbstractSignal, Motion, clock, shape_of
from workbench.validation.refusals import Array, matrix

MOST_ROWS = 2000  # of a table: each is a comparison at each evaluation, and a part of what is compiled
TINY = float(np.finfo(float).tiny)  # where there is no way to go, nothing is divided by 0


@block
class Trapezoid(AbstractSignal):
    """A motion with a trapezoidal velocity from start to goal, in the shortest time within limits, number by number:

        D = |goal - start|,   v = min(speed, sqrt(D acceleration)),   T = D / v + v / acceleration.

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
    """A motion from point to point, at rest in each, with the least jerk: with s = (t - t_i) / (t_(i+1) - t_i),

        x(t) = x_i + (x_(i+1) - x_i) (10 s^3 - 15 s^4 + 6 s^5),

    which minimises the integral of the squared jerk. Before the first time and after the last it rests. The `times`
    (m,) increase; `points` is (m, n), a row a time, or of a signal of one number (m,).

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


@block
class Table(AbstractSignal):
    """A signal between the rows of a table, as an expression in time: polynomials piece by piece.

    `times` (m,) in s begin at 0 or before; `values` are (m, n), a row a time, or of a signal of one number (m,). They
    are no parameters. A run that goes on behind the last row is refused.

    Raises
    ------
    ValueError
        If a number is not finite, the times do not increase or begin after 0, there are fewer than two rows or more
        than 2000, or times and values are not equally many.

    Examples
    --------
    >>> wb.Table("h", "m", times=[0.0, 1.0, 2.0], values=[0.1, 0.2, 0.2]).at(0.5).h
    SX(0.15)
    """

    signal: str
    unit: str
    times: Array
    values: Array
    interpolation: str = option(
        {
            "linear": "straight lines, whose corners have no second derivative",
            "cubic": "a cubic spline with two continuous derivatives, whose outer two pieces are one at each end",
            "hold": "each row until the next, as a computer's command is held",
        },
        default="linear",
    )

    def __post_init__(self) -> None:
        times, values = np.array(self.times), np.array(self.values)
        if times.ndim != 1 or values.ndim not in (1, 2) or len(values) != len(times):
            raise ValueError(
                f"`Table(times=..., values=...)` must have one row of values for each time, (m,) and (m, n); got "
                f"shapes {times.shape} and {values.shape}."
            )
        refuse_times("Table(times=...)", times)
        if times[0] > 0 or len(times) > MOST_ROWS:
            raise ValueError(
                f"`Table(times=...)` must begin at 0 s or before, as every run does, and have at most {MOST_ROWS} "
                f"rows, each of which costs at every step; got {len(times)} from {times[0]:g} s on."
            )
        matrix("Table(values=...)", values.reshape(len(times), -1))
        for name, numbers in (("times", times), ("values", values.reshape(len(times), -1))):
            numbers.flags.writeable = False
            object.__setattr__(self, name, numbers)

    @property
    def dof(self) -> int:
        return int(self.values.shape[1])

    @property
    def ends(self) -> float:
        return float(self.times[-1])

    def motion(self, t: Number) -> Motion:
        rows = self._pieces()
        chosen = ca.SX(rows[0])
        for row, time in zip(rows[1:], self.times[1:-1], strict=True):
            chosen = ca.if_else(clock(t) >= time, ca.SX(row), chosen)
        s = t - chosen[0]
        a, b, c, d = ca.vertsplit(chosen[1:], self.dof)
        return a + s * (b + s * (c + s * d)), b + s * (2 * c + s * 3 * d), 2 * c + 6 * d * s

    def _pieces(self) -> Array:
        """For each piece its begin and the coefficients of 1, s, s^2 and s^3: (m - 1, 1 + 4 n)."""
        begins, zero = self.values[:-1], np.zeros_like(self.values[:-1])
        slopes = np.diff(self.values, axis=0) / np.diff(self.times)[:, np.newaxis]
        coefficients: tuple[Array, ...] = (begins, slopes, zero, zero)
        if self.interpolation == "hold":
            coefficients = (begins, zero, zero, zero)
        elif self.interpolation == "cubic":
            from scipy.interpolate import CubicSpline  # half a second, which only splines pay

            coefficients = tuple(CubicSpline(self.times, self.values).c[::-1])
        return np.hstack([self.times[:-1, np.newaxis], *coefficients])


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
