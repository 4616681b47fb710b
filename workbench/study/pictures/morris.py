"""Morris plane: how large the effects of each factor are, mu*, against how much they change, sigma."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.notation.formula import Relation, Symbol
from workbench.study.cells import Column, Phrase, Table, parts
from workbench.study.curves import Array, Label
from workbench.study.document import Figure, Panel, Points, Series
from workbench.study.pictures.parts import BEYOND, Labels, captioned, each, number, refusals, with_unit, written
from workbench.study.sensitivity import Estimate, MorrisEffects
from workbench.validation.doors import door

MU_STAR, SIGMA = Symbol("mu", mark="*"), Symbol("sigma")
LEAST = 0.02  # of the other axis that an axis spans: below lies rounding
MOST = 1.6  # of the largest number that an axis spans: intervals that are wider are cut
NEAR = 0.03  # of both axes: factors as near to 0 are named in the caption
LETTERS = 200  # of names that the plane has room for


@door
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
        How factors and outputs are written, by their names; as they stand where it does not say.

    Raises
    ------
    ValueError
        If the note is empty.
    """
    single = each(effects)
    names, key = _names(single[0], labels)
    titles = [written(one.names[0], labels) if len(effects.names) > 1 else "" for one in single]
    panels = tuple(_panel(one, unit, names, title) for one, title in zip(single, titles, strict=True))
    near = [_near(panel, names) for panel in panels]
    beyond = any(map(_goes_on, single, panels))
    return Figure(
        name,
        captioned(
            "morris_plane", caption, note, *refusals(effects), *key, *_said_near(near, names), *([BEYOND] * beyond)
        ),
        tuple(_without(panel, places) for panel, places in zip(panels, near, strict=True)),
        numbers=_numbers(name, caption, single, unit),
    )


def _near(panel: Panel, names: tuple[Label, ...]) -> list[int]:
    """The factors that crowd next to 0, two or more, where names would hide one another."""
    points = panel.series[0]
    assert isinstance(points, Points)
    shares = [
        np.asarray(part) / (lim or (0.0, 1.0))[1] for part, lim in ((points.x, panel.xlim), (points.y, panel.ylim))
    ]
    near = np.flatnonzero(np.max(shares, axis=0) < NEAR).tolist()
    return near if 2 <= len(near) < len(names) else []


def _said_near(near: list[list[int]], names: tuple[Label, ...]) -> tuple[Phrase, ...]:
    """A sentence for each panel whose factors next to 0 are named here."""
    said: list[Phrase] = []
    for letter, places in zip("abcdefghijklmnopqrstuvwxyz", near, strict=False):
        if places:
            listed = [part for k, i in enumerate(places) for part in (*([", "] if k else []), *parts(names[i]))]
            said.append(("Next to 0", f" in ({letter})" if len(near) > 1 else "", " lie ", *listed, "."))
    return tuple(said)


def _without(panel: Panel, places: list[int]) -> Panel:
    """A panel whose points at these places have no name."""
    points = panel.series[0]
    assert isinstance(points, Points)
    names = tuple("" if i in places else name for i, name in enumerate(points.names))
    return replace(panel, series=(replace(points, names=names), *panel.series[1:]))


def _goes_on(effects: MorrisEffects, panel: Panel) -> bool:
    """Whether an interval reaches beyond the axes."""
    assert panel.xlim is not None
    assert panel.ylim is not None
    return bool((effects.mu_star.high > panel.xlim[1]).any() or (effects.sigma.high > panel.ylim[1]).any())


def _names(effects: MorrisEffects, labels: Labels) -> tuple[tuple[Label, ...], tuple[Phrase, ...]]:
    """The names beside the points, or their numbers by falling mu*, with a key, where names would cover the plane."""
    names = tuple(written(factor, labels) for factor in effects.factors)
    if sum(map(_letters, names)) <= LETTERS:
        return names, ()
    order = np.argsort(-effects.mu_star.value, kind="stable").tolist()
    numbers = {i: str(place + 1) for place, i in enumerate(order)}
    key = [(*(["; "] if place else []), *parts(names[i]), f" ({numbers[i]})") for place, i in enumerate(order)]
    return tuple(numbers[i] for i in range(len(names))), (
        ("By falling ", MU_STAR, ": ", *(part for pair in key for part in pair)),
    )


def _letters(label: Label) -> int:
    return sum(len(part) if isinstance(part, str) else 3 for part in parts(label))


def _panel(effects: MorrisEffects, unit: str, names: tuple[Label, ...], title: Label) -> Panel:
    x, y = effects.mu_star, effects.sigma
    (xlow, xhigh, right), (ylow, yhigh, top) = _interval(x), _interval(y)
    right, top = max(right, LEAST * top), max(top, LEAST * right)
    line = np.array([0.0, min(right, top)])
    points = Points("", x.value, y.value, names, xlow=xlow, xhigh=xhigh, ylow=ylow, yhigh=yhigh)
    return Panel(
        with_unit(SIGMA, unit),
        (points, Series(Relation(SIGMA, "=", MU_STAR), line, line, "bound")),
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
    reach = min(float(ends.max(initial=largest)), MOST * largest)
    return low, high, 1.06 * reach if reach > 0 else 1.0


def _numbers(name: str, caption: Phrase, single: list[MorrisEffects], unit: str) -> Table:
    rows = []
    for one in single:
        for i in np.argsort(-one.mu_star.value, kind="stable"):
            moments = [(part.value[i], part.half[i]) for part in (one.mu_star, one.sigma, one.mu)]
            rows.append((one.names[0], one.factors[i], *(number(value) for pair in moments for value in pair)))
    heads = [Column(head, unit) for kind in ("mu*", "sigma", "mu") for head in (kind, f"{kind} (half-interval)")]
    return Table(name, caption, (Column("output"), Column("factor"), *heads), tuple(rows))
