"""`linear.plot()` and `wb.bode(linear)`: what they draw is what python-control has, and what they refuse is said."""

import math
import subprocess
import sys

import control
import numpy as np
import pytest

import workbench as wb
from tests.support.plotted_loops import CART, lines, named_points, two_channels
from workbench.blocks.loop import LinearLaw
from workbench.report.table_text import plain
from workbench.study.document.figure import Series

PLANT = control.tf([1, 2], [1, 1, 3], inputs="v", outputs="omega", name="motor")
PI = control.tf([2.0, 3.0], [1.0, 0.0], inputs="omega", outputs="v", name="pi")
L = PLANT * PI
STEP = wb.Step("omega", "rad/s", 1.0)
LOOP = wb.ClosedLoop(PLANT, controller=LinearLaw(PI, error=True), reference=STEP)
LINEAR = wb.linear_loop(LOOP)


def test_a_loop_shows_bode_and_nyquist_plots_and_poles_in_one_picture():
    picture = LINEAR.plot()
    labels = [plain(panel.ylabel) for panel in picture.figure.panels]
    assert labels == ["magnitude [dB]", "imaginary part", "phase [degrees]", "imaginary part [1/s]"]
    margin = LINEAR.margins()["v"].margins.phase_margin.value
    assert f"hase margin {margin:.3g} degrees" in picture.caption
    assert any("phase margin" in name for name in named_points(picture.figure.panels[2]))
    assert "the closed loop has no unstable poles" in picture.caption
    assert picture._repr_html_().startswith("<figure><svg")


@pytest.mark.parametrize("draw", [wb.bode, lambda linear: linear.plot("bode"), lambda linear: wb.plot(linear, "bode")])
def test_a_bode_plot_of_a_loop_is_that_of_python_control(draw):
    gain, phase = (lines(panel)[0] for panel in draw(LINEAR).figure.panels)
    theirs = control.frequency_response(L, gain.x)
    np.testing.assert_allclose(gain.y, 20 * np.log10(theirs.magnitude), atol=1e-8)
    np.testing.assert_allclose(phase.y, np.degrees(np.unwrap(theirs.phase)), atol=1e-6)


def test_the_frequencies_of_a_picture_show_the_poles_and_zeros():
    omega = lines(wb.bode(LINEAR).figure.panels[0])[0].x
    sizes = np.abs(np.concatenate([L.poles(), L.zeros(), control.feedback(L, 1).poles()]))
    sizes = sizes[sizes > 1e-6]  # the integrator has no corner
    assert omega[0] < sizes.min() / 20
    assert omega[-1] > 20 * sizes.max()


def test_a_loop_and_its_computer_share_a_picture():
    computer = wb.linear_loop(wb.DigitalLoop(LOOP, 0.1))
    picture = wb.plot({"design": LINEAR, "computer": computer}, "bode")
    assert [mark.label for mark in lines(picture.figure.panels[0])] == ["design", "computer"]
    assert lines(picture.figure.panels[0])[1].x[-1] == pytest.approx(math.pi / 0.1)
    whole = wb.plot({"design": LINEAR, "computer": computer}).caption
    assert "one plane" in whole  # their poles are not in one plane, and are not drawn


def test_a_delay_is_exact_in_bode_and_nyquist_plots_and_its_poles_are_refused():
    late = wb.linear_loop(LOOP, delays={"v": 0.1})
    gain, phase = (lines(panel)[0] for panel in wb.bode(late).figure.panels)
    values = L(1j * gain.x)
    np.testing.assert_allclose(gain.y, 20 * np.log10(np.abs(values)), atol=1e-8)
    np.testing.assert_allclose(phase.y, np.degrees(np.unwrap(np.angle(values)) - 0.1 * phase.x), atol=1e-6)
    assert "encircle" in wb.nyquist(late).caption
    whole = late.plot()
    assert "a delay has infinitely many" in whole.caption
    assert len(whole.figure.panels) == 4  # a Nichols plot stands in the place of the poles
    for kind in ("poles", "step"):
        with pytest.raises(ValueError, match="a delay has infinitely many"):
            late.plot(kind)
    with pytest.raises(ValueError, match="a delay has infinitely many"):
        late.plot("root_locus", over={"controller.system.B[0,0]": np.linspace(1, 2, 3)})


