"""The table of the factors of a sweep, as a report prints it."""

from __future__ import annotations

from workbench.core.validation.signatures import check_arguments
from workbench.engine.factors import Space
from workbench.study.document.phrases_and_tables import Cell, ReportTable, TableColumn, superscript_powers


@check_arguments
def factor_table(space: Space, name: str, caption: str) -> ReportTable:
    """The numbers that each factor moves, its distribution, and where that comes from.

    Examples
    --------
    >>> gain = wb.Factor("gain", ("k",), wb.LogUniform(5.0, 20.0))
    >>> space = wb.uncertainty.Space((gain,), wb.layout(k="1/s"))
    >>> wb.uncertainty.factor_table(space, "drawn", "What is drawn.").rows
    (('gain', 'k', 'log-uniform, 5 to 20', '1/s', 'assumed'),)
    """
    rows: list[tuple[Cell, ...]] = []
    entries = (*space.parameters.entries, *space.states.entries)
    units = [superscript_powers(entry.unit) for entry in entries for _ in range(entry.size)]
    for factor, places in zip(space.factors, space.places, strict=True):
        words = factor.distribution.words()
        paths, spread = ", ".join(factor.paths), f"share of the value: {words}" if factor.share else words
        if (way := factor.direction) is not None:
            moves = zip(factor.paths, way.centres, way.changes, strict=True)
            paths = ", ".join(f"{path} = {centre:.4g} {change:+.2g} z" for path, centre, change in moves if change)
            spread = f"z of a direction: {words}"
        unit = (
            None
            if factor.share or way is not None
            else ", ".join(dict.fromkeys(units[place] for place in places)) or None
        )
        rows.append((factor.name, paths, spread, unit, factor.origin))
    columns = tuple(map(TableColumn, ("factor", "numbers", "distribution", "unit", "origin")))
    return ReportTable(name, caption, columns, tuple(rows))
