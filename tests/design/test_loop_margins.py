"""Margins of a loop: gain, phase, delay, and the disk margin with what proves it and what breaks it."""

import control
import numpy as np
import pytest

from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.blocks.loop import open_loop
from workbench.design.linear import broken_loop, disk_margin, loop_margins, one_loop, sensitivity
from workbench.design.linear.feedback_loops import largest_gain, response_at

TEXTBOOK = control.ss(control.tf([25], [1, 10, 10, 10]))


def random_loop(seed, size=2):
    """A stable loop of `size` channels, whose closed loop is stable too."""
    rng = np.random.default_rng(seed)
    while True:
        A, B, C = rng.normal(size=(5, 5)) - 2.5 * np.eye(5), rng.normal(size=(5, size)), rng.normal(size=(size, 5))
        if np.linalg.eigvals(A - B @ C).real.max() < -0.05 > np.linalg.eigvals(A).real.max():
            return control.ss(A, B, C, 0)


def scaled(loop, factors):
    """The poles of the loop closed with each channel times a complex factor."""
    return np.linalg.eigvals(loop.A - loop.B @ np.diag(factors) @ loop.C)


def test_the_margins_of_a_single_loop_are_those_of_python_control():
    (ours,) = loop_margins(TEXTBOOK)
    gain, phase, _, _, crossover, _ = control.stability_margins(TEXTBOOK)
    assert ours.gain == (0.0, pytest.approx(gain, rel=1e-10))
    assert ours.phase == pytest.approx(phase, rel=1e-10)
    assert ours.crossover == pytest.approx(crossover, rel=1e-10)
    # its disk margin is the least of a grid, so above ours
    on_grid = control.disk_margins(TEXTBOOK, np.geomspace(1, 4, 4001))[0]
    assert ours.disk.alpha <= on_grid <= ours.disk.alpha * (1 + 1e-5)


def test_the_printed_example_of_disk_margins():
    # Seiler, Packard and Gahinet (2020), example 25 / (s^3 + 10 s^2 + 10 s + 10): 0.46, gains 0.63 to 1.59, 26 degrees
    found = disk_margin(TEXTBOOK)
    assert round(found.alpha, 2) == 0.46
    assert [round(gain, 2) for gain in found.gain] == [0.63, 1.59]
    assert round(found.phase) == 26


@pytest.mark.parametrize("seed", range(6))
def test_a_delay_just_beyond_its_margin_makes_the_loop_unstable(seed):
    loop = TEXTBOOK if not seed else random_loop(seed, 1)
    (margins,) = loop_margins(loop)
    if margins.delay == np.inf:
        return
    # Pade's approximant of order 8 is exact to 1e-9 where |omega T| < 3, as it is at the crossover
    for share, stable in ((0.98, True), (1.02, False)):
        late = loop * control.ss(control.tf(*control.pade(share * margins.delay, 8)))
        assert (np.linalg.eigvals(late.A - late.B @ late.C / (1 + late.D)).real.max() < 0) is np.bool_(stable)


@pytest.mark.parametrize("seed", range(8))
def test_a_change_within_the_disk_keeps_the_loop_stable(seed):
    loop, rng = random_loop(seed), np.random.default_rng(seed)
    alpha = disk_margin(loop).alpha
    for _ in range(300):
        d = 0.999 * alpha * np.exp(2j * np.pi * rng.uniform(size=2))
        assert scaled(loop, (2 + d) / (2 - d)).real.max() < 0


@pytest.mark.parametrize("seed", range(8))
def test_the_two_bounds_of_a_disk_margin_enclose_it_closely(seed):
    found = disk_margin(random_loop(seed))
    assert found.alpha <= found.alpha_above * (1 + 1e-9)
    assert found.alpha_above < 1.6 * found.alpha  # what one constant scaling gives away


@pytest.mark.parametrize("size", [3, 5])
def test_many_channels_have_a_disk_margin_that_random_changes_respect(size):
    loop, rng = random_loop(size, size), np.random.default_rng(size)
    found = disk_margin(loop)
    assert found.alpha <= found.alpha_above
    for _ in range(200):
        d = 0.999 * found.alpha * np.exp(2j * np.pi * rng.uniform(size=size))
        assert scaled(loop, (2 + d) / (2 - d)).real.max() < 0


@pytest.mark.parametrize("seed", range(4))
def test_the_disk_of_all_loops_is_no_larger_than_that_of_one(seed):
    loop = random_loop(seed)
    single = min(margins.disk.alpha for margins in loop_margins(loop))
    assert disk_margin(loop).alpha <= single * (1 + 1e-5)


def test_a_diagonal_loop_has_the_margin_of_its_weakest_channel():
    other = control.ss(-1.0, 1.0, 2.0, 0.0)
    both = control.append(TEXTBOOK, other)
    assert disk_margin(both).alpha == pytest.approx(disk_margin(TEXTBOOK).alpha, rel=1e-5)
    assert loop_margins(both)[0].phase == pytest.approx(loop_margins(TEXTBOOK)[0].phase)


def test_scaling_inputs_does_not_change_the_margin():
    loop = random_loop(1)
    d = np.diag([1.0, 50.0])
    other = control.ss(loop.A, loop.B @ np.linalg.inv(d), d @ loop.C, 0)
    assert disk_margin(other).alpha == pytest.approx(disk_margin(loop).alpha, rel=1e-3)


