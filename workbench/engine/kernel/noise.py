"""Standard normal numbers without a state: each is a function of seed, run, step and entry, and of nothing else.

Philox turns the counter (run, step, pair of entries) under the key `seed` into 128 bits. They make a number
u in (0, 1) and a point (c, s) on the unit circle, and these a pair of independent normal numbers:

    r c,  r s          with  r = sqrt(-2 ln u)

It uses whole numbers and + - * / sqrt, and no fused product, so a number has the same bits on every machine. Its error
is below 1e-15 of it; none exceeds 8.58, where u is 2^-53.

References
----------
Salmon, Moraes, Dror and Shaw (2011), Parallel random numbers: as easy as 1, 2, 3, SC11, section 3.3: Philox4x32-10.
Box and Muller (1958), A note on the generation of random normal deviates, Annals of Mathematical Statistics 29.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.core.validation.refusals import Array, Integers
from workbench.engine.machines.elementary_functions import COSINE, SINE
from workbench.engine.machines.machine import Machine, MachineNumber, MachineWord, Value, select
from workbench.engine.machines.numpy_spelling import Arrays

ARRAYS = Arrays(fused_products=False)
Words = tuple[MachineWord[Value], MachineWord[Value], MachineWord[Value], MachineWord[Value]]

STEP_BITS = 32  # beyond 2^32 steps a counter would repeat an earlier one
BLOCK = 2**14  # counters at a time: what is made of them stays in the cache

# Salmon et al. (2011), section 3.3; the key grows by 2^32 times (sqrt(5) - 1) / 2 and sqrt(3) - 1.
ROUNDS = 10
MULTIPLIERS = (0xD2511F53, 0xCD9E8D57)
WEYL = (0x9E3779B9, 0xBB67AE85)
LOW = 0xFFFFFFFF

ONE = 0x3FF0000000000000  # the bits of 1.0
FRACTION = 0x000FFFFFFFFFFFFF
ROOT_HALF = 0x3FE6A09E667F3BCD  # the bits of sqrt(1/2)
TWO_52 = 0x4330000000000000  # the bits of 2^52, whose last bits count in ones
HALF_PI = 1.57079632679489661923
# fdlibm (Sun Microsystems, 1993), e_log.c: ln 2 in two parts, the first with 32 bits, and Lg7 to Lg1
LN_2 = (6.93147180369123816490e-01, 1.90821492927058770002e-10)
LOGARITHM = (
    1.479819860511658591e-01,
    1.531383769920937332e-01,
    1.818357216161805012e-01,
    2.222219843214978396e-01,
    2.857142874366239149e-01,
    3.999999999940941908e-01,
    6.666666666666735130e-01,
)


def normals(seed: int, runs: Integers, steps: Integers, entries: int) -> Array:
    """Standard normal numbers (B, N, entries), each a function of its seed, run, step and entry only.

    `seed` is below 2^64, the indices `runs` (B,) are below 2^63 and `steps` (N,) below 2^32, and `entries` at most
    2^33.
    """
    if entries == 0:
        return np.empty((len(runs), len(steps), 0))
    run_words, step_words = np.asarray(runs).astype(np.uint64), np.asarray(steps).astype(np.uint64)
    pairs = np.arange((entries + 1) // 2, dtype=np.uint64)
    out = np.empty((len(runs) * len(steps), len(pairs), 2))
    size = max(1, BLOCK // max(1, len(pairs)))
    for first in range(0, len(out), size):
        run, step = np.divmod(np.arange(first, min(first + size, len(out))), len(steps))
        of_run, of_step = run_words[run, np.newaxis], step_words[step, np.newaxis]
        key, one, k, index = (MachineWord(ARRAYS, word) for word in (np.uint64(seed), of_run, of_step, pairs))
        made = pair(key, one, k, index)
        out[first : first + size, :, 0], out[first : first + size, :, 1] = (number.value for number in made)
    return out.reshape(len(runs), len(steps), 2 * len(pairs))[:, :, :entries]


def normals_on(machine: Machine[Value], seed: Value, run: Value, step: Value, entries: int) -> list[Value]:
    """The first entries of a step of a run on a machine, from its words of seed, run and step, in their ranges."""
    first, second, third = (MachineWord(machine, word) for word in (seed, run, step))
    made: list[Value] = []
    for index in range((entries + 1) // 2):
        made += (number.value for number in pair(first, second, third, MachineWord(machine, machine.word(index))))
    return made[:entries]


def pair(
    seed: MachineWord[Value], run: MachineWord[Value], step: MachineWord[Value], index: MachineWord[Value]
) -> tuple[MachineNumber[Value], MachineNumber[Value]]:
    """The entries 2 index and 2 index + 1 of a step of a run."""
    words = philox((run & LOW, run >> 32, step, index), (seed & LOW, seed >> 32))
    radius = (logarithm(uniform(words[1] << 32 | words[0])) * -2.0).do("sqrt")
    c, s = circle(words[3] << 32 | words[2])
    return radius * c, radius * s


def philox(counter: Words[Value], key: tuple[MachineWord[Value], MachineWord[Value]]) -> Words[Value]:
    """Philox4x32-10: four words of 32 bits from four, one to one under every key."""
    x0, x1, x2, x3 = counter
    for i in range(ROUNDS):
        # a product of two words has 64 bits; what the other lines leave above the lowest 32 is never used
        left, right = (x0 & LOW) * MULTIPLIERS[0], (x2 & LOW) * MULTIPLIERS[1]
        x0, x2 = right >> 32 ^ x1 ^ (key[0] + i * WEYL[0]), left >> 32 ^ x3 ^ (key[1] + i * WEYL[1])
        x1, x3 = right, left
    return x0 & LOW, x1 & LOW, x2 & LOW, x3 & LOW


def uniform(bits: MachineWord[Value]) -> MachineNumber[Value]:
    """(k + 1/2) / 2^52 from the first 52 bits k: never 0, never 1, and exact."""
    return (bits >> 12 | ONE).number - (1 - 2**-53)


def circle(bits: MachineWord[Value]) -> tuple[MachineNumber[Value], MachineNumber[Value]]:
    """A point on the unit circle: 52 bits make an angle within pi / 4, two more reflect it into all quarters."""
    angle = (uniform(bits) - 0.5) * HALF_PI
    square = angle * angle
    sine = angle * square * polynomial(square, SINE) + angle
    cosine = square * square * polynomial(square, COSINE) + (square * -0.5 + 1.0)
    cosine = (cosine.bits ^ bits << 63).number
    turned = (bits & 2).nonzero
    return select(turned, sine, cosine), select(turned, cosine, sine)


def logarithm(x: MachineNumber[Value]) -> MachineNumber[Value]:
    """ln x for normal x > 0, to the last bit or two: x = 2^n m with m within a factor sqrt(2) of one.

    With f = m - 1 and s = f / (2 + f) it is ln m = f - (f^2/2 - s (f^2/2 + R(s^2))), as in fdlibm.
    """
    shifted = x.bits + (ONE - ROOT_HALF)
    n = (shifted >> 52 | TWO_52).number - (2.0**52 + 1023)
    f = ((shifted & FRACTION) + ROOT_HALF).number - 1.0
    s = f / (f + 2.0)
    square, half = s * s, f * f * 0.5
    tail = s * (square * polynomial(square, LOGARITHM) + half) + n * LN_2[1]
    return n * LN_2[0] - ((half - tail) - f)


def polynomial(x: MachineNumber[Value], coefficients: Sequence[float]) -> MachineNumber[Value]:
    """The value of a polynomial by Horner's rule, highest power first, every product and every sum rounded."""
    result = x * coefficients[0] + coefficients[1]
    for coefficient in coefficients[2:]:
        result = result * x + coefficient
    return result
