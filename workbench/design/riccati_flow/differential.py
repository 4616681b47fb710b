"""The Riccati equations in time, backward from a terminal weight and forward from a start, and along states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, as_array, describe
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import EPS, Certificate, DesignError, answer, symmetric
from workbench.design.riccati import Riccati, care
from workbench.design.riccati_flow.moebius import LARGEST, Escape, constant_flow
from workbench.design.riccati_flow.time_varying import Coefficient, Coefficients, varying_flow

GRIDS = (0, 1)  # halvings beyond need: two ways to cut time, whose answers differ by what rounding does
CAUTION = 10.0  # by which that difference is taken for the error
PASSES = 4
FINEST = 1e-14  # tolerance of a step, below which there is only rounding
Factors = Callable[[Array], tuple[Numbers, Numbers]]


@dataclass(frozen=True, eq=False)
@show
class RiccatiFlow:
    """P(t) (N, n, n) at times (N,) in s, symmetric to the last bit, with the gains K = R^-1 B' P (N, m, n) of u = -K x.

    The other fields are (N,). `error` estimates the relative error of P in the Frobenius norm. `least` is the least
    eigenvalue of P. `rest` is the norm of P' over the sum of the norms of its four terms. `distance` is the norm of P -
    X over that of X, the stabilising solution of the algebraic equation; it is None if coefficients vary or there is no
    X.
    """

    times: Array
    P: Array
    K: Array
    error: Array
    least: Array
    rest: Array
    distance: Array | None

    def __str__(self) -> str:
        away = "" if self.distance is None else f", from the algebraic solution {self.distance[-1]:.1e}"
        return (
            f"{len(self.times)} times in [{self.times[0]:g}, {self.times[-1]:g}] s: error {self.error.max():.1e}, "
            f"least eigenvalue {self.least.min():.3g}; at the last time P' {self.rest[-1]:.1e} of its terms{away}"
        )


@check_arguments
def rde(
    A: Coefficient, B: Coefficient, Q: Coefficient, R: Coefficient, P1: Numbers, times: Numbers, *, rtol: float = 1e-10
) -> RiccatiFlow:
    """The differential Riccati equation of the finite horizon, backward from the terminal weight:

        -P' = A'P + PA - P B R^-1 B' P + Q,      P(t_N) = P1.

    u = -R^-1 B' P(t) x minimises the integral of x'Qx + u'Ru over [t, t_N] plus x(t_N)' P1 x(t_N). Where Q and P1 are
    positive semidefinite P(t) exists at all times, and is so too.

    Parameters
    ----------
    A, B, Q, R
        (n, n), (n, m), (n, n) and (m, m), each a matrix or a smooth function of time that gives one.
    P1
        (n, n), symmetric.
    times
        (N,), rising, in s; the last is the horizon.
    rtol
        The relative error allowed.

    Raises
    ------
    ValueError
        If a matrix does not fit, Q or P1 is not symmetric, R not positive definite, or the times do not rise.
    DesignError
        If P escapes to infinity within the times (the message brackets when), or its error would be beyond rtol.

    References
    ----------
    Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods, chapter 2. Davison and Maki (1973), The
    numerical solution of the matrix Riccati differential equation, IEEE Transactions on Automatic Control 18(1).
    """
    return _solve_flow("rde(A, B, Q, R, P1, times)", (A, B, Q, R), ("P1", P1), times, rtol, backward=True)


@check_arguments
def fpre(
    A: Coefficient, B: Coefficient, Q: Coefficient, R: Coefficient, P0: Numbers, times: Numbers, *, rtol: float = 1e-10
) -> RiccatiFlow:
    """The forward-propagating Riccati equation, as in (34) of Long (2025):

        P' = A'P + PA - P B R^-1 B' P + Q,       P(t_1) = P0.

    For constant coefficients it is `rde` with time turned round, and tends to the same algebraic solution; for
    others u = -R^-1 B' P(t) x minimises nothing, and need not stabilise. Arguments and refusals are those of `rde`.

    References
    ----------
    Weiss, Kolmanovsky and Bernstein (2012), Forward-integration Riccati-based output-feedback control of linear
    time-varying systems, American Control Conference. Long (2025), doi:10.54939/1859-1043.j.mst.107.2025.13-23.
    """
    return _solve_flow("fpre(A, B, Q, R, P0, times)", (A, B, Q, R), ("P0", P0), times, rtol, backward=False)


@dataclass(frozen=True, eq=False)
@show
class StateDependent:
    """P (N, n, n) at states (N, n), with the gains K = R^-1 B' P (N, m, n) of u = -K x and N certificates."""

    states: Array
    P: Array
    K: Array
    certificates: tuple[Certificate, ...]

    @property
    def decay_rate(self) -> float:
        """The least decay rate with the state frozen, in 1/s, which proves nothing for the moving state."""
        return min(certificate.decay_rate for certificate in self.certificates)


