"""Tornado: how far each factor by itself moves an output from its base, the widest swing first."""

from __future__ import annotations

import numpy as np

from workbench.study.document.cells import Column, Phrase, Table
from workbench.study.document.curves import STYLES
from workbench.study.document.document import Bars, Figure, Panel, Series
from workbench.study.pictures.parts import Labels, captioned, each, number, refusals, with_unit, written
from workbench.study.uncertainty.tornado import Tornado
from workbench.validation.signatures import door

LEVEL = 0.36  # of a row: the thickness of the bar of one level


@door
def tornado_figure(
    name: str, caption: Phrase, tornado: Tornado, note: Phrase, unit: str = "", *, labels: Labels = None
) -> Figure:
    """Two bars a factor from the output of the base: its lowest level above, its highest below.

    So both are seen where they lie on the same side of the base. Levels between are marked. Several outputs have a
    panel each, with an order of its own.

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
    single = each(tornado)
    return Figure(
        name,
        captioned("tornado_figure", caption, note, *refusals(tornado)),
        tuple(_panel(one, unit, labels) for one in single),
        numbers=_numbers(name, caption, single, unit),
    )


def _panel(tornado: Tornado, unit: str, labels: Labels) -> Panel:
    order, base = tornado.order, float(tornado.base)
    lowest, highest = int(np.argmin(tornado.levels)), int(np.argmax(tornado.levels))
    rows, moved = np.arange(len(order), dtype=float), tornado.moved[order]
    marks: list[Bars | Series] = []
    for k, level in enumerate(np.argsort(tornado.levels).tolist()):
        label, ends = _level(tornado.levels[level]), moved[:, level]
        if level == highest:
            marks.append(Bars(label, rows + LEVEL / 2, ends, base, shade=1.0, thick=LEVEL))
        elif level == lowest:
            marks.append(Bars(label, rows - LEVEL / 2, ends, base, shade=0.25, thick=LEVEL))
        else:
            marks.append(Series(label, ends, rows, 1 + k % (STYLES - 1), look="marks"))
    return Panel(
        "",
        tuple(marks),
        xlabel=with_unit(written(tornado.names[0], labels), unit),
        vlines=(base,),
        ynames=tuple(written(tornado.factors[i], labels) for i in order),
    )


def _level(level: float) -> str:
    ends = {0.0: "at the low end of its range", 1.0: "at the high end of its range"}
    return ends.get(float(level), f"at its {100 * level:g} % quantile")


def _numbers(name: str, caption: Phrase, tornados: list[Tornado], unit: str) -> Table:
    rows = [
        (one.names[0], one.factors[i], number(float(one.base)), *map(number, one.moved[i]), number(one.swing[i]))
        for one in tornados
        for i in one.order
    ]
    levels = [Column(_level(level), unit) for level in tornados[0].levels]
    head = (Column("output"), Column("factor"), Column("base", unit), *levels, Column("swing", unit))
    return Table(name, caption, head, tuple(rows))
