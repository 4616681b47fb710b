"""Normal numbers by their key: the generator, the numbers made of it, and their statistics."""

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest
from scipy import special, stats

from workbench.engine.kernel import noise
from workbench.engine.kernel.noise import BLOCK, circle, logarithm, normals, philox, uniform
from workbench.engine.machines.machine import MachineWord

# The chance that a test refuses numbers that are as they should be. The seeds are fixed, so its answer never changes.
SIGNIFICANCE = 1e-5


def words(bits):
    """Words of 64 bits on the machine that `normals` uses."""
    return MachineWord(noise.ARRAYS, bits)


# Bits at the ends and in the middle of the range, where u is next to 0, to 1, or the angle next to nought.
EDGES = np.array([0, 1, 2, 3, 2**12, 2**63 - 1, 2**63, 2**63 + 2**12, 2**64 - 2**12, 2**64 - 1], dtype=np.uint64)


def some_bits(count):
    """Words of 64 bits: plain ones, and ones near both ends on every scale."""
    rng = np.random.default_rng(3)
    words = rng.integers(0, 2**64, 3 * count, dtype=np.uint64).reshape(3, count)
    words[1:] >>= rng.integers(0, 64, (2, count), dtype=np.uint64)
    words[2] = ~words[2]
    return np.concatenate([EDGES, words.ravel()])


# The generator


