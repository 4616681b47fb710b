"""Sobol indices, each factor's part of an output's variance, alone and with others; SALib's beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array, known_name
from workbench.core.validation.signatures import check_arguments
from workbench.study.uncertainty.outputs import (
    Estimate,
    Flags,
    Outputs,
    of_output,
    outputs_of,
    t_quantile,
)
from workbench.study.uncertainty.sobol_design import SCRAMBLES, SobolDesign
from workbench.study.uncertainty.sobol_estimators import EACH, column_indices, terms

AT_ONCE = 2**22  # numbers that are looked at together: some arrays of 32 MB
MOST_DRAWS = 10**8  # of a bootstrap at once: 0.8 GB


@dataclass(frozen=True, eq=False)
@check_arguments
class SobolIndices:
    """Sobol indices of d factors for k outputs; for a single output without the axis k.

    Attributes
    ----------
    S1, ST, S2
        First order and total (k, d); second order (k, d (d - 1) / 2) for the `pairs` of factors, or None. An interval
        of S1 or ST holds by itself, those of S2 hold together, for all pairs of an output.
    groups, sums1, sumsT
        Names of groups of factors, and the sums (k, G) of S1 and of ST over each, with intervals of their own.
    deviation
        The standard deviation (k,) of the outputs over all factors.
    refusals
        The reason for each output that has no indices; its numbers are NaN.
    """

    names: tuple[str, ...]
    factors: tuple[str, ...]
    S1: Estimate
    ST: Estimate
    S2: Estimate | None
    deviation: Array
    refusals: Mapping[str, str]
    remarks: tuple[str, ...]
    groups: tuple[str, ...] = ()
    sums1: Estimate | None = None
    sumsT: Estimate | None = None

    @property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """The factors of each second-order index, by their places."""
        return tuple((i, j) for i in range(len(self.factors)) for j in range(i + 1, len(self.factors)))

    @check_arguments
    def __getitem__(self, name: str) -> SobolIndices:
        """The indices of one output; one that was refused is refused again, with its reason."""
        return of_output(self, name, "S1", "ST", "S2", "deviation", "sums1", "sumsT")

    @check_arguments
    def of_group(self, group: str, total: bool = False) -> Estimate:
        """The sum of S1, or of ST if `total`, over the factors of a group: (k,), or one number for a single output."""
        place = self.groups.index(known_name(group, self.groups, "groups"))
        found = self.sumsT if total else self.sums1
        assert found is not None
        return Estimate(found.value[..., place], found.half[..., place])


@check_arguments
def sobol(
    design: SobolDesign,
    outputs: object,
    names: Sequence[str] | None = None,
    *,
    factors: Sequence[str] | None = None,
    errors: object = None,
    confidence: float = 0.95,
    groups: Mapping[str, Sequence[str]] | None = None,
    control_variate: bool = False,
) -> SobolIndices:
    """Sobol indices of every output, with intervals from the scatter among the design's independent scrambles.

        S1_i = V(E(y | x_i)) / V(y)        ST_i = E(V(y | all but x_i)) / V(y)
        S2_ij = V(E(y | x_i, x_j)) / V(y) - S1_i - S1_j

    The estimators are those of Saltelli et al. (2010), Computer Physics Communications 181, table 2 (b) and (f), and
    of second order those of Azzini, Mara and Rosati (2021), Environmental Modelling and Software 144. An interval is
    the jackknife's over the scrambles (Efron and Stein 1981, Annals of Statistics 9), with Student's quantile, which is
    corrected for the number of pairs after Bonferroni. Outputs with failed runs or no variation are refused by name.

    Parameters
    ----------
    outputs
        (N,) or (N, k) in the order of the design's points; several metrics, or one at many times.
    errors
        The errors of the outputs, of the same shape, NaN where unknown; a remark says where they blur the indices.
    groups
        By name of a group, the factors over which S1 and ST are summed. A sum of ST counts interactions within the
        group more than once.
    control_variate
        True if the quadratic polynomial that fits the runs serves as control variate (Owen 2013, Monte Carlo theory,
        methods and examples, section 8.9): its indices are exact, and only what it leaves is estimated.

    Raises
    ------
    ValueError, LookupError
        If an argument has the wrong kind or shape, every output is refused, a group names no factor, or there are too
        few runs for the control variate.

    Examples
    --------
    >>> design = wb.SobolDesign(dimensions=2, base=256)
    >>> u = design.points(0, design.size)
    >>> wb.sobol(design, u[:, 0] + 2 * u[:, 1]).S1.value.round(2)
    array([[0.2, 0.8]])
    """
    t = t_quantile("sobol", confidence, SCRAMBLES - 1)
    coefficients = terms(design.dimensions) + 1
    if control_variate and design.size < EACH * coefficients:
        raise ValueError(
            f"`sobol(control_variate=True)` needs at least {EACH} runs for each of {coefficients} coefficients of its "
            f"polynomial; got {design.size}: raise `base`, or do without."
        )
    held = outputs_of("sobol", design, outputs, names, factors, errors)
    return _indices(design, held, t, dict(groups or {}), control_variate, confidence)


@check_arguments
def least_base(dimensions: int, second_order: bool = False) -> int:
    """The least `base` of a `SobolDesign` with enough runs for `sobol(control_variate=True)`, a power of two.

    Examples
    --------
    >>> wb.uncertainty.least_base(dimensions=12)
    32
    """
    needed, base = EACH * (terms(dimensions) + 1), 2 * SCRAMBLES
    while SobolDesign(dimensions, base, second_order).size < needed:
        base *= 2
    return base


def _indices(
    design: SobolDesign, held: Outputs, t: float, groups: Mapping[str, Sequence[str]], control: bool, confidence: float
) -> SobolIndices:
    """The indices of all outputs, some columns at a time."""
    at_once = max(1, AT_ONCE // design.size)
    members = np.zeros((len(groups), len(held.factors)))
    for row, listed in zip(members, groups.values(), strict=True):
        row[[held.factors.index(known_name(name, held.factors, "factors")) for name in listed]] = 1.0
    columns = (held.scaled_columns[:, j : j + at_once] for j in range(0, len(held.names), at_once))
    parts = (column_indices(design, some, t, members, control) for some in columns)
    *numbers, unmoved, deviation = map(np.concatenate, zip(*parts, strict=True))
    for part in numbers:
        part[~held.is_accepted] = np.nan
    S1, ST, S2, *sums = map(Estimate, numbers[::2], numbers[1::2])
    # Bonferroni: each of the pairs misses so rarely that all hold together
    pairs = max(1, S2.value.shape[1])
    S2 = Estimate(S2.value, S2.half * t_quantile("sobol", 1 - (1 - confidence) / pairs, SCRAMBLES - 1) / t)
    return SobolIndices(
        held.names,
        held.factors,
        S1,
        ST,
        S2 if design.second_order else None,
        np.where(held.is_accepted, deviation * held.spread, np.nan),
        held.refusals,
        held.remarks + _unmoved(held, unmoved),
        tuple(groups),
        *(sums if groups else (None, None)),
    )


def _unmoved(held: Outputs, unmoved: Flags) -> tuple[str, ...]:
    """A remark for each factor that some outputs do not depend on at all."""
    remarks = []
    for i, factor in enumerate(held.factors):
        dead = [name for name, flag in zip(held.names, unmoved[:, i] & held.is_accepted, strict=True) if flag]
        if dead:
            few = ", ".join(map(repr, dead[:3])) + (f" and {len(dead) - 3} more outputs" if len(dead) > 3 else "")
            remarks.append(f"'{factor}' changes {few} in no run: its indices there are exactly zero.")
    return tuple(remarks)
