"""The program of the frequency answers, compiled for this processor, or in NumPy with the same bits."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency.adjoint_answers import PutAnswer, Solutions, SparseRows, Systems, answers
from workbench.design.frequency.response_program import hyman, reduce
from workbench.design.matrices import EPS, Complex
from workbench.engine.kernel.vector_loops import ArrayLoops, LoopCode, Room
from workbench.engine.machines.numpy_spelling import Lanes

ROWS, LANES = 512, 4096  # at once: rows of the compiled program, and answers of an array of NumPy's, in the cache
ROOM = 2**22  # doubles, of the matrices that NumPy reduces at once
SIZES = ("blocks", "n", "nu", "ny", "entries", "m")
INPUT_ARRAYS = ("A", "AT", "columns", "starts", "columnsT", "startsT", "B", "C", "D", "W", "roundings", "s")
ROOMS = ("Q", "x", "y", "r", "sizes", "gains", "residuals", "z")
OUTPUT_ARRAYS = ("values", "errors", "sensitivities")
Rooms = dict[str, Room]


@dataclass(frozen=True, eq=False)
class FrequencyAnswers:
    """The answers (N, m, ny, nu), the error of each, and its change over the relative changes of all entries."""

    values: Complex
    errors: Array
    sensitivities: Array


def row_answers(
    A: Array, B: Array, Cy: Array, D: Array, s: Complex, use_kernel: bool | None = None
) -> FrequencyAnswers:
    """C (s I - A)^-1 B + D of finite matrices, each (N, ...), at points s (m,); no numbers where that breaks down.

    `use_kernel` is for tests: False for NumPy, True for machine code; else it is machine code where that can be.
    """
    N, shape = len(A), (len(s), Cy.shape[1], B.shape[2])
    function = _function() if use_kernel is None or use_kernel else None
    n, sides = A.shape[1], B.shape[2] + Cy.shape[1]
    width, some = (function[0], ROWS) if function else (1, max(1, ROOM // (sides * n * (2 * n + 1))))
    room = -(-N // width) * width  # a block that is not full repeats its last row
    made = FrequencyAnswers(np.empty((room, *shape), complex), np.empty((room, *shape)), np.empty((room, *shape)))
    for first in range(0, N, some):
        rows = slice(first, min(first + some, N))
        part = _rows_of(made, slice(first, min(first + some, room)))
        if function:
            _run_kernel(function, A[rows], B[rows], Cy[rows], D[rows], s, part)
        else:
            _in_arrays(A[rows], B[rows], Cy[rows], D[rows], s, part)
    return _rows_of(made, slice(0, N))


def _rows_of(of: FrequencyAnswers, rows: slice) -> FrequencyAnswers:
    return FrequencyAnswers(of.values[rows], of.errors[rows], of.sensitivities[rows])


def adjoint_answers(A: Array, B: Array, Cy: Array, D: Array, s: Complex, x: Complex, y: Complex) -> FrequencyAnswers:
    """The answers of N systems, each at a point s (N,), from solutions x (N, n, nu) and y (N, n, ny)."""
    (N, n, nu), ny = B.shape, Cy.shape[1]
    arrays = _rooms(nu, ny, n, (N,)) | {name: _parts(M) for name, M in (("x", x), ("y", y))}
    of = _systems(n, nu, ny, _matrices(A, B, Cy, D, lambda M: np.ascontiguousarray(M.reshape(N, -1).T)))
    made = FrequencyAnswers(np.empty((N, 1, ny, nu), np.complex128), np.empty((N, 1, ny, nu)), np.empty((N, 1, ny, nu)))
    _put_together(of, (s.real, s.imag), arrays, made)
    return FrequencyAnswers(made.values[:, 0], made.errors[:, 0], made.sensitivities[:, 0])


def _parts(solutions: Complex) -> Array:
    """Solutions (N, n, k) as parts (k 2 n, N), one solution after the other."""
    columns = np.ascontiguousarray(solutions.transpose(2, 1, 0))
    return np.stack([columns.real, columns.imag], axis=2).reshape(-1, len(solutions))


def _in_arrays(A: Array, B: Array, Cy: Array, D: Array, s: Complex, outputs: FrequencyAnswers) -> None:
    """Reduce the matrices of all rows at once, and solve at all points for as many rows as the cache holds."""
    (N, n, nu), ny, machine = B.shape, Cy.shape[1], ArrayLoops()
    given = _matrices(A, B, Cy, D, lambda M: np.ascontiguousarray(M.reshape(N, -1).T)[:, np.newaxis])
    given["Q"] = np.empty(((nu + ny) * n * n, 1, N))
    with np.errstate(all="ignore"):
        for k in range(nu + ny):
            own, turned = (machine.part(given[name], k, size) for name, size in (("W", n * (n + 1)), ("Q", n * n)))
            reduce(machine, n, own, turned, np.empty((n, 1, N)))
    some = max(1, LANES // len(s))
    for first in range(0, N, some):
        rows = slice(first, min(first + some, N))
        few = {name: M[..., rows] if M.ndim == 3 else M for name, M in given.items()}
        _solve_points(n, nu, ny, few, s, _rows_of(outputs, rows))


def _solve_points(n: int, nu: int, ny: int, inputs: Rooms, s: Complex, outputs: FrequencyAnswers) -> None:
    """Put the answers of some rows at all points, whose lanes have shape (m, rows)."""
    machine, parts = ArrayLoops(), (s.real[:, np.newaxis], s.imag[:, np.newaxis])
    arrays = _rooms(nu, ny, n, (len(s), inputs["D"].shape[2]))
    with np.errstate(all="ignore"):
        for k in range(nu + ny):
            own, turned = (machine.part(inputs[name], k, size) for name, size in (("W", n * (n + 1)), ("Q", n * n)))
            into = machine.part(arrays["x"], k, 2 * n) if k < nu else machine.part(arrays["y"], k - nu, 2 * n)
            hyman(machine, n, own, turned, parts, arrays["z"], into)
    _put_together(_systems(n, nu, ny, inputs), parts, arrays, outputs)


def _put_together(of: Systems[Room, int], s: tuple[Array, Array], arrays: Rooms, outputs: FrequencyAnswers) -> None:
    """Put the answers of NumPy's machine from the solutions, whose lanes have shape (m, N)."""
    values, errors, sensitivities = (
        part.reshape(*part.shape[:2], -1).T for part in (outputs.values, outputs.errors, outputs.sensitivities)
    )

    def put(place: int, real: Lanes, imaginary: Lanes, error: Lanes, sensitivity: Lanes) -> None:
        values.real[place], values.imag[place] = real, imaginary
        errors[place], sensitivities[place] = error, sensitivity

    with np.errstate(all="ignore"):
        rooms = [arrays[name] for name in ("x", "y", "r", "sizes", "gains", "residuals")]
        at = Solutions(*[*rooms, _roundings(of.n)])
        answers(ArrayLoops(), of, s, at, put)


