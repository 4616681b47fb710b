"""Sobol indices: the part of an output's variance that is due to each factor, alone and together with others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from workbench.study.uncertainty.estimators import EACH, column_indices, terms
from workbench.study.uncertainty.outputs import (
    Estimate,
    Flags,
    Outputs,
    factor_names,
    outputs_of,
    place_of,
    refuse_all,
    t_quantile,
)
from workbench.study.uncertainty.sobol_design import SCRAMBLES, SobolDesign
from workbench.validation.refusals import Array, known
from workbench.validation.signatures import door

AT_ONCE = 2**22  # numbers that are looked at together: some arrays of 32 MB


@dataclass(frozen=True, eq=False)
@door
class SobolIndices:
    """Indices of d factors for k outputs, or for a single one, which leaves the axis k out.

    Attributes
    ----------
    S1, ST, S2
        First order and total (k, d); second order (k, d (d - 1) / 2) for the `pairs` of factors, or None. An interval
        of S1 or ST holds by itself, those of S2 hold together, for all pairs of an output: of some hundred pairs a few
        would seem to act by chance alone.
    groups, sums1, sumsT
        Names of groups of factors, and the sums (k, G) of S1 and of ST over each, with intervals of their own.
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
    groups: tuple[str, ...] = ()
    sums1: Estimate | None = None
    sumsT: Estimate | None = None

    @property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """The factors of each second-order index, by their places."""
        return tuple((i, j) for i in range(len(self.factors)) for j in range(i + 1, len(self.factors)))

    @door
    def __getitem__(self, name: str) -> SobolIndices:
        """The indices of one output; one that was refused is refused again, with its reason."""
        j = place_of(self.names, self.refused, name)
        S2, sums1, sumsT = (None if part is None else part[j] for part in (self.S2, self.sums1, self.sumsT))
        parts = {"S1": self.S1[j], "ST": self.ST[j], "S2": S2, "sums1": sums1, "sumsT": sumsT}
        found: SobolIndices = replace(self, names=(name,), deviation=self.deviation[j], refused={}, **cast(Any, parts))
        return found

    @door
    def of_group(self, group: str, total: bool = False) -> Estimate:
        """The sum of S1, or of ST, over the factors of a group: (k,), or of a single output one number."""
        place = self.groups.index(known(group, self.groups, "groups"))
        found = self.sumsT if total else self.sums1
        assert found is not None
        return Estimate(found.value[..., place], found.half[..., place])


@door
def sobol(
    design: SobolDesign,
    outputs: Any,
    names: Sequence[str] | None = None,
    *,
    factors: Sequence[str] | None = None,
    errors: Any = None,
    confidence: float = 0.95,
    groups: Mapping[str, Sequence[str]] | None = None,
    control: bool = False,
) -> SobolIndices:
    """Sobol indices of every output, with intervals from the scatter among the design's independent scrambles.

        S1_i = V(E(y | x_i)) / V(y)        ST_i = E(V(y | all but x_i)) / V(y)
        S2_ij = V(E(y | x_i, x_j)) / V(y) - S1_i - S1_j

    An interval is the jackknife's over the scrambles, with Student's quantile, and for pairs Bonferroni's: rows of a
    Sobol net are no independent draws to bootstrap. Outputs with failed runs or no variation are refused by name.

    Parameters
    ----------
    outputs
        (N,) or (N, k) in the order of the design's points; several metrics, or one at many times.
    names, factors
        Of the k outputs and the d factors.
    errors
        The error of each output, of the same shape, NaN if unknown; a remark says where it blurs the indices.
    groups
        Names to the factors over which S1 and ST are summed.
    control
        True if the quadratic polynomial that fits the runs serves as control variate: its own indices are exact, and
        only what it leaves is estimated, the better the nearer an output is to quadratic.

    Raises
    ------
    ValueError, LookupError
        If an argument has the wrong kind or shape, every output is refused, a group has what is no factor, or there
        are too few runs for the control variate.

    References
    ----------
    Saltelli et al. (2010), Computer Physics Communications 181, table 2 (b) and (f); of second order Azzini, Mara and
    Rosati (2021), Environmental Modelling and Software 144; the jackknife: Efron and Stein (1981), Annals of
    Statistics 9; control variates: Owen (2013), Monte Carlo theory, methods and examples, section 8.9.

    Examples
    --------
    >>> design = wb.SobolDesign(dimensions=2, base=256)
    >>> u = design.points(0, design.size)
    >>> wb.sobol(design, u[:, 0] + 2 * u[:, 1]).S1.value.round(2)
    array([[0.2, 0.8]])
    """
    named = factor_names("sobol", design, factors)
    t = t_quantile("sobol", confidence, SCRAMBLES - 1)
    _check_runs(design, control)
    refuse_all("sobol", held := outputs_of("sobol", design, outputs, names, errors))
    return _indices(design, held, named, t, dict(groups or {}), control, confidence)


def _check_runs(design: SobolDesign, control: bool) -> None:
    """Refuse a design with so few runs that the control variate would interpolate them."""
    if control and design.size < EACH * (terms(design.dimensions) + 1):
        raise ValueError(
            f"`sobol(control=True)` needs at least {EACH} runs for each of the {terms(design.dimensions) + 1} "
            f"coefficients of its polynomial; got {design.size}: raise `base`, or do without."
        )


def _indices(
    design: SobolDesign,
    held: Outputs,
    factors: tuple[str, ...],
    t: float,
    groups: Mapping[str, Sequence[str]],
    control: bool,
    confidence: float,
) -> SobolIndices:
    """The indices of all outputs, some columns at a time."""
    at_once = max(1, AT_ONCE // design.size)
    members = _members(groups, factors)
    columns = (held.scaled[:, j : j + at_once] for j in range(0, len(held.names), at_once))
    parts = [column_indices(design, some, t, members, control) for some in columns]
    S1, ST, S2, *sums = (_joined([part.indices[i] for part in parts], held.known) for i in range(5))
    # Bonferroni: each of the pairs misses so rarely that all hold together
    pairs = max(1, S2.value.shape[1])
    S2 = Estimate(S2.value, S2.half * t_quantile("sobol", 1 - (1 - confidence) / pairs, SCRAMBLES - 1) / t)
    unmoved = np.concatenate([part.unmoved for part in parts])
    deviation = np.concatenate([part.deviation for part in parts]) * held.spread
    return SobolIndices(
        held.names,
        factors,
        S1,
        ST,
        S2 if design.second_order else None,
        np.where(held.known, deviation, np.nan),
        held.refused,
        held.remarks + _unmoved(held, factors, unmoved),
        tuple(groups),
        *(sums if groups else (None, None)),
    )


def _members(groups: Mapping[str, Sequence[str]], factors: tuple[str, ...]) -> Array:
    """The factors of each group, (G, d), as zeros and ones."""
    inside = np.zeros((len(groups), len(factors)))
    for row, listed in zip(inside, groups.values(), strict=True):
        row[[factors.index(known(name, factors, "factors")) for name in listed]] = 1.0
    return inside


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
