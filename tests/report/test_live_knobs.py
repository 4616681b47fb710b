"""The knobs of a live page: those of a study or of its sweeps, and which are refused."""

import pytest

import workbench as wb
from tests.support.live_study import KP, case, data_of, loop, page
from workbench.report.html_page import html
from workbench.report.live.live_data import live_data
from workbench.report.live.loop_study import loop_study
from workbench.study import case_runs, writeup
from workbench.study.knob import Knob
from workbench.study.study import Study


def test_without_knobs_the_factors_of_the_sweeps_are_offered():
    factors = (
        wb.Factor("gain", ("controller.Kp",), wb.LogUniform(50.0, 200.0), "stated"),
        wb.Factor("inertia", ("plant.J",), wb.Uniform(0.5, 2.0), share=True),
    )
    sweep = wb.Sweep("s", case().run, factors, wb.SobolDesign(2, 16))
    study = Study("small", "T", "Q?", "M.", page, cases=(case(),), sweeps=(sweep,))
    results = case_runs.run(study)
    data = live_data(study, results, writeup.document(study, results, "command"))
    gain, inertia = data["knobs"]
    assert (gain["low"], gain["high"], gain["log"], gain["value"], gain["origin"]) == (50, 200, True, 100, "stated")
    assert (inertia["value"], inertia["share"], inertia["unit"]) == (1.0, True, "1")


def test_a_study_may_stay_as_printed():
    assert data_of(live=None) is None
    assert data_of(live=()) is None  # nothing is offered


@pytest.mark.parametrize(
    ("knobs", "says"),
    [
        ((Knob("K", "controller.Kq", 1.0, 2.0),), r"no 'controller\.Kq', which the knob 'K' turns, .* Did you mean"),
        ((Knob("Kp", "controller.Kp", 200.0, 300.0),), "must hold the number of the loops, 100; got 200 to 300"),
        ((Knob("J", "plant.J", -1.0, 1.0),), "'J' goes from -1 to 1, too far"),
        ((KP, KP), "distinct names"),
    ],
)
def test_a_knob_that_fits_no_loop_is_refused_in_one_sentence(knobs, says):
    with pytest.raises((ValueError, LookupError), match=says):
        data_of(live=knobs)


def test_a_knob_of_two_different_numbers_must_be_a_share():
    cases = case(), case("stiffer", 200.0)
    with pytest.raises(ValueError, match="'controller.Kp' is 100 or 200 in different loops: turn a share"):
        data_of(*cases)
    assert data_of(*cases, live=(Knob("K", "controller.Kp", 0.5, 2.0, share=True),))["knobs"][0]["value"] == 1.0


def test_a_loop_alone_has_a_page_with_a_knob_for_every_number():
    study = loop_study(loop(), until=1.0, h=1e-3)
    results = case_runs.run(study)
    data = live_data(study, results, writeup.document(study, results, "command"))
    assert {"controller.Kp", "plant.J", "reference.level"} <= {knob["name"] for knob in data["knobs"]}
    assert len(data["curves"]) == 3  # speed, its reference, and the voltage
    assert {cell["metric"] for cell in data["cells"] if "metric" in cell} == {0, 1, 2}
    with pytest.raises(ValueError, match=r"live\(until=...\)"):
        loop_study(loop(), until=1.0005, h=1e-3)


def test_a_turned_case_refuses_what_it_does_not_have():
    study = Study("small", "T", "Q?", "M.", page, cases=(case(),), live=(KP,))
    with pytest.raises(LookupError, match="no 'kp' among the 1 knobs of this study. They are: Kp"):
        wb.turn_knobs(study, "speed: PI", {"kp": 1.0})
    with pytest.raises(LookupError, match="cases of this study"):
        wb.turn_knobs(study, "speed: PID", {})


def test_a_page_without_knobs_has_no_script():
    study = Study("small", "T", "Q?", "M.", page, cases=(case(),), live=None)
    results = case_runs.run(study)
    text = html(writeup.document(study, results, "command"), live=None)
    assert "<script" not in text
    assert "data-cell" not in text
