"""The answer of a linear system from approximate solutions on both of its sides, with its error, on two machines.

For (s I - A) x = b and (s I - A)^T y = c the answer is c x + D + y r, in which r = b - (s I - A) x is formed in twice
the working precision. The error of the answer is then a product of the errors of x and of y.

References
----------
Pierce and Giles (2000), Adjoint recovery of superconvergent functionals from PDE approximations, SIAM Review 42; Ogita,
Rump, Oishi (2005), Accurate sum and dot product, SIAM J. Sci. Comput. 26.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic

from workbench.design.frequency.response_program import Pair, pair, put_pair, size_of, times
from workbench.design.matrices import EPS
from workbench.engine.kernel.vector_loops import Index, LoopMachine, Place, Pointer, Vector

# Takes the place of an answer among those at a frequency, its two parts, its error and its sensitivity.
PutAnswer = Callable[[Index, Vector, Vector, Vector, Vector], None]

LOST_RATIO, BOUNDLESS = 0.1, 1e150  # a residual over its right side, and the gain of a solution that has a larger one


@dataclass(frozen=True, eq=False)
class SparseRows(Generic[Pointer]):
    """The entries of a matrix row by row, the column of each, and the place where each row starts, (n + 1,)."""

    entries: Pointer
    columns: Pointer
    starts: Pointer


@dataclass(frozen=True, eq=False)
class Systems(Generic[Pointer, Index]):
    """The arrays of some systems with n states, nu inputs and ny outputs.

    A and its transpose `AT`; B (nu n), input by input; C (ny n), output by output; D (ny nu).
    """

    n: Index
    nu: Index
    ny: Index
    A: SparseRows[Pointer]
    AT: SparseRows[Pointer]
    B: Pointer
    C: Pointer
    D: Pointer


@dataclass(frozen=True, eq=False)
class Solutions(Generic[Pointer]):
    """The arrays of the states x (nu 2 n), input by input, and of y (ny 2 n), output by output, and rooms.

    `r` (nu 2 n) is for residuals, `sizes` (nu n) for the sizes of their terms, `gains` and `residuals` (nu + ny) for
    those of the solutions. `roundings` (2,) are those of a sum of n terms, in one precision and in two.
    """

    x: Pointer
    y: Pointer
    r: Pointer
    sizes: Pointer
    gains: Pointer
    residuals: Pointer
    roundings: Pointer


def answers(
    m: LoopMachine[Vector, Pointer, Index],
    of: Systems[Pointer, Index],
    s: Pair[Vector],
    at: Solutions[Pointer],
    put: PutAnswer[Index, Vector],
) -> None:
    """Put c x + D + y r of each output and input, with its error and its sensitivity.

    The error has the rounding of the sums, and the product of the errors of x and y, for which the gains of both stand
    for the norm of (s I - A)^-1. The sensitivity is the change of the answer, over the relative changes of the entries.
    """

    def one_input(j: Index) -> tuple[()]:
        residual(m, of, s, at, j)
        return ()

    def one_output(i: Index) -> tuple[()]:
        left_residual(m, of, s, at, i)
        return ()

    m.fold(0, of.nu, (), one_input)
    m.fold(0, of.ny, (), one_output)

    def one_row(i: Index) -> tuple[()]:
        m.fold(0, of.nu, (), lambda j: cell(m, of, at, i, j, put))
        return ()

    m.fold(0, of.ny, (), one_row)


def cell(
    m: LoopMachine[Vector, Pointer, Index],
    of: Systems[Pointer, Index],
    at: Solutions[Pointer],
    i: Place[Index],
    j: Place[Index],
    put: PutAnswer[Index, Vector],
) -> tuple[()]:
    """Put the answer of output i to input j."""
    n, zero, two = of.n, m.number(0.0), m.index("mul", of.n, 2)
    x, y, r = m.part(at.x, j, two), m.part(at.y, i, two), m.part(at.r, j, two)
    sizes, c, place = m.part(at.sizes, j, n), m.part(of.C, i, n), m.index("add", m.index("mul", i, of.nu), j)

    def add(k: Index, rh: Vector, rl: Vector, ih: Vector, il: Vector, *sums: Vector) -> tuple[Vector, ...]:
        ck, xk, yk, rk = m.load(c, k), pair(m, x, k), pair(m, y, k), pair(m, r, k)
        weight = size_of(m, yk)
        terms = m.do("add", m.do("mul", weight, m.load(sizes, k)), m.do("mul", m.do("fabs", ck), size_of(m, xk)))
        more = (*times(m, yk, rk), m.do("mul", weight, size_of(m, rk)), terms)
        return (
            *plus(m, rh, rl, *m.product(ck, xk[0])),
            *plus(m, ih, il, *m.product(ck, xk[1])),
            *(m.do("add", old, new) for old, new in zip(sums, more, strict=True)),
        )

    d = m.load(of.D, place)
    rh, rl, ih, il, yr, yi, moved, terms = m.fold(0, n, (d, *[zero] * 7), add)
    real, imaginary = m.do("add", rh, m.do("add", rl, yr)), m.do("add", ih, m.do("add", il, yi))
    size, terms = size_of(m, (real, imaginary)), m.do("add", terms, m.do("fabs", d))
    gain = larger(m, m.load(at.gains, j), m.load(at.gains, m.index("add", of.nu, i)))
    wrong = m.do("mul", m.load(at.residuals, j), m.load(at.residuals, m.index("add", of.nu, i)))
    error = m.do("add", m.do("mul", gain, wrong), m.do("mul", m.number(EPS), size))
    error = m.do("add", error, m.do("mul", m.load(at.roundings, 0), moved))
    error = m.do("add", error, m.do("mul", m.load(at.roundings, 1), terms))
    put(place, real, imaginary, error, terms)
    return ()


def residual(
    m: LoopMachine[Vector, Pointer, Index],
    of: Systems[Pointer, Index],
    s: Pair[Vector],
    at: Solutions[Pointer],
    j: Place[Index],
) -> tuple[()]:
    """The residual b - (s I - A) x of an input in twice the precision, the sizes of its terms, and the gain of x."""
    n, zero, two = of.n, m.number(0.0), m.index("mul", of.n, 2)
    x, r, sizes, b = m.part(at.x, j, two), m.part(at.r, j, two), m.part(at.sizes, j, n), m.part(of.B, j, n)
    modulus = size_of(m, s)

    def equation(k: Index, *sums: Vector) -> tuple[Vector, ...]:
        xk, bk = pair(m, x, k), m.load(b, k)

        def add(e: Index, rh: Vector, rl: Vector, ih: Vector, il: Vector, size: Vector) -> tuple[Vector, ...]:
            a, xl = m.load(of.A.entries, e), pair(m, x, m.whole(of.A.columns, e))
            more = m.do("add", size, m.do("mul", m.do("fabs", a), size_of(m, xl)))
            return (*plus(m, rh, rl, *m.product(a, xl[0])), *plus(m, ih, il, *m.product(a, xl[1])), more)

        own = m.do("add", m.do("fabs", bk), m.do("mul", modulus, size_of(m, xk)))
        rh, rl, ih, il, size = m.fold(*span(m, of.A, k), (bk, zero, zero, zero, own), add)
        rh, rl = minus(m, rh, rl, *m.product(s[0], xk[0]))
        rh, rl = plus(m, rh, rl, *m.product(s[1], xk[1]))
        ih, il = minus(m, ih, il, *m.product(s[0], xk[1]))
        ih, il = minus(m, ih, il, *m.product(s[1], xk[0]))
        left = (m.do("add", rh, rl), m.do("add", ih, il))
        put_pair(m, r, k, left)
        m.store(sizes, k, size)
        more = (size_of(m, xk), m.do("fabs", bk), size_of(m, left))
        return tuple(m.do("add", old, new) for old, new in zip(sums, more, strict=True))

    states, driven, left = m.fold(0, n, (zero, zero, zero), equation)
    m.store(at.gains, j, gain_of(m, states, driven, left))
    m.store(at.residuals, j, left)
    return ()


def left_residual(
    m: LoopMachine[Vector, Pointer, Index],
    of: Systems[Pointer, Index],
    s: Pair[Vector],
    at: Solutions[Pointer],
    i: Place[Index],
) -> tuple[()]:
    """The gain of the solution of an output, and the size of its residual c - (s I - A)^T y."""
    n, zero, two = of.n, m.number(0.0), m.index("mul", of.n, 2)
    y, c = m.part(at.y, i, two), m.part(of.C, i, n)

    def equation(k: Index, *sums: Vector) -> tuple[Vector, ...]:
        yk, ck = pair(m, y, k), m.load(c, k)

        def add(e: Index, real: Vector, imaginary: Vector) -> Pair[Vector]:
            a, (yr, yi) = m.load(of.AT.entries, e), pair(m, y, m.whole(of.AT.columns, e))
            return m.do("add", real, m.do("mul", a, yr)), m.do("add", imaginary, m.do("mul", a, yi))

        real, imaginary = m.fold(*span(m, of.AT, k), (ck, zero), add)
        turned = times(m, s, yk)
        left = (m.do("sub", real, turned[0]), m.do("sub", imaginary, turned[1]))
        more = (size_of(m, yk), m.do("fabs", ck), size_of(m, left))
        return tuple(m.do("add", old, new) for old, new in zip(sums, more, strict=True))

    states, seen, left = m.fold(0, n, (zero, zero, zero), equation)
    place = m.index("add", of.nu, i)
    m.store(at.gains, place, gain_of(m, states, seen, left))
    m.store(at.residuals, place, left)
    return ()


def gain_of(m: LoopMachine[Vector, Pointer, Index], states: Vector, right: Vector, left: Vector) -> Vector:
    """The size of a solution over that of its right side; without bound if its residual is no smaller than that side.

    A solution that is lost, as by numbers beyond the range of doubles, would say nothing of the matrix.
    """
    zero = m.number(0.0)
    gain = m.do("select", m.do("gt", right, zero), m.do("div", states, right), zero)
    return m.do("select", m.do("gt", left, m.do("mul", m.number(LOST_RATIO), right)), m.number(BOUNDLESS), gain)


def span(m: LoopMachine[Vector, Pointer, Index], matrix: SparseRows[Pointer], k: Place[Index]) -> tuple[Index, Index]:
    """The first place of a row, and the one behind its last."""
    return m.whole(matrix.starts, k), m.whole(matrix.starts, m.index("add", k, 1))


def plus(
    m: LoopMachine[Vector, Pointer, Index], high: Vector, low: Vector, value: Vector, remainder: Vector
) -> Pair[Vector]:
    """The sum of high + low and value + lacking, as a rounded sum and all that it lacks."""
    total = m.do("add", high, value)
    other = m.do("sub", total, high)
    error = m.do("add", m.do("sub", high, m.do("sub", total, other)), m.do("sub", value, other))
    return total, m.do("add", low, m.do("add", error, remainder))


def minus(
    m: LoopMachine[Vector, Pointer, Index], high: Vector, low: Vector, value: Vector, remainder: Vector
) -> Pair[Vector]:
    """The difference of the same."""
    return plus(m, high, low, m.do("neg", value), m.do("neg", remainder))


def larger(m: LoopMachine[Vector, Pointer, Index], a: Vector, b: Vector) -> Vector:
    """The larger of two numbers."""
    return m.do("select", m.do("gt", a, b), a, b)
