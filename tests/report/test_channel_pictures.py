"""Pictures of several channels, phase planes, describing functions and envelopes, against definitions and libraries."""

import math

import control
import numpy as np
import pytest

from workbench.design.chattering import BoundaryLayer, Relay, harmonic_balance
from workbench.report.loop_pictures import (
    Envelope,
    EquilibriumMark,
    FrequencyMatrix,
    PhaseCurve,
    VectorField,
    bode_envelope,
    characteristic_loci_figure,
    curve_turns,
    describing_function_figure,
    determinant_figure,
    envelope_figure,
    phase_figure,
    relative_gain_figure,
    singular_value_figure,
)
from workbench.report.loop_pictures.frequency_matrices import characteristic_curves, determinant_curve
from workbench.report.loop_pictures.phase_planes import zero_lines
from workbench.report.table_text import plain
from workbench.study.document.figure import Arrows, Band, Points, Series
from workbench.study.document.frequency_curves import FrequencyCurve

OMEGA = np.geomspace(1e-3, 1e3, 1501)
PLANT = control.ss(
    [[-1.0, 0.5, 0.0], [0.0, -2.0, 1.0], [0.3, 0.0, -0.5]],
    [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]],
    [[1.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
    np.zeros((2, 2)),
)
STEADY = np.array([[87.8, -86.4], [108.2, -109.6]])  # Skogestad and Postlethwaite (2005), the distillation column


def matrix(system, label="G", **more):
    return FrequencyMatrix(label, OMEGA, np.moveaxis(system(1j * OMEGA), -1, 0), **more)


def caption(figure):
    return plain(figure.caption)


def lines(figure):
    return [mark for mark in figure.panels[0].series if isinstance(mark, Series)]


def test_singular_values_are_those_of_python_control():
    figure = singular_value_figure("s", "", [matrix(PLANT)])
    theirs = control.singular_values_response(PLANT, OMEGA).magnitude.reshape(2, -1)
    for line, wanted in zip(lines(figure), theirs, strict=True):
        assert np.allclose(line.y, 20 * np.log10(wanted), rtol=0, atol=1e-7)  # dB: the least is 1e-7 of the largest


def test_relative_gains_of_the_distillation_column_are_the_published_ones():
    lag = 1 / (1 + 75j * OMEGA)
    figure = relative_gain_figure("r", "", FrequencyMatrix("G", OMEGA, STEADY * lag[:, None, None]))
    assert [round(float(line.y[0]), 1) for line in lines(figure)] == [35.1, 34.1, 34.1, 35.1]
    assert [line.label for line in lines(figure)] == ["y1, u1", "y1, u2", "y2, u1", "y2, u2"]


def test_where_a_plant_is_singular_its_relative_gains_have_a_gap():
    values = np.array([STEADY, [[1.0, 1.0], [1.0, 1.0]], STEADY], dtype=complex)
    figure = relative_gain_figure("r", "", FrequencyMatrix("G", [1.0, 2.0, 3.0], values))
    assert [bool(np.isnan(y)) for y in lines(figure)[0].y] == [False, True, False]


@pytest.mark.parametrize("k", [1.0, 30.0, -3.0, -30.0])
def test_the_turns_of_the_determinant_give_the_closed_loops_unstable_poles(k):
    loop = matrix(k * PLANT, "L")
    closed = control.feedback(k * PLANT, control.ss([], [], [], np.eye(2)))
    unstable = int((closed.poles().real > 0).sum())
    curve = determinant_curve(loop)
    assert np.allclose(curve.values, [np.linalg.det(np.eye(2) + L) for L in loop.values])
    assert curve_turns(OMEGA, curve.values, None, 0.0).clockwise == unstable
    loci = characteristic_curves(loop)
    assert sum(curve_turns(OMEGA, one.values, None, -1.0).clockwise for one in loci) == unstable
    words = caption(determinant_figure("d", "", [loop], unstable_poles=0))
    assert f"has {unstable or 'no'} unstable pole" in words


def test_characteristic_loci_are_continuous_and_have_the_determinant_as_their_product():
    loop = matrix(5 * PLANT, "L", disk_margin=0.4)
    curves = characteristic_curves(loop)
    product = np.prod([1 + one.values for one in curves], axis=0)
    assert np.allclose(product, determinant_curve(loop).values)
    assert max(np.abs(np.diff(one.values)).max() for one in curves) < 0.2
    words = caption(characteristic_loci_figure("c", "", loop))
    assert "L: disk margin 0.4." in words
    assert "encircle" not in words


def test_nullclines_lie_where_a_rate_is_zero_and_are_joined():
    x = np.linspace(-2, 2, 81)
    X, Y = np.meshgrid(x, x)
    across, up = zero_lines(x, x, X**2 + Y**2 - 1)
    held = np.isfinite(up)
    assert np.hypot(across[held], up[held]) == pytest.approx(np.ones(held.sum()), abs=0.05**2)  # a chord of a cell
    assert (~held).sum() == 1  # one line, closed
    assert (across[0], up[0]) == (across[-2], up[-2])


def test_a_phase_plane_has_arrows_along_the_field_and_the_run():
    x = np.linspace(-3, 3, 31)
    X, Y = np.meshgrid(x, x)
    t = np.linspace(0, 5, 3000)
    run = PhaseCurve("run", np.cos(t), -np.sin(t))
    figure = phase_figure("p", "", VectorField(x, x, Y, -X), "x", "y", [EquilibriumMark(0.0, 0.0, "centre")], [run])
    heads, field = (mark for mark in figure.panels[0].series if isinstance(mark, Arrows))
    assert np.allclose(field.u, field.y)
    assert np.allclose(field.v, -field.x)
    assert (heads.u * heads.y - heads.v * heads.x > 0).all()  # clockwise
    (points,) = (mark for mark in figure.panels[0].series if isinstance(mark, Points))
    assert points.names == ("centre",)


@pytest.mark.parametrize("switch", [Relay(1.5), BoundaryLayer(1.0, 0.05)])
def test_an_oscillation_stands_where_the_curve_meets_the_describing_function(switch):
    W = control.tf([4.0], [1, 3, 3, 1])
    balance = harmonic_balance(W, switch)
    figure = describing_function_figure("d", "", FrequencyCurve("W", OMEGA, W(1j * OMEGA)), switch, balance, "rad")
    (points,) = (mark for mark in figure.panels[0].series if isinstance(mark, Points))
    (found,) = balance.oscillations
    assert points.label == "attracts"
    assert (points.x[0], points.y[0]) == pytest.approx((-0.5, 0.0), rel=1e-9)  # W(j sqrt 3) = 4 / (1 + j sqrt 3)^3
    assert f"{math.sqrt(3):.3g} rad/s" in plain(points.names[0])
    assert f"amplitude {found.amplitude:.4g}" in caption(figure)


def test_an_envelope_has_the_quantiles_of_its_draws_and_names_the_worst():
    rng = np.random.default_rng(1)
    rows = rng.normal(size=(200, 30))
    rows[3, 4] = np.nan
    x = np.arange(30.0)
    figure = envelope_figure("e", "", Envelope(x, rows, 17, "draw 17"), "time [s]", "speed", "rad/s")
    sound = np.delete(rows, 3, axis=0)
    worst, median = lines(figure)
    assert np.array_equal(worst.y, rows[17])
    assert plain(worst.label) == "worst: draw 17"
    assert np.allclose(median.y, np.median(sound, axis=0))
    middle, whole = (mark for mark in figure.panels[0].series if isinstance(mark, Band))
    assert np.allclose((middle.low, middle.high), np.quantile(sound, (0.05, 0.95), axis=0))
    assert np.array_equal((whole.low, whole.high), (sound.min(axis=0), sound.max(axis=0)))
    assert "Left out: 1 draw that has no value at some places (3, counted from 0). The worst is draw 17." in caption(
        figure
    )


def test_an_envelope_of_answers_has_gains_and_phases():
    rows = np.array([k / (1 + 1j * OMEGA) ** 3 for k in (1.0, 2.0, 4.0)])
    figure = bode_envelope("e", "", Envelope(OMEGA, rows))
    gain, phase = (next(mark for mark in panel.series if isinstance(mark, Series)) for panel in figure.panels)
    assert np.allclose(gain.y, 20 * np.log10(np.abs(rows[1])))
    assert phase.y[-1] == pytest.approx(-270, abs=0.2)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: FrequencyMatrix("G", [1.0, 2.0], np.ones((3, 2, 2))), "a matrix for each frequency"),
        (lambda: FrequencyMatrix("G", [1.0, 2.0], np.ones((2, 2, 2)), ("a",)), "a name for each of 2 inputs"),
        (
            lambda: determinant_figure("d", "", [FrequencyMatrix("G", [1.0, 2.0], np.ones((2, 1, 2)))]),
            "one output for each",
        ),
        (lambda: determinant_figure("d", "", []), "at least one"),
        (lambda: relative_gain_figure("r", "", FrequencyMatrix("G", [1.0, 2.0], np.ones((2, 4, 4)))), "up to three"),
        (lambda: VectorField([0.0, 1.0], [0.0, 1.0], np.ones((2, 3)), np.ones((2, 2))), "an array"),
        (lambda: Envelope([0.0, 1.0], [[np.nan, 1.0]]), "without NaN"),
        (lambda: Envelope([0.0, 1.0], [[1.0, 1.0]], 4), "the first 0"),
        (lambda: envelope_figure("e", "", Envelope([0.0, 1.0], [[1j, 1.0]]), "x", "y"), "real answers"),
        (lambda: bode_envelope("e", "", Envelope([0.0, 1.0], [[1j, 1.0]])), "above zero"),
    ],
)
def test_bad_input_gets_a_sentence(call, words):
    with pytest.raises(ValueError, match=words):
        call()