def test_a_step_of_a_loop_is_that_of_python_control():
    (panel,) = LINEAR.plot("step").figure.panels
    ours = lines(panel)[0]
    theirs = control.step_response(control.feedback(L, 1), ours.x)
    np.testing.assert_allclose(ours.y, theirs.outputs, atol=1e-9)
    assert LINEAR.plot("step").caption.startswith("Step of 1 rad/s at omega_ref. Rise time")
    assert LINEAR.plot("step").caption == wb.step_response(LINEAR).caption


def test_a_load_is_answered_by_every_output_in_a_panel_of_its_own():
    figure = LINEAR.plot("step", inputs="v_load", outputs=("omega", "v"), until=5.0).figure
    assert [plain(panel.ylabel) for panel in figure.panels] == ["omega", "v"]
    alone = LINEAR.plot("step", inputs="v_load", outputs="omega")
    assert "overshoot" not in alone.caption  # it ends at zero, but for rounding
    ours = lines(figure.panels[0])[0]
    theirs = control.step_response(control.feedback(PLANT, PI), ours.x)
    np.testing.assert_allclose(ours.y, theirs.outputs, atol=1e-9)


def several_periods():
    """A plant with an observer that runs every two periods and a law that runs every three."""
    matrices = ([[0.0, 1.0], [-2.0, -2.0]], [[0.0], [1.0]], [[1.0, 0.5]], 0.0)
    plant = control.ss(*matrices, 0, states=["a", "b"], inputs=["u"], outputs=["w"])
    filters = control.ss(0.6, 0.4, 1.0, 0.0, 0.2, inputs=["w"], outputs=["w"])
    law = control.ss(0.5, 0.2, -1.0, -0.4, 0.3, inputs=["w"], outputs=["u"])
    return wb.DigitalLoop(wb.ClosedLoop(plant, filters, law), 0.1)


@pytest.mark.heavy
def test_a_step_over_several_periods_is_that_of_the_step_that_runs():
    digital = several_periods()
    linear, sampled = wb.linear_loop(digital), digital.ode(inputs=True)
    (panel,) = linear.plot("step", inputs="u_load", outputs="w", until=6.0).figure.panels
    ours = lines(panel)[0]
    step, p = sampled.step(64), sampled.parameters.default.copy()
    p[sampled.parameters.slice("u_load")] = 1.0
    x, seen = np.zeros(sampled.states.size), []
    for k in range(6, 6 + len(ours.x)):  # all blocks run at the instant 6
        seen.append(float(np.array(step.y(k, x, p, [])).ravel()[sampled.outputs.slice("w")][0]))
        x = np.array(step.F(k, x, p, [])).ravel()
    np.testing.assert_allclose(ours.y, seen, atol=1e-9)  # the substeps leave less


@pytest.mark.heavy
def test_a_loop_of_several_periods_has_a_bode_plot_and_poles_and_no_nyquist_plot():
    linear = wb.linear_loop(several_periods())
    picture = linear.plot()
    assert len(picture.figure.panels) == 3
    assert "several periods" in picture.caption
    with pytest.raises(ValueError, match="needs one loop gain"):
        linear.plot("nyquist")


def test_the_gang_of_six_has_a_panel_for_each():
    figure = LINEAR.plot("gang_of_six").figure
    assert [panel.title.partition(":")[0] for panel in figure.panels] == ["TF", "T", "PS", "CSF", "CS", "S"]
    ours = next(mark for mark in figure.panels[5].series if isinstance(mark, Series))
    np.testing.assert_allclose(10 ** (ours.y / 20), np.abs(1 / (1 + L(1j * ours.x))), rtol=1e-8)
    four = two_channels().plot("gang_of_six").figure
    assert [panel.title for panel in four.panels] == ["T", "PS", "CS", "S"]


