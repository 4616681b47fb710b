"""One thread for the linear algebra of a solver.

OpenBLAS lets its threads wait for one another in a loop. In the many small steps of a Schur form they do so most
of the time, and where another program needs a processor too they wait for that: 70 s instead of 10 at n = 421.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from numpy.linalg import _umath_linalg
from scipy.linalg import _flapack

# the names that its builds give to `openblas_set_num_threads`, and to its fellow that gets
PREFIXES, SUFFIXES = ("scipy_", ""), ("64_", "")


@contextmanager
def one_thread() -> Iterator[None]:
    """Within it, OpenBLAS as NumPy and SciPy use it runs one thread in this process; other libraries stay as they are.

    The number is of the whole process. Where two solvers run at once in threads of Python it may stay one.
    """
    before = [(change, usual()) for usual, change in _libraries()]
    for change, _ in before:
        change(1)
    try:
        yield
    finally:
        for change, usual in before:
            change(usual)


@cache
def _libraries() -> tuple[tuple[Callable[[], int], Callable[[int], Any]], ...]:
    """The functions that get and set the number of threads, of every OpenBLAS found."""
    found = []
    for module in (_umath_linalg, _flapack):
        library = ctypes.CDLL(module.__file__)
        for name in (f"{prefix}openblas_{{}}_num_threads{suffix}" for prefix in PREFIXES for suffix in SUFFIXES):
            if hasattr(library, name.format("set")) and hasattr(library, name.format("get")):
                found.append((getattr(library, name.format("get")), getattr(library, name.format("set"))))
                break
    return tuple(found)
