"""Curves that a page draws again: thinned, placed and looked at as the printed ones, on rulers that grow."""

import numpy as np
import pytest

from tests.support.browsers import needs_node
from tests.support.live_figures import places_of, plain, said
from workbench.report.figures.curves import crop_curves, thin_curves
from workbench.report.figures.style import line_of
from workbench.study.document.document import Series


def odd_curves(seed):
    """Curves of all kinds: smooth and chattering, with gaps alone and in a row, equal numbers, and running back."""
    random = np.random.default_rng(seed)
    for _ in range(40):
        n = int(random.integers(2, 3000))
        noise = random.normal(size=n)
        y = [np.sin(np.arange(n) / 50), noise, np.round(noise)][random.integers(3)]
        y = np.where(random.random(n) < random.choice([0.0, 0.02, 0.5]), np.nan, y)
        first = int(random.integers(0, n))
        y[first : first + int(random.integers(0, n))] = np.nan
        x = np.cumsum(random.random(n)) if random.random() < 0.7 else random.normal(size=n)
        yield x, y, int(random.choice([120, 385, 600]))


@needs_node
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.heavy) for seed in (1, 2))])
def test_a_curve_is_thinned_to_the_very_points_that_are_printed(seed):
    cases = list(odd_curves(seed))
    body = "return given.map(([x, y, n]) => [...thinnedPlaces(numbers(x), numbers(y), 0, x.length, n)]);"
    told = said(body, [(plain(x), plain(y), points) for x, y, points in cases])
    for (x, y, points), places in zip(cases, told, strict=True):
        assert places == places_of(x, thin_curves((x, y), points)[0])


@needs_node
def test_a_close_view_spends_its_points_as_the_printed_one():
    random = np.random.default_rng(5)
    cases = []
    for _ in range(60):
        n = int(random.integers(2, 2000))
        x = np.cumsum(random.random(n))
        low = float(random.choice([x[random.integers(n)], random.uniform(-50, x[-1] + 50)]))
        cases.append((x, random.normal(size=n), (low, low + float(random.uniform(1, 500)))))
    body = """return given.map(([x, y, limits]) => {
        const [first, last] = windowPlaces(numbers(x), ...limits);
        return [...thinnedPlaces(numbers(x), numbers(y), first, last, 120)];
    });"""
    told = said(body, [(plain(x), plain(y), limits) for x, y, limits in cases])
    for (x, y, limits), places in zip(cases, told, strict=True):
        assert places == places_of(x, thin_curves(crop_curves((x, y), limits), 120)[0])


@needs_node
def test_a_curve_chatters_where_the_printed_one_does():
    t = np.linspace(0, 10, 400)
    cases = [np.sin(t), np.sin(200 * t), np.sin(40 * t), 0 * t, np.where(t > 5, np.nan, np.sin(200 * t)), t[:90] % 0.1]
    told = said("return given.map(y => chatters(numbers(y), [...y.keys()]));", [plain(y) for y in cases])
    assert told == [line_of(Series("a", t[: len(y)], y), y)["linewidth"] == 0.5 for y in cases]
    assert len(set(told)) == 2


@needs_node
def test_a_path_has_gaps_steps_and_two_decimals():
    body = """const same = x => x, down = y => 100 - y, places = [0, 1, 2, 3, 4];
    const x = numbers([0, 1.006, 2, 3, 123456.789]), y = numbers([5, 6.1, null, 100.25, 1e9]);
    return [pathOf(same, down, x, y, places, false), pathOf(same, down, x, y, places, true)];"""
    line, steps = said(body)
    assert line == "M0 95L1.01 93.9M3 -0.25L100000 -100000"
    assert steps == "M0 95H1.01V93.9H2M3 -0.25H100000V-100000"


RULERS = [
    ({"scale": "linear", "low": -1.1, "high": 2.2, "fixed": False}, (-1.0, 2.0), (-1.1, 2.2)),
    ({"scale": "linear", "low": -1.1, "high": 2.2, "fixed": False}, (-1.0, 5.3), (-1.1, 6.0)),
    ({"scale": "linear", "low": -1.1, "high": 2.2, "fixed": False}, (-720.0, 0.0), (-800.0, 2.2)),
    ({"scale": "linear", "low": -1.1, "high": 2.2, "fixed": True}, (-720.0, 9.0), (-1.1, 2.2)),
    ({"scale": "linear", "low": -1.1, "high": 2.2, "fixed": False}, (1e9, -1e9), (-1.1, 2.2)),  # nothing is drawn
    ({"scale": "log", "low": 0.02, "high": 3.0, "fixed": False}, (0.1, 3.0), (0.02, 3.0)),
    ({"scale": "log", "low": 0.02, "high": 3.0, "fixed": False}, (2e-5, 31.0), (1e-5, 100.0)),
]


@needs_node
@pytest.mark.parametrize(("ruler", "numbers", "wanted"), RULERS)
def test_a_ruler_grows_to_a_mark_beyond_the_numbers_and_never_shrinks(ruler, numbers, wanted):
    assert said("return grownRange(...given, 5);", [ruler, *numbers]) == pytest.approx(wanted)


@needs_node
def test_marks_are_nice_few_and_within_the_ruler():
    random = np.random.default_rng(2)
    cases = []
    for _ in range(200):
        low = float(random.normal() * 10.0 ** random.integers(-6, 7))
        cases.append((low, low + float(random.uniform(0.1, 9) * abs(low) + 1e-9), int(random.integers(2, 10))))
    told = said('return given.map(([low, high, n]) => rulerMarks("linear", low, high, n, 99));', cases)
    for (low, high, most), ruler in zip(cases, told, strict=True):
        places = np.array([place for place, _, _ in ruler["marks"]])
        assert 1 <= len(places) <= most + 1
        assert ((places >= low - 1e-9 * (high - low)) & (places <= high + 1e-9 * (high - low))).all()
        written = np.array([float(text.replace("−", "-")) for _, text, _ in ruler["marks"]]) * 10.0 ** ruler["power"]
        assert written == pytest.approx(places, abs=1e-9 * (high - low), rel=1e-12)
        if len(places) > 1:
            step = np.diff(places)[0]
            assert f"{step:.1e}"[:3] in ("1.0", "2.0", "2.5", "5.0")


@needs_node
def test_numbers_share_a_power_of_ten_and_logarithmic_ones_are_powers():
    texts = 'const texts = ({power, marks}) => [power, ...marks.map(([, text, raised]) => text + "^" + raised)];'
    linear, wide, small, log = said(
        f"""{texts} return [rulerMarks("linear", -60, 60, 4, 9), rulerMarks("linear", -2e5, 2e5, 5, 9),
        rulerMarks("linear", 0, 0.0004, 5, 9), rulerMarks("log", 1e-6, 100, 5, 9)].map(texts);"""
    )
    assert linear == [0, "−50^", "0^", "50^"]
    assert wide == [5, "−2^", "−1^", "0^", "1^", "2^"]
    assert small == [-4, "0^", "1^", "2^", "3^", "4^"]
    assert log == [0, "10^−6", "10^−4", "10^−2", "10^0", "10^2"]
