"""The mark of a test that needs a browser."""

import pytest

from studies.performance.chromium import program

needs_chromium = pytest.mark.skipif(program() is None, reason="this machine has no Chromium")
