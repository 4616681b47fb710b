"""Maps of poles, root loci and step responses: what they draw against python-control, and from the definition."""

import math

import control
import numpy as np
import pytest

from workbench.design import frequency, step_response
from workbench.report import loop_pictures
from workbench.report.figures.figure_sheet import draw_all
from workbench.report.loop_pictures import (
    PoleZeroSet,
    TimeResponse,
    impulse_figure,
    pole_zero_map,
    root_locus_figure,
    sampled_step_info,
    step_figure,
)
from workbench.report.loop_pictures.root_loci import branches
from workbench.report.table_text import plain
from workbench.study.document.figure import Band, Guides, Points, Series

s = control.tf("s")
THIRD = 1 / (s + 1) ** 3
RESONANT = (s + 1) / (s * (s + 5) * (s**2 + 0.4 * s + 4))


def caption(figure):
    return plain(figure.caption)


def guides(figure):
    (found,) = (mark for mark in figure.panels[0].series if isinstance(mark, Guides))
    return zip(found.lines, found.names, strict=True)


def test_a_map_has_crosses_at_poles_and_rings_at_zeros():
    figure = pole_zero_map("p", "", [PoleZeroSet("G", RESONANT.poles(), RESONANT.zeros())])
    poles, zeros = (mark for mark in figure.panels[0].series if isinstance(mark, Points))
    assert (poles.shape, zeros.shape) == ("pole", "zero")
    assert np.array_equal(poles.x + 1j * poles.y, RESONANT.poles())
    assert np.array_equal(zeros.x + 1j * zeros.y, RESONANT.zeros())


def test_rays_have_a_constant_damping_and_arcs_a_constant_natural_frequency():
    for (x, y), name in guides(pole_zero_map("p", "", [PoleZeroSet("G", RESONANT.poles())])):
        size = np.hypot(x, y)[1:-1] if "rad" in name else np.hypot(x, y)[1:]
        if "rad" in name:
            assert size == pytest.approx(np.full(len(size), float(name.split()[0])))
        elif name:
            assert -x[1:] / size == pytest.approx(np.full(len(size), float(name)))


def test_the_grid_of_a_sampled_plane_is_that_of_its_logarithm():
    h, seen = 0.1, 0
    poles = control.sample_system(RESONANT, h).poles()
    for (x, y), name in guides(pole_zero_map("p", "", [PoleZeroSet("G", poles, period=h)])):
        z = x + 1j * y
        root = np.log(z[np.abs(z) > 1e-6]) / h
        inside = np.abs(root.imag) < 0.999 * math.pi / h
        root = root[inside & (np.abs(root) > 1e-6)]
        if "rad" in name:
            assert np.abs(root) == pytest.approx(np.full(len(root), float(name.split()[0])), rel=2e-3)  # a rounded name
        elif name:
            assert -root.real / np.abs(root) == pytest.approx(np.full(len(root), float(name)))
        seen += bool(name)
    assert seen > 10


@pytest.mark.parametrize(("period", "poles"), [(None, [-1.0, -2.0]), (0.1, [0.5, 0.2]), (0.001, [0.99, 0.999])])
def test_a_plane_has_axes_of_one_scale(period, poles):
    (sheet,) = draw_all([pole_zero_map("p", "", [PoleZeroSet("G", poles, period=period)])]).values()
    (panel,) = sheet.plate["panels"]
    across, up = (
        (panel[axis]["high"] - panel[axis]["low"]) / length for axis, length in zip("xy", panel["box"][2:], strict=True)
    )
    assert across == pytest.approx(up, rel=1e-9)


def test_branches_are_the_poles_of_python_control_in_a_continuous_order():
    gains = np.linspace(0.001, 60, 2000)
    theirs = control.root_locus_map(RESONANT, gains).loci
    figure = root_locus_figure("r", "", "k", gains, theirs)
    paths = branches(theirs)
    assert np.allclose(np.sort_complex(paths), np.sort_complex(theirs), rtol=1e-12)
    steps = np.abs(np.diff(paths, axis=0)).max(axis=0)
    assert steps.max() < 0.6  # near a branch point poles move by the root of the step in gain
    lines = [mark for mark in figure.panels[0].series if isinstance(mark, Series) and mark.style == 0]
    assert len(lines) == 4


