"""The counts of a predictive law in b4: what is printed without the other solvers, and one law counted here."""

import numpy as np
import pytest

from studies.b4_handover import filter_law, predictive_laws, predictive_tables
from studies.b4_handover.filter_law import FilterCount, filter_count
from studies.b4_handover.osqp_code import osqp_lacks, osqp_run
from studies.b4_handover.predictive_laws import PredictiveCount, SolverCount, predictive_count, predictive_keys
from studies.b4_handover.predictive_problems import IDLE, PUSHED, problems
from studies.b4_handover.predictive_tables import error_in_words, in_thousands
from studies.b4_handover.tinympc import tinympc_lacks
from tests.support.targets_here import needs_cortex_m
from workbench.report.number_text import number_text
from workbench.study import Results

STACK = 8192  # bytes, which the issue allows
OURS = SolverCount(1000.0, 1200.0, 1e-9, 3.0)


def results(**changes):
    """Results in which each law has the same count."""
    one = {"tinympc": SolverCount(4000.0, 9000.0, 1e-3, 5.0), "osqp": None, "reasons": ("osqp is missing",)} | changes
    count = PredictiveCount(0.2, 0, OURS, 500, 800, **one)
    filtered = (FilterCount(0.5, 1.0, 3, 1e4, 2e4, 0, 900, ""),) * len(filter_law.STAGES)
    return Results(works={predictive_laws.WORK: (count,) * len(predictive_keys()), filter_law.WORK: filtered})


def test_every_problem_has_a_row_at_every_horizon():
    for run in (PUSHED, IDLE):
        table = predictive_tables.solver_table(results(), run)
        assert len(table.rows) == len(problems()) * len(predictive_laws.HORIZONS)
        assert {row[6:8] for row in table.rows} == {(4.0, 7.5)}
    assert {one.sizes[0] for one in problems()} == {2, 4, 6, 8, 16}


def test_a_solver_that_is_not_here_is_named_and_leaves_its_cells_empty():
    section = predictive_tables.predictive_section(results(tinympc=None, reasons=("no sources", "no osqp")))
    assert any("Not counted here: no sources; no osqp." in str(item) for item in section.blocks)
    table = predictive_tables.solver_table(results(tinympc=None), PUSHED)
    assert {row[4:] for row in table.rows} == {(None,) * 4}


def test_instructions_are_thousands_to_three_digits_without_a_power_of_ten():
    counts = (1548.0, 22783.3, 148642.0, 7_303_007.0, 227_394_680.0)
    assert [str(number_text(in_thousands(one), 3)) for one in counts] == ["1.55", "22.8", "149", "7300", "227\u2009000"]


def test_osqp_has_a_row_for_both_kinds_of_run():
    table = predictive_tables.osqp_table(results(osqp=SolverCount(2_345_678.0, 3e6, 1e-4, 25.0)))
    assert {row[2:] for row in table.rows} == {(2350, 3000, 2350, 3000)}


def test_errors_of_a_column_are_all_written_with_a_power_of_ten():
    assert [error_in_words(one) for one in (0.28, 4.2e-4, 3e-17)] == ["3·10⁻¹", "4·10⁻⁴", "rounding"]
    assert {row[2:5] for row in predictive_tables.error_table(results()).rows} == {("1·10⁻⁹", "1·10⁻³", None)}


@needs_cortex_m
def test_a_counted_law_has_the_bits_of_the_simulation():
    count = predictive_count(f"double integrator|4|{PUSHED}")
    assert count.differing_bits == 0
    assert 0 < count.law.mean <= count.law.most
    assert 0.05 < count.active < 0.5  # the limit acts in some periods
    assert (count.tinympc is None) == bool(tinympc_lacks())


@needs_cortex_m
def test_the_rocket_with_its_cone_has_the_bits_of_the_simulation():
    count = predictive_count(f"rocket with its cone|4|{PUSHED}")
    assert count.differing_bits == 0
    assert count.active > 0.2
    assert count.law.error < 1e-2
    assert count.osqp is None  # which has no cones


@needs_cortex_m
def test_the_safety_filter_has_the_bits_of_the_simulation_and_keeps_its_limits():
    count = filter_count(4)
    assert count.differing_bits == 0
    assert count.interventions > 0.5
    assert count.largest <= 1 + 1e-9
    assert [row[0] for row in filter_law.filter_table(results()).rows] == list(filter_law.STAGES)


@needs_cortex_m
@pytest.mark.release  # a minute and a half for the largest
@pytest.mark.parametrize("problem", [one.name for one in problems()])
def test_no_plan_of_64_stages_is_on_the_stack(problem):
    count = predictive_count(f"{problem}|64|{IDLE}")
    assert count.stack < STACK
    assert count.active == 0.0


@needs_cortex_m
@pytest.mark.heavy
@pytest.mark.skipif(bool(osqp_lacks()), reason=osqp_lacks())
def test_osqp_solves_the_same_problem():
    problem = problems()[0]
    design = problem.design(4)
    states = np.array([[0.4, 0.1], [2.0, 1.0], [-3.0, 0.2]])
    run = osqp_run(design.problem, problem.low, problem.high, states)
    exact = [design.exact.first_move(state) for state in states]
    np.testing.assert_allclose(run.u, exact, rtol=0, atol=5e-3)  # its tolerance is 1e-3, absolute and relative
    assert run.successes.all()
