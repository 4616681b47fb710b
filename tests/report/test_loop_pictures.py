"""Bode, Nyquist and Nichols plots: what they draw against python-control, by hand, and from the definition."""

import math

import control
import numpy as np
import pytest

from tests.support.loop_gain_curves import DOUBLE, LOOPS, SAMPLED, THIRD, caption, curve, s, series
from workbench.design.frequency import stability_margins
from workbench.report.figures.figure_sheet import draw
from workbench.report.loop_pictures import bode_figure, nichols_figure, nyquist_figure
from workbench.report.loop_pictures.asymptotes import asymptotic_gain, asymptotic_phase
from workbench.report.table_text import plain
from workbench.study.document.figure import Area, Guides, Points
from workbench.study.document.frequency_curves import CornerFrequencies, FrequencyCurve
from workbench.study.document.gain_bounds import Disk, GainBound


@pytest.mark.parametrize("name", LOOPS)
def test_a_bode_plot_has_the_gains_and_phases_of_python_control(name):
    one = curve(LOOPS[name])
    gain, phase = (series(panel, "L")[0] for panel in bode_figure("b", "", [one]).panels)
    theirs = control.frequency_response(LOOPS[name], one.frequencies)
    assert np.allclose(gain.y, 20 * np.log10(theirs.magnitude), rtol=0, atol=1e-9)  # dB: rounding of two evaluations
    turned = np.degrees(np.unwrap(theirs.phase))
    turns = (phase.y - turned) / 360
    assert np.allclose(turns, round(float(turns[0])), rtol=0, atol=1e-9)  # but for full turns, the same


@pytest.mark.parametrize(
    ("system", "first"),
    [
        (THIRD, 0.0),
        (DOUBLE, -180.0),
        (1 / s, -90.0),
        (1 / (s**3 + s**2 * 1e-9), -270.0),
        (s / (s + 1), 90.0),
        (-1 / (s + 1), -180.0),
    ],
)
def test_a_phase_begins_where_the_slope_of_its_gain_says(system, first):
    one = curve(system, margins=False, frequencies=np.geomspace(1e-4, 1.0, 200))
    phase = series(bode_figure("b", "", [one]).panels[1], "L")[0]
    assert phase.y[0] == pytest.approx(first, abs=0.1)  # degrees: the first frequency is not zero


def test_margins_are_marked_where_python_control_has_them():
    gain, phase, at_phase, at_gain = control.margin(THIRD)
    upper, lower = bode_figure("b", "", [curve(THIRD)]).panels
    (marked,) = (mark for mark in upper.series if isinstance(mark, Points))
    assert (marked.x[0], marked.y[0]) == pytest.approx((at_phase, -20 * math.log10(gain)), rel=1e-9)
    assert plain(marked.names[0]) == "gain margin 6.02 dB, 1.73 rad/s"
    (marked,) = (mark for mark in lower.series if isinstance(mark, Points))
    assert (marked.x[0], marked.y[0]) == pytest.approx((at_gain, phase - 180), rel=1e-9)
    assert -180.0 in lower.hlines


def test_a_caption_says_the_margins_or_that_there_are_none():
    words = caption(bode_figure("b", "Loops.", [curve(THIRD, "first"), curve(4 * THIRD, "second")]))
    assert "first: gain margin 6.02 dB, phase margin 27.1 degrees" in words
    assert "second: the closed loop is not stable, so that it has no margins." in words


def test_a_gain_that_may_fall_is_said_without_a_minus():
    falls = 5 * control.tf([1, 1], [1]) ** 2 * control.tf([1], [1, 0, 0, 0]) * control.tf([1], [0.02, 1]) ** 2
    margins = stability_margins(falls).margins
    fall, rise = (20 * abs(np.log10(one.value)) for one in (margins.gain_low, margins.gain_high))
    words = caption(bode_figure("b", "", [curve(falls)]))
    assert words.startswith(f"Gain margin {rise:.3g} dB (the gain may also fall by {fall:.3g} dB), phase margin")
    names = [
        name for mark in bode_figure("b", "", [curve(falls)]).panels[0].series for name in getattr(mark, "names", ())
    ]
    assert any(plain(name).startswith(f"gain may fall by {fall:.3g} dB") for name in names)
    alone = caption(bode_figure("b", "", [curve(control.tf([4], [1, -1]))]))
    assert alone.startswith("The gain may fall by 12 dB and rise without limit; phase margin")


def test_a_nichols_chart_holds_the_critical_point_of_a_loop_with_many_integrators():
    (panel,) = nichols_figure("n", "", [curve(control.tf([5, 10, 5], [1, 0, 0, 0]))]).panels
    assert panel.ylim[0] < -10 < 10 < panel.ylim[1] < 90


def test_the_margins_of_one_channel_of_several_are_told_with_those_of_all():
    words = caption(bode_figure("b", "Loops.", [curve(THIRD, multiloop_disk_margin=0.21)]))
    assert words.endswith("disk margin 0.378; disk margin of all channels at once 0.21.")


