"""Each test of an observer, a metric and a target can fail: one with a mistake is caught by the test that is for it."""

from dataclasses import dataclass, replace
from itertools import count
from unittest import SkipTest

import numpy as np
import pytest

import workbench as wb
from tests.support.kits import assert_caught, kit_of
from tests.support.motor_blocks import Motor
from workbench.engine.metrics import AbstractMetric
from workbench.handover.targets import TARGETS
from workbench.testing import MetricTests, ObserverTests, TargetTests, metric_tests

CALLS = count()


def observer(gain=((20.0,), (1.0,)), **own):
    """The tests of an observer of a motor with other attributes."""
    cls = own.pop("cls", None)
    made = (lambda: wb.LinearObserver(Motor(), gain)) if cls is None else cls
    return kit_of(ObserverTests, "observer", made, plant=lambda self: Motor(), **own)


@wb.block
class Doubled(wb.Observer):
    """A reading, twice as large as it is."""

    reads = gives = wb.layout(omega="rad/s")

    def estimate(self, t, z, y):
        return {"omega": 2 * y.omega}


@wb.block
class Oracle(wb.Observer):
    """An observer that says it uses a truth and reads none."""

    reads = gives = wb.layout(omega="rad/s")
    uses_truth = True

    def estimate(self, t, z, y):
        return {"omega": y.omega}


class Shy(Oracle):
    """An observer that hides its period from the loop."""

    @property
    def period(self):
        return 0.01 if next(CALLS) % 4 == 0 else None


OBSERVERS = [
    (observer(cls=Doubled), "test_it_follows_its_plant", "`Doubled` must estimate 'omega' to 0.01"),
    (observer(gain=((-500.0,), (0.0,)), until=0.3), "test_it_forgets", "`LinearObserver` must forget a wrong start"),
    (observer(cls=Oracle), "test_it_reads_no_truth", "take `uses_truth` out"),
    (kit_of(ObserverTests, "observer", Doubled), "test_it_follows", "must have a plant to observe; it has no plant"),
    (observer(cls=Motor), "test_its_ports", "must return a `wb.Observer`"),
]


@pytest.mark.parametrize(("tests", "start", "says"), OBSERVERS)
def test_a_bad_observer_is_caught(tests, start, says):
    assert_caught(tests, start, says)


@dataclass(frozen=True)
class Own(AbstractMetric):
    """A metric with a mistake."""

    mistake: str = ""

    @property
    def watches(self):
        return ("omega",)

    def integrand(self, t, y):
        return y["omega"] ** 2

    def memory(self, size):
        return wb.layout(steps=("1", [0.0]))

    def update(self, k, h, z, y):
        return {"steps": z["steps"] + 1}

    def value(self, integral, z, horizon):
        if self.mistake == "mean":
            return np.tile(integral.mean(axis=0), (len(integral), 1))
        if self.mistake == "steps":
            return z["steps"]
        if self.mistake == "infinite":
            return integral / 0.0
        return integral + next(CALLS) if self.mistake == "state" else integral


def metric(mistake=""):
    return kit_of(MetricTests, "metric", lambda: Own("own", "rad^2/s", "own", mistake=mistake))


METRICS = [
    ("state", "test_it_is_the_same", "its values differ when it is measured again"),
    ("mean", "test_its_value_has_the_same_bits", "its values differ in chunks"),
    ("mean", "test_a_run_that_diverges", "differ beside a run that diverges"),
    ("steps", "test_its_error_bounds", "must have an error that bounds the change"),
    ("steps", "test_its_error_shrinks", "must have an error that shrinks with the step"),
    ("infinite", "test_it_has_a_finite_value", "must have a finite value; that of a loop that settles is inf"),
]


@pytest.mark.parametrize(("mistake", "start", "says"), METRICS)
@pytest.mark.filterwarnings("ignore:divide by zero")
def test_a_bad_metric_is_caught(mistake, start, says):
    assert_caught(metric(mistake), start, says)


def test_a_measurement_that_has_a_value_for_a_lost_run_is_caught(monkeypatch):
    true = metric_tests.measure

    def measure(*given, **more):
        found = true(*given, **more)
        return replace(found, values=np.nan_to_num(found.values))

    monkeypatch.setattr(metric_tests, "measure", measure)
    assert_caught(metric(), "test_a_run_that_diverges", "must be NaN for a run that diverges")


def target(**own):
    """The tests of a target that answers as a function does."""
    return kit_of(TargetTests, "target", lambda: type("Wrong", (type(TARGETS["numpy"]),), own)("wrong"))


def answers_with(change):
    plain = type(TARGETS["numpy"]).answers
    return lambda self, *given: replace(found := plain(self, *given), u=change(found.u))


WRONG = [
    (target(answers=answers_with(np.negative)), "test_a_pid_law", "`wrong` must give the bits of the loop; at instant"),
    (target(answers=answers_with(lambda u: np.nextafter(u, 0))), "test_a_law_of_all", "must give the bits of the loop"),
    (target(answers=answers_with(lambda u: u[:, 0])), "test_it_runs_a_recording", "must give commands of shape"),
    (target(figures=lambda self, *given: None), "test_it_tells_its_cost", "must give `TargetCost`; it gave None"),
    (target(programs=("cobol",)), "test_the_programs", "'cobol' is another one"),
]


@pytest.mark.parametrize(("tests", "start", "says"), WRONG)
def test_a_bad_target_is_caught(tests, start, says):
    assert_caught(tests, start, says)


def test_a_target_whose_programs_are_not_here_is_skipped_with_what_to_install(monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(SkipTest, match="apt-get install"):
        target(programs=("gcc",)).test_a_pid_law_has_the_bits_of_its_loop()
