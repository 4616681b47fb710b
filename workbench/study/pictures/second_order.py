"""Second-order map: which pairs of factors act together, and by what part of the variance."""

from __future__ import annotations

import numpy as np

from workbench.study.document.cells import Column, Phrase, Table
from workbench.study.document.document import Figure, HeatMap, Panel
from workbench.study.pictures.parts import Labels, captioned, each, number, refusals, written
from workbench.study.uncertainty.indices import SobolIndices
from workbench.study.uncertainty.outputs import Estimate
from workbench.validation.signatures import door

DARKEST = 0.1  # the least index whose cell may be as dark as can be
ALONE = "Grey: the interval holds 0, so that these runs are too few to tell it from 0."


@door
def second_order_map(
    name: str, caption: Phrase, indices: SobolIndices, note: Phrase, *, labels: Labels = None
) -> Figure:
    """S2 of every pair of factors in a cell, the darker the larger; grey where its interval holds 0.

    Several outputs have a panel each.

    Parameters
    ----------
    indices
        With those of second order.
    note
        Runs, failed runs, seed and step error, as `sample.note_of(metric, joint)` says them.
    labels
        How factors and outputs are written, by their names; as they stand where it does not say.

    Raises
    ------
    ValueError
        If the note is empty, or there are no pairs.
    """
    if indices.S2 is None or not indices.pairs:
        what = "without second order" if indices.S2 is None else "of one factor"
        raise ValueError(
            f"`second_order_map('{name}')` needs indices of pairs of factors; got indices {what}. Draw the runs with "
            "`SobolDesign(..., second_order=True)` over two factors or more."
        )
    single = each(indices)
    return Figure(
        name,
        captioned("second_order_map", caption, note, *refusals(indices), ALONE),
        tuple(_panel(one, labels, titled=len(indices.names) > 1) for one in single),
        numbers=_numbers(name, caption, single),
    )


def _panel(one: SobolIndices, labels: Labels, titled: bool) -> Panel:
    """Rows are the factors but the first, columns those but the last: a pair stands in one cell."""
    assert one.S2 is not None
    d = len(one.factors)
    values, faint = np.full((d - 1, d - 1), np.nan), np.zeros((d - 1, d - 1), dtype=bool)
    for k, (i, j) in enumerate(one.pairs):
        values[j - 1, i] = one.S2.value[k]
        faint[j - 1, i] = not (one.S2.low[k] > 0 or one.S2.high[k] < 0)
    names = tuple(written(factor, labels) for factor in one.factors)
    return Panel(
        "",
        (HeatMap(values, faint, most=max(DARKEST, _largest(one.S2))),),
        xlabel="",
        title=written(one.names[0], labels) if titled else "",
        xnames=names[:-1],
        ynames=names[1:],
    )


def _largest(estimate: Estimate) -> float:
    return float(estimate.value.max())


def _numbers(name: str, caption: Phrase, single: list[SobolIndices]) -> Table:
    rows = tuple(
        (one.names[0], one.factors[i], one.factors[j], number(one.S2.value[k]), number(one.S2.half[k]))
        for one in single
        if one.S2 is not None
        for k, (i, j) in enumerate(one.pairs)
    )
    return Table(name, caption, tuple(map(Column, ("output", "factor", "with", "S2", "S2 (half-interval)"))), rows)
