"""Morris plane: how large the effects of each factor are, mu*, against how much they change, sigma."""

from __future__ import annotations

import numpy as np

from workbench.notation.formula import Relation, Symbol
from workbench.study.cells import Column, Phrase, Table
from workbench.study.curves import Array
from workbench.study.document import Figure, Panel, Points, Series
from workbench.study.pictures.parts import Labels, captioned, each, named, number, refusals, with_unit
from workbench.study.sensitivity import Estimate, MorrisEffects

MU_STAR, SIGMA = Symbol("mu", mark="*"), Symbol("sigma")


def morris_plane(
    name: str, caption: Phrase, effects: MorrisEffects, note: Phrase, unit: str = "", *, labels: Labels = None
) -> Figure:
    """The factors in the plane of mu* and sigma with their intervals, and the line sigma = mu*.

    Far right is what matters. Below the line a factor acts much alike everywhere, above it by curves or together with
    others. Intervals are cut at 0, as neither number can be negative; one that nothing bounds ends in an arrow.
    Several outputs have a panel each.

    Parameters
    ----------
    note
        Runs, failed runs, seed and step error, as `sample.note_of(metric, joint)` says them.
    unit
        Of the output.
    labels
        How factors and outputs are written, by their names; as they stand, without.

    Raises
    ------
    ValueError
        If the note is empty.
    LookupError
        If a label names no factor or output.
    """
    named("morris_plane", (*effects.factors, *effects.names), labels)
    single = list(each(effects))
    said = (*refusals(effects), *(() if all(map(_bounded, single)) else (UNBOUNDED,)))
    return Figure(
        name,
        captioned("morris_plane", caption, note, *said),
        tuple(_panel(one, unit, labels, titled=len(effects.names) > 1) for one in single),
        numbers=_numbers(name, caption, single, unit),
    )


LEAST = 0.02  # of the other axis that an axis spans: below lies rounding
UNBOUNDED = "An interval with an arrow goes on beyond the axes."


def _bounded(effects: MorrisEffects) -> bool:
    return bool(np.isfinite(effects.mu_star.half).all() and np.isfinite(effects.sigma.half).all())


def _panel(effects: MorrisEffects, unit: str, labels: Labels, titled: bool) -> Panel:
    x, y = effects.mu_star, effects.sigma
    (xlow, xhigh, right), (ylow, yhigh, top) = _interval(x), _interval(y)
    right, top = max(right, LEAST * top), max(top, LEAST * right)
    end = min(right, top)
    written = dict(labels or {})
    (output,) = effects.names
    points = Points(
        "",
        x.value,
        y.value,
        tuple(written.get(factor, factor) for factor in effects.factors),
        xlow=xlow,
        xhigh=xhigh,
        ylow=ylow,
        yhigh=yhigh,
    )
    return Panel(
        with_unit(SIGMA, unit),
        (points, Series(Relation(SIGMA, "=", MU_STAR), [0.0, end], [0.0, end], "bound")),
        xlabel=with_unit(MU_STAR, unit),
        xlim=(0.0, right),
        ylim=(0.0, top),
        title=written.get(output, output) if titled else "",
    )


def _interval(estimate: Estimate) -> tuple[Array, Array, float]:
    """The ends of the intervals, and the end of an axis that shows the values and most of their intervals."""
    low, high = np.maximum(estimate.low, 0.0), estimate.high
    largest = float(estimate.value.max())
    ends = high[np.isfinite(high)]
    reach = min(float(ends.max(initial=largest)), 2 * largest)
    return low, high, 1.06 * reach if reach > 0 else 1.0


def _numbers(name: str, caption: Phrase, single: list[MorrisEffects], unit: str) -> Table:
    rows = []
    for one in single:
        for i in np.argsort(-one.mu_star.value, kind="stable"):
            moments = [(part.value[i], part.half[i]) for part in (one.mu_star, one.sigma, one.mu)]
            rows.append((one.names[0], one.factors[i], *(number(value) for pair in moments for value in pair)))
    heads = [Column(head, unit) for kind in ("mu*", "sigma", "mu") for head in (kind, f"{kind} (half-interval)")]
    return Table(name, caption, (Column("output"), Column("factor"), *heads), tuple(rows))
