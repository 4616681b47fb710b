"""The modes of a linear system: its poles, and tests of controllability and observability."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import EPS, Complex, pole_text

if TYPE_CHECKING:
    import control

TOLERANCE = 1e-9  # of the margin: below it a mode counts as not reached
TAKES_PART = 0.1  # of the largest entry: what a state must have to be named
DESCENTS = 30
NEARBY = 4.0  # times the norm of A and the nx-th root of rounding: how far that may move a multiple eigenvalue


@dataclass(frozen=True)
@show
class Pole:
    """An eigenvalue lambda of A in 1/s, or z of a discrete system, with its frequency, damping and dominant states.

    `frequency` is |lambda| in rad/s, with lambda = log(z) / dt for a discrete system. `damping` is -Re lambda /
    |lambda|: 1 for a decay without oscillation, negative for growth, NaN at zero. A small change of A moves the pole by
    `condition` times as much; it is infinite at a defective eigenvalue. `states` are those with a participation factor
    of at least a tenth of the largest, the largest first.
    """

    value: complex
    frequency: float
    damping: float
    condition: float
    states: tuple[str, ...]


@check_arguments
def poles(system: control.StateSpace) -> tuple[Pole, ...]:
    """The poles of a system, the slowest to decay first.

    References
    ----------
    Wilkinson (1965), The Algebraic Eigenvalue Problem, chapter 2; Perez-Arriaga, Verghese and Schweppe (1982),
    IEEE Transactions on Power Apparatus and Systems 101 (participation factors).
    """
    A = state_space("poles", system)[0]
    names = system.state_labels
    values, right = np.linalg.eig(A)
    try:
        left = np.asarray(np.linalg.inv(right))  # its rows are left eigenvectors, each with w v = 1
    except np.linalg.LinAlgError:  # a defective eigenvalue
        left = np.full_like(right, np.inf)
    found = []
    for k, value in enumerate(values):
        along = left[k] * right[:, k]
        with np.errstate(over="ignore"):
            condition = float(np.linalg.norm(left[k]))
        size, damping = _frequency_and_damping(complex(value), system.dt if system.isdtime(strict=True) else None)
        found.append(Pole(complex(value), size, damping, condition, _names_of(along, names)))
    growth = np.abs(values) if system.isdtime(strict=True) else values.real
    return tuple(found[k] for k in np.lexsort((-values.imag, -np.round(growth, 9))))


def _frequency_and_damping(value: complex, dt: float | None) -> tuple[float, float]:
    """The natural frequency and damping of a pole; infinite and 1 for z = 0, which decays in one step."""
    if dt is not None and not value:
        return float("inf"), 1.0
    s = value if dt is None else complex(np.log(value)) / dt
    size = abs(s)
    return size, -s.real / size if size else float("nan")


@dataclass(frozen=True, eq=False)
@show
class HautusMode:
    """An eigenvalue of A under the test of Popov, Belevitch and Hautus, where its matrix is nearest to a loss of rank.

    `margin` is the smallest singular value of [lambda I - A, B], or [lambda I - A; Cy], as a share of the norm of [A,
    B] or [A; Cy]: the size of the change of the matrices that would hide the mode. After this change no input would
    move, or no output would show, the unit vector `direction` (nx,). `states` take part in it, the largest first.
    """

    value: complex
    margin: float
    direction: Complex
    states: tuple[str, ...]


@dataclass(frozen=True, eq=False)
@show
class Hautus:
    """A test of Popov, Belevitch and Hautus: the margin of each of the `modes` must exceed the `tolerance`."""

    kind: str
    modes: tuple[HautusMode, ...]
    tolerance: float

    @property
    def holds(self) -> bool:
        """True if the margin of every mode exceeds the tolerance."""
        return not self.failing_modes

    @property
    def failing_modes(self) -> tuple[HautusMode, ...]:
        """The modes whose margin does not exceed the tolerance."""
        return tuple(mode for mode in self.modes if mode.margin <= self.tolerance)

    @property
    def margin(self) -> float:
        """The smallest margin."""
        return self.modes[0].margin

    def __str__(self) -> str:
        if self.holds:
            return f"{self.kind}: the smallest margin is {self.margin:.2g} (tolerance {self.tolerance:.1g})"
        what = "no input moves" if self.kind == "controllable" else "no output shows"
        modes = "; ".join(
            f"{pole_text(m.value)} 1/s along {', '.join(m.states)} (margin {m.margin:.1g})" for m in self.failing_modes
        )
        return f"not {self.kind}: {what} the mode {modes} (tolerance {self.tolerance:.1g})"


@check_arguments
def controllability(system: control.StateSpace, tolerance: float = TOLERANCE) -> Hautus:
    """The test that rank [lambda I - A, B] = nx at every eigenvalue lambda of A: inputs move every mode.

    Margins depend on the units of the states. A margin below `tolerance`, a number between rounding and 1, counts as
    zero. Rounding moves multiple eigenvalues; so the smallest singular value is sought near such an eigenvalue, too.

    References
    ----------
    Hautus (1969), Indagationes Mathematicae 31; Eising (1984), Systems & Control Letters 4 (the distance).
    """
    A, B, _, _ = state_space("controllability", system)
    return _hautus("controllable", A, B, system.state_labels, tolerance)


@check_arguments
def observability(system: control.StateSpace, tolerance: float = TOLERANCE) -> Hautus:
    """The test that rank [lambda I - A; Cy] = nx at every eigenvalue lambda of A: outputs show every mode.

    Margins, tolerance and refusals are those of `controllability`.

    Examples
    --------
    >>> import control
    >>> from workbench.design.linear import observability
    >>> observability(control.ss([[0.0, 1.0], [-2.0, -0.3]], [[0.0], [1.0]], [[1.0, 0.0]], 0.0)).kind
    'observable'
    """
    A, _, Cy, _ = state_space("observability", system)
    return _hautus("observable", A.T, Cy.T, system.state_labels, tolerance)  # controllable of the transpose


def _least(A: Array, B: Array, value: complex) -> tuple[Complex, float, complex]:
    """The least singular value of [lambda I - A, B], its left vector w, and w* v: its derivative by lambda."""
    U, s, V = np.linalg.svd(np.hstack([value * np.eye(len(A)) - A, B]), full_matrices=False)
    w = U[:, -1]
    return w, float(s[-1]), complex(w.conj() @ V[-1, : len(A)].conj())


def _names_of(vector: Complex, names: list[str]) -> tuple[str, ...]:
    """The names of the entries that are large, the largest first; of equal ones the first."""
    size = np.abs(vector)
    largest = size.max()
    order = np.argsort(-np.round(size / (largest or 1.0), 6), kind="stable")
    return tuple(names[i] for i in order if size[i] >= TAKES_PART * largest)


def _hautus(kind: str, A: Array, B: Array, names: list[str], tolerance: float) -> Hautus:
    if not EPS < tolerance < 1:
        raise ValueError(f"`{kind}(tolerance=...)` must be between rounding, 2e-16, and 1; got {tolerance!r}.")
    scale = float(np.linalg.norm(np.hstack([A, B]), 2)) or 1.0
    modes = (hautus_mode(A, B, value, scale, names) for value in np.linalg.eigvals(A).astype(complex))
    return Hautus(kind, tuple(sorted(modes, key=lambda m: m.margin)), tolerance)


def mode_at(A: Array, B: Array, value: complex, scale: float, names: list[str]) -> HautusMode:
    """The mode at an eigenvalue itself."""
    w, margin, _ = _least(A, B, value)
    return HautusMode(complex(value), margin / scale, w, _names_of(w, names))


def hautus_mode(A: Array, B: Array, value: complex, scale: float, names: list[str]) -> HautusMode:
    """The mode at an eigenvalue, or near it where the least singular value of [lambda I - A, B] has a minimum."""
    w, margin, slope = _least(A, B, value)
    start, reach = value, NEARBY * EPS ** (1 / len(A)) * float(np.linalg.norm(A, 2))
    for _ in range(DESCENTS):
        step = margin / slope if slope else 0.0
        for nearby in (value - step, value - abs(slope) ** 2 * step):
            found = _least(A, B, nearby)
            if found[1] < margin * (1 - 1e-6) and abs(nearby - start) <= reach:
                value, (w, margin, slope) = nearby, found
                break
        else:
            break
    return HautusMode(complex(value), margin / scale, w, _names_of(w, names))
