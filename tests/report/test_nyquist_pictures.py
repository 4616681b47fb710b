"""Nyquist and Nichols pictures of loop gains: turns, circles and lines, and what cannot be told."""

import math

import control
import numpy as np
import pytest

from tests.support.loop_gain_curves import LOOPS, RESONANT, THIRD, UNSTABLE, caption, curve, s, series
from workbench.report.figures.figure_sheet import draw_all
from workbench.report.loop_pictures import bode_figure, curve_turns, nichols_figure, nyquist_figure
from workbench.report.table_text import plain
from workbench.study.document.figure import Arrows, Guides, Points, Series
from workbench.study.document.frequency_curves import FrequencyCurve
from workbench.study.document.gain_bounds import Disk


def test_a_turn_that_a_coarse_grid_cannot_tell_is_said():
    omega = np.array([1.0, 2.0, 3.0])
    one = FrequencyCurve("L", omega, [1.0, -1.0 + 0.1j, 1.0])
    assert "Between 1 and 2 rad/s the phase turns by 174 degrees in one step" in caption(bode_figure("b", "", [one]))
    other = FrequencyCurve("slow", omega, [1.0, 0.5, 0.2])
    assert "L: between 1 and 2 rad/s the phase" in caption(bode_figure("b", "", [other, one]))


@pytest.mark.parametrize("name", LOOPS)
def test_turns_about_the_critical_point_are_those_of_python_control(name):
    system = LOOPS[name]
    one = curve(system, margins=False)
    theirs = control.nyquist_response(system, warn_encirclements=False, warn_nyquist=False)
    assert curve_turns(one.frequencies, one.values, one.period).clockwise == theirs.count


@pytest.mark.parametrize("name", LOOPS)
def test_turns_and_unstable_poles_give_those_of_the_closed_loop(name):
    system = LOOPS[name]
    one = curve(system, margins=False)
    limit = (lambda p: np.abs(p) > 1 + 1e-6) if system.dt else (lambda p: p.real > 1e-6)
    opened, closed = (int(limit(loop.poles()).sum()) for loop in (system, control.feedback(system)))
    assert curve_turns(one.frequencies, one.values, one.period).clockwise + opened == closed


def test_what_a_curve_cannot_tell_is_not_counted():
    omega = np.geomspace(0.1, 1.0, 50)
    assert "neither near zero" in curve_turns(omega, (1 / s)(1j * omega)).reason
    assert "gap" in curve_turns(omega, np.where(omega < 0.5, np.nan, 1.0)).reason
    crossing = np.geomspace(0.01, math.sqrt(3), 300)  # it ends where it is real, far beyond -1, and still moves
    assert "neither near zero" in curve_turns(crossing, (80 / (s + 1) ** 3)(1j * crossing)).reason
    jumps = np.array([1.0, 2.0, 3.0])
    assert "120 degrees" in curve_turns(jumps, [1.0, -2.0 + 0.1j, 0.1]).reason
    figure = nyquist_figure("n", "", [FrequencyCurve("L", omega, (1 / s)(1j * omega))])
    assert "are not counted" in caption(figure)


def test_a_caption_says_turns_closures_and_unstable_poles():
    assert "encircles −1 once, anticlockwise." in caption(nyquist_figure("n", "", [curve(UNSTABLE)], unstable_poles=1))
    words = caption(nyquist_figure("n", "", [curve(RESONANT)], unstable_poles=0))
    assert "encircles −1 twice, clockwise. At infinity it is closed by 1 half turn clockwise." in words
    assert "the closed loop has 2 unstable poles." in words
    assert "contradicts" in caption(nyquist_figure("n", "", [curve(UNSTABLE)], unstable_poles=0))


def test_the_circles_of_the_margins_touch_the_curve():
    one = curve(THIRD, frequencies=np.geomspace(0.01, 100, 20001))
    figure = nyquist_figure("n", "", [one])
    for mark in figure.panels[0].series:
        if isinstance(mark, Series) and ("Ms" in plain(mark.label) or "disk" in plain(mark.label)):
            centre, radius = (mark.x.min() + mark.x.max()) / 2, np.ptp(mark.x) / 2
            near = np.abs(one.values - centre).min()
            assert near == pytest.approx(radius, rel=1e-4)  # the curve has gaps of 1e-3


def test_a_nyquist_plot_has_axes_of_one_scale_and_marks_the_critical_point():
    figure = nyquist_figure("n", "", [curve(THIRD)], forbidden_disks=[Disk.of_Ms(1.4)])
    (sheet,) = draw_all([figure]).values()
    (panel,) = sheet.plate["panels"]
    across, up = (
        (panel[axis]["high"] - panel[axis]["low"]) / length for axis, length in zip("xy", panel["box"][2:], strict=True)
    )
    assert across == pytest.approx(up, rel=1e-9)
    assert any(
        isinstance(mark, Points) and mark.shape == "critical" and mark.x[0] == -1 for mark in figure.panels[0].series
    )
    assert {mark["look"] for mark in panel["series"]} >= {"line", "arrows", "area", "guides", "points"}


def test_arrowheads_point_to_higher_frequencies():
    one = curve(THIRD)
    for mark in nyquist_figure("n", "", [one]).panels[0].series:
        if isinstance(mark, Arrows) and mark.style == 0:
            for x, y, u, v in zip(mark.x, mark.y, mark.u, mark.v, strict=True):
                k = int(np.abs(one.values - (x + 1j * y)).argmin())
                along = one.values[k + 1] - one.values[k - 1]
                assert along.real * u + along.imag * v > 0


def test_a_curve_that_goes_to_infinity_is_cut_where_the_caption_says():
    figure = nyquist_figure("n", "", [curve(RESONANT)], reach=2.0)
    assert "The curve leaves the frame: it reaches a distance of" in caption(figure)
    assert "frame" not in caption(nyquist_figure("n", "", [curve(THIRD)]))
    drawn = [mark for mark in series(figure.panels[0]) if mark.style == 0]
    assert max(np.hypot(mark.x, mark.y).max() for mark in drawn) <= 8.0


def test_m_and_n_lines_have_the_gain_and_phase_of_t():
    figure = nichols_figure("n", "", [curve(THIRD)])
    (chart,) = (mark for mark in figure.panels[0].series if isinstance(mark, Guides))
    seen = 0
    for (x, y), name in zip(chart.lines, chart.names, strict=True):
        L = 10 ** (y / 20) * np.exp(1j * np.radians(x))
        with np.errstate(invalid="ignore"):  # gaps
            T = L / (1 + L)
        held = np.isfinite(T)
        if name.endswith("dB"):
            level = float(name.removesuffix(" dB").replace("−", "-"))
            assert np.allclose(20 * np.log10(np.abs(T[held])), level, atol=1e-6)  # dB: near -1 digits are lost
        else:
            wanted = float(name.removesuffix("°").replace("−", "-"))
            assert np.allclose(np.cos(np.angle(T[held]) - math.radians(wanted)), 1, atol=1e-6)
        seen += 1
    assert seen > 20


def test_a_nichols_plot_has_the_gain_over_the_phase():
    one = curve(RESONANT)
    drawn = series(nichols_figure("n", "", [one]).panels[0], "L")[0]
    assert np.allclose(10 ** (drawn.y / 20) * np.exp(1j * np.radians(drawn.x)), one.values, rtol=1e-9)
