"""The compiled march, for which some platforms have no wheel: the mark of a test that needs it, and what stands in."""

from importlib.util import find_spec

import pytest

from tests.support.equations import decay
from workbench.core import rk4
from workbench.engine import arithmetic

COMPILES = find_spec("llvmlite") is not None
WITHOUT = "nothing is compiled here without llvmlite"
needs_llvmlite = pytest.mark.skipif(not COMPILES, reason=WITHOUT)
NATIVE = pytest.param("native", marks=needs_llvmlite)
ENGINES = ("native", "numpy", "casadi") if COMPILES else ("numpy", "casadi")  # the fastest first

STEP = rk4(decay(), 0.1)
ARITHMETIC = arithmetic.default_for(STEP)  # of all small steps
SLOW = (  # the lines before a sweep that is not compiled
    ()
    if arithmetic.is_compiled(STEP, ARITHMETIC)
    else (f"The arithmetic '{ARITHMETIC}' is not compiled here: the same bits take some 100 times longer.\n",)
)
