"""Each public law of the workbench passes the tests that a law of a user's own must pass."""

from dataclasses import fields, replace
from functools import cache

import pytest

from tests.support.cases import heavy_but
from tests.support.house_blocks import LONG_TESTS, example_of, public_classes, without
from workbench.arms.laws import Sdre
from workbench.arms.mechanics import Link, PlanarArm
from workbench.blocks.laws import Cascade
from workbench.blocks.loop import AbstractController
from workbench.testing import LawTests

LAWS = public_classes(("workbench.blocks.laws", "workbench.arms.laws"), AbstractController)
ROD = PlanarArm((Link(2.0, 0.7, 0.3, 0.1, 0.4),), 9.81, "right")
# Smaller than in its docstring: for two joints its Riccati equation has some thirty thousand operations.
SMALLER = {"arms.Sdre": Sdre(ROD, Qp=[[1.0]], Qd=[[1.0]], R=[[1.0]])}
PERIOD = 0.01  # s
LIGHT = next(name for name, cls in LAWS.items() if cls is Cascade)  # two laws, each with a memory


CHOICES = [  # of the options of each law, but the usual ones
    f"{name} {field.name}={choice}"
    for name, cls in LAWS.items()
    for field in fields(cls)
    for choice in field.metadata.get("option", ())
    if choice != field.default
]
# Of choices that take other numbers than the usual one.
NUMBERS = {
    "back-calculation": {"Tt": 0.1},
    "frozen": {"Q": None, "R": None},
    "algebraic": {"P": None},
    **{key: {"safe_command": [0.0]} for key in ("safe_command", "last_good", "cold")},
}


@pytest.fixture(scope="class", params=heavy_but([*LAWS, *CHOICES], *LAWS))
def any_law(request):
    request.cls.example = chosen_law(*request.param.split(" "))


@cache
def example(name):
    """The law of the example in its docstring, or a smaller one."""
    return SMALLER.get(name) or example_of(LAWS[name])


def chosen_law(name, *choice):
    """The law of an example, with another choice of an option."""
    law = example(name)
    for field, value in (one.split("=") for one in choice):
        law = replace(law, **{field: value}, **NUMBERS.get(value, {}))
        law = law.run_every(PERIOD) if value == "implicit" else law  # which is solved over a period
    return law


@pytest.mark.usefixtures("any_law")
@without(*LONG_TESTS)
class TestEquations(LawTests):
    def law(self):
        return self.example


@pytest.fixture(scope="class", params=heavy_but(LAWS, LIGHT))
def light_law(request):
    request.cls.example = example(request.param)


@pytest.mark.usefixtures("light_law")
@without(*sorted(name for name in dir(TestEquations) if name.startswith("test_") and name not in LONG_TESTS))
class TestRunsAndForms(LawTests):
    def law(self):
        return self.example