@check_arguments
def sdre(factors: Factors, states: Array, Q: Numbers, R: Numbers) -> StateDependent:
    """The solution of the state-dependent Riccati equation at states x of x' = A(x) x + B(x) u:

        A(x)'P + P A(x) - P B(x) R^-1 B(x)' P + Q = 0.

    u = -R^-1 B(x)' P(x) x stabilises a neighbourhood of x = 0 and is optimal in the limit there. The
    factorisation A(x) is not unique, and another one gives another P.

    Parameters
    ----------
    factors
        From a state (n,) to A (n, n) and B (n, m).
    states
        (N, n), or one state (n,).
    Q, R
        (n, n) and (m, m), as `care` takes them.

    Raises
    ------
    ValueError
        If `states` is not such an array, or a matrix does not fit.
    DesignError
        If there is no stabilising solution at one of the states, which the message names.

    References
    ----------
    Cimen (2008), State-dependent Riccati equation (SDRE) control: a survey, IFAC World Congress.

    Examples
    --------
    >>> from workbench.design.riccati_flow import sdre
    >>> sdre(lambda x: (np.diag(x), np.eye(1)), [[0.0], [1.0]], [[1.0]], [[1.0]]).K.ravel().round(3)
    array([1.   , 2.414])
    """
    call = "sdre(factors, states, Q, R)"
    x = np.atleast_2d(states)
    if x.ndim != 2 or x.size == 0 or not np.isfinite(x).all():
        raise ValueError(f"`{call}`: states must be finite numbers (N, n); got shape {x.shape}.")
    answers: list[Riccati] = []
    for i, state in enumerate(x):
        where = f"`{call}`, at state {i}, {state.tolist()}"
        try:
            found = answer(call, "factors", factors, state)
            if not isinstance(found, tuple | list) or len(found) != 2:
                raise ValueError(f"factors must give A and B; got {type(found).__name__}.")
            A, B = found
            answers.append(care(A, B, Q, R))
        except ValueError as error:  # a `DesignError` is one, and stays one
            raise type(error)(f"{where}: {error}") from error
        if answers[-1].K.shape != answers[0].K.shape:
            shapes = f"{answers[-1].K.shape} after {answers[0].K.shape}"
            raise ValueError(f"{where}: A and B must have the same shapes at all states; K is {shapes}.")
    P, K = (np.array([getattr(answer, name) for answer in answers]) for name in ("X", "K"))
    return StateDependent(x, P, K, tuple(answer.certificate for answer in answers))


def _solve_flow(
    call: str,
    arguments: tuple[Coefficient, ...],
    start: tuple[str, Numbers],
    times: Numbers,
    rtol: float,
    backward: bool,
) -> RiccatiFlow:
    coefficients = Coefficients(call, *arguments)
    t = _rising_times(call, times)
    if not 1e-13 <= rtol <= 1e-2:
        raise ValueError(f"`{call}`: rtol must lie between 1e-13, near rounding, and 1e-2; got {rtol!r}.")
    begin, sign = (t[-1], -1.0) if backward else (t[0], 1.0)
    first = coefficients.at(begin)
    P = symmetric(call, *start, len(first.A))
    gone = np.abs((t[::-1] if backward else t) - begin)
    march = _constant if coefficients.constant else _varying_solution
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is seen, and refused
        found, error = march(coefficients, P, gone, rtol, begin, sign)
    if backward:
        found, error = found[::-1], error[::-1]
    pairs = [(coefficients.at(when), X) for when, X in zip(t, found, strict=True)]
    K, rest = np.array([at.gain(X) for at, X in pairs]), np.array([at.rest(X) for at, X in pairs])
    least = np.array(np.linalg.eigvalsh(found)[:, 0])
    return RiccatiFlow(t, found, K, error, least, rest, _distance(coefficients, found))


