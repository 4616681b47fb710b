"""Phase crossovers that rest on the last digits of a loop's matrices, against matrices with other last digits."""

from fractions import Fraction
from itertools import pairwise

import control
import numpy as np
import pytest

import workbench as wb
from workbench.design.frequency.axis_loop import axis_loop
from workbench.design.frequency.positive_roots import at

QFT = ([0.32, 0.032], [4.0, 2.0, 1.0])  # a controller of the two masses, example 5 of the QFT Toolbox


def spring_loop(total=3.0, scale=0.7):
    """((m1 + m2) s^2 D + N) / (s^4 D) as a state-space system, whose rounding leaves a small C A B."""
    num, den = QFT
    top = np.polyadd(total * np.polymul([1.0, 0.0, 0.0], den), num)
    return control.ss(control.tf(scale * top, np.polymul([1.0, 0.0, 0.0, 0.0, 0.0], den)))


def with_other_digits(loop, seed):
    """The system with each entry at most half a unit in the last place away, which doubles may show as one unit."""
    rng = np.random.default_rng(seed)
    parts = (np.asarray(part) for part in (loop.A, loop.B, loop.C, loop.D))
    moved = [np.nextafter(part, part + rng.choice([-1.0, 0.0, 1.0], part.shape)) * (part != 0) for part in parts]
    return control.ss(*moved)


def raw_crossovers(loop):
    """The number of frequencies above 1e4 rad/s at which L is real and negative, by signs of Im L in exact numbers."""
    exact = axis_loop("test", loop, 0.0)
    signs = [at(exact.Q, Fraction(10.0**k) ** 2) > 0 for k in range(4, 14)]
    return sum(a != b for a, b in pairwise(signs))


def test_a_crossover_of_two_masses_that_other_last_digits_undo_is_named_and_not_listed():
    loops = [with_other_digits(spring_loop(), seed) for seed in range(12)]
    counts = [raw_crossovers(loop) for loop in loops]
    assert set(counts) == {0, 1}  # the last digits decide
    found = wb.stability_margins(loops[counts.index(1)])
    none = wb.stability_margins(loops[counts.index(0)])
    assert none.gain_high.value == np.inf
    assert none.remarks == ()
    assert [round(one.frequency.value, 3) for one in found.phase_crossovers] == [0.447]
    assert found.gain_high.value == np.inf
    assert 1e13 < found.gain_high.low < np.inf  # the bound holds for the matrices as written
    assert "not listed" in found.remarks[0]
    assert found.gain_low.value == pytest.approx(0.1299, abs=1e-4)


def test_crossovers_that_all_such_matrices_have_are_listed_as_before():
    fast = control.ss(control.tf([1.0], np.poly([0.0, -1e7, -3e7])))
    loops = [
        fast,
        control.ss(control.tf([4.0], [1.0, 3.0, 3.0, 1.0])),
        control.ss(control.tf([1.0], [1e-9, 1.0, 1.0, 0.0])),
    ]
    for loop in loops:
        found = wb.stability_margins(loop)
        assert len(found.phase_crossovers) == 1
        assert found.remarks == ()
        moved = wb.stability_margins(with_other_digits(loop, 1))
        assert moved.gain_high.value == pytest.approx(found.gain_high.value, rel=1e-12)
    assert wb.stability_margins(fast).phase_crossovers[0].frequency.value == pytest.approx(np.sqrt(3e14), rel=1e-12)


def test_both_sides_of_a_narrow_pair_of_crossovers_are_told():
    """A loop that is real and negative twice within a hundredth of a decade keeps both."""
    loop = control.ss(control.tf(np.polymul([1.0, 0.02, 1.0], [1.0, 0.021, 1.01]), np.poly([0, 0, -0.01, -40, -50])))
    found, by_polynomials = wb.stability_margins(loop), wb.stability_margins(control.tf(loop))
    assert len(found.phase_crossovers) == len(by_polynomials.phase_crossovers)
    assert found.remarks == ()
