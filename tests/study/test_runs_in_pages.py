"""A page is made of results that are there: nothing is simulated in `sections` or `headlines`."""

import re
from importlib import import_module

import pytest

import workbench as wb
from tests.support.cases import heavy_but
from workbench.core.validation.permission import no_runs
from workbench.engine import simulate
from workbench.engine.reference import reference_run
from workbench.study.definition_text import Reader

PAGE = """
import workbench as wb
from workbench.study.case_runs import run

motor = wb.open_loop(wb.DCMotor())

def simulated():
    return wb.simulate(motor, until=1.0)["omega"].max()

def measured():
    return wb.measure(motor, (wb.effort("omega"),), until=1.0, h=0.01)

def ran():
    ends = wb.Run(motor, (wb.effort("omega"),), until=1.0, h=0.01)
    return run(wb.Study("inner", "T", "Q?", "M.", lambda results: [], cases=(wb.Case("a", "b", ends),)))

def sections(results):
    {sections}
    return [wb.Section("One", (wb.Paragraph("Two."),))]

def headlines(results):
    {headlines}
    return ["Three."]

study = wb.Study("page", "T", "Q?", "M.", sections, headlines, measures_time={times})
"""


def page(tmp_path, sections="pass", headlines="pass", times=False):
    (tmp_path / "page.py").write_text(PAGE.format(sections=sections, headlines=headlines, times=times))


@pytest.mark.parametrize("part", ["sections", "headlines"])
@pytest.mark.parametrize("call", ["simulated()", "measured()", "ran()"])
def test_what_simulates_while_a_page_is_made_is_refused_by_name(command, tmp_path, part, call):
    page(tmp_path, **{part: call})
    done = command("run", "page.py", "--out", "out")
    assert done.exit_code == 2
    said = r"`(simulate|run)\(.*?\)` must not be called by `Study\(" + part + r"=...\)\(results\)`: .* Declare a `Case`"
    assert re.search(said, done.stderr), done.stderr
    assert re.match(r"workbench: page\.py, line \d+: ", done.stderr.splitlines()[-1])
    assert done.stderr.count("\n") == 1


def test_a_study_that_measures_time_may_simulate_in_its_page(command, tmp_path):
    page(tmp_path, sections="simulated()", headlines="measured()", times=True)
    done = command("run", "page.py", "--out", "out")
    assert done.exit_code == 0, done.output


def test_the_reference_is_a_run_too():
    ode = wb.open_loop(wb.DCMotor())
    with (
        no_runs("Study(sections=...)(results)"),
        pytest.raises(ValueError, match=r"`reference\(ode=...\)` must not be"),
    ):
        reference_run(ode, times=[0.1])
    reference_run(ode, times=[0.1])


ENGINE = {  # what simulates, by module and name
    *("engine.simulation: simulate", "engine.metrics.measure: measure", "engine.batch: run_step"),
    *("engine.reference.solution: reference", "engine.reference.solution: reference_of_function"),
    *("study.case_runs: run", "study.tuning.search: tune", "study.uncertainty.local_sensitivity: local_sensitivities"),
    "study.executors: on_threads",
}
STUDIES = [  # but a2, whose page takes the names of claims from the table of their checks
    *("a0_two_link_arm", "a1_paper_tables.study", "a3_riccati_gains.study"),
    *("a4_observer_gains.study", "a5_linear_analysis.study", "a6_unstated_choices.study", "a7_sensitivity.study"),
    *("a8_fair_comparison.study", "a9_sampling.study", "b1_chattering.study", "b3_any_plant.study"),
    *("b4_handover.study", "own_study"),
]


def calls_of(function):
    """The functions of the workbench that a function calls, itself or by others of its study, by module and name."""
    found, seen, calls = [], set(), set()
    Reader(found, "a page").text(function)
    while found:
        one = found.pop()
        if id(one) in seen:
            continue
        seen.add(id(one))
        reader = Reader(found, str(one))
        text = reader.of_class(one) if isinstance(one, type) else reader.of_function(one)
        calls |= {f"{place}: {name}" for place, name in re.findall(r"workbench\.([\w.]+) [\d.]+: ([\w.<>]+)", text)}
    return calls


# up to eight seconds of a processor until all their loops are built
LONG = [
    f"{name}.study"
    for name in ("a1_paper_tables", "a6_unstated_choices", "a7_sensitivity", "a8_fair_comparison", "a9_sampling")
] + ["b3_any_plant.study", "b4_handover.study"]


@pytest.mark.parametrize("name", heavy_but(STUDIES, *(name for name in STUDIES if name not in LONG)))
def test_no_page_of_a_study_reaches_the_engine(name):
    study = import_module(f"studies.{name}").study
    assert not study.measures_time
    assert not (calls_of(study.sections) | calls_of(study.headlines)) & ENGINE


def test_a_page_that_reaches_the_engine_is_found():
    assert "engine.simulation: simulate" in calls_of(lambda results: simulate(results))
    assert calls_of(simulating_by_name) & ENGINE


def simulating_by_name(results):
    return [inner() for _ in range(1)]


def inner():
    return simulate(wb.open_loop(wb.DCMotor()), until=1.0)