def test_shuffled_rows_give_the_same_branches():
    rng = np.random.default_rng(3)
    gains = np.linspace(0.001, 6, 300)
    theirs = control.root_locus_map(THIRD, gains).loci
    shuffled = np.array([rng.permutation(row) for row in theirs])
    paths, others = branches(theirs), branches(shuffled)
    match = [int(np.abs(others[0] - root).argmin()) for root in paths[0]]
    assert np.allclose(paths, others[:, match], atol=1e-9)


def test_the_limit_of_stability_is_where_rouths_test_has_it():
    gains = np.linspace(0.001, 20, 2001)
    figure = root_locus_figure("r", "", "k", gains, control.root_locus_map(THIRD, gains).loci, marked_values=[4.0])
    (at,) = (
        mark for mark in figure.panels[0].series if isinstance(mark, Points) and mark.label == "limit of stability"
    )
    assert np.abs(at.y) == pytest.approx([math.sqrt(3)] * 2, rel=1e-5)  # s^3 + 3 s^2 + 3 s + 1 + k: k = 8 there
    assert "limit of stability at k = 8, by interpolation" in caption(figure)
    (dots,) = (mark for mark in figure.panels[0].series if isinstance(mark, Points) and plain(mark.label) == "k = 4")
    assert np.abs(np.poly(dots.x + 1j * dots.y) - [1, 3, 3, 5]).max() < 1e-4  # on lines between gains 0.01 apart


def test_a_sampled_locus_crosses_the_unit_circle():
    plant = control.sample_system(1 / (s * (s + 1)), 0.5)
    gains = np.linspace(0.001, 6, 2001)
    poles = control.root_locus_map(plant, gains).loci
    figure = root_locus_figure("r", "", "k", gains, poles, period=0.5)
    (at,) = (
        mark for mark in figure.panels[0].series if isinstance(mark, Points) and mark.label == "limit of stability"
    )
    assert np.hypot(at.x, at.y) == pytest.approx(np.ones(2), abs=1e-5)
    limit = control.margin(plant)[0]
    assert f"k = {limit:.3g}" in caption(figure)


def test_a_row_without_poles_is_a_gap():
    poles = np.array([[-1.0], [np.nan], [-3.0], [-4.0]], dtype=complex)
    figure = root_locus_figure("r", "", "k", [1.0, 2.0, 3.0, 4.0], poles)
    line = next(mark for mark in figure.panels[0].series if isinstance(mark, Series))
    assert np.isnan(line.y[1])
    assert np.isfinite(line.y[[0, 2, 3]]).all()


@pytest.mark.parametrize(
    "system", [4 / (s**2 + s + 4), 1 / (s + 1), (1 - s) / (s + 1) ** 2, 10 * (s + 0.2) / ((s + 1) * (s + 2))]
)
def test_the_figures_of_a_step_are_those_of_python_control(system):
    t = np.linspace(0, 20, 4001)
    y = np.asarray(control.step_response(system, t).outputs)
    final = float(np.real(system.dcgain()))
    ours, theirs = sampled_step_info(t, y, final), control.step_info(y, t, yfinal=final)
    sample = 2.01 * t[1]  # theirs are instants of the grid, at either end
    assert ours.rise_time == pytest.approx(theirs["RiseTime"], abs=sample)
    assert ours.settling_time == pytest.approx(theirs["SettlingTime"], abs=sample)
    assert ours.overshoot == pytest.approx(theirs["Overshoot"], abs=1e-9)
    assert ours.peak == pytest.approx(y.max() if final > 0 else y.min())


