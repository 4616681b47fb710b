"""The programs that run JavaScript in tests, and the marks of tests that need them."""

import shutil

import pytest

from studies.performance.chromium import program

NODE, CHROMIUM = shutil.which("node"), program()
needs_node = pytest.mark.skipif(NODE is None, reason="this machine has no Node")
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="this machine has no Chromium")
