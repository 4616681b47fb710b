"""Estimates of ARX, ARMAX, output-error, Box-Jenkins and general polynomial models by prediction errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.core.validation.refusals import Array, one_of, whole
from workbench.core.validation.refusals import seed as checked_seed
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets import Dataset
from workbench.identification.linear_models.gap_innovations import information, innovations
from workbench.identification.linear_models.gauss_newton import LocalMinimum, SearchDescent, search, tangent
from workbench.identification.linear_models.model_residuals import shaped_product, whiteness
from workbench.identification.linear_models.polynomial_model import PolynomialModel, fit_of_model
from workbench.identification.linear_models.polynomial_structure import PolynomialStructure, largest_root
from workbench.identification.linear_models.prediction_errors import Predictor
from workbench.identification.linear_models.search_starts import starts_of
from workbench.identification.linear_models.signal_records import LinearSignals, checked_offsets, signals_of

Names = str | Sequence[str]
RANK = 1e-10  # relative: a smaller singular value of the scaled gradients is of parameters that the data do not tell
NEAR_ENDS = 2.0  # the difference of N ln(squares) below which another end is as likely
STEP = 1e-2  # standard errors, of a difference of the gradient
MOST_EFFECTS = 5_000_000  # of missing outputs on errors: 40 MB of numbers
LAGS = 20  # of the test that decides on the first remark


@check_arguments
def polynomial_model(
    data: Dataset,
    inputs: Names,
    output: str,
    structure: PolynomialStructure,
    *,
    holdout: Dataset | None = None,
    offsets: str = "estimate",
    initial: str = "estimate",
    starts: int = 8,
    seed: int = 0,
) -> PolynomialModel:
    """The minimum of the one-step prediction errors of a polynomial structure, with standard errors and tests.

    In a closed loop it holds if the loop has a delay and the noise model makes the residuals white. The search has
    several starts, and `ends` has all its ends. Roots of C, D and F stay inside the unit circle.

    Parameters
    ----------
    data, holdout
        Datasets at one constant period; the summary says if there is no hold-out. Outputs of `data` may be missing or
        marked. Without C the errors that need one are left out; with C the likelihood is that of a Kalman filter.
    inputs, output, structure
        The names of the inputs and of the output, and the orders.
    offsets
        "mean" takes the means off each signal, "estimate" also estimates a constant, "none" leaves the signals.
    initial
        "estimate" for unknown values before the first sample of each experiment, "zero" for signals that were at rest.
    starts, seed
        The number of random starts beside those of regressions, and their seed.

    Raises
    ------
    ValueError
        If inputs are missing or marked, samples are not at one period, too few, or do not tell the parameters.
    LookupError
        If there is no such signal.

    References
    ----------
    Ljung (1999), System Identification, sections 7.2 to 7.5, 9.2 to 9.4, 10.2 and 13.4.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> u, e, y = rng.choice([-1.0, 1.0], 400), 0.1 * rng.standard_normal(400), np.zeros(400)
    >>> for k in range(1, 400):
    ...     y[k] = 0.8 * y[k - 1] + 0.5 * u[k - 1] + e[k]
    >>> log = wb.Dataset.of(0.1 * np.arange(400), {"u": u, "y": y}, {"u": "V", "y": "rad"})
    >>> orders = wb.linear_models.PolynomialStructure(na=1, nb=(1,))
    >>> model = wb.linear_models.polynomial_model(log, "u", "y", orders)
    >>> {name: round(value, 2) for name, value in model.parameters.items()}
    {'a1': -0.81, 'b1': 0.51}
    """
    signals, predictor, point = _problem(data, inputs, output, structure, (offsets, initial))
    count = whole("polynomial_model(starts=...)", starts, 0, 10_000)
    generator = np.random.default_rng(checked_seed("polynomial_model(seed=...)", seed))
    first = replace(predictor, records=tuple(record.interpolate() for record in predictor.records))
    end, ends = search(predictor, starts_of(first, count, generator))
    return _model(signals, predictor, end, ends, point, holdout)


def _problem(
    data: Dataset, inputs: Names, output: str, structure: PolynomialStructure, options: tuple[str, str]
) -> tuple[LinearSignals, Predictor, tuple[Array, Array]]:
    """The checked signals, their prediction errors, and the offsets u0 and y0."""
    call, (offsets, initial) = "polynomial_model", options
    checked_offsets(call, offsets)
    one_of(f"{call}(initial=...)", initial, ("estimate", "zero"))
    signals = signals_of(f"{call}(data)", data, inputs, output, structure.longest + 1, gaps=True)
    if signals.inputs.size != structure.nu:
        raise ValueError(
            f"`{call}(structure=...)` must have orders for {signals.inputs.size} inputs; it has {structure.nu}."
        )
    u0, y0 = signals.offsets(offsets)
    predictor = Predictor(structure, signals.records(u0, y0), initial == "estimate", offsets == "estimate")
    _refuse_many_gaps(call, predictor)
    least = structure.size + predictor.nuisances
    if predictor.samples < 2 * least:
        raise ValueError(
            f"`{call}(data)` has {predictor.samples} samples for {least} unknowns, initial values included; it needs "
            "at least twice as many samples: log for longer, or take lower orders."
        )
    return signals, predictor, (u0, y0)


def _refuse_many_gaps(call: str, predictor: Predictor) -> None:
    """Refuse missing outputs whose matrix of effects on the errors would be too large."""
    count, most = sum(len(record.gaps) for record in predictor.records), sum(len(one.y) for one in predictor.records)
    if predictor.structure.nc and count * most > MOST_EFFECTS:
        raise ValueError(
            f"`{call}(data)` with C takes at most {MOST_EFFECTS // most:,} missing or marked outputs among "
            f"{most:,}; got {count:,}: take a structure without C, or experiments from between the gaps."
        )


def _model(
    signals: LinearSignals,
    predictor: Predictor,
    end: SearchDescent,
    ends: tuple[LocalMinimum, ...],
    offsets: tuple[Array, Array],
    holdout: Dataset | None,
) -> PolynomialModel:
    """The model at the end of a search, with its covariance and its remarks."""
    held, errors = predictor.structure, end.errors
    free = tangent(held, end.theta, errors)
    degrees = predictor.samples - held.size - predictor.nuisances
    variance = end.squares / errors.scale**2 / degrees
    residuals = predictor.residuals(errors.e)
    covariance = _covariance(predictor, errors.J @ free, residuals, end.squares / degrees)
    if errors.basis is not None:
        residuals = innovations(predictor, end.theta, errors)
        steps = STEP * np.sqrt(np.diag(covariance))
        exact = np.linalg.inv(information(predictor, end.theta, steps, free)) * predictor.samples / degrees
        covariance = exact if (np.linalg.eigvalsh(exact) > 0).all() else covariance
    u0, y0 = offsets
    gain = float(held.polynomials(end.theta).A.sum())
    point = y0 + (errors.constant / gain if gain else 0.0)
    other = None
    if holdout is not None:
        labels = signals.inputs.labels, signals.outputs.labels
        other = fit_of_model(held, end.theta, signals_of("polynomial_model(holdout=...)", holdout, *labels), u0, point)
    return PolynomialModel(
        held,
        end.theta,
        free @ covariance @ free.T,
        signals.period,
        signals.inputs,
        signals.outputs,
        u0,
        point,
        variance,
        end.squares,
        predictor.samples,
        end.distance,
        free.shape[1] < held.size,
        ends,
        predictor,
        fit_of_model(held, end.theta, signals, u0, point),
        other,
        _remarks(predictor, end, ends, residuals, free.shape[1] < held.size),
    )


def _covariance(predictor: Predictor, J: Array, residuals: list[Array], variance: float) -> Array:
    """The covariance of the estimate; without a noise model the residuals may be coloured (Ljung 1999, section 9.4)."""
    held = predictor.structure
    scale = np.linalg.norm(J, axis=0)
    _, s, V = np.linalg.svd(J / np.where(scale > 0, scale, 1), full_matrices=False)
    if not scale.all() or s[-1] < RANK * s[0]:
        weights = np.abs(V[-1]) if scale.all() else (scale == 0).astype(float)
        names = [name for name, weight in zip(held.names, weights, strict=False) if weight > 0.05 * weights.max()]
        raise ValueError(
            f"`polynomial_model(data)`: the data do not tell {', '.join(names)} apart. Excite the input more, or take "
            "lower orders."
        )
    inverse = (V.T / s**2) @ V / np.outer(scale, scale)
    if held.na or held.nc or held.nd:
        return np.asarray(variance * inverse)
    return np.asarray(inverse @ shaped_product(predictor.on_grid(J, 0.0), residuals) @ inverse)


def _remarks(
    predictor: Predictor, end: SearchDescent, ends: tuple[LocalMinimum, ...], residuals: list[Array], at_limit: bool
) -> tuple[str, ...]:
    """Sentences on what limits the trust in an estimate, the gravest first."""
    held, found = predictor.structure, []
    if not end.is_minimum:
        found.append(f"The search ended {end.distance:.2g} standard errors from a minimum.")
    noise = held.na + held.nc + held.nd
    lags = min(LAGS + noise, predictor.samples // 4)
    if (noise or held.kind == "FIR") and lags > noise:
        test = whiteness(residuals, lags, noise)
        if not test.is_passed:
            found.append(
                f"The residuals are not white (p = {test.probability:.1g}), so the standard errors are too small."
            )
    if (largest := largest_root(held.polynomials(end.theta).A)) > 1:
        found.append(f"The model is unstable, with a pole of size {largest:.4g}.")
    if predictor.has_gaps:
        every = sum(len(record.y) for record in predictor.records)
        found.append(f"Outputs are missing or marked: {predictor.samples} of {every} errors count.")
    if at_limit:
        found.append("A root of C, D or F is held at the unit circle.")
    near = [one for one in ends[1:] if predictor.samples * np.log(one.squares / end.squares) < NEAR_ENDS]
    if near:
        found.append(
            f"{len(near)} other minimum is nearly as deep."
            if len(near) == 1
            else f"{len(near)} other minima are nearly as deep."
        )
    return tuple(found)
