"""Sobol indices, each factor's part of an output's variance, alone and with others; SALib's beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from workbench.core.validation.refusals import Array, known, whole
from workbench.core.validation.refusals import seed as as_seed
from workbench.core.validation.signatures import door
from workbench.study.uncertainty.estimators import EACH, column_indices, terms
from workbench.study.uncertainty.outputs import (
    Estimate,
    Flags,
    Outputs,
    columns_of,
    of_output,
    outputs_of,
    t_quantile,
)
from workbench.study.uncertainty.sobol_design import SCRAMBLES, SobolDesign

AT_ONCE = 2**22  # numbers that are looked at together: some arrays of 32 MB
MOST_DRAWS = 10**8  # of a bootstrap at once: 0.8 GB


@dataclass(frozen=True, eq=False)
@door
class SobolIndices:
    """Indices of d factors for k outputs, or for a single one without the axis k.

    Attributes
    ----------
    S1, ST, S2
        First order and total (k, d); second order (k, d (d - 1) / 2) for the `pairs` of factors, or None. An interval
        of S1 or ST holds by itself, those of S2 hold together, for all pairs of an output.
    groups, sums1, sumsT
        Names of groups of factors, and the sums (k, G) of S1 and of ST over each, with intervals of their own.
    deviation
        (k,), of the outputs over all factors.
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
        return cast(SobolIndices, of_output(self, name, "S1", "ST", "S2", "deviation", "sums1", "sumsT"))

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

    The estimators are those of Saltelli et al. (2010), Computer Physics Communications 181, table 2 (b) and (f), and
    of second order those of Azzini, Mara and Rosati (2021), Environmental Modelling and Software 144. An interval is
    the jackknife's over the scrambles (Efron and Stein 1981, Annals of Statistics 9), with Student's quantile, and for
    pairs Bonferroni's. Outputs with failed runs or no variation are refused by name.

    Parameters
    ----------
    outputs
        (N,) or (N, k) in the order of the design's points; several metrics, or one at many times.
    errors
        Of the outputs, of the same shape, NaN where unknown; a remark says where they blur the indices.
    groups
        By name the factors over which S1 and ST are summed.
    control
        True if the quadratic polynomial that fits the runs serves as control variate (Owen 2013, Monte Carlo theory,
        methods and examples, section 8.9): its indices are exact, and only what it leaves is estimated.

    Raises
    ------
    ValueError, LookupError
        If an argument has the wrong kind or shape, every output is refused, a group has what is no factor, or there
        are too few runs for the control variate.

    Examples
    --------
    >>> design = wb.SobolDesign(dimensions=2, base=256)
    >>> u = design.points(0, design.size)
    >>> wb.sobol(design, u[:, 0] + 2 * u[:, 1]).S1.value.round(2)
    array([[0.2, 0.8]])
    """
    t = t_quantile("sobol", confidence, SCRAMBLES - 1)
    coefficients = terms(design.dimensions) + 1
    if control and design.size < EACH * coefficients:
        raise ValueError(
            f"`sobol(control=True)` needs at least {EACH} runs for each of the {coefficients} coefficients of its "
            f"polynomial; got {design.size}: raise `base`, or do without."
        )
    held = outputs_of("sobol", design, outputs, names, factors, errors)
    return _indices(design, held, t, dict(groups or {}), control, confidence)


@door
def least_base(dimensions: int, second_order: bool = False) -> int:
    """The least `base` of a `SobolDesign` whose runs are enough for `sobol(control=True)`: a power of two.

    Examples
    --------
    >>> least_base(dimensions=12)
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
        row[[held.factors.index(known(name, held.factors, "factors")) for name in listed]] = 1.0
    columns = (held.scaled[:, j : j + at_once] for j in range(0, len(held.names), at_once))
    parts = (column_indices(design, some, t, members, control) for some in columns)
    *numbers, unmoved, deviation = map(np.concatenate, zip(*parts, strict=True))
    for part in numbers:
        part[~held.known] = np.nan
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
        np.where(held.known, deviation * held.spread, np.nan),
        held.refused,
        held.remarks + _unmoved(held, unmoved),
        tuple(groups),
        *(sums if groups else (None, None)),
    )


