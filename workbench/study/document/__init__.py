"""A document as data: words, tables, figures and verdicts.

The room knows numbers with their errors and says what stands where; it knows nothing of looks, which are `report`'s.
Read `document` first.

Examples
--------
>>> columns = wb.document.Column("law"), wb.document.Column("error", "rad", "right")
>>> wb.document.Table("errors", "The error of each law.", columns, (("PID", 0.1), ("SMC", 0.05))).name
'errors'
>>> speed = wb.document.Series("speed", np.array([0.0, 1.0]), np.array([0.0, 2.0]))
>>> wb.document.Figure("speed", "The motor.", (wb.document.Panel("omega [rad/s]", (speed,)),)).name
'speed'
"""

from workbench.study.document.document import Block, Equation, Itemize, Page, Paragraph, Section, Verdict
from workbench.study.document.figure import Bars, Figure, Mark, Panel, Points, Series
from workbench.study.document.finding import Finding, Variation
from workbench.study.document.phrases import (
    Cell,
    Code,
    Column,
    Measured,
    Missing,
    Part,
    Phrase,
    Reference,
    Strong,
    Table,
    raised,
)
from workbench.study.document.words import join_names, percent, span

__all__ = [
    "Bars",
    "Block",
    "Cell",
    "Code",
    "Column",
    "Equation",
    "Figure",
    "Finding",
    "Itemize",
    "Mark",
    "Measured",
    "Missing",
    "Page",
    "Panel",
    "Paragraph",
    "Part",
    "Phrase",
    "Points",
    "Reference",
    "Section",
    "Series",
    "Strong",
    "Table",
    "Variation",
    "Verdict",
    "join_names",
    "percent",
    "raised",
    "span",
]
