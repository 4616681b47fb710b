"""The solution of (s I - A) x = b at many s after one reduction to Hessenberg form, as a program of two machines.

Householder reflections turn b to the first axis and A to Hessenberg form. There the equations from the last to the
second give all states as multiples of the last one, and the first equation gives its size.

References
----------
Laub (1981), Efficient multivariable frequency response computations, IEEE Trans. Autom. Control 26; Wilkinson (1965),
The Algebraic Eigenvalue Problem, section 7.11 (Hyman's method).
"""

from __future__ import annotations

from collections.abc import Sequence

from workbench.design.matrices import EPS
from workbench.engine.kernel.vector_loops import Index, LoopMachine, Place, Pointer, Vector

TINY = 1e-200
Pair = tuple[Vector, Vector]  # the real and the imaginary part


def times(m: LoopMachine[Vector, Pointer, Index], a: Pair[Vector], b: Pair[Vector]) -> Pair[Vector]:
    """The product of two complex numbers."""
    do = m.do
    return (
        do("sub", do("mul", a[0], b[0]), do("mul", a[1], b[1])),
        do("add", do("mul", a[0], b[1]), do("mul", a[1], b[0])),
    )


def pair(m: LoopMachine[Vector, Pointer, Index], array: Pointer, index: Place[Index]) -> Pair[Vector]:
    """The complex number at a place."""
    even = m.index("mul", index, 2)
    return m.load(array, even), m.load(array, m.index("add", even, 1))


def put_pair(m: LoopMachine[Vector, Pointer, Index], array: Pointer, index: Place[Index], value: Pair[Vector]) -> None:
    """Put a complex number at a place."""
    even = m.index("mul", index, 2)
    m.store(array, even, value[0])
    m.store(array, m.index("add", even, 1), value[1])


def size_of(m: LoopMachine[Vector, Pointer, Index], value: Pair[Vector]) -> Vector:
    """A bound of the modulus, at most 1.5 times as large."""
    return m.do("add", m.do("fabs", value[0]), m.do("fabs", value[1]))


def product_with(
    m: LoopMachine[Vector, Pointer, Index],
    row: Pointer,
    column: Place[Index],
    z: Pointer,
    start: Place[Index],
    stop: Place[Index],
) -> Pair[Vector]:
    """The sum of real entries of a row, `column` places on, times complex entries of z, from `start` on."""

    def body(j: Index, *total: Vector) -> Pair[Vector]:
        h, (zr, zi) = m.load(row, m.index("add", j, column)), pair(m, z, j)
        return m.do("add", total[0], m.do("mul", h, zr)), m.do("add", total[1], m.do("mul", h, zi))

    zero = m.number(0.0)
    real, imaginary = m.fold(start, stop, (zero, zero), body)
    return real, imaginary


def reduce(m: LoopMachine[Vector, Pointer, Index], n: Place[Index], W: Pointer, Q: Pointer, u: Pointer) -> None:
    """Bring [b A] (n, n + 1) to [size e1, H] with x = Q z; the entries below the diagonal of H become their inverses.

    Such an entry that is rounding is made as large as that, so that it has an inverse. `u` is room for n numbers.
    """
    wide, last = m.index("add", n, 1), m.index("sub", n, 1)
    zero, one = m.number(0.0), m.number(1.0)

    def add_square(array: Pointer, i: Index, total: Vector) -> tuple[Vector]:
        value = m.load(array, i)
        return (m.do("add", total, m.do("mul", value, value)),)

    def of_row(i: Index, total: Vector) -> Sequence[Vector]:
        row = m.part(W, i, wide)
        return m.fold(1, wide, (total,), lambda j, of: add_square(row, j, of))

    (squares,) = m.fold(0, n, (zero,), of_row)
    least = m.do("add", m.do("mul", m.do("sqrt", squares), m.number(EPS)), m.number(TINY))

    def reflect(k: Index) -> tuple[()]:
        beta = reflector(m, n, W, u, k)

        m.fold(k, wide, (), lambda j: turn_column(m, n, W, j, u, beta, k))
        m.fold(0, n, (), lambda i: turn(m, m.part(W, i, wide), 1, u, beta, k, n))
        m.fold(0, n, (), lambda i: turn(m, m.part(Q, i, n), 0, u, beta, k, n))
        return ()

    def invert(k: Index) -> tuple[()]:
        row = m.part(W, k, wide)
        h = m.load(row, k)
        h = m.do("select", m.do("lt", m.do("fabs", h), least), least, h)
        m.store(row, k, m.do("div", one, h))
        return ()

    m.fold(0, n, (), lambda i: put_unit(m, n, m.part(Q, i, n), i))
    m.fold(0, last, (), reflect)
    m.fold(1, n, (), invert)


