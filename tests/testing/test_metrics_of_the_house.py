"""Each metric of the catalogue passes the tests that a metric of a user's own must pass."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.cases import heavy_but
from tests.support.metric_programs import HORIZON, STEP, catalogue, pair
from workbench.core import Layout
from workbench.testing import MetricTests

USUAL = {"a": [-6.0, -8.0], "b": [1.8, -1.6], "level": [0.3, -0.2], "plant.q": [1.0, -1.0]}


def settling():
    """Two states that come to rest at the numbers that they are to reach."""
    ode = pair()

    def with_usual(layout):
        return Layout(tuple(replace(e, default=np.array(USUAL[e.name])) for e in layout.entries))

    return replace(ode, states=with_usual(ode.states), parameters=with_usual(ode.parameters))


NAMES = [metric.name for metric in catalogue()]
LIGHT = "RMSE", "TV of tau_applied", "settling time"  # an integral, a sum on a grid, and a time


@pytest.fixture(scope="class", params=heavy_but(NAMES, *LIGHT))
def any_metric(request):
    request.cls.place = NAMES.index(request.param)


@pytest.mark.usefixtures("any_metric")
class TestMetrics(MetricTests):
    until, h = HORIZON, STEP

    def metric(self):
        return catalogue()[self.place]

    def equation(self):
        return settling()
