"""Targets pass the tests that a target of a user's own must pass."""

import pytest

from tests.support.cases import heavy_but
from workbench.handover.targets import TARGETS, USUAL
from workbench.testing import TargetTests

LIGHT = ("numpy",)  # a browser runs a law in test_laws_of_the_house.py
ALIKE = {f"{compiler}-O{level}" for compiler in ("gcc", "clang") for level in (0, 1, 3)}  # tests/handover runs these


@pytest.fixture(scope="class", params=heavy_but([name for name in USUAL if name not in ALIKE], *LIGHT))
def any_target(request):
    package = "fmpy" if request.param.startswith("fmi") else "llvmlite" if request.param == "browser" else "numpy"
    pytest.importorskip(package)
    request.cls.key = request.param


@pytest.mark.usefixtures("any_target")
class TestTargets(TargetTests):
    def target(self):
        return TARGETS[self.key]
