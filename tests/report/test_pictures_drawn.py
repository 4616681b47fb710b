"""Pictures as they are drawn: nothing overlaps or leaves the sheet, in the worst cases that a report may bring."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from tests.support.drawn_pictures import told
from tests.support.sensitivity_pictures import NOTE, indices, made, morris_effects, tornado_of
from workbench.core.notation.formula import symbol
from workbench.report.figures.boxes import ink_on, tint
from workbench.report.figures.figure_sheet import draw
from workbench.report.figures.pen import Extent, Pen, Rectangle, extent, fold_label
from workbench.report.figures.points import place_names
from workbench.report.figures.rulers import size_of
from workbench.report.folder import write
from workbench.report.pictures import morris_plane, rank_figure, sobol_bars, tornado_figure
from workbench.study.document.document import Bars, Colophon, Document, Figure, Panel, Points, Section

LONG = tuple(f"controller.model.links[{k}].{what}" for k in range(4) for what in ("mass", "com", "inertia"))
LONG += tuple(f"the {k}th coefficient of friction of the second joint of the arm μ̂" for k in range(8))
SHORT = ("K", "phi", "gamma", "m_1", "m_2", "l_1", "l_2", "Q", "R", "kappa", "eta", "F_v", "F_c", "delay", "payload")
SHORT += ("noise", "bias", "g", "Lambda_1", "T")
FORMULAS = {name: symbol(name) for name in SHORT}


def steep(u):
    return 1e-7 * (u @ 0.8 ** np.arange(len(u.T)) + 3 * u[:, 0] * u[:, -1])


def outliers(u):
    return 1e3 * u[:, 0] * u[:, 1] + steep(u) / 1e-7


WORST = {
    "twenty long rows": lambda: tornado_figure("f", "", tornado_of(steep, LONG), NOTE, "N*m/s"),
    "twenty long bars": lambda: sobol_bars("f", "", indices(steep, LONG, base=8), NOTE),
    "three outputs": lambda: sobol_bars(
        "f", "", indices(lambda u: np.stack([steep(u), u[:, 0], -u[:, 1]], 1), LONG, ("a", "b", "c"), base=8), NOTE
    ),
    "a crowd of names": lambda: morris_plane("f", "", morris_effects(steep, SHORT), NOTE, labels=FORMULAS),
    "a crowd of numbers": lambda: morris_plane("f", "", morris_effects(steep, LONG), NOTE),
    "all names at one place": lambda: morris_plane("f", "", morris_effects(lambda u: u.sum(axis=1), SHORT), NOTE),
    "two factors far beyond all others": lambda: morris_plane("f", "", morris_effects(outliers, SHORT), NOTE),
    "one factor": lambda: sobol_bars("f", "", indices(lambda u: -1e9 - u[:, 0], ("a",)), NOTE),
    "one long word": lambda: rank_figure("f", "", {"w" * 120: [1.0]}, NOTE),
}


@pytest.mark.parametrize("kind", WORST, ids=lambda kind: kind)
def test_no_words_overlap_or_leave_the_sheet(kind, monkeypatch):
    figure = WORST[kind]()
    width, height = (72 * inches for inches in size_of(figure))
    found = told(figure, monkeypatch)
    assert len(found) > 3
    for _, (left, bottom, right, top) in found:
        assert 0 <= left < right <= width
        assert 0 <= bottom < top <= height
    for k, (said, (left, bottom, right, top)) in enumerate(found):
        for other, (l2, b2, r2, t2) in found[:k]:
            assert min(right, r2) <= max(left, l2) or min(top, t2) <= max(bottom, b2), (said, other)


@pytest.mark.parametrize("kind", WORST, ids=lambda kind: kind)
def test_the_tallest_figure_fits_a_page_with_its_caption(kind):
    assert size_of(WORST[kind]())[1] <= 7.6


@pytest.mark.parametrize("seed", range(8))
def test_names_of_points_stay_apart_and_within_their_panel(seed):
    rng = np.random.default_rng(seed)
    within = Rectangle(10.0, 20.0, 400.0, 220.0)
    points = (10, 20) + rng.uniform(0, 1, (20, 2)) ** rng.integers(1, 9) * (400, 220)
    sizes = [Extent(width, 6.0, 2.0) for width in rng.uniform(5, 60, 20)]
    corners = place_names(points, sizes, points, np.zeros((0, 4)), within)
    ends = corners + [(size.width, size.height) for size in sizes]
    assert (corners >= (10, 20)).all()
    assert (ends <= (410, 240)).all()
    for i in range(20):
        for j in range(i):
            assert (np.minimum(ends[i], ends[j]) <= np.maximum(corners[i], corners[j])).any()


def test_a_name_stands_beside_its_point_where_there_is_room():
    point = np.array([[50.0, 50.0]])
    (corner,) = place_names(point, [Extent(20.0, 6.0, 2.0)], point, np.zeros((0, 4)), Rectangle(0, 0, 100, 100))
    assert np.hypot(*(np.clip([50, 50], corner, corner + (20, 8)) - [50, 50])) < 8


def test_a_name_stands_nearer_to_its_own_point_than_to_its_neighbour():
    points = np.array([[50.0, 50.0], [56.0, 50.0]])
    sizes = [Extent(8.0, 6.0, 2.0)] * 2
    corners = place_names(points, sizes, points, np.zeros((0, 4)), Rectangle(0, 0, 100, 100))
    for corner, own, other in zip(corners, points, points[::-1], strict=True):
        away = [np.hypot(*(np.clip(at, corner, corner + (8, 8)) - at)) for at in (own, other)]
        assert away[0] < away[1]


def strokes(figure, monkeypatch):
    """How often the pen drew a line of each number of points."""
    drawn = []
    line = Pen.line
    monkeypatch.setattr(Pen, "line", lambda pen, x, y, *look: drawn.append(len(x)) or line(pen, x, y, *look))
    draw(figure)
    return drawn


def test_an_endless_interval_ends_in_an_arrow_and_an_unknown_one_is_not_drawn(monkeypatch):
    def heads(low, high):
        bars = Bars("a", [0.0], [1.0], [0.0], low=[low], high=[high])
        return strokes(Figure("f", "", (Panel("", (bars,), ynames=("a",), xlim=(-1, 2)),)), monkeypatch).count(3)

    least = heads(np.nan, np.nan)  # the two axes
    assert heads(0.5, 1.5) == least
    assert heads(0.5, np.inf) == least + 1
    assert heads(-5, 5) == heads(-np.inf, np.inf) == least + 2


def test_a_point_beyond_the_limits_is_neither_drawn_nor_named(monkeypatch):
    points = Points("", [0.5, 2.0, np.nan], [0.5, 0.5, 0.5], ("inside", "outside", "nowhere"))
    names = [said for said, _ in told(Figure("f", "", (Panel("", (points,), xlim=(0, 1)),)), monkeypatch)]
    assert "inside" in names
    assert not {"outside", "nowhere"} & set(names)


def test_a_bar_that_is_not_known_leaves_its_row_empty(monkeypatch):
    def outlines(end):
        return strokes(
            Figure("f", "", (Panel("", (Bars("", [0.0, 1.0], [1.0, end], [0.0, 0.0]),), ynames=("a", "b")),)),
            monkeypatch,
        ).count(5)

    assert (outlines(2.0), outlines(np.nan)) == (2, 1)


@pytest.mark.parametrize("style", range(12))
def test_letters_stand_out_from_what_they_are_printed_on(style):
    """By WCAG's contrast, which asks 3 of large letters."""

    def light(color):
        parts = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in to_rgb(color)]
        return float(np.dot(parts, (0.2126, 0.7152, 0.0722)))

    for shade in np.linspace(0, 1, 21):
        lights = sorted((light(tint(style, shade)), light(ink_on(style, shade))))
        assert (lights[1] + 0.05) / (lights[0] + 0.05) > 3


