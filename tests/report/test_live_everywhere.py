"""A loop of which a page shows linear answers alone moves beside the runs of each scenario, and is none of them."""

import pytest

import workbench as wb
from studies.performance.chromium import open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite
from workbench.report.html_page import html
from workbench.report.live.live_data import live_data
from workbench.report.pictures.traces import Window, traces
from workbench.study import case_runs, writeup
from workbench.study.document.document import Section

pytestmark = [needs_llvmlite]

MOTOR = wb.DCMotor()
LAW = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0)
KNOB = wb.Knob("Kp", "controller.Kp", 10.0, 1000.0, log=True)


def case(scenario, size):
    loop = wb.ClosedLoop(MOTOR, controller=LAW, reference=wb.Step("omega", "rad/s", size))
    return wb.Case(scenario, "PI", wb.Run(loop, (wb.rmse(),), until=0.5, every=0.01, h=1e-3))


CASES = case("slow", 1.0), case("fast", 5.0), case("at rest", 0.0)


def sections(results):
    runs = [
        traces(name, "It.", [results[name, "PI"]], "omega", 0, "omega", (Window(0.0, 0.5),))
        for name in ("slow", "fast")
    ]
    return [Section("Runs", (*runs, *wb.loop_gain_pictures(results["at rest", "PI"])))]


def made(shown=sections, cases=CASES):
    study = wb.Study("small", "T", "Q?", "M.", shown, cases=cases, live=(KNOB,))
    results = case_runs.run(study)
    document = writeup.document(study, results, "")
    return document, live_data(study, results, document)


@pytest.fixture(scope="module")
def page():
    return made()


def test_a_loop_that_has_linear_answers_alone_is_of_each_scenario(page):
    loops = page[1]["loops"]
    assert [(one["scenario"], one.get("everywhere", False)) for one in loops] == [
        ("slow", False),
        ("fast", False),
        ("at rest", True),
    ]
    assert loops[2]["drawing"] is None
    assert loops[2]["linear"] is not None


def test_a_page_of_nothing_else_has_its_scenario():
    _, data = made(lambda results: [Section("Margins", wb.loop_gain_pictures(results["slow", "PI"]))], CASES[:1])
    assert [one.get("everywhere", False) for one in data["loops"]] == [False]


@pytest.mark.heavy
@needs_chromium
def test_in_a_browser_it_moves_with_the_runs_of_the_scenario_that_is_shown(page, tmp_path, browser):
    document, data = page
    place = tmp_path / "page.html"
    place.write_text(html(document, live=data), encoding="utf-8")
    with open_page(place, browser=browser) as live:
        live.value("document.querySelector('.bench-handle').click()")
        live.until("livePage.pool")
        assert live.value("[...document.querySelectorAll('#bench-scenario option')].map((one) => one.textContent)") == [
            "slow",
            "fast",
            "all of them",
        ]
        live.value("livePage.bench.knobs[0].turn(500)")
        live.until("livePage.flight && !livePage.flight.whole.size && livePage.answers.size === 1")
        assert live.value("[...livePage.views.keys()]") == [0, 2]
        found = live.value(
            "livePage.answers.get(2).answer.value({quantity: 'phase margin', channel: 0, unit: 'degrees'})"
        )
        study = wb.Study("small", "T", "Q?", "M.", sections, cases=CASES, live=(KNOB,))
        margins = wb.linear_loop_at_knobs(study, "at rest: PI", {"Kp": 500.0}).margins()["v"].margins
        assert found == pytest.approx(margins.phase_margin.value, rel=1e-9)
        assert live.value("document.querySelectorAll('.bench-results tbody tr, .bench tbody tr').length") == 1
        assert live.value("location.hash = '#scenario=at%20rest', 1") == 1
        assert live.until("livePage.state.scenario") == "slow"
        assert live.complaints == []
