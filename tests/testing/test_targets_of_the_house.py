"""Targets pass the tests that a target of a user's own must pass."""

import pytest

from tests.support.cases import heavy_but
from workbench.handover.targets import TARGETS, USUAL
from workbench.testing import TargetTests

LIGHT = ("numpy",)  # a browser runs a law in test_laws_of_the_house.py


@pytest.fixture(scope="class", params=heavy_but(USUAL, *LIGHT))
def any_target(request):
    package = "fmpy" if request.param.startswith("fmi") else "llvmlite" if request.param == "browser" else "numpy"
    pytest.importorskip(package)
    request.cls.key = request.param


@pytest.mark.usefixtures("any_target")
class TestTargets(TargetTests):
    def target(self):
        return TARGETS[self.key]