@pytest.mark.parametrize("seed", range(10))
def test_the_largest_gain_is_above_every_frequency_and_is_reached(seed):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(6, 6))
    A -= (np.linalg.eigvals(A).real.max() + 0.01 * 10 ** -rng.uniform(0, 3)) * np.eye(6)  # a lightly damped mode
    G = control.ss(A, rng.normal(size=(6, 2)), rng.normal(size=(3, 6)), rng.normal(size=(3, 2)))
    peak = largest_gain(G)
    eigenvalues = np.linalg.eigvals(A)
    around = np.concatenate([np.abs(e.imag) + abs(e.real) * np.linspace(-3, 3, 301) for e in eigenvalues])
    grid = np.concatenate([around, np.geomspace(1e-3, 1e3, 2000)])
    seen = np.linalg.norm(response_at(G, grid), 2, axis=(-2, -1)).max()
    assert seen <= peak.above
    assert peak.below == pytest.approx(np.linalg.norm(response_at(G, np.array([peak.frequency]))[0], 2), rel=1e-9)
    assert peak.above <= peak.below * (1 + 2e-6)


def test_a_resonance_of_a_millionth_of_damping_is_not_missed():
    # 1 / (s^2 + 2 zeta s + 1) peaks at 1 / (2 zeta sqrt(1 - zeta^2)), and a grid would have to be lucky
    zeta = 1e-6
    G = control.ss(control.tf([1], [1, 2 * zeta, 1]))
    peak = largest_gain(G)
    assert peak.above == pytest.approx(1 / (2 * zeta), rel=1e-5)


def test_the_sensitivity_and_the_single_loops_are_those_of_the_blocks():
    loop = random_loop(5)
    for omega in (0.1, 1.0, 10.0):
        L = loop(1j * omega)
        np.testing.assert_allclose(sensitivity(loop)(1j * omega), np.linalg.inv(np.eye(2) + L), rtol=1e-10)
        alone = L[0, 0] - L[0, 1] * L[1, 0] / (1 + L[1, 1])  # Schur complement: the second loop closed
        np.testing.assert_allclose(one_loop(loop, 0)(1j * omega), alone, rtol=1e-10)


def test_an_integrator_in_the_loop_has_no_margin_downwards():
    (found,) = loop_margins(control.ss(control.tf([1], [1, 1, 0])))
    assert found.gain == (0.0, np.inf)
    assert found.disk.alpha < 2


def test_an_unstable_loop_has_no_margin():
    with pytest.raises(ValueError, match=r"only where it is asymptotically stable once closed; here a pole is 1 1/s"):
        disk_margin(control.ss(2.0, 1.0, 1.0, 0.0))


@pytest.mark.parametrize(
    ("loop", "message"),
    [
        (control.ss(-1, [[1, 1]], 1, 0), "a square `StateSpace`.*got 1 by 2"),
        (control.ss(-0.5, 1, 1, 0, 0.1), "in continuous time.*dt = 0.1"),
        (control.ss(-1, 1, 1, -1), r"regular I \+ D"),
        (control.ss(np.nan, 1, 1, 0), "finite matrices"),
        (np.eye(2), "a `StateSpace`"),
    ],
)
def test_what_is_no_loop_is_refused(loop, message):
    with pytest.raises(ValueError, match=message):
        disk_margin(loop)


def test_a_channel_that_is_none_is_refused():
    with pytest.raises(LookupError, match="counts from 0 to 1; got 2"):
        one_loop(random_loop(0), 2)


def test_a_loop_needs_an_output_for_each_input():
    ode = open_loop(Manipulator(paper_arm(), q=[0, 0]))
    with pytest.raises(ValueError, match="an output for each input.*'plant' has 2 inputs and 4 outputs"):
        broken_loop(ode, 0.0, np.zeros(4))


@pytest.mark.parametrize(
    ("numerator", "denominator"),
    [([1e4], [1, 1]), ([1e5], [1, 0]), ([2e3, 1e6], [1, 0, 0]), ([2e-4, 1e-8], [1, 0, 0])],
)
def test_a_crossover_far_from_all_poles_of_the_loop_is_found(numerator, denominator):
    loop = control.ss(control.tf(numerator, denominator))
    _, phase, _, _, crossover, _ = control.stability_margins(loop)
    (ours,) = loop_margins(loop)
    assert ours.phase == pytest.approx(phase, rel=1e-8)
    assert ours.crossover == pytest.approx(crossover, rel=1e-8)
    assert ours.delay == pytest.approx(np.radians(phase) / crossover, rel=1e-8)


def test_a_crossover_at_a_resonance_narrower_than_any_grid_is_found():
    # 1e-3 / (s^2 + 2e-5 s + 100) crosses |L| = 1 within 5e-5 rad/s of 10
    A, B, C = [[0, 1, 0], [-100, -2e-5, 0], [0, 0, -1]], [[0], [1], [1]], [[1e-3, 0, 0.5]]
    (ours,) = loop_margins(control.ss(A, B, C, 0))
    assert ours.crossover == pytest.approx(10, abs=1e-4)
    L = np.array(C) @ np.linalg.solve(1j * ours.crossover * np.eye(3) - np.array(A), B)
    assert abs(L.item()) == pytest.approx(1, rel=1e-6)
    assert ours.phase < 90


def test_a_gain_that_makes_the_loop_ill_posed_is_its_margin():
    # 1 + k L = ((1 - k / 2) s + 1 + 5 k) / (s + 1)
    (ours,) = loop_margins(control.ss([[-1]], [[1]], [[5.5]], [[-0.5]]))
    assert ours.gain[1] == pytest.approx(2)


def test_a_loop_without_states_has_margins():
    (ours,) = loop_margins(control.ss([], [], [], [[-0.5]]))
    assert ours.gain[1] == pytest.approx(2)
