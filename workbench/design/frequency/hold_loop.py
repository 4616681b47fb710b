"""The loop of a linear plant behind a zero-order hold and a discrete law, with an exact delay of the command."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, finite
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.exponentials import growth, held_map
from workbench.design.frequency.period_poles import PeriodPoles, period_poles
from workbench.design.frequency.response_errors import response_with_error
from workbench.design.frequency.sampled_loop_inputs import SAME, Matrices, band, continuous_plant, sampled_law
from workbench.design.matrices import Complex, DesignError

if TYPE_CHECKING:
    import control

LONGEST = 500  # states of the map that the delay may add: its poles are found within seconds


@dataclass(frozen=True, eq=False)
@show
class HoldResponse:
    """The frequency responses of a sampled loop at `frequencies` (m,) in rad/s, with their rounding errors.

    `loop` is L(e^jwh) = P(e^jwh) K(e^jwh), (m, ny, ny), cut at the sampled output. `between` (m, ny, ny) is the part at
    the frequency w of the plant's output in continuous time, if the reference is e^jwkh at the instants kh; it leaves
    out the harmonics that the hold adds at w + 2 pi i / h. If the closed loop is not stable, no run converges to
    `between`. `loop_error` and `between_error` say how far rounding may have moved each.
    """

    frequencies: Array
    loop: Complex
    between: Complex
    loop_error: Array
    between_error: Array


@dataclass(frozen=True, eq=False)
@show
class HoldLoop:
    """The plant x' = A x + B u, y = Cy x, and the law z+ = Ak z + Bk e, u = Ck z + Dk e with e = r - y.

    At the instant k h the law reads y and computes u. The plant gets u `delay` s later, for a period h. The delay is
    `whole` periods and `rest` s. `plant` has A, B, Cy, and `period` is h in s.
    """

    plant: tuple[Array, Array, Array]
    law: Matrices
    period: float
    delay: float
    whole: int
    rest: float

    @property
    def poles(self) -> PeriodPoles:
        """The poles of the map of one period: of the plant, the law and the commands that are on their way."""
        A, B, Cy = self.plant
        Ak, Bk, Ck, Dk = self.law
        n, nk, nu = len(A), len(Ak), B.shape[1]
        waiting = self.whole + (self.rest > 0)
        if waiting * nu > LONGEST:
            raise DesignError(
                f"`hold_loop(delay=...)`: a delay of {waiting} periods adds {waiting * nu} states to the map of the "
                f"period, of which {LONGEST} are the most whose poles are computed; its response has no such limit."
            )
        E, new, old = self._map()
        command = np.zeros((nu, n + nk + waiting * nu))
        command[:, : n + nk] = np.hstack([-Dk @ Cy, Ck])
        line = np.eye(waiting * nu, command.shape[1], n + nk)  # the commands u(k-1), u(k-2), ...
        commands = np.vstack([command, line])
        change = np.zeros((command.shape[1], command.shape[1]))
        change[:n, :n] = E
        change[:n] += new @ commands[self.whole * nu :][:nu]
        if self.rest:
            change[:n] += old @ commands[(self.whole + 1) * nu :][:nu]
        change[n : n + nk, : n + nk] = np.hstack([-Bk @ Cy, Ak - np.eye(nk)])
        change[n + nk :] = commands[: waiting * nu] - line
        return period_poles("hold_loop(...).poles", self.period, change)

    @check_arguments
    def response(self, frequencies: Array) -> HoldResponse:
        """The frequency response at `frequencies` (m,) in rad/s, in rising order from zero to Nyquist's pi / h.

        Raises
        ------
        ValueError
            If there are no frequencies, or one is not finite, negative, above Nyquist's or below the one before it.
        DesignError
            If the loop, or the closed loop, has a pole there.
        """
        omega = band("hold_loop(...).response(frequencies=...)", frequencies, math.pi / self.period)
        (A, B, Cy), (Ak, Bk, Ck, Dk) = self.plant, self.law
        m, n, nk, ny = len(omega), len(A), len(Ak), len(Cy)
        E, new, old = self._map()
        turn = np.expm1(1j * omega * self.period)[:, np.newaxis, np.newaxis]  # z - 1
        z = 1 + turn
        late = np.exp(-1j * omega * self.whole * self.period)[:, np.newaxis, np.newaxis]
        G = late * (new + old / z)
        loop = np.zeros((m, n + nk, n + nk), complex)
        loop[:, :n, :n] = turn * np.eye(n) - E
        loop[:, n:, n:] = turn * np.eye(nk) - (Ak - np.eye(nk))
        loop[:, :n, n:] = -G @ Ck
        closed = loop.copy()
        closed[:, :n, :n] += G @ Dk @ Cy
        closed[:, n:, :n] = Bk @ Cy
        driven = np.concatenate([G @ Dk, np.broadcast_to(Bk, (m, *Bk.shape)).astype(complex)], axis=1)
        seen, through = self._between(omega, z, late)
        output = np.broadcast_to(np.hstack([Cy, np.zeros((ny, nk))]), (m, ny, n + nk))
        sizes = np.zeros((n + nk, n + nk))
        sizes[:n, :n] = np.abs(growth(A, self.period / 2)[0])  # by rounding of which E is off where it returns to zero
        turns = 1 + omega * (self.delay + self.period)  # the phases that are rounded
        L, L_error = response_with_error("The loop", omega, loop, driven, output, 0j * Cy @ B @ Dk, sizes)
        Y, Y_error = response_with_error("The closed loop", omega, closed, driven, seen, through, sizes)
        L_error, Y_error = (turns[:, np.newaxis, np.newaxis] * error for error in (L_error, Y_error))
        return HoldResponse(omega, L, Y, L_error, Y_error)

    def _map(self) -> tuple[Array, Array, Array]:
        """E, G_new and G_old of x+ = x + E x + G_new u(k - whole) + G_old u(k - whole - 1)."""
        A, B, _ = self.plant
        E, _ = held_map(A, B, self.period)
        after, new = held_map(A, B, self.period - self.rest)
        _, first = held_map(A, B, self.rest)
        return E, new, first + after @ first

    def _between(self, omega: Array, z: Complex, late: Complex) -> tuple[Complex, Complex]:
        """The rows (m, ny, nx) by which the part at w of the output follows from the state, and from r directly.

        It is the mean of y(t) e^-jwt over a period; the plant and the command that is held are one system, whose
        exponential turned by -jw is integrated over the two spans of the period.
        """
        A, B, Cy = self.plant
        _, _, Ck, Dk = self.law
        n, nu = B.shape
        flow = np.zeros((n + nu, n + nu))
        flow[:n, :n], flow[:n, n:] = A, B
        turned = flow - 1j * omega[:, np.newaxis, np.newaxis] * np.eye(n + nu)
        first = growth(turned, self.rest)[1][:, :n]
        then = growth(turned, self.period - self.rest)[1][:, :n]
        then = then * np.exp(-1j * omega * self.rest)[:, np.newaxis, np.newaxis]
        E, G = held_map(A, B, self.rest)
        by_state = first[:, :, :n] + then[:, :, :n] @ (np.eye(n) + E)
        by_command = late * ((first[:, :, n:] + then[:, :, :n] @ G) / z + then[:, :, n:])
        by_command, by_state = Cy @ by_command / self.period, Cy @ by_state / self.period
        return np.concatenate([by_state - by_command @ Dk @ Cy, by_command @ Ck], axis=2), by_command @ Dk


@check_arguments
def hold_loop(plant: control.StateSpace, law: control.StateSpace, delay: float = 0.0) -> HoldLoop:
    """The loop that a discrete law closes around a continuous plant, by negative feedback: e = r - y.

    Parameters
    ----------
    plant
        In continuous time, without feedthrough: its output does not depend on the command of the same instant.
    law
        In discrete time, from the ny errors to the nu commands; its dt is the period h.
    delay
        The time from the reading to the command in s: any fraction or number of periods; it is exact.

    Raises
    ------
    ValueError
        If plant and law do not fit, the law has no period, or the delay is negative or not finite.
    DesignError
        If the exponential of the plant over a period is too large.

    References
    ----------
    Åström and Wittenmark (1997), Computer-Controlled Systems, sections 2.3 and 7.7.

    Examples
    --------
    >>> import control
    >>> from workbench.design.frequency import hold_loop
    >>> law = control.ss([[0.5]], [[1.0]], [[0.2]], [[0.1]], 0.1)
    >>> plant = control.ss([[0.0, 1.0], [0.0, -1.0]], [[0.0], [1.0]], [[1.0, 0.0]], 0.0)
    >>> hold_loop(plant, law, 0.03).response([1.0, 2.0]).frequencies
    array([1., 2.])
    """
    A, B, Cy = continuous_plant("hold_loop(plant=...)", plant)
    matrices, period = sampled_law("hold_loop(law=...)", law)
    if (law.ninputs, law.noutputs) != (plant.noutputs, plant.ninputs):
        raise ValueError(
            f"`hold_loop(law=...)` must have the {plant.noutputs} outputs of the plant as inputs and its "
            f"{plant.ninputs} inputs as outputs; got {law.ninputs} inputs and {law.noutputs} outputs."
        )
    late = finite("hold_loop(delay=...)", delay, " of seconds", low=0)
    whole, rest = round(late / period), math.fmod(late, period)  # the rest exactly
    if min(rest, period - rest) <= SAME * late:
        return HoldLoop((A, B, Cy), matrices, period, late, whole, 0.0)
    return HoldLoop((A, B, Cy), matrices, period, late, round((late - rest) / period), rest)
