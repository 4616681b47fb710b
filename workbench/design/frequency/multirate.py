"""Laws with periods of their own around one plant, as one map over the common period of all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, refusal, seconds, several
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.frequency.exponentials import held_map
from workbench.design.frequency.period_poles import PeriodPoles, period_poles
from workbench.design.frequency.sampled_loop_inputs import Matrices, continuous_plant, sampled_law
from workbench.design.matrices import EPS

if TYPE_CHECKING:
    import control

MOST = 10_000  # instants of one law in the common period
NEAR = 1e-9  # relative: how near the dt of a law must be to its period
SAME = Fraction(4 * EPS)  # relative: two decimal periods as doubles have the ratio of the decimals to this


@dataclass(frozen=True, eq=False)
@show
class LiftedLoop:
    """The map of a loop over the common `period` of its laws in s; its state (nx + nz,) is that of plant and laws.

    All laws read at t = 0, so the commands held before are no part of the state. `counts` says how often each law reads
    in the common period; `change` is the map minus the identity.
    """

    period: float
    counts: tuple[int, ...]
    change: Array

    @property
    def poles(self) -> PeriodPoles:
        """The poles of the map over the common period."""
        return period_poles("lift_rates(...).poles", self.period, self.change, sum(self.counts))


@check_arguments
def lift_rates(
    plant: control.StateSpace, laws: Sequence[System], periods: Sequence[Fraction] | None = None
) -> LiftedLoop:
    """The loop that laws u_i = -K_i y_i close around a plant, each at its period, all at t = 0, over a common period.

    Parameters
    ----------
    plant
        In continuous time without feedthrough; its inputs and outputs are those of the laws, one law after the other.
    laws
        In discrete time; each has its period as dt, reads its outputs and holds its commands until it reads again.
    periods
        The exact periods in s as fractions, if the doubles dt are their rounded values.

    Raises
    ------
    ValueError
        If plant and laws do not fit, or the periods have no common one.
    DesignError
        If the exponential of the plant over a gap is too large.

    References
    ----------
    Kranc (1957), Input-output analysis of multirate feedback systems, IRE Trans. Autom. Control 3.

    Examples
    --------
    >>> import control
    >>> from workbench.design.frequency import lift_rates
    >>> law = control.ss([[0.5]], [[1.0]], [[0.2]], [[0.1]], 0.1)
    >>> plant = control.ss([[0.0, 1.0], [0.0, -1.0]], [[0.0], [1.0]], [[1.0, 0.0]], 0.0)
    >>> lift_rates(plant, [law]).period
    0.1
    """
    A, B, Cy = continuous_plant("lift_rates(plant=...)", plant)
    if not laws:
        raise ValueError("`lift_rates(laws=...)` must hold at least one law; got none.")
    parts = [sampled_law(f"lift_rates(laws=[{i}])", law) for i, law in enumerate(laws)]
    matrices = [part[0] for part in parts]
    ways = [(law.ninputs, law.noutputs) for law in laws]
    if tuple(map(sum, zip(*ways, strict=True))) != (plant.noutputs, plant.ninputs):
        raise ValueError(
            f"`lift_rates(laws=...)` must read the {plant.noutputs} outputs of the plant and drive its {plant.ninputs} "
            f"inputs, each one once; got {ways}, inputs and outputs of each law."
        )
    own = [part[1] for part in parts]
    spans: Sequence[Fraction | float] = (
        own if periods is None else several("lift_rates(periods=...)", periods, Fraction)
    )
    if len(spans) != len(own) or any(abs(float(a) - b) > NEAR * b for a, b in zip(spans, own, strict=True)):
        raise ValueError(
            f"`lift_rates(periods=...)` must be the {len(own)} periods of the laws as fractions; got "
            f"{', '.join(map(str, spans))} for {', '.join(f'{one:g}' for one in own)} s."
        )
    period, counts = common_period(spans)
    return LiftedLoop(period, counts, _change(A, B, Cy, matrices, period, counts))


@check_arguments
def common_period(periods: Sequence[object]) -> tuple[float, tuple[int, ...]]:
    """The least common multiple of periods in s, numbers or fractions, and how often each fits into it.

    Their ratios are taken as the simplest fractions from which they differ by rounding alone, so that 0.3 is three
    times 0.1; two periods such as 1 and sqrt(2) have no common period with at most 10,000 instants.

    Raises
    ------
    ValueError
        If a period is not positive, or there is no common one.

    Examples
    --------
    >>> from fractions import Fraction
    >>> wb.frequency.common_period([0.1, Fraction(1, 4)])
    (0.5, (5, 2))
    """
    if not periods:
        raise ValueError("`common_period(periods=...)` must hold at least one period; got none.")
    exact = [_fraction(f"common_period(periods=[{i}])", one) for i, one in enumerate(periods)]
    ratios = []
    for i, one in enumerate(exact):
        ratio = one / exact[0]
        near = ratio.limit_denominator(MOST)
        if abs(near - ratio) > SAME * ratio:
            raise _no_common(exact, 0, i)
        ratios.append(near)
    # the least common multiple of fractions in lowest terms
    times = Fraction(lcm(*(ratio.numerator for ratio in ratios)), gcd(*(ratio.denominator for ratio in ratios)))
    counts = tuple(int(times / ratio) for ratio in ratios)
    if max(counts) > MOST:
        raise _no_common(exact, counts.index(min(counts)), counts.index(max(counts)))
    return float(exact[0] * times), counts


def _fraction(call: str, period: object) -> Fraction:
    """A period as the fraction that it exactly is."""
    if isinstance(period, Fraction):
        if period <= 0:
            raise refusal(call, "a positive fraction of seconds", period)
        return period
    return Fraction(seconds(call, period))


def _no_common(periods: Sequence[Fraction], first: int, other: int) -> ValueError:
    return ValueError(
        f"`common_period(periods=...)`: {float(periods[first])!r} s and {float(periods[other])!r} s have no common "
        f"period in which each fits {MOST} times at most; choose periods whose ratio is a simple fraction."
    )


def _change(A: Array, B: Array, Cy: Array, laws: Sequence[Matrices], period: float, counts: tuple[int, ...]) -> Array:
    """The map over the common period less I, of the states x and z; between instants the commands are states, too."""
    n, nz, nu = len(A), sum(len(law[0]) for law in laws), B.shape[1]
    size, ticks = n + nz + nu, lcm(*counts)
    flows: dict[int, Array] = {}

    def flow(gap: int) -> Array:
        if gap not in flows:
            step = np.zeros((size, size))
            step[:n, :n], step[:n, n + nz :] = held_map(A, B, gap * period / ticks)
            flows[gap] = step
        return flows[gap]

    instants = sorted({k * (ticks // count) for count in counts for k in range(count)})
    change = np.zeros((size, size))
    for now, then in zip(instants, [*instants[1:], ticks], strict=True):
        reading = [now % (ticks // count) == 0 for count in counts]
        for step in (_jump(Cy, laws, reading, size, n), flow(then - now)):
            change = change + step + step @ change
    return change[: n + nz, : n + nz]


def _jump(Cy: Array, laws: Sequence[Matrices], reading_rows: Sequence[bool], size: int, n: int) -> Array:
    """The change of (x, z, u) at an instant at which some of the laws read."""
    step = np.zeros((size, size))
    z, u, y = n, n + sum(len(law[0]) for law in laws), 0
    for (Ak, Bk, Ck, Dk), reads in zip(laws, reading_rows, strict=True):
        states, commands = slice(z, z + len(Ak)), slice(u, u + len(Dk))
        output = Cy[y : y + Dk.shape[1]]
        if reads:
            step[states, :n], step[states, states] = Bk @ output, Ak - np.eye(len(Ak))
            step[commands, :n], step[commands, states] = -Dk @ output, -Ck
            step[commands, commands] = -np.eye(len(Dk))
        z, u, y = states.stop, commands.stop, y + Dk.shape[1]
    return step
