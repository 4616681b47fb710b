"""Values of three laws in the same draws, and a sample of a comparison."""

import numpy as np

from tests.support.samples import made_sample
from workbench.study.uncertainty import MonteCarlo

RNG = np.random.default_rng(7)
DRAWS = RNG.normal(size=200)  # what all laws of a draw have in common
LAWS = {
    "good": 1.0 + DRAWS + 0.1 * RNG.normal(size=200),
    "twin": 1.0 + DRAWS + 0.1 * RNG.normal(size=200),
    "poor": 1.2 + DRAWS + 0.1 * RNG.normal(size=200),
}


def sample(design=None, drawn=None, **changes):
    given = {
        "name": "s",
        "factors": ("x",),
        "columns": (("error", 0, "rad"),),
        "t": np.ones(1),
        "h": 0.01,
        "seed": 0,
        "fingerprint": "",
        "factor_values": np.arange(30.0)[:, None] if drawn is None else drawn,
        "values": np.zeros((30, 1, 1)),
        "again": np.arange(2),
        "errors": np.zeros((2, 1, 1)),
        "limits": np.ones(2),
        "diverged_at": np.full(30, np.nan),
        "design": design or MonteCarlo(1, 30, seed=9),
    }
    return made_sample(**(given | changes))
