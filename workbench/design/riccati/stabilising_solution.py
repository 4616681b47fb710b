"""The stabilising solution of a Riccati equation with its certificate, or the reason why there is none.

References
----------
Hautus (1969), Controllability and observability conditions of linear autonomous systems, Indag. Math. 31.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.core.point import OperatingPoint
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import (
    EPS,
    Certificate,
    Complex,
    DesignError,
    definite,
    indefinite,
    invertible,
    matrix,
    one_thread,
    pole_text,
    square,
    symmetric,
)
from workbench.design.riccati.algebraic_equation import Data, RiccatiEquation, distances, hamiltonian, norm
from workbench.design.riccati.conditioning import BinaryUnits, Conditioning, conditioning, good_units, in_range
from workbench.design.riccati.double_double import twice
from workbench.design.riccati.newton import NewtonResult, candidates, refine

NEAR = 1e-7  # half the digits and a little more: eigenvalues that meet on the boundary are found no better
RANK_TOLERANCE = 1e-12  # a relative distance from a loss of rank that rounding may have made
MOST_MODES = 40  # each asks for singular values
WORST_RESIDUAL = 1e-11
WORST_ERROR = 1e-4  # four digits of X for the data as given
WORST_MOVE = 1e-2  # two digits of X in good units when every matrix is rounded to floating-point numbers
WORTH_A_WARNING = 1e-6
UNSURE = 0.01  # of a margin, that rounding may take
RESIDUAL_ROUNDING = 2.0**-100  # of the terms of a residual: what sums in twice the working precision may lose
ROUNDING = 8 * EPS  # what a few operations on the data, a change of coordinates say, do to them


@dataclass(frozen=True)
@show
class Riccati:
    """The stabilising solution X (n, n) of an algebraic Riccati equation, symmetric, and its gain.

    K is (m, n) of a regulator u = -K x, or (n, ny) of an estimator x_hat' = A x_hat + K (y - C x_hat); the poles (n,)
    are those of A - B K, or A - K C. `point` is the operating point of the linearised system from which K was designed,
    if any.
    """

    X: Array
    K: Array
    poles: Complex
    certificate: Certificate
    point: OperatingPoint | None = None


@check_arguments
def care(A: Numbers, B: Numbers, Q: Numbers, R: Numbers, S: Numbers | None = None, E: Numbers | None = None) -> Riccati:
    """The stabilising X of A'XE + E'XA - (E'XB + S) R^-1 (B'XE + S') + Q = 0, and K = R^-1 (B'XE + S').

    With u = -K x every pole of E x' = A x + B u lies left of the imaginary axis. Q may be indefinite.

    Parameters
    ----------
    A, B, E
        (n, n), (n, m) and (n, n); without E, the identity.
    Q, R, S
        The symmetric weights of states (n, n) and inputs (m, m), R positive definite, and between them (n, m), or zero.

    Raises
    ------
    ValueError
        If a matrix is not real, finite, or of its shape, Q or R not symmetric, R not positive definite, or E singular.
    DesignError
        If there is no stabilising X, or none that can be trusted.

    Examples
    --------
    >>> from workbench.design.riccati import care
    >>> from workbench.design.riccati_flow import fpre, rde
    >>> one, times = [[1.0]], [0.0, 9.0]
    >>> care([[0.0]], one, one, one).X, fpre([[0.0]], one, one, one, [[2.0]], times).P[-1].round(3)
    (array([[1.]]), array([[1.]]))
    >>> rde([[0.0]], one, one, one, [[2.0]], times).P[0].round(3)
    array([[1.]])
    >>> care([[0.0, 1.0], [0.0, 0.0]], [[0.0], [1.0]], np.eye(2), np.eye(1), np.zeros((2, 1)), np.eye(2)).K.round(3)
    array([[1.   , 1.732]])
    """
    call = "care(A, B, Q, R)"
    return stabilising_solution(call, checked_data(call, A, B, Q, R, S, E), discrete=False)


@check_arguments
def dare(A: Numbers, B: Numbers, Q: Numbers, R: Numbers, S: Numbers | None = None, E: Numbers | None = None) -> Riccati:
    """The stabilising X of A'XA - E'XE - (A'XB + S) (R + B'XB)^-1 (B'XA + S') + Q = 0, and its gain K.

    With u = -K x, K = (R + B'XB)^-1 (B'XA + S'), every pole of E x+ = A x + B u lies inside the unit circle. Shapes and
    refusals are those of `care`, but R may be singular or indefinite, as long as R + B'XB has an inverse; where that is
    not positive definite the certificate warns.

    Examples
    --------
    >>> from workbench.design.riccati import dare
    >>> dare([[1.0, 0.1], [0.0, 1.0]], [[0.0], [0.1]], np.eye(2), np.eye(1), np.zeros((2, 1)), np.eye(2)).K.round(3)
    array([[0.917, 1.682]])
    """
    call = "dare(A, B, Q, R)"
    return stabilising_solution(call, checked_data(call, A, B, Q, R, S, E, positive=False), discrete=True)


def checked_data(
    call: str, A: object, B: object, Q: object, R: object, S: object = None, E: object = None, positive: bool = True
) -> Data:
    """The matrices of a Riccati equation, each of its shape; R must be definite if it must be `positive`."""
    a = square(call, "A", A)
    n = len(a)
    b = matrix(call, "B", B, rows=n)
    m = b.shape[1]
    weight = definite if positive else symmetric
    return Data(
        A=a,
        B=b,
        Q=symmetric(call, "Q", Q, n),
        R=weight(call, "R", R, m),
        S=np.zeros((n, m)) if S is None else matrix(call, "S", S, n, m),
        E=None if E is None else invertible(call, "E", E, n),
    )


# The reasons that there is no gain, in words for a regulator and for an estimator.
REGULATOR = {
    "unmoved": "the pair (A, B) is not stabilisable: no input moves the unstable mode {mode} of A (relative PBH "
    "distance {distance:.1e}). Give it an actuator, or leave it out of the model",
    "free": "the mode {mode} of A lies on the {edge} and costs nothing in Q (relative PBH distance {distance:.1e}), "
    "so it stays where it is. Give it a weight in Q",
}
ESTIMATOR = {
    "unmoved": "the pair (A, C) is not detectable: no output sees the unstable mode {mode} of A (relative PBH distance "
    "{distance:.1e}). Give it a sensor, or leave it out of the model",
    "free": "the mode {mode} of A lies on the {edge} and no noise drives it (relative PBH distance {distance:.1e}), so "
    "the filter stops to look at it. Give it noise in Qn",
}


def reason(d: Data, discrete: bool, words: dict[str, str] = REGULATOR) -> str:
    """One sentence on why there is no stabilising solution, or an empty text if none is seen."""
    modes: Complex = np.asarray(linalg.eigvals(d.A, d.E), dtype=complex)
    modes = modes[np.isfinite(modes)]
    inside = distances(modes, discrete)
    scale = 1.0 if discrete else max(1e-300, float(np.abs(modes).max(initial=0)))
    mode, distance = _worst(d, modes[inside <= NEAR * scale], d.B, beside=True)
    if distance <= RANK_TOLERANCE:
        return words["unmoved"].format(mode=pole_text(mode), distance=distance)
    mode, distance = _worst(d, modes[np.abs(inside) <= NEAR * scale], d.Q, beside=False)
    if distance <= RANK_TOLERANCE and not d.S.any():
        edge = "unit circle" if discrete else "imaginary axis"
        return words["free"].format(mode=pole_text(mode), distance=distance, edge=edge)
    return "" if discrete else _axis(d)


def _axis(d: Data) -> str:
    try:
        values = np.linalg.eigvals(hamiltonian(d))
    except (np.linalg.LinAlgError, ValueError):
        return ""
    nearest = values[np.abs(values.real).argmin()]
    if abs(nearest.real) > NEAR * np.abs(values).max():
        return ""
    return (
        f"the Hamiltonian matrix has the eigenvalue {pole_text(complex(0, abs(nearest.imag)))} on the imaginary axis, "
        "within rounding, so no X stabilises A - B K. Weigh the states more in Q"
    )


def _worst(d: Data, modes: Complex, other: Array, beside: bool) -> tuple[complex, float]:
    """The mode whose pencil [A - mode E, other], or the same stacked, comes nearest to a loss of rank."""
    found = 0j, np.inf
    E = np.eye(d.n) if d.E is None else d.E
    # both parts are made of one size, so that neither hides the other's zeros
    size = [max(norm(matrix), 1e-300) for matrix in (d.A, other)]
    for mode in modes[:MOST_MODES]:
        parts = [(d.A - mode * E) / size[0], other / size[1]]
        values = np.linalg.svd(np.hstack(parts) if beside else np.vstack(parts), compute_uv=False)
        if values[-1] < found[1]:
            found = complex(mode), float(values[-1])
    return found


@one_thread()
@np.errstate(all="ignore")  # what leaves the range of floats is seen in the certificate
def stabilising_solution(call: str, data: Data, discrete: bool, words: dict[str, str] = REGULATOR) -> Riccati:
    """The stabilising solution of the first method that finds one that can be trusted, or a refusal with the reason."""
    units = good_units(data)
    equation = RiccatiEquation(units.into(data), discrete)
    objections = []
    for X in candidates(equation):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # singular matrices are seen in the certificate
                found = refine(equation, X)
                certificate, K, against = _judge(equation, found, units)
        except (OverflowError, ValueError):  # SciPy's answer to what is not finite, and the parent of LinAlgError
            continue
        if not against:
            X = in_range(call, "X", units.out_of(found.point.X), found.point.X)
            K = in_range(call, "K", units.gain(K), K)
            return Riccati(X, K, found.operator.poles, certificate)
        objections.append(against)
        if certificate.decay_rate > 0 and certificate.residual <= WORST_RESIDUAL and certificate.error <= WORST_ERROR:
            break  # every method would end at this X, trusted or not
    why = reason(equation.data, discrete, words) or (objections[0] if objections else "no method finds one")
    raise DesignError(f"`{call}`: there is no stabilising solution X that can be trusted: {why}.")


def _judge(equation: RiccatiEquation, solution: NewtonResult, units: BinaryUnits) -> tuple[Certificate, Array, str]:
    """The certificate of a refined candidate, its gain, and the worst objection to it."""
    point = solution.point
    margin = solution.operator.margin
    known = conditioning(equation, solution, units) if margin > 0 else Conditioning(np.inf, np.inf, 0.0, np.inf)
    # the gain may hang on digits that X has no room for, so it is that of X and the next step together
    beyond = equation.at(twice(point.X) + solution.correction)
    still = solution.operator.solve(-beyond.residual)
    # what Newton's method still sees, what its next step would leave, and what lies below the digits of its residual
    lacking = (
        norm(units.out_of(solution.correction))
        + norm(units.out_of(still))
        + RESIDUAL_ROUNDING * point.terms * known.response
    )
    error = lacking / (norm(units.out_of(point.X)) or np.inf)
    of_gain = norm(units.gain(equation.gain_change(beyond, still))) / (norm(units.gain(beyond.K)) or np.inf)
    certificate = Certificate(
        residual=point.relative,
        error=max(error, EPS / 2) if point.X.any() else 0.0,
        condition=known.condition,
        decay_rate=margin,
        newton_steps=solution.steps,
        warnings=tuple(_warnings(equation, solution, error, of_gain, known)),
    )
    return certificate, beyond.K, _against(solution, certificate, known)


def _against(solution: NewtonResult, certificate: Certificate, sensitivity: Conditioning) -> str:
    if not certificate.decay_rate > 0:
        slowest = complex(solution.operator.poles[solution.operator.margins.argmin()])
        return f"the closed loop of the nearest solution has the pole {pole_text(slowest)}"
    if not certificate.residual <= WORST_RESIDUAL:
        return f"the relative residual stays at {certificate.residual:.1e}, above {WORST_RESIDUAL:g}"
    if not sensitivity.reach > ROUNDING:
        return (
            f"a relative change of the data by {sensitivity.reach:.1e}, less than their rounding, may move "
            "eigenvalues of the closed loop onto the edge of stability"
        )
    if not certificate.error <= WORST_ERROR:
        return f"the relative error of X is about {certificate.error:.1e}, above {WORST_ERROR:g}"
    if not sensitivity.in_good_units * EPS <= WORST_MOVE:
        change = f"{sensitivity.in_good_units * EPS:.1e}"
        return f"rounding the data can change X, in good units, by {change} of its size, so its digits mean nothing"
    return ""


def doubts(condition: float, error: float) -> Iterator[str]:
    """The reasons for doubt in a solution X of any equation."""
    if condition * EPS > WORTH_A_WARNING:
        yield f"rounding the data can change X by up to {condition * EPS:.1e} of its size"
    if error > WORTH_A_WARNING:
        yield f"X is known to a relative error of about {error:.1e} only"


def _warnings(
    equation: RiccatiEquation, solution: NewtonResult, error: float, of_gain: float, sensitivity: Conditioning
) -> Iterator[str]:
    yield from doubts(sensitivity.condition, error)
    if of_gain > WORTH_A_WARNING:
        yield f"K is known to a relative error of about {of_gain:.1e} only"
    margin = solution.operator.margin
    if margin > 0 and (sure := solution.operator.sure_margin()) < (1 - UNSURE) * margin:
        yield f"rounding moves the poles: of the decay rate {margin:.3g} only {sure:.3g} is sure"
    if sensitivity.reach < 1 and sensitivity.reach > 0 and sensitivity.reach < EPS / WORTH_A_WARNING:
        yield f"relative changes of the data beyond about {sensitivity.reach:.1e} may leave no stabilising solution"
    if indefinite(equation.data.Q):
        yield "Q is not positive semidefinite: X stabilises, but a loop that does not may cost less"
    if indefinite((solution.point.W + solution.point.W.T) / 2):
        yield "R + B'XB is not positive definite: u = -K x stabilises, but the cost has no minimum there"
