"""Budget curves: the best that searches found against what it cost."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.study.document.cells import Column, Phrase, Table
from workbench.study.document.curves import STYLES, Array
from workbench.study.document.document import Band, Figure, Label, Panel, Series
from workbench.study.pictures.parts import by_law, captioned, require_array, scale_of, stretches
from workbench.validation.signatures import door


@door
def budget_curves(
    name: str,
    caption: Phrase,
    curves: Mapping[str, tuple[Array, Array]],
    note: Phrase,
    ylabel: Label,
) -> Figure:
    """The best so far against the evaluations that it cost, law by law.

    Of several searches the line is their median, and the band reaches from the best to the worst. Where a search has
    nothing admissible yet there is no band, and no line if that holds for half of them. A search that ended before the
    others goes on at its best, as `Tuned.curves` has it.

    Parameters
    ----------
    curves
        By law, evaluations (n,) and the best so far, (n,) or (searches, n); infinite or NaN while none is admissible.
    note
        Evaluations, failed ones, seeds and step error.

    Raises
    ------
    ValueError
        If the note is empty, or a curve has no such shapes.
    """
    held = {law: _curve(law, pair) for law, pair in by_law("budget_curves", "curves", curves).items()}
    finite = np.concatenate([best[np.isfinite(best)] for _, best in held.values()])
    if not finite.size:
        raise ValueError(f"`budget_curves('{name}')` needs a law that found something admissible; got none.")
    marks: list[Series | Band] = []
    for k, (law, (spent, best)) in enumerate(held.items()):
        middle = np.median(best, axis=0)
        marks.append(Series(law, spent, np.where(np.isfinite(middle), middle, np.nan), k % STYLES, "steps"))
        low, high = best.min(axis=0), best.max(axis=0)
        spread = np.where(np.isfinite(high) & (len(best) > 1), high, np.nan)
        marks += [_band(spent[j], low[j], high[j], k % STYLES) for j in stretches(spread)]
    several = any(len(best) > 1 for _, best in held.values())
    said = ["Lines are medians of searches from different seeds; bands reach from the best to the worst."] * several
    panel = Panel(ylabel, tuple(marks), xlabel="evaluations", yscale=scale_of(finite))
    return Figure(
        name, captioned("budget_curves", caption, note, *said), (panel,), numbers=_numbers(name, caption, held, ylabel)
    )


def _band(spent: Array, low: Array, high: Array, style: int) -> Band:
    """A band in steps, as its line."""
    return Band("", np.repeat(spent, 2)[1:], np.repeat(low, 2)[:-1], np.repeat(high, 2)[:-1], style)


def _curve(law: str, pair: tuple[Array, Array]) -> tuple[Array, Array]:
    call = f"budget_curves(curves={{'{law}': ...}})"
    spent, best = require_array(call, pair[0]), np.atleast_2d(require_array(call, pair[1]))
    if best.ndim != 2 or spent.shape != best.shape[1:]:
        raise ValueError(
            f"`{call}` must be evaluations (n,) and the best so far, (n,) or (searches, n); got the shapes "
            f"{spent.shape} and {best.shape}."
        )
    return spent, np.where(np.isnan(best), np.inf, best)


def _numbers(name: str, caption: Phrase, held: Mapping[str, tuple[Array, Array]], ylabel: Label) -> Table:
    rows = tuple(
        (law, search + 1, float(spent[k]), float(best[search, k]))
        for law, (spent, best) in held.items()
        for search in range(len(best))
        for k in range(len(spent))
    )
    return Table(name, caption, (*map(Column, ("law", "search", "evaluations")), Column(ylabel)), rows)
