"""The loop of a linear plant behind a zero-order hold and a discrete law, with an exact delay of the command."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import matrix_balance

from workbench.design.frequency.exponentials import growth, held_map
from workbench.design.frequency.period_poles import PeriodPoles, period_poles
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import EPS, Complex, Refused
from workbench.validation.notebook_display import show
from workbench.validation.refusals import Array, finite, numbers, refusal
from workbench.validation.signatures import door

if TYPE_CHECKING:
    import control

LONGEST = 500  # states of the map that the delay may add: its poles are found within seconds
SAME = 4 * EPS  # relative: a delay nearer to a whole number of periods than this is one
Matrices = tuple[Array, Array, Array, Array]


@dataclass(frozen=True, eq=False)
@show
class HoldResponse:
    """The answers of a sampled loop at `frequencies` (m,) in rad/s, and how far rounding may have moved each.

    `loop` is L(e^jwh) = P(e^jwh) K(e^jwh), (m, ny, ny), cut at the sampled output. `between` (m, ny, ny) is the part at
    w of the plant's output in continuous time while the reference is e^jwkh at the instants kh, without the harmonics
    that the hold adds at w + 2 pi i / h. Where the closed loop is not stable no run tends to it.
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

    At the instant k h the law reads y and computes u, which is applied `delay` s later and held for a period h: after
    `whole` periods and a `rest` of the next.
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
            raise Refused(
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

    @door
    def response(self, frequencies: Array) -> HoldResponse:
        """The answers at frequencies (m,) in rad/s, in rising order from zero to Nyquist's frequency pi / h.

        Raises
        ------
        ValueError
            If the frequencies are none, not finite, falling, negative, or above Nyquist's.
        Refused
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
        L, L_error = solved("The loop", omega, loop, driven, output, 0j * Cy @ B @ Dk, sizes)
        Y, Y_error = solved("The closed loop", omega, closed, driven, seen, through, sizes)
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


@door
def hold_loop(plant: control.StateSpace, law: control.StateSpace, delay: float = 0.0) -> HoldLoop:
    """The loop that a discrete law closes around a continuous plant, by negative feedback: e = r - y.

    Parameters
    ----------
    plant
        In continuous time, without feedthrough: its output at an instant does not know the command of that instant.
    law
        In discrete time, from the ny errors to the nu commands; its dt is the period h.
    delay
        From the reading to the command, in s: any fraction or number of periods, exactly.

    Raises
    ------
    ValueError
        If plant and law do not fit, the law has no period, or the delay is negative or not finite.
    Refused
        If the exponential of the plant over a period is too large.

    References
    ----------
    Åström and Wittenmark (1997), Computer-Controlled Systems, sections 2.3 and 7.7.
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


def continuous_plant(call: str, plant: Any) -> tuple[Array, Array, Array]:
    """A, B and Cy of a plant in continuous time without feedthrough."""
    A, B, Cy, D = state_space(call.partition("(")[0], plant)
    if plant.isdtime(strict=True):
        raise ValueError(f"`{call}` must be in continuous time; '{plant.name}' has the period {plant.dt} s.")
    if D.any():
        raise ValueError(
            f"`{call}` must have no feedthrough D, or its output at an instant would depend on whether it is read "
            f"before or after the command changes; that of '{plant.name}' has. Add the lag of its sensor."
        )
    return A, B, Cy


def sampled_law(call: str, law: Any) -> tuple[Matrices, float]:
    """The matrices of a law in discrete time, and its period in s."""
    matrices = state_space(call.partition("(")[0], law)
    if not law.isdtime(strict=True) or law.dt is True or not 0 < law.dt < math.inf:
        raise ValueError(
            f"`{call}` must be in discrete time with a positive period dt in s; '{law.name}' has dt = {law.dt}. Sample "
            "a continuous law by `c2d`."
        )
    return matrices, float(law.dt)


def band(call: str, frequencies: Any, nyquist: float = math.inf) -> Array:
    """Frequencies (m,) in rad/s that do not fall, from zero to Nyquist's frequency."""
    omega = numbers(call, frequencies, 1)
    if not omega.size or not np.isfinite(omega).all():
        raise refusal(call, "a vector of finite numbers, at least one", frequencies)
    if (np.diff(omega) < 0).any() or omega[0] < 0:
        raise ValueError(
            f"`{call}` must rise from zero on, in rad/s; got {omega[0]:g} first and {omega[-1]:g} last. Sort them."
        )
    if omega[-1] > nyquist * (1 + SAME):
        raise ValueError(
            f"`{call}` must not exceed Nyquist's frequency pi / h = {nyquist:.6g} rad/s, above which samples repeat "
            f"what they are below it; got {omega[-1]:.6g} rad/s."
        )
    return omega


def solved(
    what: str, omega: Array, matrix: Complex, driven: Complex, seen: Complex, through: Complex, sizes: Array
) -> tuple[Complex, Array]:
    """seen matrix^-1 driven + through at each frequency (m, ny, nu), and the error that rounding may have made there.

    To first order each entry of the matrix is off by some roundings of itself and of its `sizes`, which the answers of
    both sides weigh.
    """
    scale = matrix_balance(np.abs(matrix).max(axis=0), permute=False, separate=True)[1][0]
    matrix, driven, seen = matrix * scale / scale[:, np.newaxis], driven / scale[:, np.newaxis], seen * scale
    try:
        right = _refined(matrix, driven)
        left = _refined(matrix.swapaxes(1, 2), seen.swapaxes(1, 2)).swapaxes(1, 2)
    except np.linalg.LinAlgError:
        right = left = np.full((), np.nan)
    if not np.isfinite(right).all() or not np.isfinite(left).all():
        at = omega[int(np.argmin([np.linalg.svd(one, compute_uv=False)[-1] for one in matrix]))]
        raise Refused(f"{what} has a pole at {at:.6g} rad/s, where it has no answer; leave that frequency out.")
    size = np.abs(matrix) + sizes * scale / scale[:, np.newaxis]
    terms = np.abs(left) @ (size @ np.abs(right) + np.abs(driven)) + np.abs(seen) @ np.abs(right) + np.abs(through)
    return np.asarray(seen @ right + through), np.asarray((matrix.shape[1] + 1) * EPS * terms)


def _refined(matrix: Complex, driven: Complex) -> Complex:
    """matrix^-1 driven, with a step of refinement, after which each entry of the matrix counts by its own size."""
    first = np.linalg.solve(matrix, driven)
    return np.asarray(first + np.linalg.solve(matrix, driven - matrix @ first))