def test_figures_from_samples_and_certified_figures_have_names_of_their_own():
    rooms = (step_response, frequency, loop_pictures)
    names = [name for room in rooms for name in room.__all__]
    assert sorted(set(names)) == sorted(names)


def test_the_figures_of_a_second_order_step_are_those_of_its_formula():
    zeta, t = 0.3, np.linspace(0, 60, 200_001)
    wd = math.sqrt(1 - zeta**2)
    y = 1 - np.exp(-zeta * t) * (np.cos(wd * t) + zeta / wd * np.sin(wd * t))
    info = sampled_step_info(t, y, 1.0)
    assert info.overshoot == pytest.approx(100 * math.exp(-math.pi * zeta / wd), rel=1e-6)
    assert info.peak_time == pytest.approx(math.pi / wd, abs=t[1])


def test_a_response_that_has_not_settled_says_so():
    t = np.linspace(0, 1, 50)
    assert math.isnan(sampled_step_info(t, 1 - np.exp(-t), 1.0).settling_time)
    figure = step_figure("s", "", [TimeResponse("y", t, 1 - np.exp(-t), 1.0)])
    assert "No rise within these times" in caption(figure)
    assert "not settled within these times" in caption(figure)


def test_a_step_downwards_has_the_figures_of_the_one_upwards():
    t = np.linspace(0, 20, 2001)
    y = np.asarray(control.step_response(4 / (s**2 + s + 4), t).outputs)
    up, down = sampled_step_info(t, y, 1.0), sampled_step_info(t, 3 - 2 * y, 1.0)
    assert (down.rise_time, down.settling_time, down.overshoot) == pytest.approx(
        (up.rise_time, up.settling_time, up.overshoot)
    )


def test_a_step_shows_its_band_and_its_peak_and_a_computers_holds():
    t = np.linspace(0, 20, 2001)
    y = np.asarray(control.step_response(4 / (s**2 + s + 4), t).outputs)
    figure = step_figure("s", "", [TimeResponse("y", t, y, 1.0, "rad")])
    assert any(isinstance(mark, Band) and mark.low[0] == 0.98 for mark in figure.panels[0].series)
    (points,) = (mark for mark in figure.panels[0].series if isinstance(mark, Points))
    assert [plain(name).rpartition(" time")[0] or plain(name).split()[0] for name in points.names] == [
        "rise",
        "overshoot",
        "settling",
    ]
    (line,) = impulse_figure("i", "", [TimeResponse("y", t[:50], y[:50], period=0.01)]).panels[0].series
    assert line.look == "steps"


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: pole_zero_map("p", "", [PoleZeroSet("G", [], [])]), "a pole or a zero"),
        (lambda: pole_zero_map("p", "", [PoleZeroSet("G", [1.0]), PoleZeroSet("H", [1.0], period=0.1)]), "one plane"),
        (lambda: PoleZeroSet("G", [np.nan]), "finite"),
        (lambda: PoleZeroSet("G", [1.0], names=("a", "b")), "a name for each of 1"),
        (lambda: root_locus_figure("r", "", "k", [1.0], [[1.0]]), "two or more"),
        (lambda: root_locus_figure("r", "", "k", [1.0, 1.0], [[1.0], [1.0]]), "rising or falling"),
        (lambda: root_locus_figure("r", "", "k", [1.0, 2.0], [[1.0]]), "a row for each value"),
        (lambda: root_locus_figure("r", "", "k", [1.0, 2.0], [[1.0], [1.0]], marked_values=[3.0]), "within the values"),
        (lambda: TimeResponse("y", [0.0, 0.0], [1.0, 1.0]), "rising order"),
        (lambda: TimeResponse("y", [0.0, 1.0], [1.0]), "each of 2 times"),
        (lambda: step_figure("s", "", []), "at least one response"),
        (lambda: sampled_step_info([0.0, 1.0], [1.0, 1.0], 1.0), "a step of 0"),
    ],
)
def test_bad_input_gets_a_sentence(call, words):
    with pytest.raises(ValueError, match=words):
        call()
