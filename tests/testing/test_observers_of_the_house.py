"""Each public observer passes the tests that an observer of a user's own must pass."""

import pytest

import workbench as wb
from tests.support.cases import heavy_but
from tests.support.house_blocks import LONG_TESTS, example_of, public_classes, without
from workbench.arms.observers import MomentumObserver, StateAndDisturbanceObserver
from workbench.blocks.loop import AbstractObserver
from workbench.testing import ObserverTests

OBSERVERS = public_classes(("workbench.blocks.observers", "workbench.arms.observers"), AbstractObserver)
ARM = wb.paper_arm()
OF_ARMS = wb.Manipulator(ARM, q=[0.5, 0.0]), wb.DCMotor()
LAGS = ("DirtyDerivative", "ExtendedStateObserver", "VelocityFilter")  # which follow a velocity with a lag
LARGE = {"blocks.UnscentedKalmanFilter"}
LIGHT = "blocks.ExtendedKalmanFilter"


class AbstractObserversOfTheHouse(ObserverTests):
    def observer(self):
        return self.example

    def plant(self):
        if isinstance(self.example, wb.FullState):  # which has the states of its example, and no model
            return wb.CartPole(phi=0.1)
        if isinstance(self.example, wb.OffsetFreeObserver):  # which has the matrices of its example's plant
            return wb.DCMotor()
        if not self.is_of_arms:
            return ObserverTests.plant(self)
        return next(plant for plant in OF_ARMS if all(name in plant.outputs for name in self.example.reads.names))


def choose(request):
    """Give a class of tests the observer that is named by a parameter, and its tolerance."""
    tests, cls = request.cls, OBSERVERS[request.param]
    tests.is_of_arms = request.param.startswith("arms.")
    tests.tolerance = 0.1 if cls.__name__ in LAGS else ObserverTests.tolerance
    tests.example = with_disturbance() if cls is StateAndDisturbanceObserver else example_of(cls)


def with_disturbance():
    """An observer of the state and one of the disturbance, which no example of one docstring makes."""
    return StateAndDisturbanceObserver(example_of(OBSERVERS["arms.ArmFullState"]), MomentumObserver(ARM, 20.0))


@pytest.fixture(scope="class", params=heavy_but(OBSERVERS, *sorted(set(OBSERVERS) - LARGE)))
def any_observer(request):
    choose(request)


@pytest.mark.usefixtures("any_observer")
@without(*LONG_TESTS)
class TestEstimates(AbstractObserversOfTheHouse):
    """Ports, units, numbers, and estimates from right and wrong starts."""


@pytest.fixture(scope="class", params=heavy_but(OBSERVERS, LIGHT))
def light_observer(request):
    choose(request)


@pytest.mark.usefixtures("light_observer")
@without(*sorted(name for name in dir(TestEstimates) if name.startswith("test_") and name not in LONG_TESTS))
class TestRunsAndForms(AbstractObserversOfTheHouse):
    """Bits of runs, and the forms for other machines."""