def test_another_answer_is_drawn_by_the_names_of_its_signals():
    picture = LINEAR.plot("bode", of="closed", inputs="v_load", outputs="omega")
    ours = lines(picture.figure.panels[0])[0]
    np.testing.assert_allclose(10 ** (ours.y / 20), np.abs(control.feedback(PLANT, PI)(1j * ours.x)), rtol=1e-8)
    assert ours.label == "omega from v_load"


@pytest.mark.heavy
def test_core_knows_no_picture_until_one_is_asked_for():
    code = (
        "import sys, workbench.core.plot_registry as d; assert not d.PLOTTERS; "
        "assert not {'matplotlib', 'workbench.report'} & sys.modules.keys(); "
        "import workbench as wb; wb.plot; assert len(d.PLOTTERS) == 5"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: LINEAR.plot("bodee"), "bode"),
        (lambda: LINEAR.rows({"plant.system.A[0,0]": np.array([-1.0, -2.0])}).plot("nyquist"), "sensitivity"),
        (lambda: wb.plot(3.0), "an object that has a picture"),
        (lambda: wb.plot({}), "empty mapping"),
        (lambda: LINEAR.plot("root_locus"), "the path of a parameter"),
        (lambda: LINEAR.plot("root_locus", over={"controller.system.B[0,0]": [2.0, 1.0, 3.0]}), "rising or falling"),
        (lambda: wb.root_locus(L, "plant.m", [1.0, 2.0]), "a `LinearLoop`, if a parameter is named"),
        (lambda: LINEAR.plot("bode", frequencies=[2.0, 1.0]), "rise"),
        (lambda: LINEAR.plot("step", until=-1.0), "until"),
        (lambda: wb.plot({"a": LINEAR, "b": LINEAR}, "gang_of_six"), "one `LinearLoop`"),
        (lambda: wb.linear_loop(LOOP, "omega").plot("relative_gains"), "cut at inputs of its plant"),
        (lambda: two_channels().plot("bode", of="closed"), "up to 12 answers"),
    ],
)
def test_bad_input_gets_a_sentence(call, words):
    with pytest.raises(ValueError, match=words):
        call()


def test_a_parameter_that_is_not_there_is_answered_with_the_nearest():
    with pytest.raises(LookupError, match=r"Did you mean 'plant.m'\?"):
        CART.plot("root_locus", over={"plant.mm": [1.0, 2.0]})
    with pytest.raises(LookupError, match="'omegaa'"):
        LINEAR.plot("step", outputs="omegaa")


@wb.block
class Hidden(wb.Plant):
    """x' = -x + u beside h' = a h, which nothing reads."""

    a: float = wb.parameter(default=0.5, unit="1/s")
    x: float = wb.initial(default=0.0, unit="m")
    h: float = wb.initial(default=0.0, unit="m")
    inputs, outputs = wb.layout(u="m/s"), wb.layout(x="m")

    def rate(self, t, x, u):
        return {"x": u.u - x.x, "h": self.a * x.h}


@wb.block
class Minus(wb.Controller):
    """u = -x."""

    reads, drives = wb.layout(x="m"), wb.layout(u="m/s")

    def command(self, t, z, est, ref):
        return {"u": -est.x}


def test_a_mode_that_grows_and_that_l_does_not_show_is_counted_among_its_unstable_poles():
    linear = wb.linear_loop(wb.ClosedLoop(Hidden(), controller=Minus()))
    assert not linear.stable
    assert "With 1 unstable pole of L, the closed loop has 1 unstable pole." in plain(linear.plot("nyquist").caption)


def test_an_option_that_a_picture_does_not_have_is_refused_by_its_name():
    with pytest.raises(LookupError, match=r"no 'colour' among the 7 options of `LinearLoop.plot\('bode'\)`"):
        LINEAR.plot("bode", colour=3)
    with pytest.raises(LookupError, match=r"no 'until' among .* options of `LinearRows.plot\('bode'\)`"):
        LINEAR.rows({}).plot("bode", until=3)