def test_a_computers_nyquist_frequency_has_a_line():
    figure = bode_figure("b", "", [curve(SAMPLED)])
    for panel in figure.panels:
        assert panel.vlines == pytest.approx([math.pi / 0.1])
    assert any(isinstance(mark, Guides) and "Nyquist" in mark.names[0] for mark in figure.panels[0].series)


def test_asymptotes_are_those_drawn_by_hand():
    corners = CornerFrequencies([0.0, -10.0], [-1.0], 100.0)  # 100 (s + 1) / (s (s + 10))
    at = np.array([0.01, 0.1, 1.0, 10.0, 100.0, 1000.0])
    assert asymptotic_gain(corners, at) == pytest.approx([60, 40, 20, 20, 0, -20])
    assert asymptotic_phase(corners, at) == pytest.approx([-90, -90, -45, -45, -90, -90])


def test_asymptotes_of_a_resonance_turn_over_its_damping():
    corners = CornerFrequencies([-0.1 + 1j * math.sqrt(0.99), -0.1 - 1j * math.sqrt(0.99)], [], 1.0)
    at = np.array([0.1, 10**-0.1, 1.0, 10**0.1, 10.0])
    assert asymptotic_gain(corners, at) == pytest.approx([0, 0, 0, -4, -40])
    assert asymptotic_phase(corners, at) == pytest.approx([0, 0, -90, -180, -180])


def test_asymptotes_know_the_right_half_plane():
    corners = CornerFrequencies([-1.0], [1.0], -1.0)  # (1 - s) / (1 + s), an all-pass
    at = np.array([1e-3, 1.0, 1e3])
    assert asymptotic_gain(corners, at) == pytest.approx([0, 0, 0])
    assert asymptotic_phase(corners, at) == pytest.approx([0, -90, -180])
    figure = bode_figure("b", "", [curve((1 - s) / (1 + s), margins=False, corners=corners)], asymptotes=True)
    drawn, line = series(figure.panels[1])
    assert np.abs(np.interp(line.x, drawn.x, drawn.y) - line.y).max() < 12  # degrees: a pole's is 5.7 off, here are two


def test_the_first_frequency_may_be_zero_and_a_gap_may_be_anywhere():
    omega = np.array([0.0, 0.5, 1.0, 2.0])
    one = FrequencyCurve("L", omega, [1.0, 0.5, np.nan, 0.1])
    gain = series(bode_figure("b", "", [one]).panels[0], "L")[0]
    assert list(gain.x) == [0.5, 1.0, 2.0]
    assert np.isnan(gain.y[1])


def test_a_bound_shades_what_a_gain_must_not_reach():
    figure = bode_figure("b", "", [curve(THIRD)], bounds=[GainBound("no", [0.1, 10.0], [2.0, 0.5])])
    (area,) = (mark for mark in figure.panels[0].series if isinstance(mark, Area))
    assert area.y[:2] == pytest.approx([20 * math.log10(2.0), 20 * math.log10(0.5)])
    assert area.y[2:].min() > figure.panels[0].ylim[1]


@pytest.mark.parametrize("make", [bode_figure, nyquist_figure, nichols_figure])
def test_the_same_picture_has_the_same_bytes_and_numbers(make):
    one, other = (make("p", "", [curve(THIRD), curve(SAMPLED, "sampled")]) for _ in range(2))
    assert draw(one) == draw(other)
    rows = [row for row in one.numbers.rows if row[0] == "L"]
    assert len(rows) == 1501
    assert complex(*rows[700][-2:]) == curve(THIRD).values[700]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: FrequencyCurve("L", [2.0, 1.0], [1.0, 1.0]), "falls"),
        (lambda: FrequencyCurve("L", [], []), "at least one frequency|two or more frequencies"),
        (lambda: FrequencyCurve("L", [-1.0, 1.0], [1.0, 1.0]), "from zero on"),
        (lambda: FrequencyCurve("L", [1.0, 40.0], [1.0, 1.0], 0.1), "Nyquist's frequency pi / h = 31.4159 rad/s"),
        (lambda: FrequencyCurve("L", [1.0, 2.0], [1.0]), "an answer for each of 2 frequencies"),
        (lambda: FrequencyCurve("L", [1.0, 2.0], [1.0, np.inf]), "NaN for a gap"),
        (lambda: bode_figure("b", "", []), "at least one curve"),
        (lambda: bode_figure("b", "", [FrequencyCurve("L", [1.0, 2.0], [0.0, 0.0])]), "neither zero nor a gap"),
        (
            lambda: bode_figure("b", "", [curve(SAMPLED, corners=CornerFrequencies([], [], 1.0))], asymptotes=True),
            "is sampled",
        ),
        (lambda: CornerFrequencies([], [], 0.0), "not zero"),
        (lambda: GainBound("b", [1.0, 2.0], [1.0, -1.0]), "a positive factor"),
        (lambda: Disk.of_Ms(0.9), "above one"),
        (lambda: Disk("d", 0.0, 0.0), "radius"),
        (lambda: nyquist_figure("n", "", [curve(THIRD)], unstable_poles=-1), "unstable poles"),
        (lambda: nyquist_figure("n", "", [curve(THIRD)], reach=0.0), "reach"),
    ],
)
def test_bad_input_gets_a_sentence(call, words):
    with pytest.raises(ValueError, match=words):
        call()
