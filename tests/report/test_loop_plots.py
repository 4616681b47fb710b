"""wb.bode and its like: systems of python-control in one call, in a notebook and as files."""

import control
import numpy as np
import pytest

import workbench as wb
from workbench.design.frequency import stability_margins
from workbench.design.linear.system_answers import system_answers, system_roots
from workbench.report.loop_pictures import nyquist_figure
from workbench.report.table_text import plain
from workbench.study.document.frequency_curves import FrequencyCurve
from workbench.study.document.gain_bounds import Disk
from workbench.study.document.plane_marks import Area

s = control.tf("s")
LOOP = 10 * (s + 1) / (s * (s + 5) * (s**2 + 0.04 * s + 4))
TWO = control.ss([[-1.0, 0.0], [0.0, -2.0]], np.eye(2), [[1.0, 1.0], [0.0, 1.0]], np.zeros((2, 2)))


def test_frequencies_by_default_show_a_resonance():
    found = system_answers(LOOP)
    near = np.abs(found.values[(found.frequencies > 1.9) & (found.frequencies < 2.1)])
    dense = np.abs(LOOP(1j * np.linspace(1.9, 2.1, 200_001)))
    assert near.max() == pytest.approx(dense.max(), rel=1e-3)
    assert np.allclose(found.values[:, 0, 0], LOOP(1j * found.frequencies))


def test_frequencies_of_a_sampled_system_end_at_nyquists():
    found = system_answers(control.sample_system(LOOP, 0.05))
    assert found.frequencies[-1] == pytest.approx(np.pi / 0.05, rel=1e-12)
    assert found.period == 0.05


def test_several_systems_share_a_picture_by_their_names():
    picture = wb.bode({"plant": LOOP, "in a computer": control.sample_system(LOOP, 0.05)})
    labels = [mark.label for mark in picture.figure.panels[0].series if hasattr(mark, "label")]
    assert labels[:2] == ["plant", "in a computer"]


@pytest.mark.parametrize("kind", ["svg", "pdf", "png"])
def test_a_picture_is_a_file_of_each_kind(tmp_path, kind):
    path = wb.nyquist(LOOP).savefig(tmp_path / f"loop.{kind}")
    assert path.read_bytes().startswith({"svg": b"<svg", "pdf": b"%PDF", "png": b"\x89PNG"}[kind])


def test_a_notebook_shows_a_picture_with_its_caption():
    picture = wb.nichols(0.01 * LOOP)
    assert picture._repr_html_().startswith("<figure><svg")
    assert "phase margin" in picture._repr_html_()
    assert "savefig" in repr(picture)


def test_asymptotes_of_a_system_end_on_its_curve():
    gain, line = [mark for mark in wb.bode(LOOP, asymptotes=True).figure.panels[0].series if hasattr(mark, "look")][:2]
    assert gain.y[0] == pytest.approx(line.y[0], abs=0.1)
    assert gain.y[-1] == pytest.approx(line.y[-1], abs=0.1)


def test_a_root_locus_has_python_controls_poles():
    gains = np.linspace(0.0, 5.0, 11)
    rows = wb.root_locus(LOOP, gains).figure.numbers.rows
    for k in gains:
        ours = np.sort_complex([row[2] + 1j * row[3] for row in rows if row[0] == k])
        theirs = np.sort_complex(control.feedback(k * LOOP).poles()) if k else np.sort_complex(LOOP.poles())
        assert np.allclose(ours, theirs, atol=1e-6)


def test_the_root_locus_of_many_poles_begins_at_them():
    poles = -np.arange(1.0, 25.0)  # whose multiplied-out polynomial has roots that are wrong by more than one
    chain = control.ss(np.diag(poles), np.ones((24, 1)), np.ones((1, 24)), 0.0)
    rows = wb.root_locus(chain, [0.0, 1.0]).figure.numbers.rows
    found = np.sort([row[2] for row in rows if row[0] == 0])
    np.testing.assert_allclose(found, poles[::-1], rtol=1e-10)
    assert np.abs(np.sort(np.roots(np.poly(poles)).real) - poles[::-1]).max() > 1e-3


