"""The answer and the findings of a page as JSON, for other pages and for a README that quotes them."""

from __future__ import annotations

import json

from workbench.report.outline import labels, resolve_references
from workbench.report.table_text import plain
from workbench.study.document.document import Document, Finding, Phrase


def findings_json(document: Document) -> str:
    """The title, the answer and each finding with its scope and its variations, as plain text in JSON."""
    places = labels(document)

    def text(phrase: Phrase) -> str:
        return " ".join(plain(resolve_references(phrase, places)).split())

    def tree(one: Finding) -> dict[str, object]:
        return {
            "name": one.name,
            "kind": one.kind,
            "statement": text(one.statement),
            "evidence": text(one.evidence),
            "answer": one.answer,
            "change": one.change,
            "statistic": text(one.statistic),
            "sample": text(one.sample),
            "given": text(one.information),
            "chosen": text(one.assumptions),
            "fitted": text(one.fitted_numbers),
            "untried": text(one.limitations),
            "variations": [{"words": v.words, "answer": v.answer, "detail": v.detail} for v in one.variations],
            "cites": list(one.cites),
        }

    page = {
        "title": text(document.title),
        "answer": text(document.answer),
        "findings": [tree(one) for one in document.findings],
    }
    return json.dumps(page, ensure_ascii=False, indent=1) + "\n"
