"""One thread for the linear algebra of a solver.

OpenBLAS lets its threads wait for one another in a loop. In the many small steps of a Schur form they do so most
of the time, and where another program needs a processor too they wait for that: 70 s instead of 10 at n = 421.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

import numpy.linalg  # noqa: F401
import scipy.linalg  # noqa: F401  both bring a BLAS of their own, which must be here before it is looked for
from threadpoolctl import ThreadpoolController


@contextmanager
def one_thread() -> Iterator[None]:
    """Within it, the BLAS of NumPy and SciPy runs one thread in this process; other libraries stay as they are.

    The number is of the whole process. Where two solvers run at once in threads of Python it may stay one.
    """
    with libraries().limit(limits=1, user_api="blas"):
        yield


@cache
def libraries() -> ThreadpoolController:
    """What of this process has a number of threads, as found when it is first asked."""
    return ThreadpoolController()