def test_a_nyquist_plot_shades_the_disks_that_its_curve_must_not_enter():
    def areas(picture):
        return [mark for mark in picture.figure.panels[0].series if isinstance(mark, Area)]

    (area,) = areas(wb.nyquist(LOOP, forbidden_disks=(Disk("d", -2.0, 0.5),)))
    assert (area.x.min(), area.x.max()) == pytest.approx((-2.5, -1.5), rel=1e-4)  # of a polygon of some hundred sides
    assert not areas(wb.nyquist(LOOP))


@pytest.mark.parametrize("draw", [wb.nyquist, wb.nichols, lambda system: wb.bode(system, margins=True)])
def test_margins_that_are_refused_are_said_to_be(draw):
    caption = draw((1 - s) / (s + 2)).caption  # 1 + L is zero at infinity
    assert "No margins of L: " in caption
    assert "infinity" in caption


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: wb.bode(TWO), "singular_values"),
        (lambda: wb.bode(3.0), "python-control"),
        (lambda: wb.bode({}), "a mapping"),
        (lambda: wb.nyquist(LOOP, [2.0, 1.0]), "falls"),
        (lambda: wb.root_locus(s), "no more zeros than poles"),
        (lambda: wb.step_response(LOOP, until=-1.0), "until"),
        (lambda: wb.bode(LOOP).savefig("x.jpg"), "ending"),
    ],
)
def test_bad_input_gets_a_sentence(call, words):
    with pytest.raises(ValueError, match=words):
        call()


@pytest.mark.parametrize("first", [1.0, 10.0, 100.0])
def test_turns_are_not_counted_where_the_frequencies_begin_above_a_slow_pole(first):
    caption = wb.nyquist(control.tf([5], [1, -1]), frequencies=np.geomspace(first, 1e5, 2000)).caption  # closed: s = -4
    assert "are not counted" in caption
    assert "unstable" not in caption


def test_a_crossing_on_a_value_of_the_gain_is_seen():
    caption = wb.root_locus(control.tf([1], [1, -1]), np.linspace(0, 2, 201)).caption  # the pole is 1 - k
    assert "crosses the limit of stability at k = 1" in caption


@pytest.mark.parametrize("seed", range(6))
def test_an_integrator_that_rounding_moves_off_the_axis_is_none_of_the_unstable_poles(seed):
    turn = np.random.default_rng(seed).normal(size=(3, 3))
    space = control.ss(control.tf([1], [1, 3, 2, 0]))
    turned = control.ss(np.linalg.solve(turn, space.A @ turn), np.linalg.solve(turn, space.B), space.C @ turn, 0)
    roots = system_roots(turned)
    assert roots.zeros.size == 0  # in truth there are none; those of python-control lie at 1e5 to 1e13 rad/s
    assert roots.gain == pytest.approx(1.0)
    assert "With no unstable poles of L, the closed loop has no unstable poles." in plain(wb.nyquist(turned).caption)


def test_turns_that_contradict_the_certified_closed_loop_give_no_count_of_poles():
    words = plain(nyquist_figure("n", "", [curve_of(4 / (control.tf("s") + 1) ** 3)], unstable_poles=1).caption)
    assert "The closed loop is stable, but these turns do not show it" in words


def curve_of(system):
    omega = np.geomspace(1e-3, 1e3, 800)
    return FrequencyCurve("L", omega, system(1j * omega), margins=stability_margins(system))


def test_a_plant_of_200_states_has_its_answers_from_one_schur_form():
    A = np.diag(-np.linspace(0.1, 50, 200)) + np.diag(0.1 * np.ones(199), 1)
    space = control.ss(A, np.ones((200, 1)), np.ones((1, 200)) / 200, 0)
    found = system_answers(space)
    some = slice(None, None, 200)
    np.testing.assert_allclose(found.values[some, 0, 0], space(1j * found.frequencies[some]), rtol=1e-12)
