"""The points of which none other is better in one measure without being worse in another."""

from __future__ import annotations

import numpy as np

from workbench.validation.refusals import Array, Integers
from workbench.validation.signatures import door


@door
def pareto(points: Array) -> Integers:
    """The places of the non-dominated among points (B, m) whose m measures should all be small.

    A point is dominated if another is nowhere larger and somewhere smaller; so of equal points all stay. They come in
    rising order of the first measure, then of the next ones. A point with a NaN, a run that failed, is on no front.

    Raises
    ------
    ValueError
        If they are no such table.
    """
    if points.ndim != 2 or not points.shape[1]:
        raise ValueError(f"`pareto(points)` takes points (B, m), one column a measure; got shape {points.shape}.")
    known = np.flatnonzero(~np.isnan(points).any(axis=1))
    # in this order nobody is dominated by one who comes later
    order = known[np.lexsort(points[known].T[::-1])]
    front: list[int] = []
    held = np.empty((0, points.shape[1]))
    for place in order:
        point = points[place]
        below = (held <= point).all(axis=1)
        if not (below & (held < point).any(axis=1)).any():
            front.append(int(place))
            held = np.vstack([held, point])
    return np.array(front, dtype=int)
