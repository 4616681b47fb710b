"""The margins of a loop with too many states for exact polynomials: eigenvalues in doubles, each with its error.

Candidates of a crossover are the imaginary eigenvalues of a Hamiltonian matrix, where |L| = 1, and the zeros of
L(s) - L(-s), where L is real; between two of them the sign decides. What rounding may have moved, to first order, is
the error of each figure; none of them is proved. The circle of a discrete loop is taken to the axis by
z = (1 + v) / (1 - v).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import block_diag, eig, eigvals, schur

from workbench.core.validation.refusals import Array
from workbench.design.frequency.axis_loop import exact_delay, period_of
from workbench.design.frequency.bilinear_loops import delayed_loop, loop_on_axis
from workbench.design.frequency.certified_values import (
    INFINITE,
    ZERO,
    CertifiedPeak,
    CertifiedValue,
    greatest,
    least,
    magnitude,
    twice_inverse,
    widen,
)
from workbench.design.frequency.exact_systems import MOST_STATES
from workbench.design.frequency.margin_records import Crossover, StabilityMargins, StableMargins
from workbench.design.frequency.response_errors import response_with_error
from workbench.design.linear.feedback_loops import crossings_of, largest_gain, pole_frequencies, sensitivity
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import EPS, Complex, DesignError, one_thread, pole_text

if TYPE_CHECKING:
    import control

MOST = 400  # states: some minute
GRID = 500  # frequencies between which a sign is looked at, beside the candidates
AT_ONCE = 16  # responses with their errors
INTEGRATES = 1e12  # the condition of A beyond which a loop does


def estimated_margins(loop: control.StateSpace, delay: float) -> StabilityMargins:
    """The margins of a `StateSpace` with one channel, of a discrete one with whole periods of delay.

    Raises
    ------
    ValueError
        As `stability_margins`.
    DesignError
        If a continuous loop has a delay, the loop has more than `MOST` states, 1 + D is zero, or a pole of the closed
        loop is as near to the axis as rounding may move it.
    """
    call = "stability_margins"
    matrices, period = state_space(call, loop), period_of(call, loop)
    late = exact_delay(call, delay, period)
    if late and period is None:
        raise DesignError(
            f"`{call}(delay=...)` must be zero for a continuous loop with more than {MOST_STATES} states, as its peaks "
            f"are bounded by exact polynomials; got {delay:g} s for {len(matrices[0])} states. Reduce it first: "
            "`wb.reduction` takes up to 60 states, `control.balred` with Slycot more."
        )
    if len(matrices[0]) + late > MOST:
        raise DesignError(
            f"`{call}(loop=...)` must have at most {MOST} states, as eigenvalues of twice as many are needed; "
            f"got {len(matrices[0]) + int(late)}. Reduce it first, by `control.balred` with Slycot "
            "say."
        )
    with one_thread():
        given = delayed_loop(*matrices, int(late))
        L = loop_on_axis(given) if period else given
        S = sensitivity(L)
        axis = _Axis(L, given, period)
        found = axis.gain_crossovers(), axis.phase_crossovers()
        stable = _is_stable(S)
        margins = _margins(axis, S, *found) if stable else None
    remark = (
        f"The loop has {len(L.A)} states: its figures are from eigenvalues in doubles, and their bounds are estimates "
        "of rounding, not proofs."
    )
    return StabilityMargins(stable, *found, margins, (remark,))


def _is_stable(S: control.StateSpace) -> bool:
    """True if all poles lie on the left by more than rounding moves them, False if one lies on the right."""
    values, left, right = eig(S.A, left=True, right=True)
    across = np.abs(np.einsum("ij,ij->j", left.conj(), right))
    with np.errstate(divide="ignore"):
        errors = len(S.A) * EPS * np.linalg.norm(S.A, 2) / across
    if (values.real > errors).any():
        return False
    if (near := values[np.abs(values.real) <= errors]).size:
        raise DesignError(
            f"`stability_margins(loop=...)` must know on which side the poles of the closed loop lie; "
            f"{pole_text(near[0])} is as near to the axis as rounding may move it. Reduce it, or balance its states."
        )
    return True


@dataclass(frozen=True, eq=False)
class _Axis:
    """A loop L on the imaginary axis, and the same loop as the given `system`, in z if it has a period in s."""

    L: control.StateSpace
    system: control.StateSpace
    period: float | None

    def frequency(self, omega: CertifiedValue) -> CertifiedValue:
        """The frequency that an omega on the axis stands for."""
        if self.period is None:
            return omega
        h = self.period
        return widen(*(2 / h * math.atan(part) for part in (omega.value, omega.low, omega.high)))

    def gain_crossovers(self) -> tuple[Crossover, ...]:
        """All places with |L| = 1 but those where it is only touched, with the phase margin in degrees."""
        answer, own = _response(self.L), abs(float(self.L.D[0, 0]))
        candidates = crossings_of(self.L, 1.0) if own != 1 else np.zeros(0)

        def excess(omega: Array) -> Array:
            size = np.abs(answer(omega))
            return np.asarray((size - 1) / (size + 1))

        rows = []
        for omega, value, slope, error in self._answers(_zeros(excess, _between(self.L, candidates))):
            rate = slope / value
            doubt = (error + abs(abs(value) - 1)) / max(abs(rate.real), 1e-300) + 2 * EPS * omega
            degrees = math.degrees(float(np.angle(-value)))
            spread = math.degrees(error + abs(rate.imag) * doubt) + 4 * EPS * 180
            margin = CertifiedValue(degrees, degrees - spread, degrees + spread)
            rows.append(Crossover(self.frequency(CertifiedValue(omega, omega - doubt, omega + doubt)), margin))
        return tuple(rows)

    def phase_crossovers(self) -> tuple[Crossover, ...]:
        """All places with L < 0, zero and infinity included, with the factor -1 / L."""
        answer, own = _response(self.L), float(self.L.D[0, 0])
        places = _zeros(lambda omega: np.asarray(answer(omega).imag), _between(self.L, _real_candidates(self.L)))
        if len(self.L.A) and np.linalg.cond(self.L.A) < INTEGRATES:
            places = np.concatenate([[0.0], places])
        rows = []
        for omega, value, slope, error in self._answers(places):
            doubt = (error + abs(value.imag)) / max(abs(slope.imag), 1e-300) + 2 * EPS * omega if omega else 0.0
            if value.real < 0:
                factor, spread = -1 / value.real, (error + abs(slope.real) * doubt) / value.real**2
                rows.append(
                    Crossover(
                        self.frequency(CertifiedValue(omega, omega - doubt, omega + doubt)),
                        CertifiedValue(factor, factor - spread, factor + spread),
                    )
                )
        if own < 0:
            size, error = -own, 0.0
            if self.period is not None:
                ((_, value, _, error),) = self._answers(np.array([math.inf]))
                size = abs(value)
            margin = widen(1 / size, 1 / (size + error), 1 / (size - error))
            rows.append(Crossover(self.frequency(INFINITE), margin))
        return tuple(rows)

    def _answers(self, places: Array) -> list[tuple[float, complex, complex, float]]:
        """omega, L, its slope by omega, and the error of L, at each place on the axis."""
        if self.period is None:
            return _with_errors(self.system, places, np.asarray(1j * places), np.full(len(places), 1j))
        with np.errstate(invalid="ignore"):
            z = np.where(np.isinf(places), -1.0, (1 + 1j * places) / (1 - 1j * places))
            return _with_errors(self.system, places, np.asarray(z), np.asarray(2j / (1 - 1j * places) ** 2))


def _margins(
    axis: _Axis, S: control.StateSpace, gains: tuple[Crossover, ...], phases: tuple[Crossover, ...]
) -> StableMargins:
    factors, answer = [row.margin for row in phases], _response(S)
    Ms, Mt, balance = (_peak(axis, S, answer, k, d) for k, d in ((1.0, 0.0), (-1.0, 1.0), (2.0, -1.0)))
    delay = least(_delay(row) for row in gains)
    if axis.period is None and abs(float(axis.L.D[0, 0])) > 1:
        delay = ZERO
    return StableMargins(
        greatest(f for f in factors if f.value < 1),
        least(f for f in factors if f.value > 1),
        least(magnitude(row.margin) for row in gains),
        delay,
        *(Ms, Mt, twice_inverse(balance.gain), balance.frequency),
    )


def _peak(axis: _Axis, S: control.StateSpace, answer: Callable[[Array], Complex], k: float, d: float) -> CertifiedPeak:
    """The peak of k S + d: of S, of T = 1 - S, and of S - T = 2 S - 1."""
    import control

    def response(omega: Array) -> Complex:
        return np.asarray((k * answer(omega) + d)[:, np.newaxis, np.newaxis])

    system = control.ss(S.A, S.B, k * S.C, k * S.D + d)
    top = largest_gain(system, response)
    doubt = 0.0
    if math.isfinite(top.frequency):
        place = np.array([top.frequency])
        ((*_, doubt),) = _with_errors(system, place, 1j * place, 0j * place)
    at = axis.frequency(CertifiedValue(top.frequency, top.frequency, top.frequency))
    return CertifiedPeak(CertifiedValue(top.below, top.below - doubt, top.above + doubt), at.value)


def _delay(row: Crossover) -> CertifiedValue:
    """The delay in s whose lag is the phase margin, taken as positive."""
    turn = 360.0 if row.margin.value < 0 else 0.0
    value, low, high = (math.radians(part + turn) for part in (row.margin.value, row.margin.low, row.margin.high))
    return widen(value / row.frequency.value, low / row.frequency.high, high / row.frequency.low)


def _response(G: control.StateSpace) -> Callable[[Array], Complex]:
    """The function C (j omega - A)^-1 B + D of frequencies (m,), by back substitution in the Schur form of A."""
    n = len(G.A)
    T, U = schur(G.A, output="complex") if n else (np.zeros((0, 0), complex), np.zeros((0, 0), complex))
    b, c, d = (U.conj().T @ G.B)[:, 0], (G.C @ U)[0], float(G.D[0, 0])

    def answer(omega: Array) -> Complex:
        s = 1j * np.asarray(omega)
        x = np.zeros((n, len(s)), complex)
        with np.errstate(all="ignore"):
            for k in range(n - 1, -1, -1):
                x[k] = (b[k] + T[k, k + 1 :] @ x[k + 1 :]) / (s - T[k, k])
        return np.asarray(c @ x + d)

    return answer


def _with_errors(
    G: control.StateSpace, places: Array, points: Complex, turns: Complex
) -> list[tuple[float, complex, complex, float]]:
    """The place, G at its point s, the slope for ds = `turns`, and the error of G, each."""
    n, rows = len(G.A), []
    rounded = np.eye(n) * (points.real != 0).any()  # z on the circle is rounded, j omega is not
    for start in range(0, len(places), AT_ONCE):
        part = slice(start, start + AT_ONCE)
        m = len(places[part])
        matrix = points[part, np.newaxis, np.newaxis] * np.eye(n) - G.A
        driven, seen = np.broadcast_to(G.B + 0j, (m, n, 1)), np.broadcast_to(G.C + 0j, (m, 1, n))
        values, errors = response_with_error("The loop", places[part], matrix, driven, seen, G.D + 0j, rounded)
        slopes = -seen @ np.linalg.solve(matrix, np.linalg.solve(matrix, driven))
        parts = values[:, 0, 0], turns[part] * slopes[:, 0, 0], errors[:, 0, 0]
        rows += list(zip(places[part].tolist(), *(one.tolist() for one in parts), strict=True))
    return rows


def _real_candidates(L: control.StateSpace) -> Array:
    """The frequencies at which L may be real, (N,): the zeros of L(s) - L(-s), perhaps with some others."""
    nx = len(L.A)
    pencil = np.block([[block_diag(L.A, -L.A), np.vstack([L.B, L.B])], [L.C, L.C, np.zeros((1, 1))]])
    with np.errstate(divide="ignore", invalid="ignore"):  # the zeros at infinity
        zeros = eigvals(pencil, block_diag(np.eye(2 * nx), np.zeros((1, 1))))
    return np.unique(np.abs(zeros[np.isfinite(zeros)].imag))


def _between(L: control.StateSpace, candidates: Array) -> Array:
    """Frequencies in rad/s, from far below all poles to far above, with one between any two candidates of a zero."""
    spread = np.concatenate([pole_frequencies(system, GRID) for system in (L, sensitivity(L))])
    candidates = np.sort(candidates[(candidates > 0) & (candidates < 1e6 * spread.max())])
    # not just halfway, where an undamped pole may lie
    gaps = 0.47 * candidates[:-1] + 0.53 * candidates[1:]
    ends = np.concatenate([candidates[:1] / 3, 3 * candidates[-1:]])
    return np.unique(np.concatenate([spread, gaps, ends]))


def _zeros(function: Callable[[Array], Array], frequencies: Array) -> Array:
    """The zeros of a function of frequencies, at those given and between those where it changes its sign."""
    from scipy.optimize import brentq  # here, as it takes long to import

    def at(omega: float) -> float:
        return float(function(np.array([omega]))[0])

    signs = np.sign(function(frequencies))
    places = np.flatnonzero(signs[:-1] * signs[1:] < 0)
    ends = [(float(frequencies[k]), float(frequencies[k + 1])) for k in places]
    found = [brentq(at, low, high, xtol=1e-13 * low, rtol=1e-13) for low, high in ends]
    return np.sort([*found, *frequencies[signs == 0]])
