"""The pages of `reports/` that are kept: a checkout has them, and a source archive has no more than their numbers."""

from pathlib import Path

import pytest

REPORTS = Path(__file__).parents[2] / "reports"
PAGES = sorted(REPORTS.glob("*/index.html"))
PDFS = sorted(REPORTS.glob("*/report.pdf"))
needs_pages = pytest.mark.skipif(not PAGES, reason="the pages of reports/ are in a checkout, not in a source archive")
NONE = [pytest.param(None, marks=needs_pages, id="none")]  # in the place of pages, so that a test is skipped by name
