"""Which march serves a job: compiled where it can be, NumPy or CasADi's machine elsewhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.core import Step
from workbench.simulate import arithmetic as of
from workbench.simulate.arithmetic import CASADI, FUSED, PORTABLE
from workbench.simulate.job import PAIRS, Job, March
from workbench.simulate.kernel import numpy_kernel, virtual_machine
from workbench.simulate.kernel.plan import pass_of
from workbench.validation.refusals import Array, one_of

FEW_RUNS = 64  # up to so many, CasADi's machine is faster than NumPy
ENGINES = {"native": (FUSED, PORTABLE), "numpy": (PORTABLE, FUSED), "casadi": (CASADI,)}  # the first if none is named


def continued(job: Job, x: Array, begin: int, steps: int) -> Array:
    """The states (B, nx) of a job's runs `steps` steps after those in x (B, nx), which are at step `begin`."""
    job = replace(job, stride=steps, begin=begin)
    rows = np.stack([x, x], axis=1)
    march_of(job)(job, rows, lambda share: None)
    return np.asarray(rows[:, 1])


def arithmetic_of(step: Step, runs: int, name: str | None = None, engine: str | None = None) -> str:
    """The arithmetic for some runs of a step: the named one, else that of the engine, else of what runs them fastest.

    Raises
    ------
    ValueError
        If there is none of that name, the engine has not got it, or the step cannot be run in it.
    """
    if engine is not None:
        one_of("simulate(engine=...)", engine, ENGINES)
    if name is not None and engine is not None and of.check(name) not in ENGINES[engine]:
        raise ValueError(
            f"`simulate(arithmetic='{name}', engine='{engine}')` must name an arithmetic that the engine has: "
            f"{' or '.join(map(repr, ENGINES[engine]))}. Leave one of the two names out."
        )
    if name is None and engine is None:
        default = of.default_for(step)
        return CASADI if runs <= FEW_RUNS and not of.is_compiled(step, default) else default
    chosen = ENGINES[engine][0] if name is None and engine is not None else of.check(name)
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
        return virtual_machine.march
    if engine == "native":
        try:
            return of.native(job.arithmetic)
        except ImportError as error:
            raise ValueError(f"`simulate(engine='native')` cannot run here: {error}.") from error
    compiled = engine is None and of.is_compiled(job.step, job.arithmetic)
    return of.native(job.arithmetic) if compiled else numpy_kernel.march


def march_of_pairs(job: Job) -> March | None:
    """What marches few runs at their step and at twice of it side by side; None where there is nothing that does."""
    if len(job.p) > PAIRS or job.arithmetic == CASADI or not of.is_compiled(job.step, job.arithmetic):
        return None
    return of.native(job.arithmetic)
