"""Pictures of rows of a loop: envelopes, and the worst row by its value."""

import control
import numpy as np
import pytest

import workbench as wb
from tests.support.plotted_loops import CART, Cart, Lagged, loop_gain, two_channels

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
