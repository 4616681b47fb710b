"""Which march serves a job: compiled where it can be, NumPy or CasADi's machine elsewhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.core.numbers import Array
from workbench.simulate.job import PAIRS, Job, March
from workbench.simulate.kernel import numpy_kernel, virtual_machine
from workbench.simulate.kernel.plan import pass_of

MOST_COMPILED = 30_000  # operations of a step: LLVM needs minutes for more, and a stack that grows with them
FEW_RUNS = 64  # up to so many, CasADi's machine is faster than NumPy


def continued(job: Job, x: Array, begin: int, steps: int) -> Array:
    """The states (B, nx) of a job's runs `steps` steps after those in x (B, nx), which are at step `begin`."""
    job = replace(job, stride=steps, begin=begin)
    rows = np.stack([x, x], axis=1)
    march_of(job)(job, rows, lambda share: None)
    return np.asarray(rows[:, 1])


def march_of(job: Job, engine: str | None = None) -> March:
    """The compiled march where it can be had, another elsewhere; by name, that one or a refusal."""
    if engine not in (None, "native", "numpy", "casadi"):
        raise ValueError(
            f"`simulate(engine=...)` is 'native', 'numpy', 'casadi' or None for the best of them; got {engine!r}."
        )
    if engine == "casadi":
        return virtual_machine.march
    try:
        pass_of(job.step)
    except ValueError as error:  # an operation that the graph does not know
        if engine is not None:
            raise ValueError(f"`simulate(engine='{engine}')` cannot run this step: {error}") from error
        return virtual_machine.march
    if engine == "numpy":
        return numpy_kernel.march
    elsewhere = virtual_machine.march if len(job.p) <= FEW_RUNS else numpy_kernel.march
    if engine is None and job.step.operations > MOST_COMPILED:
        return elsewhere
    try:
        return _native()
    except ImportError as error:
        if engine == "native":
            raise ValueError(f"`simulate(engine='native')` cannot run here: {error}.") from error
        return elsewhere


def march_of_pairs(job: Job) -> March | None:
    """What marches few runs at their step and at twice of it side by side; None where there is nothing that does."""
    if len(job.p) > PAIRS:
        return None
    try:
        native = _native()
    except ImportError:
        return None
    return native if march_of(job) is native else None


def _native() -> March:
    """The compiled march; an ImportError where nothing can be compiled."""
    from workbench.simulate.kernel import llvm, native

    if not llvm.has_fma():
        raise ImportError("this processor has no fused multiply-add")
    return native.march
