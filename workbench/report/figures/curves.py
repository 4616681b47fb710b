"""The points of the curves of a figure, thinned for drawing."""

from __future__ import annotations

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.report.figures.rulers import Ruler
from workbench.report.figures.style import points_of
from workbench.study.document.figure import Band, Figure, Mark, Panel, Series

GOLDEN = (np.sqrt(5) - 1) / 2


def drawn_points(mark: Mark, panel: Panel, figure: Figure) -> tuple[Array, ...]:
    """The points of a curve that are drawn, an abscissa and its ordinates; a mark that is no curve has none."""
    if not isinstance(mark, Series | Band):
        return ()
    curves = crop_curves(
        mark.curves, None if panel.aspect == "equal" else panel.xlim
    )  # equal axes may be wider than their limits
    if isinstance(mark, Series) and mark.look == "dots":
        return thin_dots(curves, points_of(figure))
    if panel.xscale == "linear" and panel.xcut is None:
        return thin_curves(curves, points_of(figure))
    low, high = panel.xlim or (float(curves[0][0]), float(curves[0][-1]))
    ruler = Ruler(panel.xscale, low, high, cut=panel.xcut)
    return thin_curves(curves, points_of(figure), ruler.straight(curves[0]))


def crop_curves(curves: tuple[Array, ...], limits: tuple[float, float] | None) -> tuple[Array, ...]:
    """The curves within the limits of the abscissa and one point to each side; one that runs back is left whole."""
    if limits is None or (np.diff(curves[0]) < 0).any():
        return curves
    first, last = np.searchsorted(curves[0], limits)
    inside = slice(max(0, int(first) - 1), max(int(last) + 1, 2))
    return tuple(curve[inside] for curve in curves)


def thin_dots(curves: tuple[Array, ...], points: int) -> tuple[Array, ...]:
    """A selection of about `points` of the points (N,) of an abscissa and its ordinates that shows how they scatter.

    Each of equally long stretches keeps one point, whatever its ordinate; its place in the stretch moves by the golden
    section from one stretch to the next, so that no period of the points decides. The least and the greatest ordinate
    of all are kept.
    """
    n = len(curves[0])
    if n <= points:
        return curves
    k = np.arange(points)
    kept = [np.floor((k + np.mod(k * GOLDEN, 1.0)) * n / points).astype(int)]
    kept += [[np.nanargmin(one), np.nanargmax(one)] for one in curves[1:] if not np.isnan(one).all()]
    places = np.unique(np.minimum(np.concatenate(kept), n - 1))
    return tuple(curve[places] for curve in curves)


def thin_curves(curves: tuple[Array, ...], points: int, across: Array | None = None) -> tuple[Array, ...]:
    """A selection of about `points` of the points (N,) of an abscissa and its ordinates, which keeps their extremes.

    Each of equally long stretches keeps the points where an ordinate is least and greatest, and one gap if it holds any
    NaN; a curve whose abscissa runs back and forth keeps the extremes of the abscissa too. So are both ends. Stretches
    hold as many points each, or, with `across`, the places of ascending points on an uneven ruler, are as wide.
    """
    n = len(curves[0])
    if n <= points:
        return curves
    back = (np.diff(curves[0]) < 0).any()
    sources = curves if back else curves[1:]
    stretches = max(1, points // (2 * len(sources)))
    ends = np.linspace(0, n, stretches + 1).astype(int)
    if across is not None and not back:
        edges = across[0] + (across[-1] - across[0]) * np.arange(1, stretches) / stretches
        ends = np.unique([0, *np.searchsorted(across, edges), n])
    begin, last = ends[:-1], ends[1:, np.newaxis] - 1
    # the places of each stretch, a row each; those of a shorter one end with its last place again and again
    within = np.minimum(begin[:, np.newaxis] + np.arange(np.diff(ends).max()), last)
    kept = [np.array([0, n - 1])]
    for source in sources:
        gaps = np.isnan(source)
        low, high = np.where(gaps, np.inf, source), np.where(gaps, -np.inf, source)
        gap = gaps[within]
        kept += [begin + low[within].argmin(axis=1), begin + high[within].argmax(axis=1)]
        kept.append((begin + gap.argmax(axis=1))[gap.any(axis=1)])
    places = np.unique(np.concatenate(kept))
    return tuple(curve[places] for curve in curves)
