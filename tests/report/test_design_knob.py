"""A knob whose positions are designs, and the plans of a predictive law, in Python and on a live page."""

import json
import re

import numpy as np
import pytest

import workbench as wb
from studies.performance.chromium import open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite
from workbench.report.live.loop_study import knobs_of, loop_study

IDLE = "livePage.flight && !livePage.flight.fine.size && !livePage.held"
PLANT, WEIGHTS, UNTIL = wb.CartPole(phi=0.1), (0.05, 0.1, 0.2), 1.0
CART = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)


def data_of(page):
    return json.loads(re.search(r'<script type="application/json" id="live">(.*?)</script>', page.text, re.S)[1])


def lqr_loop(weight):
    law = wb.StateFeedback.of(PLANT, wb.lqr(CART, np.eye(4), [[weight]]).K, follow=("x",))
    return wb.ClosedLoop(PLANT, wb.FullState.of(PLANT), law, wb.Step("x", "m", 0.2))


def predictive_loop(weight):
    Q = np.diag([10.0, 1.0, 10.0, 1.0])
    design = wb.predictive_design(CART, 0.02, Q, [[weight]], 8, limits={"F": (-3.0, 3.0)}, sweeps=4, modes=1)
    law = wb.ModelPredictive.of(PLANT, design, follow=("x",))
    loop = wb.ClosedLoop(PLANT, observer=wb.FullState.of(PLANT), controller=law, reference=wb.Step("x", "m", 1.0))
    return wb.DigitalLoop(loop, 0.02)


def knob_of(loop, values=WEIGHTS):
    return wb.DesignKnob.of("weight of the force", values, loop)


def test_a_design_knob_turns_all_numbers_that_follow_from_its_value():
    knob = knob_of(lqr_loop)
    assert sorted(knob.numbers) == [f"controller.K[0,{i}]" for i in range(4)]
    study = loop_study(lqr_loop(0.1), UNTIL, 1e-3, (wb.rmse(),), (knob,))
    turned = wb.turn_knobs(study, "run: loop", {"weight of the force": 0.05})
    own = wb.measure(lqr_loop(0.05), (wb.rmse(),), until=UNTIL, h=1e-3, arithmetic="portable")
    np.testing.assert_array_equal(turned.score("RMSE").value, own.score("RMSE").value)


def test_values_that_are_no_designs_are_refused_by_name():
    with pytest.raises(ValueError, match="2 to 200 ascending numbers; got 1"):
        knob_of(lqr_loop, (0.1,))
    with pytest.raises(ValueError, match="ascending"):
        knob_of(lqr_loop, (0.2, 0.1))
    with pytest.raises(ValueError, match="all 3 loops have the same ones"):
        knob_of(lambda weight: lqr_loop(0.1))
    with pytest.raises(ValueError, match="none of its 3 values gives the parameters of this loop"):
        wb.live(lqr_loop(0.3), until=UNTIL, knobs=(knob_of(lqr_loop),))


def test_designs_of_other_sizes_are_refused_by_name():
    def loop(weight):
        return (
            wb.ClosedLoop(PLANT, wb.FullState.of(PLANT), wb.StateFeedback.of(PLANT, np.ones((1, 4)) * weight))
            if (weight < 1)
            else lqr_loop(weight)
        )

    with pytest.raises(ValueError, match=re.escape("must have loops with the same parameters; that of 2 differs")):
        knob_of(loop, (0.5, 2.0))


def test_numbers_that_a_design_computes_have_no_knob_of_their_own():
    system = predictive_loop(0.1).ode()
    names = [knob.name for knob in knobs_of(system.step(1))]
    assert "controller.high" in names
    assert not {"controller.K", "controller.sigma", "controller.W", "controller.A"} & set(names)


@needs_llvmlite
def test_the_page_of_a_predictive_law_holds_its_plans():
    data = data_of(wb.live(predictive_loop(0.1), until=UNTIL, knobs=(knob_of(predictive_loop),)))
    plans = [curve for curve in data["curves"] if curve["stages"]]
    assert {curve["stages"] for curve in plans} == {9}
    assert {curve["figure"] for curve in plans} == {"signal_1", "signal_2"}
    assert data["knobs"][0]["stops"] == list(WEIGHTS)


@needs_chromium
@needs_llvmlite
def test_a_turned_design_and_its_plans_have_the_bits_of_python(tmp_path, browser):
    page = wb.live(predictive_loop(0.1), until=UNTIL, knobs=(knob_of(predictive_loop),)).write(tmp_path / "page.html")
    with open_page(page, "#knobs=weight%20of%20the%20force:0.21", browser=browser) as shown:
        shown.until("livePage.data")
        shown.until(IDLE)
        assert shown.value("livePage.state.values[0]") == 0.2  # the nearest of the designs
        view = "[...livePage.views.values()][0]"
        index = "livePage.data.curves.findIndex((one) => one.stages)"
        plan = shown.value(f"[...numbersOfCurve(livePage.data.curves[{index}], {view}, livePage.data.loops[0]).y]")
        row = shown.value(f"livePage.data.curves[{index}].rows[0]")
        h = shown.value("livePage.data.loops[0].every")
    run = wb.simulate(predictive_loop(0.2).ode().step(1), until=UNTIL, arithmetic="portable")
    assert plan == run["predicted_x"][0, round(row * h / 0.02)].tolist()
