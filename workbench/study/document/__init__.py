"""A document as data: words, tables, figures and verdicts.

This package holds numbers with their errors, and the order of blocks on a page; the package `report` decides how they
look. Read `document` first.

Examples
--------
>>> columns = wb.document.TableColumn("law"), wb.document.TableColumn("error", "rad", "right")
>>> wb.document.ReportTable("errors", "The error of each law.", columns, (("PID", 0.1), ("SMC", 0.05))).name
'errors'
>>> speed = wb.document.Series("speed", np.array([0.0, 1.0]), np.array([0.0, 2.0]))
>>> wb.document.Figure("speed", "The motor.", (wb.document.Panel("omega [rad/s]", (speed,)),)).name
'speed'
"""

from workbench.study.document.document import Block, Equation, Itemize, Page, Paragraph, Section, Verdict
from workbench.study.document.figure import Bars, Figure, Mark, Panel, Points, Series
from workbench.study.document.finding import Finding, Variation
from workbench.study.document.phrases_and_tables import (
    Cell,
    Code,
    CrossReference,
    MissingCell,
    Part,
    Phrase,
    ReportTable,
    Strong,
    TableColumn,
    ValueWithError,
    superscript_powers,
)
from workbench.study.document.words import join_names, percent, span

__all__ = [
    "Bars",
    "Block",
    "Cell",
    "Code",
    "TableColumn",
    "Equation",
    "Figure",
    "Finding",
    "Itemize",
    "Mark",
    "ValueWithError",
    "MissingCell",
    "Page",
    "Panel",
    "Paragraph",
    "Part",
    "Phrase",
    "Points",
    "CrossReference",
    "Section",
    "Series",
    "Strong",
    "ReportTable",
    "Variation",
    "Verdict",
    "join_names",
    "percent",
    "superscript_powers",
    "span",
]
