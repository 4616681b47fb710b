"""Sobol indices: what part of an output's variance is due to each factor, alone and together with others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import stdtrit

from workbench.core.layout import Array
from workbench.core.sockets import require
from workbench.study.sampling import SobolDesign
from workbench.study.sampling.sobol import SCRAMBLES
from workbench.study.sensitivity.outputs import Estimate, Flags, Outputs, factor_names, outputs_of, place_of

AT_ONCE = 2**22  # numbers that are looked at together: some arrays of 32 MB
Means = dict[str, Array]


@dataclass(frozen=True, eq=False)
class SobolIndices:
    """Indices of d factors for k outputs, or for a single one, which leaves the axis k out.

    Attributes
    ----------
    S1, ST, S2
        First order and total (k, d); second order (k, d (d - 1) / 2) for the `pairs` of factors, or None.
    deviation
        (k,), the standard deviation of the outputs over all factors.
    refused
        The reason for each output that has no indices; its numbers are NaN.
    """

    names: tuple[str, ...]
    factors: tuple[str, ...]
    S1: Estimate
    ST: Estimate
    S2: Estimate | None
    deviation: Array
    refused: Mapping[str, str]
    remarks: tuple[str, ...]

    @property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """The factors of each second-order index, by their places."""
        return tuple((i, j) for i in range(len(self.factors)) for j in range(i + 1, len(self.factors)))

    def __getitem__(self, name: str) -> SobolIndices:
        """The indices of one output; one that was refused is refused again, with its reason."""
        j = place_of(self.names, self.refused, name)
        S2 = None if self.S2 is None else self.S2[j]
        return replace(
            self, names=(name,), S1=self.S1[j], ST=self.ST[j], S2=S2, deviation=self.deviation[j], refused={}
        )


def sobol(
    design: SobolDesign,
    outputs: Any,
    names: Sequence[str] | None = None,
    *,
    factors: Sequence[str] | None = None,
    errors: Any = None,
    confidence: float = 0.95,
) -> SobolIndices:
    """Sobol indices of every output, with intervals from the scatter among the design's independent scrambles.

        S1_i = V(E(y | x_i)) / V(y)        ST_i = E(V(y | all but x_i)) / V(y)
        S2_ij = V(E(y | x_i, x_j)) / V(y) - S1_i - S1_j

    An interval is the jackknife's over the scrambles, with Student's quantile. Rows of a Sobol net are no independent
    draws: a bootstrap over them gives intervals that are much too wide. Outputs with failed runs, infinities or
    no variation beyond rounding are refused by name; see `SobolIndices.refused`.

    Parameters
    ----------
    outputs
        (N,) or (N, k) in the order of the design's points; several metrics, or one at many times.
    names, factors
        Of the k outputs and the d factors.
    errors
        How far off each output is, of the same shape: told of where it blurs the indices.

    Raises
    ------
    ValueError
        If an argument has the wrong kind or shape, or if every output is refused.

    References
    ----------
    Saltelli et al. (2010), Computer Physics Communications 181, table 2 (b) and (f); with the runs of second order
    Azzini, Mara and Rosati (2021), Environmental Modelling and Software 144; Efron and Stein (1981), The jackknife
    estimate of variance, Annals of Statistics 9.
    """
    require("sobol(design=...)", design, SobolDesign)
    named = factor_names("sobol", design, factors)
    held = outputs_of("sobol", design, outputs, names, errors)
    refuse_all("sobol", held)
    at_once = max(1, AT_ONCE // design.size)
    parts = [
        _judged(design, held.scaled[:, j : j + at_once], t_quantile("sobol", confidence, SCRAMBLES - 1))
        for j in range(0, len(held.names), at_once)
    ]
    S1, ST, S2 = (_joined([part.indices[i] for part in parts], held.known) for i in range(3))
    unmoved = np.concatenate([part.unmoved for part in parts])
    deviation = np.concatenate([part.deviation for part in parts]) * held.spread
    remarks = held.remarks + _unmoved(held, named, unmoved)
    return SobolIndices(
        held.names,
        named,
        S1,
        ST,
        S2 if design.second_order else None,
        np.where(held.known, deviation, np.nan),
        held.refused,
        remarks,
    )


def refuse_all(call: str, held: Outputs) -> None:
    """Refuse where no output is left."""
    if not held.known.any():
        said = "; ".join(f"'{name}': {why}" for name, why in list(held.refused.items())[:3])
        raise ValueError(f"`{call}(outputs=...)` must have an output that can be judged; got none: {said}.")


def t_quantile(call: str, confidence: float, freedom: int) -> float:
    """How many standard errors wide half of a confidence interval is."""
    if isinstance(confidence, bool) or not isinstance(confidence, int | float) or not 0 < confidence < 1:
        raise ValueError(f"`{call}(confidence=...)` must be a number between 0 and 1; got {confidence!r}.")
    return float(stdtrit(freedom, 0.5 + confidence / 2))


@dataclass(frozen=True, eq=False)
class _Judged:
    """Some columns: S1, ST and S2 (c, ...), where a factor moves nothing (c, d), and the standard deviations (c,)."""

    indices: tuple[Estimate, Estimate, Estimate]
    unmoved: Flags
    deviation: Array


def _judged(design: SobolDesign, y: Array, t: float) -> _Judged:
    """What the runs say of some columns (N, c)."""
    d = design.dimensions
    runs = y.reshape(SCRAMBLES, -1, design.block, y.shape[1])  # (scrambles, pairs of points, block, c)
    A, AB, BA, B = runs[:, :, :1], runs[:, :, 1 : 1 + d], runs[:, :, 1 + d : -1], runs[:, :, -1:]
    unmoved = (AB == A).all(axis=(0, 1))
    means = _means_of_both(A, AB, BA, B) if design.second_order else _means(A, AB, B)
    statistic = _of_both if design.second_order else _of_one
    deviation = np.concatenate([A, B], axis=2).std(axis=(0, 1, 2))
    return _Judged(_jackknife(means, statistic, t), unmoved.T, deviation)


def _means(A: Array, AB: Array, B: Array) -> Means:
    """Of the products behind S1 and ST, (scrambles, 1 or d, c) each."""
    return {
        "first": (B * (AB - A)).mean(axis=1),
        "total": ((A - AB) ** 2).mean(axis=1) / 2,
        "mean": (A + B).mean(axis=1) / 2,
        "square": (A**2 + B**2).mean(axis=1) / 2,
    }


def _of_one(m: Means) -> tuple[Array, Array, Array]:
    variance = m["square"] - m["mean"] ** 2
    return m["first"] / variance, m["total"] / variance, np.empty((*m["first"].shape[:-2], 0, m["first"].shape[-1]))


def _means_of_both(A: Array, AB: Array, BA: Array, B: Array) -> Means:
    """Of the products behind all three orders, each from both halves of the runs.

    E((BA_i - B)(AB_j - A)) is V_ij, the variance of the interaction, and for i = j it is -2 V_i.
    """
    from_A, from_B = AB - A, BA - B
    cross = np.einsum("smic,smjc->sijc", from_B, from_A, optimize=True) / A.shape[1]
    i, j = np.triu_indices(AB.shape[2], 1)
    variance = (((A - B) ** 2).mean(axis=1) + ((AB - BA) ** 2).mean(axis=1)) / 4
    return {
        "first": -np.einsum("siic->sic", cross) / 2,
        "total": ((from_A**2).mean(axis=1) + (from_B**2).mean(axis=1)) / 4,
        "second": (cross[:, i, j] + cross[:, j, i]) / 2,
        "variance": variance,
        "variance of pairs": (variance[:, i] + variance[:, j]) / 2,
    }


def _of_both(m: Means) -> tuple[Array, Array, Array]:
    return m["first"] / m["variance"], m["total"] / m["variance"], m["second"] / m["variance of pairs"]


def _jackknife(
    means: Means, statistic: Callable[[Means], tuple[Array, Array, Array]], t: float
) -> tuple[Estimate, Estimate, Estimate]:
    """A statistic of means with its intervals, from those of the scrambles and of all scrambles but one."""
    with np.errstate(divide="ignore", invalid="ignore"):  # no variance without the one scramble that has all of it
        values = statistic({key: mean.mean(axis=0) for key, mean in means.items()})
        without = statistic({k: (m.sum(axis=0) - m) / (SCRAMBLES - 1) for k, m in means.items()})
    first, total, second = (_estimate(v, w, t) for v, w in zip(values, without, strict=True))
    return first, total, second


def _estimate(value: Array, without: Array, t: float) -> Estimate:
    """From a value (i, c) and those without each scramble, (scrambles, i, c), to (c, i)."""
    with np.errstate(invalid="ignore"):
        half = t * np.sqrt((SCRAMBLES - 1) * without.var(axis=0))
    return Estimate(value.T, np.where(np.isfinite(half), half, np.inf).T)


def _joined(parts: Sequence[Estimate], known: Flags) -> Estimate:
    value, half = (np.concatenate([getattr(part, name) for part in parts]) for name in ("value", "half"))
    value[~known], half[~known] = np.nan, np.nan
    return Estimate(value, half)


def _unmoved(held: Outputs, factors: tuple[str, ...], unmoved: Flags) -> tuple[str, ...]:
    """A remark for each factor that some outputs do not depend on at all."""
    remarks = []
    for i, factor in enumerate(factors):
        dead = [name for name, flag in zip(held.names, unmoved[:, i] & held.known, strict=True) if flag]
        if dead:
            few = ", ".join(map(repr, dead[:3])) + (f" and {len(dead) - 3} more outputs" if len(dead) > 3 else "")
            remarks.append(f"'{factor}' changes {few} in no run: its indices there are exactly zero.")
    return tuple(remarks)
