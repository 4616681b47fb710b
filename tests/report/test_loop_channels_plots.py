"""Pictures of loops of several channels: each beside the others, and all at once."""

import numpy as np
import pytest

import workbench as wb
from tests.support.plotted_loops import A, B, lines, loop_gain, named_points, two_channels


def test_each_channel_is_drawn_as_the_loop_that_the_others_leave():
    picture = wb.bode(two_channels())
    for k, mark in enumerate(lines(picture.figure.panels[0])):
        S = np.linalg.inv(np.eye(2) + loop_gain(mark.x))
        alone = 1 / S[:, k, k] - 1  # S at one channel alone is 1 / (1 + L) of the loop that the other leaves
        np.testing.assert_allclose(10 ** (mark.y / 20), np.abs(alone), rtol=1e-6)


def test_margins_of_single_channels_stand_beside_the_disk_margin_of_all():
    linear = two_channels()
    for picture in (linear.plot(), wb.bode(linear), wb.nichols(linear)):
        assert picture.caption.count("disk margin of all channels at once") == 2
    assert f"{linear.disk_margin.alpha:.3g}" in linear.plot().caption


def test_a_loop_whose_disk_margin_is_refused_prints_no_margin_of_a_channel():
    unstable = two_channels(-3.0)
    assert not unstable.stable
    for picture in (unstable.plot(), wb.bode(unstable)):
        assert "No margins: those of single channels are not printed" in picture.caption
        assert "phase margin" not in picture.caption
        assert not named_points(picture.figure.panels[0])


def test_one_channel_of_two_says_that_its_margins_need_the_other():
    caption = two_channels(at="a").plot("bode").caption
    assert "No margins of a: it is one of 2 channels" in caption
    assert "cut the loop at a, b" in caption


def test_the_nyquist_plot_of_two_channels_counts_the_turns_of_the_determinant():
    stable, unstable = two_channels(), two_channels(-3.0)
    assert "does not encircle 0. With no unstable poles of L, the closed loop has no unstable poles" in (
        stable.plot("determinant").caption
    )
    count = sum(pole.value.real > 0 for pole in unstable.poles)
    assert f"the closed loop has {count} unstable pole" in unstable.plot("determinant").caption
    assert "disk margin" in stable.plot("characteristic_loci").caption


def test_singular_values_are_those_of_the_matrix():
    largest = lines(two_channels().plot("singular_values").figure.panels[0])[0]
    found = np.linalg.svd(loop_gain(largest.x), compute_uv=False)[:, 0]
    np.testing.assert_allclose(10 ** (largest.y / 20), found, rtol=1e-8)
    assert "disk margin" in wb.singular_values_plot(two_channels()).caption


def test_relative_gains_are_those_of_the_plant_alone():
    figure = two_channels().plot("relative_gains").figure
    own = lines(figure.panels[0])[0]
    G = np.linalg.solve(1j * own.x[:, np.newaxis, np.newaxis] * np.eye(2) - A, B + 0j)
    theirs = np.abs(G[:, 0, 0] * np.linalg.inv(G)[:, 0, 0])
    np.testing.assert_allclose(own.y, theirs, rtol=1e-8)
    with pytest.raises(ValueError, match="an output for each of 2 inputs"):
        two_channels().plot("relative_gains", outputs="y")
