"""Logs and models that no filter takes, each refused in one sentence."""

import numpy as np
import pytest

from workbench.blocks.loop import open_loop
from workbench.blocks.plants import DCMotor
from workbench.identification.datasets import Dataset
from workbench.identification.filters import (
    ParameterWalk,
    SigmaPoints,
    StochasticModel,
    extended_kalman_filter,
    unscented_kalman_filter,
)


def two_runs():
    t = np.arange(3.0)
    one, two = (Dataset.of(t, {"v": t, "omega": t}, name=name) for name in ("a", "b"))
    return one.with_experiments(two)


PLAIN = {
    "log": Dataset.of(np.arange(3.0), {"v": np.ones(3), "omega": np.ones(3)}),
    "equations": open_loop(DCMotor()),
    "Q": np.eye(2),
    "R": [[1.0]],
    "x0": [0.0, 0.0],
    "P0": np.eye(2),
}


def filter_plain(solve=extended_kalman_filter, **change):
    """A filter of the plain log, with some arguments of the model or of the filter changed."""
    arguments = PLAIN | change
    model = {name: arguments.pop(name) for name in ("equations", "Q", "R", "x0", "P0", "walks") if name in arguments}
    return solve(model=StochasticModel(**model), **arguments)


@pytest.mark.parametrize(
    ("change", "error", "sentence"),
    [
        (
            {"log": two_runs()},
            ValueError,
            "must have one experiment, as each begins with its own",
        ),
        ({"log": Dataset.of([0.0, 1.0], {"v": [1.0, np.nan], "omega": [1, 1]})}, ValueError, "'v' has none at t = 1 s"),
        ({"log": Dataset.of([0.0, 0.0], {"v": [1, 1], "omega": [1, 1]})}, ValueError, "must be times that increase"),
        ({"log": Dataset.of([0.0], {"v": [1], "omega": [1]}, {"omega": "rpm"})}, ValueError, r"'omega' is in \[rpm\]"),
        (
            {"log": Dataset.of([0.0], {"v": [1], "speed": [1]})},
            LookupError,
            "must have at least one output of",
        ),
        ({"log": Dataset.of([0.0], {"omega": [1]})}, LookupError, "There is no 'v' among the 1 signals of this log"),
        ({"signals": {"speed": "omega"}}, LookupError, "There is no 'speed' among the 2 entries"),
        ({"signals": {"omega": "speed"}}, LookupError, "There is no 'speed' among the .* outputs of the model"),
        ({"x0": None}, ValueError, "x0=.*must be given"),
        ({"Q": np.eye(3)}, ValueError, r"Q=.*must have shape \(2, 2\); got \(3, 3\)"),
        ({"R": np.eye(2)}, ValueError, r"R=.*must have shape \(1, 1\); got \(2, 2\)"),
        ({"hold": "cubic"}, ValueError, "hold=.*is one of 'hold', 'linear'"),
        ({"walks": {"v": ParameterWalk(1.0)}}, ValueError, "'v' is an input, which the log gives"),
        ({"walks": {"JJ": ParameterWalk(1.0)}}, LookupError, "There is no 'JJ'"),
    ],
)
def test_logs_that_do_not_fit_the_model_are_refused_in_one_sentence(change, error, sentence):
    with pytest.raises(error, match=sentence):
        filter_plain(**change)
    assert filter_plain().x.shape == (3, 2)


def test_weights_by_which_a_covariance_could_lose_its_definiteness_are_refused():
    with pytest.raises(ValueError, match="central weight 2 - n / c - alpha.2 . beta >= 0, without which P may lose"):
        filter_plain(solve=unscented_kalman_filter, weights=SigmaPoints(alpha=1e-3, beta=2.0))
