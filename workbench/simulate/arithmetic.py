"""An arithmetic is a name for how the operations of a step are rounded: runs of a step in one have the same bits.

    fused       a product is rounded once, together with the sum that it is for
    portable    every product and every sum is rounded by itself
    casadi      as CasADi's machine does it, with the elementary functions of this platform's library

The first two are those of a step's graph. Their operations are those that IEEE 754 rounds in one way, so that they
have the same bits on every machine, compiled or in NumPy. They know no sine of more than 1e12 rad and no remainder of
a quotient beyond 2^52: a run that comes to need one has diverged. The third is for steps that no graph can hold.
"""

from __future__ import annotations

import platform

import casadi as ca

from workbench.core import Step
from workbench.simulate.job import March
from workbench.simulate.kernel.plan import pass_of
from workbench.validation.refusals import one_of
from workbench.validation.signatures import door

FUSED, PORTABLE, CASADI = NAMES = ("fused", "portable", "casadi")
# Counts up with whatever can change a bit of the first two: the reading and rewriting of graphs, the stages of a step,
# elementary functions, noise, rounding.
VERSION = 1
MOST_COMPILED = 30_000  # operations of a step: LLVM needs minutes for more, and a stack that grows with them


def check(name: object) -> str:
    """The name of an arithmetic, or a refusal."""
    return one_of("simulate(arithmetic=...)", name, NAMES)


def signature(name: str) -> str:
    """The arithmetic and all that its bits depend on besides the step: runs with one signature have the same bits.

    Raises
    ------
    ValueError
        If there is no arithmetic of that name.
    """
    if check(name) == CASADI:
        return f"{CASADI} {ca.CasadiMeta.version()} {platform.system()} {platform.machine()}"
    return f"{name} {VERSION}"


@door
def default_for(step: Step) -> str:
    """The arithmetic in which this machine runs many copies of a step best, whoever else runs it.

    It is that of the compiled march where this can run the step, else that of NumPy, or of CasADi if no graph holds
    the step. `simulate` takes it too, but for few runs of what it cannot compile, which CasADi is fastest with.
    """
    if not has_graph(step):
        return CASADI
    return FUSED if is_compiled(step, FUSED) else PORTABLE


@door
def has_graph(step: Step) -> bool:
    """Whether a graph can hold the step: whether all of its operations are known."""
    try:
        pass_of(step)
    except ValueError:
        return False
    return True


@door
def is_compiled(step: Step, name: str) -> bool:
    """Whether this machine compiles the step in this arithmetic without being asked to."""
    if step.operations > MOST_COMPILED:
        return False
    try:
        native(name)
    except ImportError:
        return False
    return True


def native(name: str) -> March:
    """The compiled march; an ImportError where nothing can be compiled in this arithmetic."""
    from workbench.simulate.kernel import llvm, native

    if check(name) == CASADI:
        raise ImportError("CasADi's machine is no compiler")
    if name == FUSED and not llvm.has_fma():
        raise ImportError("this processor has no fused multiply-add")
    return native.march