def _constant(
    coefficients: Coefficients, P: Array, elapsed_times: Array, rtol: float, begin: float, sign: float
) -> tuple[Array, Array]:
    """P (N, n, n) and its error (N,) after each length of time, which is cut in two ways."""
    at, scale = coefficients.at(begin), coefficients.scale(begin)
    lengths = np.diff(elapsed_times)
    if len(lengths) and np.ptp(lengths) <= 8 * EPS * (abs(begin) + elapsed_times[-1]):
        lengths = np.full_like(lengths, elapsed_times[-1] / len(lengths))
    one, other = (constant_flow(at.A, scale * at.G, at.Q / scale, P / scale, lengths, finer) for finer in GRIDS)
    if isinstance(one, Escape) and isinstance(other, Escape):
        both = Escape(min(one.after, other.after), max(one.before, other.before))
        raise _refusal(coefficients.call, both, begin, sign)
    if isinstance(one, Escape) or isinstance(other, Escape):
        raise DesignError(
            f"`{coefficients.call}`: whether P escapes to infinity hangs on the last digits of the data, so no P can "
            "be given at all the times. End before, or start further from an unstable solution."
        )
    ways = [np.array([P / scale, *found]) for found in (one, other)]
    error = CAUTION * (_apart(*ways) + len(P) * EPS)
    _demand(coefficients.call, error, rtol, "Give it better scaled states, or a larger rtol.")
    return scale * ways[0], error


def _varying_solution(
    coefficients: Coefficients, P: Array, elapsed_times: Array, rtol: float, begin: float, sign: float
) -> tuple[Array, Array]:
    """P (N, n, n) and its error (N,) after each length of time, by steps that keep the error within rtol."""
    scale, local = coefficients.scale(begin), rtol
    for _ in range(PASSES):
        found = varying_flow(
            lambda s: coefficients.hamiltonian(begin + sign * s, scale), P / scale, elapsed_times, local
        )
        if isinstance(found, Escape):
            raise _refusal(coefficients.call, found, begin, sign)
        fine, coarse = (np.array(tracks) for tracks in zip(*found, strict=True))
        error = _apart(fine, coarse) + EPS
        if error.max() <= rtol or local <= FINEST:
            break
        local = max(FINEST, local * rtol / float(error.max()) / 2)
    _demand(coefficients.call, error, rtol, "Smoother coefficients or a larger rtol would help.")
    return scale * fine, error


def _rising_times(call: str, times: Numbers) -> Array:
    t = as_array(times)
    if t is None or t.ndim != 1 or not t.size or not np.isfinite(t).all() or (t[1:] <= t[:-1]).any():
        raise ValueError(f"`{call}`: times must be a vector of rising finite numbers, in s; got {describe(times)}.")
    return t


def _apart(one: Array, other: Array) -> Array:
    """The distance of matrices (N, n, n) from others over their norms, (N,)."""
    size = np.linalg.norm(one, axis=(1, 2))
    distance: Array = np.linalg.norm(one - other, axis=(1, 2)) / np.where(size > 0, size, 1)
    return distance


def _demand(call: str, error: Array, rtol: float, advice: str) -> None:
    if not error.max() <= rtol:
        raise DesignError(
            f"`{call}`: P can be had to a relative error of {error.max():.1e} only, and {rtol:.1e} is asked for. "
            f"{advice}"
        )


def _refusal(call: str, escape: Escape, begin: float, sign: float) -> DesignError:
    low, high = sorted((begin + sign * escape.after, begin + sign * escape.before))
    if not np.isfinite([low, high]).all():
        return DesignError(
            f"`{call}`: P cannot be followed beyond t = {begin + sign * escape.after:.6g} s: either it passes "
            f"{LARGEST:g} there, or the coefficients jump, or they are too stiff for the steps allowed, or P hangs "
            "on the last digits of the data. End before, split the times where they jump, or smooth them."
        )
    return DesignError(
        f"`{call}`: P grows beyond every bound between t = {low:.16g} and {high:.16g} s, so there is no solution "
        "at all the times. Semidefinite Q and start rule that out; otherwise end before."
    )


def _distance(coefficients: Coefficients, P: Array) -> Array | None:
    """The distance of each P (N, n, n) from the stabilising solution of the algebraic equation, if there is one."""
    if not coefficients.constant:
        return None
    at = coefficients.at(0.0)
    try:
        X = care(at.A, at.B, at.Q, at.R).X
    except ValueError:
        return None
    size = float(np.linalg.norm(X))
    return np.array(np.linalg.norm(P - X, axis=(1, 2)) / size) if size else None
