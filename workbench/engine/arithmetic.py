"""Arithmetics, which round the operations of a step, and engines, which march it.

    fused       a product is rounded once, together with the sum that it is for
    portable    every product and every sum is rounded by itself
    casadi      as CasADi's machine does it, with this platform's elementary functions, for steps that no graph can hold

Engines are "native", compiled for this processor, up to 30,000 operations unless it is named; "numpy", many times
slower; and "casadi". The first two arithmetics have the same bits on every machine, compiled or in NumPy. They know no
sine of more than 1e12 rad and no remainder of a quotient beyond 2^52: a run that comes to need one has diverged.

Without a name the arithmetic follows from the step and the machine alone: one run and a thousand have the same bits.
"""

from __future__ import annotations

import platform
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core import StepMap
from workbench.core.validation.refusals import Array, one_of
from workbench.core.validation.signatures import check_arguments
from workbench.engine.job import Job, March
from workbench.engine.kernel import casadi_machine, numpy_kernel
from workbench.engine.kernel.plan import pass_of

FUSED, PORTABLE, CASADI = NAMES = ("fused", "portable", "casadi")
# Counts up with whatever can change a bit of the first two: the reading and rewriting of graphs, the stages of a step,
# elementary functions, noise, rounding, switches.
VERSION = 2
MOST_COMPILED = 30_000  # operations of a step: LLVM needs minutes for more, and a stack that grows with them
ENGINES = {"native": (FUSED, PORTABLE), "numpy": (PORTABLE, FUSED), "casadi": (CASADI,)}  # the first if none is named


def check(name: object) -> str:
    """The name of an arithmetic, or a refusal."""
    return one_of("simulate(arithmetic=...)", name, NAMES)


def signature(name: str) -> str:
    """The arithmetic and all else on which its bits depend: runs of a step with one signature have the same bits."""
    if check(name) == CASADI:
        return f"{CASADI} {ca.CasadiMeta.version()} {platform.system()} {platform.machine()}"
    return f"{name} {VERSION}"


@check_arguments
def default_for(step: StepMap) -> str:
    """The arithmetic in which a step is compiled here without being asked to; CasADi's where it is not compiled.

    NumPy's march of a thousand runs is up to ten times faster than CasADi's machine, and of one run sixty times slower.
    """
    try:
        pass_of(step)
    except ValueError:  # an operation that the graph does not know
        return CASADI
    if step.rule.written_operations > MOST_COMPILED:
        return CASADI
    return next((name for name in (FUSED, PORTABLE) if is_compiled(step, name)), CASADI)


@check_arguments
def is_compiled(step: StepMap, name: str) -> bool:
    """True if this machine compiles the step in this arithmetic: one at half of the step, which is longer, as well."""
    if step.rule.written_operations > 2 * MOST_COMPILED:
        return False
    try:
        native(name)
    except ImportError:
        return False
    return True


def native(name: str) -> March:
    """The compiled march; an ImportError where nothing can be compiled in this arithmetic."""
    from workbench.engine.kernel import llvm, native

    if check(name) == CASADI:
        raise ImportError("CasADi's machine is no compiler")
    if name == FUSED and not llvm.has_fma():
        raise ImportError("this processor has no fused multiply-add")
    return native.march


def arithmetic_of(step: StepMap, name: str | None = None, engine: str | None = None) -> str:
    """The arithmetic for any number of runs of a step: the named one, the engine's, or `default_for` the step."""
    if engine is not None:
        one_of("simulate(engine=...)", engine, ENGINES)
        chosen = ENGINES[engine][0] if name is None else check(name)
        if chosen not in ENGINES[engine]:
            raise ValueError(
                f"`simulate(arithmetic='{name}', engine='{engine}')` must name an arithmetic that the engine has: "
                f"{' or '.join(map(repr, ENGINES[engine]))}. Leave one of the two names out."
            )
    elif name is not None:
        chosen = check(name)
    else:
        return default_for(step)
    if chosen != CASADI:
        asked = f"engine='{engine}'" if name is None else f"arithmetic='{name}'"
        try:
            pass_of(step)
        except ValueError as error:  # an operation that the graph does not know
            raise ValueError(f"`simulate({asked})` cannot run this step: {error}") from error
    return chosen


def march_of(job: Job, engine: str | None = None) -> March:
    """The march of this engine; without a name the compiled one where it has the job's arithmetic, else another."""
    if job.arithmetic == CASADI:
        return casadi_machine.march
    if engine == "native":
        try:
            return native(job.arithmetic)
        except ImportError as error:
            raise ValueError(f"`simulate(engine='native')` cannot run here: {error}.") from error
    compiled = engine is None and is_compiled(job.step, job.arithmetic)
    return native(job.arithmetic) if compiled else numpy_kernel.march


def advance_states(job: Job, x: Array, begin: int, steps: int) -> Array:
    """The states (B, nx) of a job's runs `steps` steps after those in x (B, nx), which are at step `begin`."""
    job = replace(job, stride=steps, begin=begin)
    rows = np.stack([x, x], axis=1)
    march_of(job)(job, rows, lambda share: None)
    return np.asarray(rows[:, 1])
