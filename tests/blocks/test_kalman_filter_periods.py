"""A Kalman filter at its own period and in its own steps, and what does not fit it."""

from itertools import pairwise

import numpy as np
import pytest

from tests.support.cases import heavy_but
from tests.support.filter_runs import run
from tests.support.observed import Constant, Oscillator, Pendulum
from workbench.blocks.loop import AbstractPlant, ClosedLoop
from workbench.blocks.observers import ExtendedKalmanFilter, UnscentedKalmanFilter
from workbench.core import block, initial, layout
from workbench.core.block import Scalar
from workbench.engine import simulate

BOTH = pytest.mark.parametrize("kind", heavy_but([ExtendedKalmanFilter, UnscentedKalmanFilter], ExtendedKalmanFilter))
Q, P = np.diag([0.1, 0.2]), np.array([[1.0, 0.3], [0.3, 0.5]])
h = 0.05


@BOTH
def test_in_a_faster_computer_it_runs_at_its_own_period(kind):
    """With a command that never changes the plant does the same, and so does the filter."""
    plant, observer = Oscillator(), kind(Oscillator(p=0.0), Q, [[0.01]], P, h, ("p",), {"p": 3}, substeps=2)
    loop = ClosedLoop(plant, observer, Constant(0.5))
    slow, fast = (simulate(loop.digital(h / n).step(4 // n), until=2.0, every=h)["observer.p_hat"][0] for n in (1, 2))
    # the fast computer moves the memory at t_k on to t_(k+1) as its first step begins, as the slow one does
    np.testing.assert_allclose(fast, slow, rtol=0, atol=1e-12)


def test_halving_its_steps_makes_the_error_of_a_filter_sixteen_times_smaller():
    ends = [
        run(Pendulum(), ExtendedKalmanFilter(Pendulum(phi=0.1), Q, [[0.1]], P, h, ("phi",), substeps=n))["observer.P"]
        for n in (1, 2, 4)
    ]
    first, second = (np.abs(a - b)[0, -1].max() for a, b in pairwise(ends))
    assert 12 < first / second < 20


@block
class Ticking(AbstractPlant):
    """p+ = p / 2, in discrete time."""

    p: Scalar = initial(1.0, unit="m")
    inputs = layout()
    outputs = layout(p="m")
    period = 0.1

    def update(self, t, x, u):
        return {"p": x.p / 2}


MODEL = Oscillator()


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"model": Ticking()}, ValueError, "in continuous time"),
        ({"outputs": ("q",)}, LookupError, "no 'q' among the 2 outputs of `Oscillator`"),
        ({"every": {"v": 2}}, LookupError, "no 'v' among the 1 outputs that"),
        ({"every": {"p": 0}}, ValueError, "positive whole number of instants for 'p'"),
        ({"Q": np.eye(3)}, ValueError, r"must have shape \(2, 2\), a row for each of p, v"),
        ({"R": [[0.0]]}, ValueError, "must be positive definite"),
        ({"P": [[1.0, 2.0], [0.0, 1.0]]}, ValueError, "must be symmetric"),
        ({"P": [[1.0, 2.0], [2.0, 1.0]]}, ValueError, "must be positive semidefinite"),
        ({"period": 0.0}, ValueError, "positive, finite number of seconds"),
        ({"substeps": 0}, ValueError, "whole number from 1 to 1000"),
    ],
)
@BOTH
def test_what_does_not_fit_is_refused(kind, changes, error, words):
    valid = {"model": MODEL, "Q": Q, "R": [[0.1]], "P": P, "period": h, "outputs": ("p",)}
    kind(**valid)
    with pytest.raises(error, match=words):
        kind(**valid | changes)
