"""Modes of a linear system: its poles, and which of them no input reaches or no output shows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from workbench.design.matrices import Complex
from workbench.validation.refusals import Array, described
from workbench.validation.signatures import door
from workbench.validation.views import show

if TYPE_CHECKING:
    import control

ROUNDING = float(np.finfo(float).eps)
TOLERANCE = 1e-9  # of the margin: below it a mode counts as not reached
TAKES_PART = 0.1  # of the largest entry: what a state must have to be named
DESCENTS = 30
NEARBY = 4.0  # times the norm of A and the nx-th root of rounding: how far that may move a multiple eigenvalue


@dataclass(frozen=True)
@show
class Pole:
    """An eigenvalue lambda of A, and what belongs to it.

    Attributes
    ----------
    value
        lambda in 1/s; of a discrete system the number z itself.
    frequency
        The natural frequency |lambda| in rad/s; of a discrete system that of log(z) / dt, infinite at z = 0.
    damping
        -Re lambda / |lambda|: 1 for a decay without oscillation, negative where it grows, NaN at zero.
    condition
        By how much a small change of A may move the pole, relative to that change (Wilkinson); infinite at a
        defective eigenvalue.
    states
        The states that take part, by participation factors of at least a tenth of the largest, that one first.
    """

    value: complex
    frequency: float
    damping: float
    condition: float
    states: tuple[str, ...]


@door
def poles(system: control.StateSpace) -> tuple[Pole, ...]:
    """The poles of a system, the slowest to decay first.

    Raises
    ------
    ValueError
        If it is no `StateSpace` with finite matrices.

    References
    ----------
    Wilkinson (1965), The Algebraic Eigenvalue Problem, chapter 2; Perez-Arriaga, Verghese and Schweppe (1982),
    IEEE Transactions on Power Apparatus and Systems 101 (participation factors).
    """
    A = _matrices("poles", system)[0]
    names = system.state_labels
    values, right = np.linalg.eig(A)
    left = _inverse(right)  # its rows are left eigenvectors, each with w v = 1
    found = []
    for k, value in enumerate(values):
        along = left[k] * right[:, k]
        with np.errstate(over="ignore"):
            condition = float(np.linalg.norm(left[k]))
        size, damping = _spread(complex(value), system.dt if system.isdtime(strict=True) else None)
        found.append(Pole(complex(value), size, damping, condition, _named(along, names)))
    growth = np.abs(values) if system.isdtime(strict=True) else values.real
    return tuple(found[k] for k in np.lexsort((-values.imag, -np.round(growth, 9))))


def _spread(value: complex, dt: float | None) -> tuple[float, float]:
    """Natural frequency and damping of a pole; of z = 0, which is gone after one step, infinite and 1."""
    if dt is not None and not value:
        return float("inf"), 1.0
    s = value if dt is None else complex(np.log(value)) / dt
    size = abs(s)
    return size, -s.real / size if size else float("nan")


@dataclass(frozen=True, eq=False)
@show
class Mode:
    """An eigenvalue of A under the test of Popov, Belevitch and Hautus.

    Attributes
    ----------
    value
        lambda, where the matrix of the test is nearest to a loss of rank.
    margin
        The smallest singular value of [lambda I - A, B], or of [lambda I - A; Cy], as a share of the norm of
        [A, B] or [A; Cy]: how small a change of the matrices would hide the mode.
    direction
        The unit vector (nx,) that no input moves, as w* x, or that no output shows.
    states
        Which states take part in it, the largest first.
    """

    value: complex
    margin: float
    direction: Complex
    states: tuple[str, ...]


@dataclass(frozen=True, eq=False)
@show
class Hautus:
    """The outcome of a test of Popov, Belevitch and Hautus.

    Attributes
    ----------
    kind
        "controllable", "stabilisable", "observable" or "detectable".
    modes
        All eigenvalues that the test asks about, the smallest margin first.
    tolerance
        What a margin must exceed.
    """

    kind: str
    modes: tuple[Mode, ...]
    tolerance: float

    @property
    def holds(self) -> bool:
        """Whether every mode that is asked about has its margin."""
        return not self.failing

    @property
    def failing(self) -> tuple[Mode, ...]:
        """The modes without a margin."""
        return tuple(mode for mode in self.modes if mode.margin <= self.tolerance)

    @property
    def margin(self) -> float:
        """The smallest margin; infinite where no mode is asked about."""
        return min((mode.margin for mode in self.modes), default=float("inf"))

    def __str__(self) -> str:
        """The verdict in a sentence, with the modes that fail."""
        if self.holds:
            return f"{self.kind}: the smallest margin is {self.margin:.2g} (tolerance {self.tolerance:.1g})"
        what = "no input moves" if self.kind in ("controllable", "stabilisable") else "no output shows"
        modes = "; ".join(
            f"{_shown(m.value)} along {', '.join(m.states)} (margin {m.margin:.1g})" for m in self.failing
        )
        return f"not {self.kind}: {what} the mode {modes} (tolerance {self.tolerance:.1g})"


@door
def controllability(system: control.StateSpace, tolerance: float = TOLERANCE) -> Hautus:
    """Whether rank [lambda I - A, B] = nx at every eigenvalue lambda of A: inputs move every mode.

    Margins depend on the units of the states, as every distance between matrices does. At an eigenvalue that rounding
    has moved, as it moves multiple ones, the smallest singular value is sought nearby.

    Parameters
    ----------
    tolerance
        The margin, relative to the norm of [A, B], at which a mode counts as not reached.

    Raises
    ------
    ValueError
        If it is no `StateSpace` with finite matrices, or the tolerance is not between rounding and 1.

    References
    ----------
    Hautus (1969), Indagationes Mathematicae 31; Eising (1984), Systems & Control Letters 4 (the distance).
    """
    return _hautus("controllable", system, tolerance)


@door
def stabilisability(system: control.StateSpace, tolerance: float = TOLERANCE) -> Hautus:
    """As `controllability`, of the modes that do not decay: their real part is above -`tolerance` times the norm of A.

    Of a discrete system they are those with |z| above 1 - tolerance.
    """
    return _hautus("stabilisable", system, tolerance)


@door
def observability(system: control.StateSpace, tolerance: float = TOLERANCE) -> Hautus:
    """Whether rank [lambda I - A; Cy] = nx at every eigenvalue lambda of A: outputs show every mode.

    Margins, tolerance and refusals are those of `controllability`.
    """
    return _hautus("observable", system, tolerance)


@door
def detectability(system: control.StateSpace, tolerance: float = TOLERANCE) -> Hautus:
    """As `observability`, of the modes that do not decay, as `stabilisability` counts them."""
    return _hautus("detectable", system, tolerance)


def _hautus(kind: str, system: control.StateSpace, tolerance: float) -> Hautus:
    A, B, Cy = _matrices(kind, system)
    if not ROUNDING < tolerance < 1:
        raise ValueError(f"`{kind}(tolerance=...)` must be between rounding, 2e-16, and 1; got {tolerance!r}.")
    by_input, by_all = kind in ("controllable", "stabilisable"), kind in ("controllable", "observable")
    A, B = (A, B) if by_input else (A.T, Cy.T)  # what is observable is controllable of the transpose
    scale = float(np.linalg.norm(np.hstack([A, B]), 2)) or 1.0
    discrete, edge = system.isdtime(strict=True), 1 - tolerance
    least = -np.inf if by_all else -tolerance * float(np.linalg.norm(A, 2))

    def asked(value: complex) -> complex:
        """The nearest value that the test asks about."""
        if discrete:
            return value if by_all or abs(value) >= edge else edge * value / (abs(value) or 1.0)
        return complex(max(value.real, least), value.imag)

    values = [value for value in np.linalg.eigvals(A).astype(complex) if asked(value) == value]
    modes = (_mode(A, B, value, scale, system.state_labels, asked) for value in values)
    return Hautus(kind, tuple(sorted(modes, key=lambda m: m.margin)), tolerance)


def _mode(
    A: Array, B: Array, value: complex, scale: float, names: list[str], asked: Callable[[complex], complex]
) -> Mode:
    """The mode at an eigenvalue, or where the smallest singular value of [lambda I - A, B] is least near it.

    Newton's method on w* [lambda I - A, B] v = 0 with the singular vectors w and v; short steps where that overshoots.
    It keeps to what is asked about: a mode that decays may be lost.
    """
    w, margin, slope = _least(A, B, value)
    start, reach = value, NEARBY * ROUNDING ** (1 / len(A)) * float(np.linalg.norm(A, 2))
    for _ in range(DESCENTS):
        step = margin / slope if slope else 0.0
        for nearby in (asked(value - step), asked(value - abs(slope) ** 2 * step)):
            found = _least(A, B, nearby)
            if found[1] < margin * (1 - 1e-6) and abs(nearby - start) <= reach:
                value, (w, margin, slope) = nearby, found
                break
        else:
            break
    return Mode(complex(value), margin / scale, w, _named(w, names))


def _least(A: Array, B: Array, value: complex) -> tuple[Complex, float, complex]:
    """The least singular value of [lambda I - A, B], its left vector w, and w* v: its derivative by lambda."""
    U, s, V = np.linalg.svd(np.hstack([value * np.eye(len(A)) - A, B]), full_matrices=False)
    w = U[:, -1]
    return w, float(s[-1]), complex(w.conj() @ V[-1, : len(A)].conj())


def _inverse(vectors: Array) -> Array:
    """The inverse of the matrix of eigenvectors; infinite where a defective eigenvalue leaves none."""
    try:
        return np.asarray(np.linalg.inv(vectors))
    except np.linalg.LinAlgError:
        return np.full_like(vectors, np.inf)


def _named(vector: Complex, names: list[str]) -> tuple[str, ...]:
    """The names of the entries that are large, the largest first; of equal ones the first."""
    size = np.abs(vector)
    order = np.argsort(-np.round(size / (size.max() or 1.0), 6), kind="stable")
    return tuple(names[i] for i in order if size[i] >= TAKES_PART * size.max())


def _matrices(call: str, system: Any) -> tuple[Array, Array, Array]:
    import control

    if not isinstance(system, control.StateSpace):
        raise ValueError(
            f"A system to be asked whether it is {call} must be a `StateSpace` of python-control, as `linearize` "
            f"gives; got {described(system)}."
            if call != "poles"
            else f"`poles(system)` must be a `StateSpace` of python-control, as `linearize` gives; "
            f"got {described(system)}."
        )
    matrices = tuple(np.asarray(matrix, dtype=float) for matrix in (system.A, system.B, system.C))
    if not all(np.isfinite(matrix).all() for matrix in matrices):
        raise ValueError(f"The matrices of '{system.name}' must be finite to have modes; one of them is not.")
    A, B, Cy = matrices
    return A, B, Cy


def _shown(value: complex) -> str:
    return (
        f"{value.real:.4g}{value.imag:+.4g}j 1/s"
        if abs(value.imag) > ROUNDING * abs(value)
        else f"{value.real:.4g} 1/s"
    )
