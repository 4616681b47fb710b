"""Ranks: how probable each place among all laws is for each of them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.study.document.cells import Column, Phrase, Table
from workbench.study.document.document import Bars, Figure, Panel
from workbench.study.pictures.parts import by_law, captioned, require_array
from workbench.validation.refusals import Array
from workbench.validation.signatures import door

ORDER = "Laws stand in the order of their mean ranks."
ROUNDING = 1e-9  # by which probabilities may miss a sum of 1


@door
def rank_figure(name: str, caption: Phrase, ranks: Mapping[str, Array], note: Phrase) -> Figure:
    """A bar a law, cut into the probabilities of its ranks, the first the darkest; the least mean rank on top.

    Parameters
    ----------
    ranks
        By law, the probability of each rank from the first, (L,), which add up to 1.
    note
        Draws, failed runs, seed and step error.

    Raises
    ------
    ValueError
        If the note is empty, or these are no probabilities.
    """
    held = np.array([_checked(law, given, ranks) for law, given in by_law("rank_figure", "ranks", ranks).items()])
    order = np.argsort(held @ np.arange(1, held.shape[1] + 1), kind="stable")
    laws, held = [list(ranks)[i] for i in order], held[order]
    ends = np.minimum(held.cumsum(axis=1), 1.0)
    bars = tuple(
        Bars(
            f"rank {place + 1}",
            np.arange(len(laws), dtype=float),
            ends[:, place],
            ends[:, place] - held[:, place],
            shade=_shade(place, held.shape[1]),
            texts=tuple(f"{100 * part:.0f} %" for part in held[:, place]),
        )
        for place in range(held.shape[1])
    )
    panel = Panel("", bars, xlabel="probability", xlim=(0.0, 1.0), ynames=tuple(laws))
    rows = tuple((law, *map(float, row)) for law, row in zip(laws, held, strict=True))
    heads = (Column("law"), *(Column(f"rank {place + 1}") for place in range(held.shape[1])))
    return Figure(
        name, captioned("rank_figure", caption, note, ORDER), (panel,), numbers=Table(name, caption, heads, rows)
    )


def _shade(place: int, places: int) -> float:
    return 1.0 - 0.94 * place / max(1, places - 1)


def _checked(law: str, given: Array, ranks: Mapping[str, Array]) -> Array:
    call = f"rank_figure(ranks={{'{law}': ...}})"
    row = require_array(call, given)
    if row.ndim != 1 or len(row) < len(ranks) or len({np.size(other) for other in ranks.values()}) > 1:
        raise ValueError(
            f"`{call}` must be the probability of each rank from the first, as many for each law, and at least one a "
            f"law; got {np.size(given)} for {len(ranks)} laws."
        )
    if not ((row >= 0) & (row <= 1)).all() or abs(row.sum() - 1) > ROUNDING:
        raise ValueError(f"`{call}` must be probabilities that add up to 1; got {np.array2string(row, precision=4)}.")
    return row
