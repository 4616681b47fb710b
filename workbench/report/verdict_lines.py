"""The verdicts of a page as lines, as the command line prints them."""

from __future__ import annotations

from workbench.report.table_text import plain
from workbench.study.document.document import Document, Verdict


def verdict_lines(page: Document) -> list[str]:
    """The verdicts of a page in their order, each on one line: 'holds: The loop is stable.'"""
    blocks = (block for section in page.sections for block in section.blocks)
    lines = (f"{block.kind}: {plain(block.statement)}" for block in blocks if isinstance(block, Verdict))
    return [" ".join(line.split()) for line in lines]
