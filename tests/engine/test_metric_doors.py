"""Metrics, one's own too, are held to their contract: what does not fit is refused by metric, method and what came."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

from tests.support.equations import decay
from workbench.core import Entry, Layout, rk4
from workbench.engine import simulate
from workbench.engine.metrics import AbstractMetric, late_error, measure, rmse, step_with_metrics, total_variation
from workbench.engine.metrics.contract import Integral
from workbench.engine.metrics.measured_equation import common_grid

ODE = decay()
MEMORY = Layout((Entry("last", np.zeros(1)),))


@dataclass(frozen=True)
class Own(AbstractMetric):
    """The last value of an output; whatever is told beside that is given instead."""

    told: dict[str, Any]

    @property
    def watches(self):
        return self.told.get("watches", ("e",))

    @property
    def grid(self):
        return self.told.get("grid")

    def check(self, ode, horizon):
        return self._of("check", None)

    def integrand(self, t, y):
        return self._of("integrand", y["e"])

    def memory(self, joints):
        return self._of("memory", MEMORY)

    def update(self, k, h, z, y):
        return self._of("update", {"last": y["e"]})

    def value(self, integral, z, horizon):
        return self._of("value", z["last"])

    def _of(self, name, usual):
        given = self.told.get(name, usual)
        if isinstance(given, BaseException):
            raise given
        return given


def measure_own(**told):
    return measure(ODE, [Own("own", "", "the last", told)], until=1.0, h=0.1)


def test_a_metric_of_ones_own_that_keeps_the_contract_is_measured():
    assert measure_own().score("own").value == pytest.approx(np.exp(-3), abs=2e-5)  # RK4 of 0.1 s
    assert measure_own(value=[[2]]).score("own").value.dtype == float
    assert measure_own(integrand=np.array([2.0])).score("own").value.shape == (1,)
    assert measure_own(grid=np.float32(0.5), watches=["e"]).metrics[0].grid == 0.5


VALUE = "`Own.value` must give numbers (B, k), a row for each run, for the metric 'own'; it "
UPDATE = "`Own.update` must give an expression of the same shape for each name in z, for the metric 'own'; it "
ODD = [
    ({"value": None}, VALUE + "gave None."),
    ({"value": "x"}, VALUE + "gave 'x'."),
    ({"value": 1.0}, VALUE + "gave an array of shape () where the integral has (1, 1)."),
    ({"value": np.ones(1)}, VALUE + "gave an array of shape (1,) where the integral has (1, 1)."),
    ({"value": np.ones((2, 1))}, VALUE + "gave an array of shape (2, 1) where the integral has (1, 1)."),
    ({"value": np.ones((1, 0))}, VALUE + "gave an array of shape (1, 0) where the integral has (1, 1)."),
    ({"value": KeyError("last")}, VALUE + "raised KeyError: 'last'."),
    ({"value": ValueError("no\nway\x1b[2J")}, VALUE + "raised ValueError: no way [2J."),
    ({"integrand": "x"}, "`Own.integrand` must give an expression (k, 1) or None, for the metric 'own'; it gave 'x'."),
    ({"integrand": ca.SX(2, 2)}, "it gave one of shape (2, 2)."),
    ({"integrand": np.array([ca.SX(1)], dtype=object)}, "it gave an array of shape (1,) and kind object."),
    ({"integrand": RuntimeError()}, "it raised RuntimeError."),
    ({"memory": {"last": 0.0}}, "`Own.memory` must give a `Layout`, for the metric 'own'; it gave {'last': 0.0}."),
    ({"update": None}, UPDATE + "gave None."),
    ({"update": {}}, UPDATE + "gave {} where z has {'last': (1, 1)}."),
    ({"update": {"last": ca.SX(2, 1)}}, UPDATE + "gave {'last': (2, 1)} where z has {'last': (1, 1)}."),
    ({"update": {"last": "x"}}, UPDATE + "gave 'x' at ['last']."),
    ({"check": False}, "`Own.check` must raise a `ValueError` or give None, for the metric 'own'; it gave False."),
    ({"check": ValueError("Not for this.")}, "Not for this."),
    ({"check": LookupError("Not with this.")}, "Not with this."),
    ({"watches": "e"}, "`Own.watches` must be a tuple of outputs, for the metric 'own'; it gave 'e'"),
    ({"watches": ()}, "`Own.watches` must be a tuple of at least 1 `str`; got none."),
    ({"grid": "x"}, "`Own.grid` must be a positive, finite number of seconds; got 'x'."),
]


@pytest.mark.parametrize(("told", "says"), ODD, ids=[f"{told}" for told, _ in ODD])
def test_what_a_metric_gives_or_raises_beside_its_contract_is_named(told, says):
    kind = LookupError if isinstance(told.get("check"), LookupError) else ValueError
    with pytest.raises(kind, match=re.escape(says)) as refused:
        measure_own(**told)
    assert str(refused.value).isprintable()


def test_what_a_metric_raised_is_the_cause_of_the_refusal():
    error = ZeroDivisionError("division by zero")
    with pytest.raises(ValueError, match="it raised ZeroDivisionError: division by zero") as refused:
        measure_own(value=error)
    assert refused.value.__cause__ is error


G = "`Integral(g=...)` must be a function of (t, y) that gives an expression (k, 1), for the metric 'mine'; it "


@pytest.mark.parametrize(
    ("g", "says"),
    [
        (lambda t, y: None, G + "gave None."),
        (lambda t, y: y["q"], G + "raised KeyError: 'q'."),
        (lambda t: t, G + "raised TypeError: "),
        (lambda t, y: np.array([None]), G + "gave an array of shape (1,) and kind object."),
        (3.0, "`Integral(g=...)` must be a function; got 3.0."),
    ],
)
def test_an_integrand_that_is_none_is_refused(g, says):
    with pytest.raises(ValueError, match=re.escape(says)):
        measure(ODE, [Integral("mine", "m", "", g, lambda integral, horizon: integral)], until=1.0, h=0.1)


def test_an_integrand_of_numbers_is_integrated():
    mine = Integral("mine", "m", "", lambda t, y: np.array([2.0]), lambda integral, horizon: integral)
    assert measure(ODE, [mine], until=1.5, h=0.1).score("mine").value == pytest.approx(3.0, rel=1e-12)  # rounding


def one(**given):
    return measure(ODE, **({"metrics": [rmse()], "until": 1.0, "h": 0.1} | given))


REFUSED = [
    (lambda: one(metrics=[rmse]), "a tuple of `AbstractMetric`; got the function `rmse` itself: call it at [0]."),
    (lambda: one(metrics=[Own]), "got the class `Own` itself: make one with `Own(...)` at [0]."),
    (lambda: one(metrics=rmse()), "must be a tuple of `AbstractMetric`; got an `Integral`"),
    (
        lambda: step_with_metrics(ODE, ["rmse"], 0.1),
        "`step_with_metrics(metrics=...)` must be a tuple of `AbstractMetric`; got 'rmse'",
    ),
    (lambda: one(every=0.0), "`measure(every=...)` must be a positive, finite number of seconds; got 0.0."),
    (lambda: one(progress=len), "`measure(progress=...)` must be a function of the share that is done, from 0 to 1"),
    (lambda: one(until=1.7e308), "must be at most 2^53 times the step 0.1 s"),
    (lambda: one(p=["x"]), "`measure(p=...)` must be numbers, in an array or lists or None; got ['x']."),
    (lambda: one(x0=np.ones((0, 1))), "`measure(x0=...)` needs at least one run; got no rows."),
    (lambda: one(metrics=[late_error(2.0)]), "'late error' needs a horizon beyond the 2 s after which it begins"),
    (lambda: late_error(-1.0), "`late_error(after=...)` must be a finite number of seconds, at least 0; got -1.0."),
    (lambda: replace(total_variation(0.1), sample=0), "`TotalVariation(sample=...)` must be a positive"),
    (lambda: common_grid([total_variation(1e-300)], 1.0), "at most 2^53 of the shortest; got 1e-300 s and 1 s."),
]


@pytest.mark.parametrize(("call", "says"), REFUSED, ids=[says[:40] for _, says in REFUSED])
def test_what_cannot_be_measured_is_refused_at_the_door(call, says):
    with pytest.raises(ValueError, match=re.escape(says)):
        call()


def test_numbers_of_numpy_are_numbers():
    late = late_error(np.longdouble(0.5))
    assert type(late.after) is float
    found = measure(ODE, [late], until=np.float32(1.0), h=np.longdouble(0.5), seed=np.int8(1), tolerance=np.float64(1))
    assert (
        found.score("late error").value == measure(ODE, [late_error(0.5)], until=1.0, h=0.5).score("late error").value
    )


def test_trajectories_have_the_runs_that_they_have():
    runs = simulate(rk4(ODE, 0.1), until=1.0)
    assert len(runs.to_frame(np.int64(0))) == 11
    with pytest.raises(ValueError, match=r"`to_frame\(run=...\)` must be a whole number from 0 to 0; got 1"):
        runs.to_frame(1)
    with pytest.raises(ValueError, match=r"`Trajectories\(x=...\)` must have shape \(1, 11, 1\)"):
        replace(runs, x=np.ones((1, 3, 1)))