def test_shades_of_one_colour_fall_apart_in_grey_too():
    greys = [float(np.dot(to_rgb(tint(0, shade)), (0.299, 0.587, 0.114))) for shade in (0.25, 1.0)]
    assert greys[0] - greys[1] > 0.3


@pytest.mark.parametrize("kind", made(NOTE), ids=lambda kind: kind)
def test_the_same_picture_gives_the_same_bytes(kind):
    assert draw(made(NOTE)[kind]()) == draw(made(NOTE)[kind]())


def test_rows_points_and_bars_are_named(monkeypatch):
    def texts(mark, **panel):
        return [said for said, _ in told(Figure("f", "", (Panel("", (mark,), xlabel="", **panel),)), monkeypatch)]

    points = Points("", [1.0, 2.0], [3.0, 4.0], ("a", symbol("K")), xlow=[0.5, np.nan], xhigh=[np.inf, np.nan])
    assert {"a", "$K$"} <= set(texts(points, xlim=(0, 3)))
    bars = Bars("", [0.0, 1.0], [1.0, 2.0], [0.0, 0.0], texts=("x", "y"))
    assert {"x", "y", "a", "b"} <= set(texts(bars, ynames=("a", "b")))


def test_a_long_name_is_broken_where_a_reader_would_and_loses_no_letter():
    name = "controller.model.links[0].centre of gravity $5 in the frame"
    lines = fold_label(name.replace("$", r"\$"), 8.0, 60.0).split("\n")
    assert "".join(lines).replace(" ", "").replace("\\", "") == name.replace(" ", "")
    assert all(extent(line, 8.0).width <= 60 for line in lines)
    assert lines[0] == "controller.model."
    assert len(fold_label("w" * 90, 8.0, 60.0).split("\n")) > 5


def test_the_numbers_of_a_figure_are_written_beside_it(tmp_path):
    figure = rank_figure("ranks", "Who wins.", {"PID": [0.25, 0.75], "SMC": [0.75, 0.25]}, NOTE)
    write(Document("t", "q", "m", (Section("s", (figure,)),), Colophon("c", "0")), tmp_path / "report")
    held = (tmp_path / "report" / "figures" / "ranks.csv").read_text().splitlines()
    assert held == ["law,rank 1,rank 2", "SMC,0.75,0.25", "PID,0.25,0.75"]
    write(Document("t", "q", "m", (Section("s", ()),), Colophon("c", "0")), tmp_path / "report")
    assert not (tmp_path / "report" / "figures").exists()
