"""A document as data: words, tables, figures and verdicts.

The room knows numbers with their errors and says what stands where; it knows nothing of looks, which are `report`'s.
Read `document` first.
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
    "raised",
]
