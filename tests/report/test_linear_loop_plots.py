"""`linear.plot()` and `wb.bode(linear)`: what they draw is what python-control has, and what they refuse is said."""

import math
import subprocess
import sys

import control
import numpy as np
import pytest

import workbench as wb
from workbench.blocks.loop import LinearLaw
from workbench.report.table_text import plain
from workbench.study.document.figure import Points, Series

PLANT = control.tf([1, 2], [1, 1, 3], inputs="v", outputs="omega", name="motor")
PI = control.tf([2.0, 3.0], [1.0, 0.0], inputs="omega", outputs="v", name="pi")
L = PLANT * PI
STEP = wb.Step("omega", "rad/s", 1.0)
LOOP = wb.ClosedLoop(PLANT, controller=LinearLaw(PI, error=True), reference=STEP)
LINEAR = wb.linear_loop(LOOP)

A, B = np.array([[-1.0, 0.4], [0.2, -2.0]]), np.array([[1.0, 0.3], [0.1, 2.0]])
GAINS = np.array([[3.0, -0.5], [0.8, 2.0]])
LAG = control.ss([[-20.0]], [[20.0]], [[1.0]], 0.0)
NAMES = {"inputs": ["a", "b"], "outputs": ["y", "z"]}
TWO = control.ss(A, B, np.eye(2), np.zeros((2, 2)), states=["y", "z"], **NAMES)
LAW = control.ss(
    -20.0 * np.eye(2), 20.0 * np.eye(2), -GAINS, np.zeros((2, 2)), inputs=["y", "z"], outputs=["a", "b"]
)  # u = -K times the lagged outputs


def two_channels(gain=1.0, **options):
    law = control.ss(LAW.A, LAW.B, gain * LAW.C, LAW.D, inputs=["y", "z"], outputs=["a", "b"])
    return wb.linear_loop(wb.ClosedLoop(TWO, controller=LinearLaw(law)), **options)


def loop_gain(omega):
    """L = K (s/20 + 1)^-1 G at the inputs of the plant."""
    s = 1j * np.asarray(omega)[:, np.newaxis, np.newaxis]
    G = np.linalg.solve(s * np.eye(2) - A, B + 0j)
    return 20 / (s + 20) * (GAINS @ G)


def lines(panel):
    return [mark for mark in panel.series if isinstance(mark, Series) and mark.label != "" and mark.style != "aid"]


def named_points(panel):
    return [str(name) for mark in panel.series if isinstance(mark, Points) for name in mark.names if name]


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


def test_each_channel_is_drawn_as_the_loop_that_the_others_leave():
    picture = wb.bode(two_channels())
    for k, mark in enumerate(lines(picture.figure.panels[0])):
        S = np.linalg.inv(np.eye(2) + loop_gain(mark.x))
        alone = 1 / S[:, k, k] - 1  # S at one channel alone is 1 / (1 + L) of the loop that the other leaves
        np.testing.assert_allclose(10 ** (mark.y / 20), np.abs(alone), rtol=1e-6)


def test_margins_of_single_channels_stand_beside_the_disk_margin_of_all():
    linear = two_channels()
    for picture in (linear.plot(), wb.bode(linear), wb.nichols(linear)):
        assert picture.caption.count("disk margin of all channels at once") == 2
    assert f"{linear.disk_margin.alpha:.3g}" in linear.plot().caption


def test_a_loop_whose_disk_margin_is_refused_prints_no_margin_of_a_channel():
    unstable = two_channels(-3.0)
    assert not unstable.stable
    for picture in (unstable.plot(), wb.bode(unstable)):
        assert "No margins: those of single channels are not printed" in picture.caption
        assert "phase margin" not in picture.caption
        assert not named_points(picture.figure.panels[0])


def test_one_channel_of_two_says_that_its_margins_need_the_other():
    caption = two_channels(at="a").plot("bode").caption
    assert "No margins of a: it is one of 2 channels" in caption
    assert "cut the loop at a, b" in caption


