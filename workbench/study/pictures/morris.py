"""Morris plane: how large the effects of each factor are, mu*, against how much they change, sigma."""

from __future__ import annotations

import numpy as np

from workbench.notation.formula import Relation, Symbol
from workbench.study.cells import Column, Phrase, Table, parts
from workbench.study.curves import Array, Label
from workbench.study.document import Figure, Panel, Points, Series
from workbench.study.pictures.parts import Labels, captioned, each, named, number, refusals, with_unit
from workbench.study.sensitivity import Estimate, MorrisEffects

MU_STAR, SIGMA = Symbol("mu", mark="*"), Symbol("sigma")
LEAST = 0.02  # of the other axis that an axis spans: below lies rounding
LETTERS = 200  # of names that the plane has room for
UNBOUNDED = "An interval with an arrow goes on beyond the axes."


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
    names, key = _names(single[0], labels)
    said = (*refusals(effects), *key, *(() if all(map(_bounded, single)) else (UNBOUNDED,)))
    return Figure(
        name,
        captioned("morris_plane", caption, note, *said),
        tuple(_panel(one, unit, names, _title(one, labels) if len(effects.names) > 1 else "") for one in single),
        numbers=_numbers(name, caption, single, unit),
    )


def _bounded(effects: MorrisEffects) -> bool:
    return bool(np.isfinite(effects.mu_star.half).all() and np.isfinite(effects.sigma.half).all())


def _names(effects: MorrisEffects, labels: Labels) -> tuple[tuple[Label, ...], tuple[Phrase, ...]]:
    """The names beside the points, or their numbers by falling mu*, with a key, where names would cover the plane."""
    names = named("morris_plane", effects.factors, {k: v for k, v in (labels or {}).items() if k in effects.factors})
    if sum(map(_letters, names)) <= LETTERS:
        return names, ()
    order = np.argsort(-effects.mu_star.value, kind="stable").tolist()
    numbers = {i: str(place + 1) for place, i in enumerate(order)}
    key = [(*(["; "] if place else []), *parts(names[i]), f" ({numbers[i]})") for place, i in enumerate(order)]
    return tuple(numbers[i] for i in range(len(names))), (tuple(part for pair in key for part in pair),)


def _letters(label: Label) -> int:
    return sum(len(part) if isinstance(part, str) else 3 for part in parts(label))


def _title(effects: MorrisEffects, labels: Labels) -> Label:
    (output,) = effects.names
    return (labels or {}).get(output, output)


def _panel(effects: MorrisEffects, unit: str, names: tuple[Label, ...], title: Label) -> Panel:
    x, y = effects.mu_star, effects.sigma
    (xlow, xhigh, right), (ylow, yhigh, top) = _interval(x), _interval(y)
    right, top = max(right, LEAST * top), max(top, LEAST * right)
    end = min(right, top)
    points = Points("", x.value, y.value, names, xlow=xlow, xhigh=xhigh, ylow=ylow, yhigh=yhigh)
    return Panel(
        with_unit(SIGMA, unit),
        (points, Series(Relation(SIGMA, "=", MU_STAR), [0.0, end], [0.0, end], "bound")),
        xlabel=with_unit(MU_STAR, unit),
        xlim=(0.0, right),
        ylim=(0.0, top),
        title=title,
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