def _run_kernel(
    function: tuple[int, Callable[..., None]],
    A: Array,
    B: Array,
    Cy: Array,
    D: Array,
    s: Complex,
    outputs: FrequencyAnswers,
) -> None:
    width, call = function
    (N, n, nu), ny, m = B.shape, Cy.shape[1], len(s)
    blocks = -(-N // width)
    fill = np.minimum(np.arange(blocks * width), N - 1)

    def lanes(M: Array) -> Array:
        return np.ascontiguousarray(M.reshape(N, -1)[fill].reshape(blocks, width, -1).transpose(0, 2, 1))

    arrays: Rooms = _matrices(A, B, Cy, D, lanes) | _rooms(nu, ny, n, (width,))
    arrays |= {"Q": np.empty(((nu + ny) * n * n, width)), "s": np.ascontiguousarray(s).view(float)}
    arrays["roundings"] = np.repeat(_roundings(n)[:, np.newaxis], width, axis=1)
    arrays |= {name: getattr(outputs, name) for name in OUTPUT_ARRAYS}
    sizes = (blocks, n, nu, ny, len(arrays["columns"]), m)
    call(*sizes, *(arrays[name].ctypes.data for name in (*INPUT_ARRAYS, *ROOMS, *OUTPUT_ARRAYS)))


def _matrices(A: Array, B: Array, Cy: Array, D: Array, lanes: Callable[[Array], Array]) -> Rooms:
    """The arrays of the program, with the rows of the systems in the lanes; A without entries that are zero in all."""
    (N, n, nu), ny = B.shape, Cy.shape[1]
    bt, at = B.transpose(0, 2, 1), A.transpose(0, 2, 1)
    right = [bt[:, :, :, np.newaxis], np.broadcast_to(A[:, np.newaxis], (N, nu, n, n))]
    left = [Cy[:, :, :, np.newaxis], np.broadcast_to(at[:, np.newaxis], (N, ny, n, n))]
    W = np.concatenate([np.concatenate(right, axis=3), np.concatenate(left, axis=3)], axis=1)
    found: Rooms = {"B": lanes(bt), "C": lanes(Cy), "D": lanes(D), "W": lanes(W)}
    for end, M in (("", A), ("T", at)):
        rows, columns = np.nonzero((M != 0).any(axis=0))
        starts = np.searchsorted(rows, np.arange(n + 1)).astype(np.int64)
        found |= {f"A{end}": lanes(M[:, rows, columns]), f"columns{end}": columns.astype(np.int64)}
        found[f"starts{end}"] = starts
    return found


def _systems(n: int, nu: int, ny: int, of: Rooms) -> Systems[Room, int]:
    A, AT = (SparseRows(of[f"A{end}"], of[f"columns{end}"], of[f"starts{end}"]) for end in ("", "T"))
    return Systems(n, nu, ny, A, AT, of["B"], of["C"], of["D"])


def _rooms(nu: int, ny: int, n: int, lanes: tuple[int, ...]) -> Rooms:
    sizes = {"x": nu * 2 * n, "y": ny * 2 * n, "r": nu * 2 * n, "sizes": nu * n, "z": 2 * n}
    sizes |= {"gains": nu + ny, "residuals": nu + ny}
    return {name: np.empty((size, *lanes)) for name, size in sizes.items()}


def _roundings(n: int) -> Array:
    """Bounds of the rounding of complex sums of n terms, in one precision and in two."""
    return np.array([4 * (n + 2) * EPS, 8 * ((n + 2) * EPS) ** 2])


@cache
def _function() -> tuple[int, Callable[..., None]] | None:
    """The compiled program, and the number of its lanes; None where nothing is compiled, or products are not fused."""
    try:
        from workbench.engine.kernel import llvm
    except ImportError:
        return None
    if not llvm.has_fma():
        return None
    width = llvm.lanes()
    arguments = [*[ctypes.c_int64] * len(SIZES), *[ctypes.c_void_p] * len((*INPUT_ARRAYS, *ROOMS, *OUTPUT_ARRAYS))]
    return width, llvm.compile_module(program(width)).function("workbench_responses", *arguments)


def program(width: int) -> str:
    """The program as LLVM IR, for `width` systems side by side."""
    m, n, nu, ny = LoopCode(width), "%n", "%nu", "%ny"
    square, cells, all_sides = m.index("mul", n, n), m.index("mul", nu, ny), m.index("add", nu, ny)
    augmented, twice = m.index("add", square, n), m.index("mul", n, 2)
    A, AT = (SparseRows(f"%A{end}", f"%columns{end}", f"%starts{end}") for end in ("", "T"))
    lengths = {
        "B": m.index("mul", nu, n),
        "C": m.index("mul", ny, n),
        "D": cells,
        "W": m.index("mul", all_sides, augmented),
    }
    answers_of_row = m.index("mul", "%m", cells)

    def block(k: str) -> tuple[()]:
        part = {name: m.part(f"%{name}", k, length) for name, length in lengths.items()}
        right_rows, left_rows = (
            SparseRows(m.part(one.entries, k, "%entries"), one.columns, one.starts) for one in (A, AT)
        )
        of = Systems(n, nu, ny, right_rows, left_rows, part["B"], part["C"], part["D"])
        at = Solutions(*(f"%{name}" for name in ("x", "y", "r", "sizes", "gains", "residuals", "roundings")))
        first = m.index("mul", k, m.index("mul", answers_of_row, width))

        def sides(c: str, to: Callable[[str, str], None]) -> tuple[()]:
            to(m.part(part["W"], c, augmented), m.part("%Q", c, square))
            return ()

        def point(f: str) -> tuple[()]:
            s = (m.broadcast("%s", m.index("mul", f, 2)), m.broadcast("%s", m.index("add", m.index("mul", f, 2), 1)))

            def right(c: str) -> tuple[()]:
                return sides(c, lambda W, Q: hyman(m, n, W, Q, s, "%z", m.part("%x", c, twice)))

            def left(c: str) -> tuple[()]:
                into = m.part("%y", m.index("sub", c, nu), twice)
                return sides(c, lambda W, Q: hyman(m, n, W, Q, s, "%z", into))

            m.fold(0, nu, (), right)
            m.fold(nu, all_sides, (), left)
            answers(m, of, s, at, _scatter_function(m, m.index("add", first, m.index("mul", f, cells)), answers_of_row))
            return ()

        m.fold(0, all_sides, (), lambda c: sides(c, lambda W, Q: reduce(m, n, W, Q, "%z")))
        m.fold(0, "%m", (), point)
        return ()

    m.fold(0, "%blocks", (), block)
    return m.function("workbench_responses", SIZES, (*INPUT_ARRAYS, *ROOMS, *OUTPUT_ARRAYS))


def _scatter_function(m: LoopCode, first: str, apart: str) -> PutAnswer[str, str]:
    """The function that puts answers of a row from a place on, and those of the next rows as far `apart`."""

    def put(place: str, real: str, imaginary: str, error: str, sensitivity: str) -> None:
        index = m.index("add", first, place)
        even, twice = m.index("mul", index, 2), m.index("mul", apart, 2)
        m.scatter("%values", even, twice, real)
        m.scatter("%values", m.index("add", even, 1), twice, imaginary)
        m.scatter("%errors", index, apart, error)
        m.scatter("%sensitivities", index, apart, sensitivity)

    return put
