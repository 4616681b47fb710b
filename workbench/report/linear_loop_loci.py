"""Root loci of a `LinearLoop`: its poles over the values of any parameter by its path, each at its own rest."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.core.validation.refusals import Array, known_name, numbers, refusal
from workbench.design.linear_loop import LinearLoop
from workbench.report.loop_pictures import root_locus_figure
from workbench.study.document.figure import Figure
from workbench.study.document.frequency_curves import number

WAYS = 'the path of a parameter and its `values`, or a mapping from the path to them: {"plant.m": values}'


def locus_figure(
    name: str, linear: LinearLoop, over: object, values: Array | None, marked_values: tuple[float, ...], grid: bool
) -> Figure:
    """The poles of the closed loop over the values of one of its parameters, with a dot at its own value.

    Raises
    ------
    ValueError
        If it is not one parameter with its values, these neither rise nor fall, or the loop has a delay.
    LookupError
        If there is no such parameter.
    """
    path, at = _parameter(over, values)
    layouts = [layout for layout in (linear.parameters, linear.states) if path in layout or path in layout.labels]
    if not layouts:
        known_name(path, [*linear.parameters.names, *linear.states.names], "parameters and states of this loop")
    places = layouts[0].indices(path)
    if len(places) != 1:
        labels = ", ".join(layouts[0].labels[i] for i in places[:9])
        raise LookupError(f"`root_locus(over=...)` takes one number; '{path}' has {len(places)}: say one of {labels}.")
    linear.system("closed")  # refuses a delay
    label = layouts[0].labels[places[0]]
    rows = linear.rows({label: at})
    poles = np.where(rows.flagged_rows[:, np.newaxis], np.nan, rows.poles)
    own = float((linear.p0 if layouts[0] is linear.parameters else linear.x0)[places[0]])
    dots = [*marked_values, *([own] if at.min() <= own <= at.max() and own not in marked_values else [])]
    remarks = []
    if rows.reasons:
        first, reason = next(iter(rows.reasons.items()))
        count = len(rows.reasons)
        words = "1 value has" if count == 1 else f"{count} values have"
        remarks.append(f"{words} no poles; of the first, {number(float(at[first]))}: {reason}")
    units = dict(pair for entry in layouts[0].entries for pair in zip(entry.labels(), entry.units, strict=True))
    period = linear.period and linear.period * linear.models.closed_model.count
    caption = " ".join(remarks)
    return root_locus_figure(
        name, caption, path, at, poles, units[label], tuple(dots), np.zeros(0, complex), period, grid=grid
    )


def _parameter(over: object, values: Array | None) -> tuple[str, Array]:
    """The path of the parameter, and its values (N,)."""
    if isinstance(over, Mapping) and values is None and len(over) == 1:
        ((path, found),) = over.items()
    elif isinstance(over, str) and values is not None:
        path, found = over, values
    else:
        raise refusal("root_locus(over=...)", WAYS, over)
    at = numbers("root_locus(values=...)", found, 1)
    if len(at) < 2 or not np.isfinite(at).all() or not ((np.diff(at) > 0).all() or (np.diff(at) < 0).all()):
        raise refusal("root_locus(values=...)", "two or more finite values in rising or falling order", found)
    return str(path), at
