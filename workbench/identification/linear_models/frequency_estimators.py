"""Frequency responses from signals: Welch's averages, the ratio of periods, and local polynomials."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import get_window

from workbench.core.validation.refusals import Array, Integers, whole
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets import Dataset
from workbench.identification.linear_models.frequency_estimate import Complex, FrequencyEstimate
from workbench.identification.linear_models.signal_records import LinearSignals, signals_of

Flags = NDArray[np.bool_]
LEAST_SEGMENTS = 4
WEAK = 1e-8  # of the largest power of the input: a line below it is not excited


@check_arguments
def spectral_response(
    data: Dataset, source: str, output: str, segment: int | None = None, window: str = "hann"
) -> FrequencyEstimate:
    """The response H1 = S_yu / S_uu by Welch's averages over segments that overlap by half, with its coherence.

    The variance of each axis is |H1|^2 (1 - coherence) / (2 K coherence), with K independent segments. In a closed loop
    H1 is biased towards -1/C where the noise exceeds the reference; the remarks say where the coherence is low.

    Parameters
    ----------
    data, source, output
        A dataset at one constant period, and the names of input and output.
    segment
        The number of samples of a segment, by default an eighth of the log.
    window
        A window of SciPy without parameters.

    Raises
    ------
    ValueError
        If samples are missing, or there are fewer than four segments.
    LookupError
        If there is no such signal.

    References
    ----------
    Welch (1967), IEEE Transactions on Audio and Electroacoustics 15; Bendat and Piersol (2010), section 9.2.4.

    Examples
    --------
    >>> u = np.random.default_rng(1).standard_normal(4000)
    >>> log = wb.Dataset.of(0.1 * np.arange(4000), {"u": u, "y": 2.0 * u}, {"u": "V", "y": "V"})
    >>> response = wb.linear_models.spectral_response(log, "u", "y")
    >>> np.allclose(response.values, 2.0)
    True
    """
    call = "spectral_response"
    signals = signals_of(f"{call}(data)", data, source, output)
    size = max(8, signals.samples // 8) if segment is None else whole(f"{call}(segment=...)", segment, 8)
    size -= size % 2
    parts = _segments(signals, size)
    if len(parts) < LEAST_SEGMENTS:
        raise ValueError(
            f"`{call}(segment=...)` must leave at least {LEAST_SEGMENTS} segments that overlap by half; "
            f"{size} samples leave {len(parts)}: take shorter ones, or log for longer."
        )
    try:
        shape = np.asarray(get_window(window, size), dtype=float)
    except ValueError:
        raise ValueError(f"`{call}(window=...)` must be a window of SciPy, as 'hann'; got {window!r}.") from None
    values, coherence = _averages(parts, shape)
    count = 2 * _independent(shape, len(parts))
    variance = np.abs(values) ** 2 * (1 - coherence) / (count * np.maximum(coherence, 1e-12))
    omega = np.asarray(2 * np.pi * np.arange(1, size // 2) / (size * signals.period), dtype=float)
    low = float(np.mean(coherence < 0.5))
    remarks = (f"The coherence is below 0.5 at {100 * low:.0f} % of the frequencies.",) if low > 0.1 else ()
    spread = variance[:, np.newaxis, np.newaxis] * np.eye(2)
    return FrequencyEstimate("H1 by Welch", omega, values, spread, signals.period, source, output, coherence, remarks)


def _averages(parts: list[tuple[Array, Array]], shape: Array) -> tuple[Complex, Array]:
    """H1 and the coherence at the lines between zero and Nyquist's frequency."""
    U, Y = (
        np.array([np.fft.rfft(shape * (part - part.mean())) for part in column]) for column in zip(*parts, strict=True)
    )
    inside = slice(1, len(shape) // 2)
    Suu, Syy = ((np.abs(lines[:, inside]) ** 2).mean(axis=0) for lines in (U, Y))
    Syu = (Y * np.conj(U)).mean(axis=0)[inside]
    return Syu / Suu, np.clip(np.abs(Syu) ** 2 / (Suu * Syy), 0.0, 1.0)


def _segments(signals: LinearSignals, size: int) -> list[tuple[Array, Array]]:
    """The segments of all experiments, each overlapping the one before by half."""
    return [
        (u[at : at + size, 0], y[at : at + size, 0])
        for u, y in zip(signals.u, signals.y, strict=True)
        for at in range(0, len(y) - size + 1, size // 2)
    ]


def _independent(window: Array, count: int) -> float:
    """The number of independent segments that `count` ones count as which overlap by half (Welch 1967)."""
    half = len(window) // 2
    shared = float((window[half:] @ window[:half]) / (window @ window)) ** 2
    return count / (1 + 2 * shared * (count - 1) / count)


@check_arguments
def periodic_response(data: Dataset, source: str, output: str, period_samples: int, skip: int = 1) -> FrequencyEstimate:
    """The empirical transfer function of a periodic input: the ratio of the means over whole periods.

    The scatter from period to period gives the covariance. Leakage is absent once transients have decayed.

    Parameters
    ----------
    data
        The dataset, at one constant period, without missing or marked samples.
    source, output
        The names of input and output.
    period_samples
        The number of samples in a period of the input.
    skip
        The number of first periods of each experiment that are left out for their transients.

    Raises
    ------
    ValueError
        If the input does not repeat, samples are missing, or fewer than two periods are left.
    LookupError
        If there is no such signal.

    References
    ----------
    Ljung (1999), System Identification, section 6.3; Pintelon and Schoukens (2012), section 2.5.

    Examples
    --------
    >>> u = np.tile(np.random.default_rng(1).standard_normal(64), 5)
    >>> y = np.convolve(u, [0.0, 1.0, 0.5])[:320] + 1e-3 * np.random.default_rng(2).standard_normal(320)
    >>> log = wb.Dataset.of(0.1 * np.arange(320), {"u": u, "y": y}, {"u": "V", "y": "V"})
    >>> response = wb.linear_models.periodic_response(log, "u", "y", 64)
    >>> round(float(abs(response.values[0])), 2)
    1.5
    """
    call = "periodic_response(data)"
    signals = signals_of(call, data, source, output)
    size, first = (
        whole("periodic_response(period_samples=...)", period_samples, 4),
        whole("periodic_response(skip=...)", skip, 0),
    )
    pairs = [
        (u[at : at + size, 0], y[at : at + size, 0])
        for u, y in zip(signals.u, signals.y, strict=True)
        for at in range(first * size, len(y) - size + 1, size)
    ]
    if len(pairs) < 2:
        raise ValueError(
            f"`periodic_response(period_samples=...)` needs two or more whole periods behind the first {first}; the "
            f"dataset has {len(pairs)}: log for longer."
        )
    U, Y = (np.fft.rfft(np.array(column), axis=1)[:, 1 : (size + 1) // 2] for column in zip(*pairs, strict=True))
    values, variance, excited = _ratios(U, Y, size)
    omega = np.asarray(2 * np.pi * np.arange(1, (size + 1) // 2)[excited] / (size * signals.period), dtype=float)
    spread = variance[:, np.newaxis, np.newaxis] * np.eye(2)
    return FrequencyEstimate("ratio of periods", omega, values, spread, signals.period, source, output)


def _ratios(U: Complex, Y: Complex, size: int) -> tuple[Complex, Array, Flags]:
    """The ratios of the means over periods (periods, lines), their variances, and which lines are excited."""
    power = np.abs(U).mean(axis=0) ** 2
    excited = power > WEAK * power.max()
    U, Y = U[:, excited], Y[:, excited]
    scatter = float(np.abs(U - U.mean(axis=0)).max() / np.abs(U).max())
    if scatter > 0.1:
        raise ValueError(
            f"`periodic_response(period_samples=...)`: the input does not repeat after {size} samples; its lines "
            f"differ by {100 * scatter:.0f} % from period to period. Give the number of samples in a period, or take "
            "`spectral_response`."
        )
    values = Y.mean(axis=0) / U.mean(axis=0)
    misfit = Y - values * U
    variance = np.sum(np.abs(misfit) ** 2, axis=0) / (len(U) - 1) / (2 * len(U) * np.abs(U.mean(axis=0)) ** 2)
    return values, variance, excited


@check_arguments
def local_polynomial_response(
    data: Dataset, source: str, output: str, order: int = 2, half_width: int | None = None
) -> FrequencyEstimate:
    """The response and the transient as polynomials over a few neighbouring lines of the spectrum, by least squares.

    It needs no window and no period, and its leakage is far below Welch's. The residuals of each fit give the variance.

    Parameters
    ----------
    data
        The dataset of one experiment, at one constant period, without missing or marked samples.
    source, output
        The names of input and output.
    order
        The degree of both polynomials.
    half_width
        The number of lines on each side, by default twice as many as the fit needs.

    Raises
    ------
    ValueError
        If there are several experiments, samples are missing, or there are too few lines.
    LookupError
        If there is no such signal.

    References
    ----------
    Pintelon and Schoukens (2012), System Identification: A Frequency Domain Approach, section 7.2.

    Examples
    --------
    >>> u = np.random.default_rng(1).standard_normal(1000)
    >>> log = wb.Dataset.of(0.1 * np.arange(1000), {"u": u, "y": 2.0 * u}, {"u": "V", "y": "V"})
    >>> response = wb.linear_models.local_polynomial_response(log, "u", "y")
    >>> np.allclose(response.values, 2.0)
    True
    """
    call = "local_polynomial_response(data)"
    signals = signals_of(call, data, source, output)
    if len(signals.y) > 1:
        raise ValueError(f"`{call}` needs a dataset of one experiment; it has {len(signals.y)}: take one of them.")
    degree = whole("local_polynomial_response(order=...)", order, 0, 10)
    unknowns = 2 * (degree + 1)
    reach = unknowns if half_width is None else whole("local_polynomial_response(half_width=...)", half_width)
    N = signals.samples
    if 2 * reach + 1 <= unknowns or 2 * reach + 1 > N // 2 - 1:
        raise ValueError(
            f"`local_polynomial_response(half_width=...)` must give more than {unknowns} lines, as the fit has "
            f"unknowns, and at most {N // 2 - 1}, as the log has lines; {reach} gives {2 * reach + 1}."
        )
    U, Y = (np.fft.rfft(column[0][:, 0] - column[0][:, 0].mean()) for column in (signals.u, signals.y))
    lines = np.arange(1, (N + 1) // 2)
    values, variance = _local_fits(U, Y, lines, degree, reach)
    omega = np.asarray(2 * np.pi * lines / (N * signals.period), dtype=float)
    spread = variance[:, np.newaxis, np.newaxis] * np.eye(2)
    return FrequencyEstimate("local polynomial", omega, values, spread, signals.period, source, output)


def _local_fits(U: Complex, Y: Complex, lines: Integers, degree: int, reach: int) -> tuple[Complex, Array]:
    """The response at each line, and the variance of its real and of its imaginary part."""
    values, variance = np.empty(len(lines), dtype=complex), np.empty(len(lines))
    for row, line in enumerate(lines):
        begin = int(np.clip(line - reach, lines[0], lines[-1] - 2 * reach))
        near = np.arange(begin, begin + 2 * reach + 1)
        powers = ((near - line) / reach)[:, np.newaxis] ** np.arange(degree + 1)
        columns = np.hstack([powers * U[near, np.newaxis], powers])
        scale = np.linalg.norm(columns, axis=0)
        Q, R = np.linalg.qr(columns / scale)
        solution = np.linalg.solve(R, Q.conj().T @ Y[near]) / scale
        misfit = Y[near] - columns @ solution
        freedom = len(near) - columns.shape[1]
        inverse = np.linalg.inv(R)[0]
        values[row] = solution[0]
        variance[row] = np.sum(np.abs(misfit) ** 2) / freedom * float(np.sum(np.abs(inverse) ** 2)) / scale[0] ** 2 / 2
    return values, variance
