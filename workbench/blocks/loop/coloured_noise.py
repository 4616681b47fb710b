"""Coloured noise: processes that move from instant to instant of a computer by an exact transition.

At the instants a process has the distribution of its equation in continuous time, for every period. It begins in its
stationary distribution, if it has one, and is held between two instants.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import field

import casadi as ca
import numpy as np

from workbench.core import block, parameter
from workbench.core.block import Scalar, Vector, quantities
from workbench.core.units import ANY, per_second
from workbench.core.validation.refusals import Array, describe, seconds, whole

TINY = float(np.finfo(float).tiny)
MOST_DRAWS = 10**8  # of a path: 0.8 GB
Parts = Mapping[str, ca.SX]


@block
class AbstractNoise(ABC):
    """The base class of coloured noises: processes with a memory. Their components are independent of one another.

    As the `by` of a `DisturbedPlant` a noise is a disturbance; in `Instruments` it is added to the readings.

    Parameters
    ----------
    signal
        Name of the output or input of a plant to which the noise is added.
    """

    signal: str
    unit: str = field(default=ANY, init=False)

    @property
    def size(self) -> int:
        """The number of components, which is the largest size of the vector fields."""
        vectors = (getattr(self, f.name) for f, quantity in quantities(self) if quantity.shape == ("*",))
        return max(int(ca.SX(each).numel()) for each in vectors)

    @property
    @abstractmethod
    def states(self) -> tuple[tuple[str, str], ...]:
        """The name and the unit of each state. The first state is the noise."""

    @abstractmethod
    def start(self, w: Sequence[ca.SX]) -> tuple[ca.SX, ...]:
        """The states at the first instant, (k, 1) each, from as many columns w of standard normal random numbers."""

    @abstractmethod
    def after(self, z: Sequence[ca.SX], w: Sequence[ca.SX], period: float) -> tuple[ca.SX, ...]:
        """The states one `period` [s] after z, (k, 1) each, with columns w of standard normal random numbers."""

    def _refuse_misfit(self, method: str, period: float = 1.0, **columns: Sequence[ca.SX]) -> None:
        """Refuse another count of columns than that of the states, columns of another shape, and no period."""
        call, size, names = f"{type(self).__name__}.{method}", self.size, [name for name, _ in self.states]
        for name, given in columns.items():
            shapes = [column.shape for column in given]
            if shapes != [(size, 1)] * len(names):
                raise ValueError(
                    f"`{call}({name}=...)` must be a column of shape ({size}, 1) for each state, {', '.join(names)}; "
                    f"got {describe(shapes)}."
                )
        seconds(f"{call}(period=...)", period)

    def path(self, period: float, count: int, rng: np.random.Generator) -> Array:
        """A sample of the noise at `count` instants with a `period` [s] between them, of shape (count, k).

        It may become the values of a `Table`, for a loop in continuous time. `rng` is a generator of NumPy.
        """
        n, k = len(self.states), self.size
        instants = whole("path(count=...)", count, 2, MOST_DRAWS // (n * k), why="which the memory of a computer holds")
        length = seconds("path(period=...)", period)
        z, w = ca.SX.sym("z", k, n), ca.SX.sym("w", k, n)
        columns = self.start(ca.horzsplit(w)), self.after(ca.horzsplit(z), ca.horzsplit(w), length)
        start, after = (ca.densify(ca.horzcat(*part)) for part in columns)
        draws = rng.standard_normal((instants, k, n))
        first = np.array(ca.Function("start", [w], [start])(draws[0]))
        march = ca.Function("after", [z, w], [after]).mapaccum(instants - 1)
        later = np.array(march(first, np.hstack([*draws[1:]])))
        return np.vstack([first[:, 0], later[:, ::n].T])


@block
class GaussMarkov(AbstractNoise):
    """First-order coloured noise (a Gauss-Markov or Ornstein-Uhlenbeck process), with white noise w of intensity 1:

        x' = -x / T + sigma sqrt(2 / T) w

    Its autocorrelation is E x(t) x(t + s) = sigma^2 exp(-|s| / T). Its two-sided power spectral density is
    S(omega) = 2 sigma^2 T / (1 + (omega T)^2). At the instants of a computer it moves by the exact transition
    x+ = a x + sigma sqrt(1 - a^2) w with a = exp(-period / T) and standard normal w, from x(0) = sigma w.

    Parameters
    ----------
    sigma
        Standard deviation of the noise.
    time_constant
        Correlation time T.

    References
    ----------
    Gelb (1974), Applied Optimal Estimation, section 3.6.

    Examples
    --------
    >>> gust = wb.DisturbedPlant(wb.DCMotor(), by=wb.GaussMarkov("v", sigma=0.5, time_constant=0.2))
    >>> gust.states.names, gust.truths.names
    (('omega', 'i', 'v.noise'), ('d_v',))
    """

    sigma: Vector = parameter(unit="{unit}", low=0, shape=("*",), symbol="sigma")
    time_constant: Vector = parameter(unit="s", low=0, strict=True, shape=("*",), symbol="T")

    @property
    def states(self) -> tuple[tuple[str, str], ...]:
        """The noise."""
        return (("noise", self.unit),)

    def start(self, w: Sequence[ca.SX]) -> tuple[ca.SX, ...]:
        """A sample of the stationary distribution: sigma w."""
        self._refuse_misfit("start", w=w)
        return (self.sigma * w[0],)

    def after(self, z: Sequence[ca.SX], w: Sequence[ca.SX], period: float) -> tuple[ca.SX, ...]:
        """The noise one `period` [s] after z: a z + sigma sqrt(1 - a^2) w."""
        self._refuse_misfit("after", period, z=z, w=w)
        share = period / self.time_constant
        half = ca.tanh(share)  # 1 - exp(-2 s) = 2 tanh(s) / (1 + tanh(s)), which loses no digit of a short period
        return (ca.exp(-share) * z[0] + self.sigma * ca.sqrt(2 * half / (1 + half)) * w[0],)


@block
class SecondOrderNoise(AbstractNoise):
    """Second-order coloured noise, with white noise w of intensity 1:

        x'' = -omega_n^2 x - 2 zeta omega_n x' + 2 sigma sqrt(zeta omega_n^3) w
        S(omega) = 4 sigma^2 zeta omega_n^3 / ((omega_n^2 - omega^2)^2 + (2 zeta omega_n omega)^2)

    S is the two-sided power spectral density. The standard deviation of x' is omega_n sigma. With a small damping zeta
    the noise is a narrow-band oscillation near omega_n, such as waves or a lightly damped mode. With
    zeta = 1 / sqrt(2) its spectrum is flat up to about omega_n. It moves by the matrix exponential, and begins in its
    stationary distribution.

    Parameters
    ----------
    sigma
        Standard deviation of the noise x.
    natural_frequency
        Natural frequency omega_n.
    damping
        Damping ratio zeta.

    References
    ----------
    Gelb (1974), Applied Optimal Estimation, section 3.6.

    Examples
    --------
    >>> waves = wb.SecondOrderNoise("F", sigma=0.2, natural_frequency=2.0, damping=0.1)
    >>> wb.DisturbedPlant(wb.CartPole(), by=waves).states.names[-2:]
    ('F.noise', 'F.noise_rate')
    """

    sigma: Vector = parameter(unit="{unit}", low=0, shape=("*",), symbol="sigma")
    natural_frequency: Scalar = parameter(unit="rad/s", low=0, strict=True, symbol="omega_n")
    damping: Scalar = parameter(unit="1", low=0, strict=True, symbol="zeta")

    @property
    def states(self) -> tuple[tuple[str, str], ...]:
        """The noise and its rate."""
        return ("noise", self.unit), ("noise_rate", per_second(self.unit))

    def start(self, w: Sequence[ca.SX]) -> tuple[ca.SX, ...]:
        """A sample of the stationary distribution, in which the noise and its rate are independent."""
        self._refuse_misfit("start", w=w)
        return self.sigma * w[0], self.sigma * self.natural_frequency * w[1]

    def after(self, z: Sequence[ca.SX], w: Sequence[ca.SX], period: float) -> tuple[ca.SX, ...]:
        """The states one period h [s] later than z: exp(A h) z + L w with L L' = P - exp(A h) P exp(A h)'.

        P = diag(sigma^2, (omega_n sigma)^2) is the covariance of the stationary distribution.
        """
        self._refuse_misfit("after", period, z=z, w=w)
        omega, zeta = self.natural_frequency, self.damping
        a, b = _damped_wave(omega * period, zeta)
        x, y = z[0], z[1] / omega  # in which P is sigma^2 times the unit matrix
        flow = ((a + zeta * b, b), (-b, a - zeta * b))
        rest = [[float(i == j) - sum(flow[i][k] * flow[j][k] for k in range(2)) for j in range(2)] for i in range(2)]
        # the rate first, as x is h^3 small in a short period, and y is h small
        fast = ca.sqrt(ca.fmax(rest[1][1], 0))
        shared = rest[0][1] / ca.fmax(fast, TINY)
        slow = ca.sqrt(ca.fmax(rest[0][0] - shared**2, 0))
        noise = flow[0][0] * x + flow[0][1] * y + self.sigma * (shared * w[1] + slow * w[0])
        rate = flow[1][0] * x + flow[1][1] * y + self.sigma * fast * w[1]
        return noise, omega * rate


@block
class RandomWalk(AbstractNoise):
    """A random walk x' = N w with white noise w of intensity 1, such as the drift of the bias of a gyro:

        E x(t)^2 = start_sigma^2 + N^2 t,      E x(t) x(s) = E x(min(t, s))^2.

    It has no stationary distribution. At the instants of a computer it moves by x+ = x + N sqrt(period) w with standard
    normal w.

    Parameters
    ----------
    intensity
        The intensity N: the standard deviation of the change in 1 s.
    start_sigma
        Standard deviation of x(0), which is normally distributed with mean zero.

    References
    ----------
    IEEE Std 952-1997 (R2008), annex C.1.4 (rate random walk).

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> walk = wb.RandomWalk("omega", intensity=1e-3)
    >>> gyro = wb.Instruments.of(motor, noise={"omega": 0.01}, coloured_noises=(walk,))
    >>> gyro.reads.names, gyro.coloured_noises[0].unit
    (('omega',), 'rad/s')
    """

    intensity: Vector = parameter(unit="{unit}/sqrt(s)", low=0, shape=("*",), symbol="N")
    start_sigma: Vector = parameter(default=0.0, unit="{unit}", low=0, shape=("*",), symbol="sigma_0")

    @property
    def states(self) -> tuple[tuple[str, str], ...]:
        """The noise."""
        return (("noise", self.unit),)

    def start(self, w: Sequence[ca.SX]) -> tuple[ca.SX, ...]:
        """The value at the first instant: start_sigma w."""
        self._refuse_misfit("start", w=w)
        return (self.start_sigma * w[0],)

    def after(self, z: Sequence[ca.SX], w: Sequence[ca.SX], period: float) -> tuple[ca.SX, ...]:
        """The noise one `period` [s] after z: z + N sqrt(period) w."""
        self._refuse_misfit("after", period, z=z, w=w)
        return (z[0] + self.intensity * np.sqrt(period) * w[0],)


def _damped_wave(angle: ca.SX, zeta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """exp(-zeta angle) cos(r) and exp(-zeta angle) sin(r) angle / r for r = angle sqrt(1 - zeta^2), also imaginary."""
    square = 1 - zeta**2
    r = angle * ca.sqrt(ca.fmax(ca.fabs(square), TINY))
    decay, root = ca.exp(-zeta * angle), ca.sqrt(ca.fmax(-square, 0))
    # 1 / (zeta + root) is zeta - root; both exponents are negative, so that nothing overflows
    slow, fast = ca.exp(-angle / (zeta + root)), ca.exp(-angle * (zeta + root))
    fall = ca.if_else(r < 1, decay * ca.sinh(ca.fmin(r, 1)), (slow - fast) / 2)  # whose difference cancels below 1
    cosine = ca.if_else(square >= 0, decay * ca.cos(r), (slow + fast) / 2)
    sine = ca.if_else(square >= 0, decay * ca.sin(r), fall)
    return cosine, sine * angle / r
