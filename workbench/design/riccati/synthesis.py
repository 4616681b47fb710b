"""From a Riccati equation to a solution that can be trusted, or to the reason why there is none."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from workbench.design.certificates import Certificate, Refused
from workbench.design.matrices import EPS, indefinite
from workbench.design.riccati.answers import Riccati
from workbench.design.riccati.conditioning import Conditioning, conditioning
from workbench.design.riccati.diagnosis import REGULATOR, Words, figure, reason
from workbench.design.riccati.double_double import twice
from workbench.design.riccati.equation import AbstractEquation, Data, Discrete, norm
from workbench.design.riccati.newton import Refined, refine
from workbench.design.riccati.one_thread import one_thread
from workbench.design.riccati.units import Units, good_units, in_range
from workbench.validation.refusals import Array

WORST_RESIDUAL = 1e-11
WORST_ERROR = 1e-4  # four digits of X for the data as given
WORST_MOVE = 1e-2  # two digits of X in good units when every matrix is rounded to floating-point numbers
WORTH_A_WARNING = 1e-6
UNSURE = 0.01  # of a margin, that rounding may take
UNSEEN = 2.0**-100  # of the terms of a residual: what sums in twice the working precision may lose
ROUNDING = 8 * EPS  # what a few operations on the data, a change of coordinates say, do to them


@dataclass(frozen=True)
class _Judged:
    """A refined candidate, its certificate, and what speaks against it, worst first."""

    found: Refined
    K: Array
    certificate: Certificate
    against: str

    @property
    def settled(self) -> bool:
        """Whether this is the stabilising solution, trusted or not."""
        known = self.certificate
        return known.margin > 0 and known.residual <= WORST_RESIDUAL and known.error <= WORST_ERROR


@one_thread()
@np.errstate(all="ignore")  # what leaves the range of floats is seen in the certificate
def stabilising(
    call: str,
    data: Data,
    equation_of: Callable[[Data], AbstractEquation],
    roads: Callable[[Data], Iterator[Array]],
    words: Words = REGULATOR,
) -> Riccati:
    """The stabilising solution of the first road that leads to one.

    Raises
    ------
    Refused
        If no road leads to a solution that can be trusted.
    """
    units = good_units(data)
    equation = equation_of(units.into(data))
    objections = []
    for X in roads(equation.data):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # singular matrices are seen in the certificate
                judged = _judge(equation, refine(equation, X), units)
        except (OverflowError, ValueError):  # SciPy's answer to what is not finite, and the parent of LinAlgError
            continue
        if not judged.against:
            point = judged.found.point
            X = in_range(call, "X", units.out_of(point.X), point.X)
            K = in_range(call, "K", units.gain(judged.K), judged.K)
            return Riccati(X, K, judged.found.operator.poles, judged.certificate)
        objections.append(judged.against)
        if judged.settled:
            break  # every road would end at this X
    why = reason(equation.data, isinstance(equation, Discrete), words) or (
        objections[0] if objections else "no method finds one"
    )
    raise Refused(f"`{call}`: there is no stabilising solution X that can be trusted: {why}.")


def _judge(equation: AbstractEquation, found: Refined, units: Units) -> _Judged:
    point = found.point
    margin = found.operator.margin
    known = conditioning(equation, found, units) if margin > 0 else Conditioning(np.inf, np.inf, 0.0, np.inf)
    # the gain may hang on digits that X has no room for, so it is that of X and the next step together
    beyond = equation.at(twice(point.X) + found.correction)
    still = found.operator.solve(-beyond.left)
    # what Newton's method still sees, what its next step would leave, and what lies below the digits of its residual
    lacking = norm(units.out_of(found.correction)) + norm(units.out_of(still)) + UNSEEN * point.terms * known.response
    error = _share(lacking, norm(units.out_of(point.X)))
    of_gain = _share(norm(units.gain(equation.steering(beyond, still))), norm(units.gain(beyond.K)))
    certificate = Certificate(
        residual=point.relative,
        error=max(error, EPS / 2) if point.X.any() else 0.0,
        condition=known.condition,
        margin=margin,
        refined=found.steps,
        warnings=tuple(_warnings(equation, found, error, of_gain, known)),
    )
    return _Judged(found, beyond.K, certificate, _against(found, certificate, known))


def _share(part: float, whole: float) -> float:
    return part / whole if whole > 0 else 0.0


def _against(found: Refined, certificate: Certificate, known: Conditioning) -> str:
    if not certificate.margin > 0:
        return f"the closed loop of the nearest solution has the pole {figure(found.operator.slowest)}"
    if not certificate.residual <= WORST_RESIDUAL:
        return f"the relative residual stays at {certificate.residual:.1e}, above {WORST_RESIDUAL:g}"
    if not known.reach > ROUNDING:
        return (
            f"a relative change of the data by {known.reach:.1e}, less than their rounding, may move eigenvalues of "
            "the closed loop onto the edge of stability"
        )
    if not certificate.error <= WORST_ERROR:
        return f"the relative error of X is about {certificate.error:.1e}, above {WORST_ERROR:g}"
    if not known.in_good_units * EPS <= WORST_MOVE:
        change = f"{known.in_good_units * EPS:.1e}"
        return f"rounding the data can change X, in good units, by {change} of its size, so its digits mean nothing"
    return ""


def _warnings(
    equation: AbstractEquation, found: Refined, error: float, of_gain: float, known: Conditioning
) -> Iterator[str]:
    if known.condition * EPS > WORTH_A_WARNING:
        yield f"rounding the data can change X by up to {known.condition * EPS:.1e} of its size"
    if error > WORTH_A_WARNING:
        yield f"X is known to a relative error of about {error:.1e} only"
    if of_gain > WORTH_A_WARNING:
        yield f"K is known to a relative error of about {of_gain:.1e} only"
    margin = found.operator.margin
    if margin > 0 and (sure := found.operator.sure_margin()) < (1 - UNSURE) * margin:
        yield f"rounding moves the poles: of the margin {margin:.3g} only {sure:.3g} is sure"
    if known.reach < 1 and known.reach > 0 and known.reach < EPS / WORTH_A_WARNING:
        yield f"relative changes of the data beyond about {known.reach:.1e} may leave no stabilising solution"
    if indefinite(equation.data.Q):
        yield "Q is not positive semidefinite: X stabilises, but a loop that does not may cost less"
    if indefinite((found.point.W + found.point.W.T) / 2):
        yield "R + B'XB is not positive definite: u = -K x stabilises, but the cost has no minimum there"