def put_unit(m: LoopMachine[Vector, Pointer, Index], n: Place[Index], row: Pointer, i: Place[Index]) -> tuple[()]:
    """Put row i of the unit matrix into a row."""

    def blank(j: Index) -> tuple[()]:
        m.store(row, j, m.number(0.0))
        return ()

    m.fold(0, n, (), blank)
    m.store(row, i, m.number(1.0))
    return ()


def turn_column(
    m: LoopMachine[Vector, Pointer, Index],
    n: Place[Index],
    W: Pointer,
    j: Place[Index],
    u: Pointer,
    beta: Vector,
    k: Place[Index],
) -> tuple[()]:
    """Reflect the part of column j of W (n, n + 1) from row k on."""
    wide = m.index("add", n, 1)

    def add(i: Index, total: Vector) -> tuple[Vector]:
        return (m.do("add", total, m.do("mul", m.load(u, i), m.load(m.part(W, i, wide), j))),)

    (inner,) = m.fold(k, n, (m.number(0.0),), add)
    share = m.do("mul", beta, inner)

    def change(i: Index) -> tuple[()]:
        row = m.part(W, i, wide)
        m.store(row, j, m.do("sub", m.load(row, j), m.do("mul", share, m.load(u, i))))
        return ()

    m.fold(k, n, (), change)
    return ()


def reflector(
    m: LoopMachine[Vector, Pointer, Index], n: Place[Index], W: Pointer, u: Pointer, k: Place[Index]
) -> Vector:
    """Put into u, from k on, the vector that turns column k of W to the axis k, and return 2 over its square."""
    wide, zero = m.index("add", n, 1), m.number(0.0)

    def copy(i: Index, total: Vector) -> tuple[Vector]:
        value = m.load(m.part(W, i, wide), k)
        m.store(u, i, value)
        return (m.do("add", total, m.do("mul", value, value)),)

    (square,) = m.fold(k, n, (zero,), copy)
    head = m.load(m.part(W, k, wide), k)
    length = m.do("neg", m.do("copysign", m.do("sqrt", square), head))
    m.store(u, k, m.do("sub", head, length))
    inverse = m.do("div", m.number(1.0), m.do("sub", square, m.do("mul", head, length)))
    return m.do("select", m.do("gt", square, zero), inverse, zero)


def turn(
    m: LoopMachine[Vector, Pointer, Index],
    row: Pointer,
    column: Place[Index],
    u: Pointer,
    beta: Vector,
    k: Place[Index],
    n: Place[Index],
) -> tuple[()]:
    """Reflect the part of a row from k on, `column` places further."""

    def add(i: Index, total: Vector) -> tuple[Vector]:
        return (m.do("add", total, m.do("mul", m.load(row, m.index("add", i, column)), m.load(u, i))),)

    (inner,) = m.fold(k, n, (m.number(0.0),), add)
    share = m.do("mul", beta, inner)

    def change(i: Index) -> tuple[()]:
        at = m.index("add", i, column)
        m.store(row, at, m.do("sub", m.load(row, at), m.do("mul", share, m.load(u, i))))
        return ()

    m.fold(k, n, (), change)
    return ()


def hyman(
    m: LoopMachine[Vector, Pointer, Index],
    n: Place[Index],
    W: Pointer,
    Q: Pointer,
    s: Pair[Vector],
    z: Pointer,
    x: Pointer,
) -> None:
    """Put into x the solution of (s I - A) x = b from the reduced [b A]; z is room of the same size, 2 n."""
    wide, last = m.index("add", n, 1), m.index("sub", n, 1)
    put_pair(m, z, last, (m.number(1.0), m.number(0.0)))

    def minus(a: Pair[Vector], b: Pair[Vector]) -> Pair[Vector]:
        return m.do("sub", a[0], b[0]), m.do("sub", a[1], b[1])

    def up(i: Index) -> tuple[()]:
        k = m.index("sub", last, i)
        row = m.part(W, k, wide)
        left = minus(times(m, s, pair(m, z, k)), product_with(m, row, 1, z, k, n))
        inverse = m.load(row, k)
        put_pair(m, z, m.index("sub", k, 1), (m.do("mul", left[0], inverse), m.do("mul", left[1], inverse)))
        return ()

    m.fold(0, last, (), up)
    first = minus(times(m, s, pair(m, z, 0)), product_with(m, W, 1, z, 0, n))
    square = m.do("add", m.do("mul", first[0], first[0]), m.do("mul", first[1], first[1]))
    share = m.do("div", m.load(W, 0), square)
    scale = (m.do("mul", first[0], share), m.do("neg", m.do("mul", first[1], share)))

    def rescale(k: Index) -> tuple[()]:
        put_pair(m, z, k, times(m, pair(m, z, k), scale))
        return ()

    def back(k: Index) -> tuple[()]:
        put_pair(m, x, k, product_with(m, m.part(Q, k, n), 0, z, 0, n))
        return ()

    m.fold(0, n, (), rescale)
    m.fold(0, n, (), back)
