"""The benchmarks of designs: the batch as it is printed, the numbers of a8, and designs that meet what they are for."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from studies.d1_benchmarks.arm_designs import DESIGNS, TUNED, crossovers, entrant, law_crossovers, matching_design
from studies.d1_benchmarks.batch import COUNT_IN_PRINT, FORMULAS, batch
from studies.d1_benchmarks.batch_designs import LIMIT, designs
from studies.d1_benchmarks.robust_problems import COMPLEIB, PUBLISHED, Bounds, figure_of
from studies.d1_benchmarks.robust_section import Score, agrees
from studies.paper.scenarios import HELD_OUT

ROOT = Path(__file__).parents[2]
EXAM = ROOT.parent / "shared" / "exams" / "design" / "batch.json"  # where an exam is kept beside the checkout
PROCESSES = {one.name: one for one in batch()}


def test_the_batch_has_nine_families_and_one_process_less_than_the_literature_counts():
    assert {one.family for one in batch()} == set(FORMULAS)
    assert len(batch()) == len(PROCESSES) == COUNT_IN_PRINT - 1


@pytest.mark.skipif(not EXAM.exists(), reason="the list of the exam is kept elsewhere")
def test_the_batch_is_that_of_an_independent_list():
    for one, other in zip(batch(), json.loads(EXAM.read_text("utf-8")), strict=True):
        assert (one.family, one.delay) == (other["family"], other["delay"])
        np.testing.assert_allclose(one.num, other["num"], rtol=1e-15)
        np.testing.assert_allclose(one.den, other["den"], rtol=1e-14)  # products in another order


@pytest.mark.parametrize(
    "name",
    [
        "P1, T = 1",
        pytest.param("P9, T = 0.5", marks=pytest.mark.heavy),
        pytest.param("P6, L1 = 0.5", marks=pytest.mark.heavy),
    ],
)
def test_optimum_laws_keep_the_limit_and_a_derivative_does_not_lower_the_integral_gain(name):
    found = designs(PROCESSES[name])
    for law in (found.PI, found.PID):
        assert not law.reason
        assert max(law.Ms, law.Mt) <= LIMIT * (1 + 1e-9)
        assert law.Ms_width < 1e-9
    assert found.PID.ki >= found.PI.ki
    assert found.simc.ki > 0


def test_the_numbers_of_the_six_laws_are_those_that_a8_prints():
    with (ROOT / "reports" / "a8_fair_comparison" / "tables" / "numbers_readings.csv").open(encoding="utf-8") as table:
        printed: dict[str, list[float]] = {}
        for row in csv.DictReader(table):
            printed.setdefault(row["law"], []).append(float(row["as tuned"]))
    for law, numbers in TUNED.items():
        assert list(numbers) == printed[law]
        assert len(entrant(law).tuned_numbers) == len(numbers)


@pytest.mark.parametrize("kind", DESIGNS)
def test_a_linear_law_has_the_crossovers_of_the_law_that_it_stands_beside(kind):
    found = crossovers(matching_design(kind, "SMC").loop(HELD_OUT[0].at_rest))
    np.testing.assert_allclose(found.omega, law_crossovers("SMC").omega, rtol=1e-3)  # the tolerance of the match


@pytest.mark.parametrize(
    "key",
    [
        "satellite norm",
        "satellite mu",
        "column stability",
        "benner",
        "tank minimum phase",
        "tank nonminimum phase",
        "masses qft peak",
        "masses qft softest",
        "masses hinf softest",
        "masses hinf stiffest",
        "masses hinf settling",
        "masses instability",
    ],
)
def test_a_published_figure_is_met(key):
    (problem,) = (one for one in PUBLISHED if one.key == key)
    bounds = figure_of(key)
    assert bounds.low <= bounds.high
    assert agrees(problem, bounds)


def test_a_requirement_is_kept_by_both_bounds_or_missed():
    most = next(one for one in PUBLISHED if one.key == "masses qft peak")
    least = next(one for one in PUBLISHED if one.key == "masses hinf stiffest")
    assert agrees(most, Bounds(2.2, 2.25))
    assert not agrees(most, Bounds(2.2, 2.26))
    assert agrees(least, Bounds(2.0, 2.1))
    assert not agrees(least, Bounds(1.99, 2.1))


def test_figures_that_are_quoted_from_memory_are_counted_apart():
    score = Score.of([(True, True), (True, False), (False, True)])
    assert (score.read, score.from_memory) == ((1, 2), (1, 1))


def test_the_structured_problems_were_chosen_with_a_source():
    for problem in COMPLEIB.values():
        assert problem["source"]
        assert isinstance(problem["target"], float)