def _unmoved(held: Outputs, unmoved: Flags) -> tuple[str, ...]:
    """A remark for each factor that some outputs do not depend on at all."""
    remarks = []
    for i, factor in enumerate(held.factors):
        dead = [name for name, flag in zip(held.names, unmoved[:, i] & held.known, strict=True) if flag]
        if dead:
            few = ", ".join(map(repr, dead[:3])) + (f" and {len(dead) - 3} more outputs" if len(dead) > 3 else "")
            remarks.append(f"'{factor}' changes {few} in no run: its indices there are exactly zero.")
    return tuple(remarks)


@door
def sobol_by_salib(
    design: SobolDesign,
    outputs: Any,
    names: Sequence[str] | None = None,
    *,
    factors: Sequence[str] | None = None,
    confidence: float = 0.95,
    resamples: int = 100,
    seed: int = 0,
) -> SobolIndices:
    """The indices that SALib (Herman and Usher 2017, Journal of Open Source Software 2(9)) finds in the same runs.

    Its intervals are the bootstrap's, by `resamples` and `seed`, as if the rows of a Sobol net were independent draws;
    outputs are refused as by `sobol`.

    Raises
    ------
    ValueError
        As `sobol` does, if there are less than two resamples, or if SALib is not installed.

    Examples
    --------
    >>> from workbench.study.uncertainty import sobol_by_salib
    >>> design = wb.SobolDesign(2, 16, True)
    >>> values = design.points() @ [1.0, 2.0]
    >>> sobol_by_salib(design, values, ("error",), factors=("k", "m"), resamples=4, seed=1).S1.value.shape
    (1, 2)
    """
    try:
        from SALib.analyze import sobol as analysis  # costs a second, and only those who ask for it
    except ImportError:
        raise ValueError(
            "`sobol_by_salib(...)` needs the package SALib: install it by `pip install control-workbench[data]`."
        ) from None
    most = max(2, MOST_DRAWS // design.size)
    whole("sobol_by_salib(resamples=...)", resamples, 2, most, why="which the memory of a computer holds")
    # SALib takes a seed of 0 for none, and would draw from NumPy's hidden state
    seed = as_seed("sobol_by_salib(seed=...)", seed) + 1
    ours = sobol(design, outputs, names, factors=factors, confidence=confidence)
    columns = columns_of("sobol_by_salib", design, outputs, names)[1]
    columns[:, [name in ours.refused for name in ours.names]] = np.nan
    found = [_by_salib(analysis, design, column, resamples, confidence, seed) for column in columns.T]
    orders = [[np.stack(part) for part in zip(*order, strict=True)] for order in zip(*found, strict=True)]
    S1, ST, S2 = (Estimate(value, half) for value, half in orders)
    return replace(ours, S1=S1, ST=ST, S2=S2 if design.second_order else None, remarks=())


def _by_salib(
    analysis: Any, design: SobolDesign, column: Array, resamples: int, confidence: float, seed: int
) -> list[tuple[Array, Array]]:
    """S1, ST and S2 with halves of their intervals, as SALib has them; NaN for a column of NaN."""
    d = design.dimensions
    pairs = np.triu_indices(d if design.second_order else 0, 1)
    if np.isnan(column).any():
        return [(np.full(size, np.nan), np.full(size, np.nan)) for size in (d, d, len(pairs[0]))]
    problem = {"num_vars": d, "names": [f"x{i}" for i in range(d)], "bounds": [[0.0, 1.0]] * d}
    said = analysis.analyze(problem, column, design.second_order, resamples, confidence, seed=seed)
    second = [said.get(key, np.empty((0, 0)))[pairs] for key in ("S2", "S2_conf")]
    return [(said["S1"], said["S1_conf"]), (said["ST"], said["ST_conf"]), (second[0], second[1])]
