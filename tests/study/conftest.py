"""A study with a sweep, as a file in the folder of a test."""

import pytest

from tests.support.swept_studies import SWEPT


@pytest.fixture
def swept(tmp_path):
    """A study with one sweep of five chunks."""
    (tmp_path / "swept.py").write_text(SWEPT, encoding="utf-8")
    return "swept.py"
