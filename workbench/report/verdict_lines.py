"""The answer, the findings and the verdicts of a page as lines, as the command line prints them."""

from __future__ import annotations

from workbench.report.outline import labels, resolve_references
from workbench.report.table_text import plain
from workbench.study.document.document import Document, Finding, Verdict


def verdict_lines(page: Document) -> list[str]:
    """The answer of a page, then its findings and verdicts in their order, each on one line.

    'holds: The loop is stable.'
    """
    places = labels(page)
    boxes: list[Finding | Verdict] = [*page.findings, *(one for one in page.blocks if isinstance(one, Verdict))]
    lines = [f"{box.kind}: {plain(resolve_references(box.statement, places))}" for box in boxes]
    return [" ".join(line.split()) for line in (plain(resolve_references(page.answer, places)), *lines) if line.strip()]
