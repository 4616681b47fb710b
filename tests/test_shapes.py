"""Bars, points and maps of cells as data, and panels whose sides have names."""

import numpy as np
import pytest

from workbench.notation.formula import symbol
from workbench.study.document import Bars, Code, Figure, HeatMap, Panel, Points, Series


def test_what_is_given_is_kept_and_cannot_be_changed():
    ends = np.array([1.0, 2.0])
    bars = Bars("a", [0, 1], ends, low=[0.5, -np.inf], high=[np.nan, 3.0])
    ends[0] = 9
    assert bars.ends.tolist() == [1, 2]
    assert bars.starts.tolist() == [0, 0]
    assert bars.low.tolist() == [0.5, -np.inf]
    with pytest.raises(ValueError, match="read-only"):
        bars.ends[0] = 9


def test_what_has_no_interval_has_one_that_is_not_known():
    points = Points("", [1.0], [2.0], (symbol("K"),))
    assert np.isnan([points.xlow, points.xhigh, points.ylow, points.yhigh]).all()


REFUSED = {
    "an endless bar": (lambda: Bars("a", [0], [np.inf]), "ends that is finite, or NaN"),
    "bars without places": (lambda: Bars("a", [0, 1], [1.0]), "one length"),
    "a shade beyond the colour": (lambda: Bars("a", [0], [1.0], shade=1.5), "shade from 0 to 1.*got 1.5"),
    "a bar of no thickness": (lambda: Bars("a", [0], [1.0], thick=0), "thickness above 0"),
    "texts for some bars": (lambda: Bars("a", [0, 1], [1.0, 2.0], texts=("x",)), "a text for each.*got 1"),
    "intervals for some bars": (lambda: Bars("a", [0, 1], [1.0, 2.0], low=[0.0]), "a low for each of 2"),
    "a style that there is not": (lambda: Bars("a", [0], [1.0], style=9), "style of 0 to 7"),
    "names for some points": (lambda: Points("", [1.0, 2.0], [1.0, 2.0], ("a",)), "one for each of its points"),
    "a name that is no label": (
        lambda: Points("", [1.0], [1.0], (Code("a"),)),
        r"of `str` or `Number`.*got a `Code` at \[0\]",
    ),
    "a point at infinity": (lambda: Points("", [np.inf], [1.0]), "x that is finite"),
    "a map of one row": (lambda: HeatMap([1.0, 2.0]), r"numbers \(r, c\)"),
    "an infinite cell": (lambda: HeatMap([[np.inf]]), "finite or NaN"),
    "bars in no row": (lambda: Panel("y", (Bars("a", [0], [1.0]),)), "name these by `ynames=`"),
    "a row without a name": (lambda: Panel("y", (Bars("a", [0, 1], [1.0, 2.0]),), ynames=("a",)), "1 names"),
    "names and limits": (lambda: Panel("y", (HeatMap([[1.0]]),), ynames=("a",), ylim=(0, 1)), "no yscale and no ylim"),
    "names on a logarithm": (
        lambda: Panel("y", (HeatMap([[1.0]]),), xnames=("a",), ynames=("a",), xscale="log"),
        "'log'",
    ),
    "bars from zero on a logarithm": (
        lambda: Panel("y", (Bars("a", [0], [1.0]),), ynames=("a",), xscale="log"),
        "> 0, which have a logarithm",
    ),
    "a name that is a number": (
        lambda: Panel("y", (HeatMap([[1.0]]),), ynames=(1,)),
        r"of `str` or `Number`.*got 1 at \[0\]",
    ),
    "numbers that are no table": (
        lambda: Figure("f", "", (Panel("y", (Series("a", [0.0], [1.0]),)),), numbers="1,2"),
        "numbers=.*must be a `Table`",
    ),
}


@pytest.mark.parametrize(("made", "why"), REFUSED.values(), ids=REFUSED.keys())
def test_what_cannot_be_drawn_is_refused_in_a_sentence(made, why):
    with pytest.raises(ValueError, match=why):
        made()