def test_the_nyquist_plot_of_two_channels_counts_the_turns_of_the_determinant():
    stable, unstable = two_channels(), two_channels(-3.0)
    assert "does not encircle 0. With no unstable poles of L, the closed loop has no unstable poles" in (
        stable.plot("determinant").caption
    )
    count = sum(pole.value.real > 0 for pole in unstable.poles)
    assert f"the closed loop has {count} unstable pole" in unstable.plot("determinant").caption
    assert "disk margin" in stable.plot("characteristic_loci").caption


def test_singular_values_are_those_of_the_matrix():
    largest = lines(two_channels().plot("singular_values").figure.panels[0])[0]
    found = np.linalg.svd(loop_gain(largest.x), compute_uv=False)[:, 0]
    np.testing.assert_allclose(10 ** (largest.y / 20), found, rtol=1e-8)
    assert "disk margin" in wb.singular_values(two_channels()).caption


def test_relative_gains_are_those_of_the_plant_alone():
    figure = two_channels().plot("relative_gains").figure
    own = lines(figure.panels[0])[0]
    G = np.linalg.solve(1j * own.x[:, np.newaxis, np.newaxis] * np.eye(2) - A, B + 0j)
    theirs = np.abs(G[:, 0, 0] * np.linalg.inv(G)[:, 0, 0])
    np.testing.assert_allclose(own.y, theirs, rtol=1e-8)
    with pytest.raises(ValueError, match="an output for each of 2 inputs"):
        two_channels().plot("relative_gains", outputs="y")


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


@wb.block
class Cart(wb.Plant):
    """A cart on a spring: m p'' = F - c p' - k p + a p, which is not stable for a > k."""

    m: float = wb.parameter(default=1.0, unit="kg", low=0, strict=True)
    c: float = wb.parameter(default=0.4, unit="N s/m")
    k: float = wb.parameter(default=2.0, unit="N/m")
    p: float = wb.initial(default=0.0, unit="m")
    pd: float = wb.initial(default=0.0, unit="m/s")
    inputs, outputs = wb.layout(F="N"), wb.layout(p="m")

    def rate(self, t, x, u):
        return {"p": x.pd, "pd": (u.F - self.c * x.pd - self.k * x.p) / self.m}


@wb.block
class Lagged(wb.Controller):
    """F = g (p_ref - f), f' = (p - f) / T."""

    g: float = wb.parameter(default=1.0, unit="N/m")
    T: float = wb.parameter(default=0.2, unit="s")
    f: float = wb.initial(default=0.0, unit="m")
    reads = follows = wb.layout(p="m")
    drives = wb.layout(F="N")

    def command(self, t, z, est, ref):
        return {"F": self.g * (ref.p - z.f)}

    def rate(self, t, z, est, ref):
        return {"f": (est.p - z.f) / self.T}


CART = wb.linear_loop(wb.ClosedLoop(Cart(), controller=Lagged(), reference=wb.Step("p", "m", 1.0)))


def cart_poles(m=1.0, c=0.4, k=2.0, g=1.0, T=0.2):
    """The roots of (m s^2 + c s + k) (T s + 1) + g."""
    return np.roots([m * T, m + c * T, c + k * T, k + g])


@pytest.mark.parametrize("draw", [wb.root_locus, lambda linear, path, at: linear.plot("root_locus", over={path: at})])
@pytest.mark.parametrize("path", ["plant.m", "controller.T", "controller.g"])
def test_a_root_locus_over_any_parameter_has_the_roots_of_its_polynomial(path, draw):
    values = np.linspace(0.1, 3.0, 30)
    figure = draw(CART, path, values).figure
    for value in values:
        ours = np.sort_complex([row[2] + 1j * row[3] for row in figure.numbers.rows if row[0] == value])
        np.testing.assert_allclose(ours, np.sort_complex(cart_poles(**{path[-1]: value})), atol=1e-9)


def test_a_root_locus_says_where_the_loop_loses_its_stability_and_has_a_dot_at_its_own_value():
    picture = CART.plot("root_locus", over={"controller.g": np.linspace(0.5, 10.0, 400)})
    m, c, k, T = 1.0, 0.4, 2.0, 0.2
    limit = (m + c * T) * (c + k * T) / (m * T) - k  # Hurwitz: a2 a1 = a3 a0
    assert f"at controller.g = {limit:.3g} N/m" in picture.caption
    assert any("controller.g = 1 N/m" in plain(mark.label) for mark in picture.figure.panels[0].series)