@pytest.mark.parametrize(
    ("counter", "key", "answer"),
    [
        ("00000000 00000000 00000000 00000000", "00000000 00000000", "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
        ("ffffffff ffffffff ffffffff ffffffff", "ffffffff ffffffff", "408f276d 41c83b0e a20bc7c6 6d5451fd"),
        ("243f6a88 85a308d3 13198a2e 03707344", "a4093822 299f31d0", "d16cfe09 94fdcceb 5001e420 24126ea1"),
    ],
)
def test_philox_gives_the_known_answers_of_its_authors(counter, key, answer):
    # Random123 1.14, tests/kat_vectors, the lines "philox4x32 10"
    def hexadecimal(text):
        return [int(word, 16) for word in text.split()]

    asked = [[words(np.array([word], dtype=np.uint64)) for word in hexadecimal(text)] for text in (counter, key)]
    assert [int(word.value[0]) for word in philox(*asked)] == hexadecimal(answer)


def test_no_two_keys_share_their_numbers():
    near = np.arange(20)
    far = np.concatenate([near, near + 2**32, 2**63 - 1 - near])
    seeds = [*near, *(near + 2**32), *(2**64 - 1 - int(i) for i in near)]
    steps = np.concatenate([near, 2**32 - 1 - near])
    made = np.stack([normals(int(seed), far, steps, 6) for seed in seeds])
    assert len(np.unique(made)) == made.size  # 864,000 draws: two of them share 52 bits with a chance of 1e-4


# The numbers


def sine(x):
    """sin x by its power series."""
    total, term, n = Decimal(0), x, 1
    while abs(term) > Decimal(10) ** -40:
        total, term, n = total + term, -term * x * x / ((n + 1) * (n + 2)), n + 2
    return total


def test_a_number_is_right_to_1e_15_of_itself_out_to_the_last_tail():
    bits = some_bits(400)
    radius = np.sqrt(logarithm(uniform(words(bits))).value * -2.0)
    turned = [number.value for number in circle(words(bits[::-1]))]
    with localcontext() as context:
        context.prec = 50
        pi = Decimal("3.14159265358979323846264338327950288419716939937511")
        for i, (word, other) in enumerate(zip(bits.tolist(), bits[::-1].tolist(), strict=True)):
            r = (-2 * (((word >> 12) + Decimal("0.5")) / 2**52).ln()).sqrt()
            angle = (((other >> 12) + Decimal("0.5")) / 2**52 - Decimal("0.5")) * pi / 2
            point = [sine(pi / 2 - angle) * (1 - 2 * (other & 1)), sine(angle)]
            for c, exact in zip(turned, point[::-1] if other & 2 else point, strict=True):
                # three roundings of half a unit in r, c and their product, and what the polynomials leave: 6e-16
                assert abs(Decimal(float(radius[i] * c[i])) / (r * exact) - 1) < Decimal("1e-15")


def test_no_bits_give_nought_or_an_infinite_number():
    ends = uniform(words(EDGES))
    assert (ends.value.min(), ends.value.max()) == (2**-53, 1 - 2**-53)
    assert np.sqrt(-2 * logarithm(ends).value).max() == pytest.approx(math.sqrt(2 * 53 * math.log(2)), rel=1e-15)
    assert min(np.abs(number.value).min() for number in circle(words(EDGES))) > 1e-16


def test_a_number_depends_on_its_own_key_only():
    runs, steps = np.arange(60) * 2**57, np.arange(90)
    every = normals(5, runs, steps, 7)
    assert BLOCK < 60 * 90 * 4  # so that many pairs are made in more than one piece
    rng = np.random.default_rng(6)
    mixed, later = rng.permutation(60), rng.permutation(90)
    assert np.array_equal(normals(5, runs[mixed], steps[later], 7), every[mixed][:, later])
    assert np.array_equal(normals(5, runs[7:11], steps[30:], 4), every[7:11, 30:, :4])
    assert np.array_equal(normals(5, runs[7:8], steps[3:4], 7), every[7:8, 3:4])


def test_no_runs_steps_or_entries_give_no_numbers():
    none = np.arange(0)
    assert normals(0, none, np.arange(3), 2).shape == (0, 3, 2)
    assert normals(0, np.arange(3), none, 2).shape == (3, 0, 2)
    assert normals(0, np.arange(3), np.arange(2), 0).shape == (3, 2, 0)


# The statistics: a million numbers of four neighbouring seeds, (seed, run, step, entry)


@pytest.fixture(scope="module")
def million():
    return np.stack([normals(seed, np.arange(50), np.arange(1000), 5) for seed in range(4)])


@pytest.mark.parametrize("power", [1, 2, 3, 4, 5, 6])
def test_the_moments_are_those_of_the_normal_law(million, power):
    def moment(k):
        return 0 if k % 2 else math.prod(range(1, k, 2))

    spread = math.sqrt((moment(2 * power) - moment(power) ** 2) / million.size)
    score = ((million**power).mean() - moment(power)) / spread
    assert abs(score) < stats.norm.isf(SIGNIFICANCE / 2)


def test_the_law_is_normal_by_kolmogorov_and_smirnov(million):
    assert stats.kstest(million.ravel(), "norm").pvalue > SIGNIFICANCE


def test_a_thousand_equally_likely_bins_are_filled_alike(million):
    counts = np.bincount((special.ndtr(million.ravel()) * 1000).astype(int), minlength=1000)
    assert stats.chisquare(counts).pvalue > SIGNIFICANCE
    assert stats.chisquare(counts).pvalue < 1 - SIGNIFICANCE  # nor more evenly than chance does


def test_the_tails_beyond_four_sigma_are_as_full_as_they_should_be(million):
    for tail in (million > 4, million < -4):
        assert stats.binomtest(int(tail.sum()), million.size, special.ndtr(-4.0)).pvalue > SIGNIFICANCE


@pytest.mark.parametrize("lag", [1, 2])
@pytest.mark.parametrize("axis", range(4), ids=["seed", "run", "step", "entry"])
def test_neighbours_by_any_index_are_independent(million, axis, lag):
    along = np.moveaxis(million, axis, 0)
    here, there = along[:-lag].ravel(), along[lag:].ravel()
    for power in (1, 2):  # the squares too: a common radius would show in them only
        assert stats.pearsonr(here**power, there**power).pvalue > SIGNIFICANCE
    cells = (special.ndtr(here) * 32).astype(int) * 32 + (special.ndtr(there) * 32).astype(int)
    assert stats.chisquare(np.bincount(cells, minlength=1024)).pvalue > SIGNIFICANCE
