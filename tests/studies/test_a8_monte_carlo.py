"""What a8 prints of its scenario 'paper', held against a plain Monte Carlo that shares no line with the workbench."""

import csv
from pathlib import Path

import numpy as np
import pytest

from tests.support.c_runs import COMPILERS, needs_compiler
from tests.support.plain_monte_carlo import Draws, compiled

REPORT = Path(__file__).parents[2] / "reports" / "a8_fair_comparison"
DRAWS = 320  # twice those of the report, so that its own intervals are the wider ones
STATISTICS = {"mean": np.mean, "median": np.median, "90 % quantile": lambda y: np.quantile(y, 0.9)}


def rows(path):
    with (REPORT / path).open(newline="") as file:
        return list(csv.DictReader(file))


def numbers(law, given):
    """As the page prints them, to seven digits."""
    found = rows(f"tables/numbers_{given}.csv")
    names = {"L_1": "L1", "L_2": "L2"}  # as they are printed, and as they are
    return {names.get(row["number"], row["number"]): float(row["as tuned"]) for row in found if row["law"] == law}


@pytest.fixture(scope="module")
def costs(tmp_path_factory):
    return compiled(COMPILERS[0], tmp_path_factory.mktemp("plain"))


@needs_compiler
@pytest.mark.heavy
@pytest.mark.parametrize(("law", "given"), [("RBF-ASMC", "readings"), ("SMC", "both"), ("AOSMC-RGS", "both")])
def test_a_plain_monte_carlo_agrees_with_mean_median_and_quantile(law, given, costs):
    rng = np.random.default_rng(2026)
    tuned = numbers(law, given)
    found = costs(law, tuned, tuned if given == "both" else None, Draws.of(rng, DRAWS), rng)
    assert np.isfinite(found).all()
    printed = {
        row["statistic"]: [float(row[end]) for end in ("low", "level", "high")]
        for row in rows(f"figures/standings_{given}.csv")
        if (row["scenario"], row["law"]) == ("paper", law)
    }
    for words, statistic in STATISTICS.items():
        low, level, high = printed[words]
        # 0.5 % of the level for trapezoids instead of RK4 in the integrals; draws and noise are others than a8's
        ours, room = statistic(found), 0.005 * level
        assert low - room <= ours <= high + room, f"{law}, {words}: {ours:.4g} beside {low:.4g} to {high:.4g}"