def test_values_without_a_rest_or_out_of_their_bounds_are_gaps_and_are_said():
    picture = CART.plot("root_locus", over={"plant.m": np.array([-1.0, 0.5, 1.0, 2.0])})
    assert "1 value has no poles; of the first, −1: 'plant.m' must be finite" in picture.caption


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


DRAWS = np.random.default_rng(2).uniform(0.5, 1.5, 40)


def test_an_envelope_is_of_the_rows_and_names_the_worst_by_its_value():
    picture = CART.rows({"controller.g": DRAWS}).plot()
    own = {mark.label: mark for mark in picture.figure.panels[0].series}
    values = np.array([g / ((1j * own["median"].x) ** 2 + 0.4j * own["median"].x + 2) for g in DRAWS])
    values /= 0.2j * own["median"].x + 1
    np.testing.assert_allclose(own["median"].y, np.median(20 * np.log10(np.abs(values)), axis=0), atol=1e-8)
    worst = int(DRAWS.argmax())  # the largest gain comes nearest to -1
    Ms = (
        wb.linear_loop(wb.ClosedLoop(Cart(), controller=Lagged(g=DRAWS[worst]), reference=wb.Step("p", "m", 1.0)))
        .margins()["F"]
        .margins.Ms.gain.value
    )
    assert f"The worst is row {worst} (controller.g = {DRAWS[worst]:.3g}), Ms {Ms:.3g}." in picture.caption


def test_a_row_that_is_not_stable_is_the_worst_and_a_row_without_an_answer_is_left_out():
    masses, gains = np.full(6, 1.0), np.array([1.0, 1.1, 9.0, 1.2, 8.0, 1.3])
    masses[0] = np.nan
    rows = CART.rows({"controller.g": gains, "plant.m": masses})
    assert "The worst is row 2 (controller.g = 9, plant.m = 1), not stable." in rows.plot().caption
    assert "Left out: 1 draw" in rows.plot().caption
    step = rows.plot("step")
    assert "Not stable, and not drawn: 2 rows." in step.caption
    assert "row 2" in rows.plot("poles").caption


def test_steps_of_rows_are_those_of_each_row_alone():
    gains = np.array([0.5, 1.0, 1.5])
    figure = CART.rows({"controller.g": gains}).plot("step", until=4.0).figure
    low, high = next((mark.low, mark.high) for mark in figure.panels[0].series if mark.label == "all draws")
    t = figure.panels[0].series[0].x
    alone = [
        control.step_response(control.feedback(control.tf([g], [1, 0.4, 2]), control.tf([1], [0.2, 1])), t).outputs
        for g in gains
    ]
    np.testing.assert_allclose(low, np.min(alone, axis=0), atol=1e-9)
    np.testing.assert_allclose(high, np.max(alone, axis=0), atol=1e-9)


def test_rows_of_several_channels_show_the_largest_gain_of_s():
    rows = two_channels().rows({"controller.system.C[0,0]": np.linspace(-4.0, -2.0, 5)})
    picture = rows.plot()
    own = {mark.label: mark for mark in picture.figure.panels[0].series}["all draws"]
    S = np.linalg.inv(np.eye(2) + loop_gain(own.x))
    sizes = 20 * np.log10(np.linalg.norm(S, 2, axis=(1, 2)))  # the row in the middle is the loop itself
    assert (own.low <= sizes + 1e-9).all()
    assert (own.high >= sizes - 1e-9).all()
    assert "largest gain of S" in picture.caption
    with pytest.raises(ValueError, match="name a channel by `at`"):
        rows.plot("bode")
    assert len(rows.plot("bode", at="b").figure.panels) == 2


@pytest.mark.heavy
def test_core_knows_no_picture_until_one_is_asked_for():
    code = (
        "import sys, workbench.core.drawers as d; assert not d.DRAWERS; "
        "assert not {'matplotlib', 'workbench.report'} & sys.modules.keys(); "
        "import workbench as wb; wb.plot; assert len(d.DRAWERS) == 3"
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
