"""Coloured noise: processes that move from instant to instant of a computer by an exact transition.

At the instants a process has the distribution of its equation in continuous time, for every period. It begins in its
stationary distribution, if it has one, and is held between two instants.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count

import casadi as ca
import numpy as np

from workbench.blocks.loop.signal_units import fit_element
from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Scalar, Vector, quantities
from workbench.core.units import ANY, per_second
from workbench.core.validation.refusals import Array, describe, seconds, whole

TINY = float(np.finfo(float).tiny)
MOST_DRAWS = 10**8  # of a path: 0.8 GB
Parts = Mapping[str, ca.SX]


@block
class AbstractNoise(ABC):
    """Noise of a `signal`, an output or an input of a plant; its numbers are independent of one another."""

    signal: str
    unit: str = field(default=ANY, init=False)

    @property
    def size(self) -> int:
        """The number of its elements, which is the largest size of its fields."""
        vectors = (getattr(self, f.name) for f, quantity in quantities(self) if quantity.shape == ("*",))
        return max(int(ca.SX(each).numel()) for each in vectors)

    @property
    @abstractmethod
    def states(self) -> tuple[tuple[str, str], ...]:
        """The name and the unit of each of its states; the first one is the noise."""

    @abstractmethod
    def start(self, w: Sequence[ca.SX]) -> tuple[ca.SX, ...]:
        """The states at the first instant, (k, 1) each, from as many columns of standard normal numbers."""

    @abstractmethod
    def after(self, z: Sequence[ca.SX], w: Sequence[ca.SX], period: float) -> tuple[ca.SX, ...]:
        """The states a `period` [s] after z, (k, 1) each, from z and columns w of standard normal numbers."""

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
        """The noise at `count` instants that are a `period` [s] apart, (count, k), for a `Table` in continuous time."""
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
    """Noise of first order, the process of Ornstein and Uhlenbeck: x' = -x / T + sigma sqrt(2 / T) w, w white,

        E x(t) x(t + s) = sigma^2 exp(-|s| / T),      S(omega) = 2 sigma^2 T / (1 + (omega T)^2) on both sides of 0.

    It moves by x+ = a x + sigma sqrt(1 - a^2) w with a = exp(-period / T), and x(0) = sigma w.

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
        """A value from the stationary distribution."""
        self._refuse_misfit("start", w=w)
        return (self.sigma * w[0],)

    def after(self, z: Sequence[ca.SX], w: Sequence[ca.SX], period: float) -> tuple[ca.SX, ...]:
        """a z + sigma sqrt(1 - a^2) w."""
        self._refuse_misfit("after", period, z=z, w=w)
        share = period / self.time_constant
        half = ca.tanh(share)  # 1 - exp(-2 s) = 2 tanh(s) / (1 + tanh(s)), which loses no digit of a short period
        return (ca.exp(-share) * z[0] + self.sigma * ca.sqrt(2 * half / (1 + half)) * w[0],)


@block
class SecondOrderNoise(AbstractNoise):
    """Noise of second order: x'' = -omega_n^2 x - 2 zeta omega_n x' + 2 sigma sqrt(zeta omega_n^3) w, w white,

        S(omega) = 4 sigma^2 zeta omega_n^3 / ((omega_n^2 - omega^2)^2 + (2 zeta omega_n omega)^2) on both sides of 0.

    The standard deviation of x is sigma, and the one of x' is omega_n sigma. With a small damping zeta it is a hum near
    omega_n, such as waves or a lightly damped mode. With zeta = 1 / sqrt(2) it is white within a band up to omega_n. It
    moves by the exponential of its matrix, and begins in its stationary distribution.

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
        """Values from the stationary distribution, in which noise and rate are independent."""
        self._refuse_misfit("start", w=w)
        return self.sigma * w[0], self.sigma * self.natural_frequency * w[1]

    def after(self, z: Sequence[ca.SX], w: Sequence[ca.SX], period: float) -> tuple[ca.SX, ...]:
        """exp(A h) z + L w with L L' = P - exp(A h) P exp(A h)', P = diag(sigma^2, (omega_n sigma)^2)."""
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
    """A drift, as of the bias of a gyro: x' = N w, w white, with x(0) normal of the standard deviation `start_sigma`,

        E x(t)^2 = start_sigma^2 + N^2 t,      E x(t) x(s) = E x(min(t, s))^2,

    where N is the `intensity`. It has no stationary distribution and moves by x+ = x + N sqrt(period) w.

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
        """The value at the start."""
        self._refuse_misfit("start", w=w)
        return (self.start_sigma * w[0],)

    def after(self, z: Sequence[ca.SX], w: Sequence[ca.SX], period: float) -> tuple[ca.SX, ...]:
        """z + N sqrt(period) w."""
        self._refuse_misfit("after", period, z=z, w=w)
        return (z[0] + self.intensity * np.sqrt(period) * w[0],)


def noise_of(field: str, noise: AbstractNoise, port: Layout, of: str) -> AbstractNoise:
    """A noise in the unit of its signal of a port, with one number for each element of the signal."""
    fitting = fit_element(field, noise, port, of)
    shape = port[noise.signal].shape
    for f, quantity in quantities(fitting):
        if quantity.shape == ("*",):
            object.__setattr__(fitting, f.name, _numbers(getattr(fitting, f.name), shape))
    return fitting


def _numbers(value: Array | float, shape: tuple[int, ...]) -> Array | float:
    return np.broadcast_to(value, shape).copy() if shape else value


@dataclass(frozen=True)
class NoiseStates:
    """The states of noises by name: 'v.noise', and 'v.noise_2' for a second noise of v."""

    noises: tuple[AbstractNoise, ...]

    @property
    def layout(self) -> Layout:
        """The states, zero before the first instant."""
        entries = (
            _entry(here, noise.size, unit)
            for noise, names in self._names()
            for here, (_, unit) in zip(names, noise.states, strict=True)
        )
        return Layout(tuple(entries))

    @property
    def signals(self) -> Layout:
        """The signals that have a noise."""
        return Layout(tuple({each.signal: _entry(each.signal, each.size, each.unit) for each in self.noises}.values()))

    def after(self, k: ca.SX, z: Parts, w: ca.SX, period: float) -> dict[str, ca.SX]:
        """The states at the instant k, with standard normal w, (size of the layout, 1)."""
        draws, moved = self.layout.view(w), dict[str, ca.SX]()
        for noise, names in self._names():
            own = [draws[name] for name in names]
            pairs = zip(noise.start(own), noise.after([z[name] for name in names], own, period), strict=True)
            moved |= {n: ca.if_else(k == 0, first, later) for n, (first, later) in zip(names, pairs, strict=True)}
        return moved

    def signal_noise(self, z: Parts) -> Signals:
        """The sum of the noises of each signal."""
        sums = dict[str, ca.SX]()
        for noise, (name, *_) in self._names():
            sums[noise.signal] = sums[noise.signal] + z[name] if noise.signal in sums else z[name]
        return Signals(sums)

    def _names(self) -> Iterator[tuple[AbstractNoise, list[str]]]:
        taken = set[str]()
        for noise in self.noises:
            for i in count(1):
                names = [f"{noise.signal}.{own}{'' if i == 1 else f'_{i}'}" for own, _ in noise.states]
                if taken.isdisjoint(names):
                    break
            taken |= set(names)
            yield noise, names


def _entry(name: str, size: int, unit: str) -> Entry:
    return Entry(name, np.zeros(() if size == 1 else size), unit)


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
