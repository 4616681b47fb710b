"""Time axes that show an early motion beside a long rest: cut or logarithmic, in print and on a live page."""

import json

import numpy as np
import pytest

from tests.support.browsers import needs_node
from tests.support.live_figures import places_of, plain, said
from workbench.report.figures.curves import crop_curves, drawn_points, thin_curves
from workbench.report.figures.figure_sheet import draw_all
from workbench.report.figures.rulers import Ruler
from workbench.report.figures.style import said_on_axis
from workbench.report.table_text import plain as text_of
from workbench.study.document.figure import Figure, Panel, Series

T = np.linspace(0.0, 100.0, 20001)
CUT = Ruler("linear", 0.0, 100.0, cut=4.0)


def test_both_parts_of_a_cut_ruler_are_even_and_take_one_half_each():
    assert CUT.share([0, 1, 2, 4, 28, 52, 100]) == pytest.approx([0, 0.125, 0.25, 0.5, 0.625, 0.75, 1])


def test_the_numbers_at_a_cut_ruler_stand_on_both_sides_and_do_not_meet():
    ticks = CUT.ticks(7, 200.0)
    near, far = ([place for place in ticks.places if (place > 4) == side] for side in (False, True))
    assert len(near) >= 2
    assert len(far) >= 2
    assert list(ticks.places) == sorted(ticks.places)
    assert np.diff(200 * CUT.share(ticks.places)).min() > 8  # points: the size of the letters


def test_half_of_the_drawn_points_are_before_the_cut_though_few_of_the_kept_times_are():
    series = Series("a", T, np.sin(40 * T))
    panel = Panel("y", (series,), xlim=(0.0, 100.0), xcut=4.0)
    x, _ = drawn_points(series, panel, Figure("f", "", (panel,)))
    assert 0.45 < np.mean(x <= 4.0) < 0.55
    even = Panel("y", (series,), xlim=(0.0, 100.0))
    assert np.mean(drawn_points(series, even, Figure("f", "", (even,)))[0] <= 4.0) < 0.1
    log = Panel("y", (Series("a", T[1:], T[1:]),), xlim=(0.01, 100.0), xscale="log")
    first = drawn_points(log.series[0], log, Figure("f", "", (log,)))[0]
    assert np.mean(first < 1.0) > 0.2  # of four decades two are below 1 s, with 200 of 20,000 times


def test_an_uneven_time_axis_says_so():
    curve = (Series("a", T + 0.1, T),)
    assert text_of(said_on_axis(Panel("y", curve, xlim=(0, 100), xcut=4.0))) == "time [s], compressed after 4 s"
    assert text_of(said_on_axis(Panel("y", curve, xscale="log"))) == "time [s], logarithmic"
    assert said_on_axis(Panel("y", curve)) == "time [s]"
    assert said_on_axis(Panel("y", curve, "frequency [Hz]", xscale="log")) == "frequency [Hz]"  # as is usual there


@pytest.mark.parametrize(
    ("xlim", "xscale", "cut"), [(None, "linear", 4.0), ((1, 3), "linear", 3.0), ((1, 9), "log", 4.0)]
)
def test_a_cut_outside_the_limits_or_on_a_logarithmic_axis_is_refused(xlim, xscale, cut):
    with pytest.raises(ValueError, match=r"`Panel\(xcut=...\)` must be a number between the two of `xlim`"):
        Panel("y", (Series("a", T + 1, T),), xlim=xlim, xscale=xscale, xcut=cut)


@needs_node
@pytest.mark.parametrize("ruler", [CUT, Ruler("log", 0.01, 100.0)], ids=["cut", "log"])
def test_a_live_page_thins_and_places_a_curve_on_an_uneven_ruler_as_in_print(ruler):
    x = T[1:] + 0.003 * np.sin(1e3 * T[1:])
    y = np.sin(7 * x)
    printed = {"scale": ruler.scale, "low": ruler.low, "high": ruler.high, "cut": ruler.cut, "fixed": True}
    body = f"""const ruler = new LiveRuler({json.dumps(printed)}, 0, 1, {{ size: 8 }});
        const [x, y] = given.map(numbers), [first, last] = windowPlaces(x, ruler.low, ruler.high);
        const places = [...thinnedPlaces(x, y, first, last, 300, ruler.straight)];
        return [places, places.map((place) => ruler.at(x[place]))];"""
    places, shares = said(body, [plain(x), plain(y)])
    curve = crop_curves((x, y), (ruler.low, ruler.high))
    drawn = thin_curves(curve, 300, ruler.straight(curve[0]))
    assert places == places_of(x, drawn[0])
    assert shares == pytest.approx(ruler.share(drawn[0]).tolist(), abs=1e-12)


def test_the_plate_of_a_cut_panel_keeps_the_cut_and_its_limits():
    panel = Panel("y", (Series("a", T, T),), xlim=(0.0, 100.0), xcut=4.0)
    x = draw_all([Figure("f", "", (panel,))])["f"].plate["panels"][0]["x"]
    assert (x["cut"], x["low"], x["high"], x["fixed"], x["time"]) == (4.0, 0.0, 100.0, True, True)
