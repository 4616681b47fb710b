"""The sweeps and cases of a study, compiled as an order and the ledger of an earlier run ask for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from workbench.simulate.arithmetic import signature
from workbench.study.case_runs import CompiledCase, compile_cases
from workbench.study.compiled import CompiledSweep, compile_sweep
from workbench.study.contract import Sweep, count_of, resized
from workbench.study.ledger.ownership import LedgerError
from workbench.study.ledger.store import about_in
from workbench.study.order import ArithmeticOf, Order
from workbench.study.study import Study

NAMED = 3  # sweeps that a message names

Sweeps = tuple[Sweep, ...] | Callable[..., tuple[Sweep, ...]]


def arithmetics_of(out: Path, order: Order) -> ArithmeticOf:
    """The arithmetic of a sweep, by its name: the one that is asked for, or else that of its chunks in the ledger."""
    about = None if order.fresh else about_in(out)
    kept = {sweep.name: sweep.arithmetic for sweep in about.sweeps} if about else {}

    def arithmetic_of(name: str) -> str | None:
        if name not in kept:
            return order.arithmetic
        chosen = order.arithmetic or kept[name].partition(" ")[0]
        if signature(chosen) != kept[name]:
            raise LedgerError(
                f"The ledger in '{out}' holds runs of '{name}' in the arithmetic '{kept[name]}', and this run would "
                f"compute in '{signature(chosen)}': two do not mix. Take the other one by `--arithmetic` or its own "
                "version, name another folder with `--out`, or begin anew with `--fresh`."
            )
        return chosen

    return arithmetic_of


def compiled_sweeps(name: str, sweeps: Sweeps, order: Order, arithmetic_of: ArithmeticOf) -> tuple[CompiledSweep, ...]:
    """The sweeps of a study that are known, compiled, with as many samples as are asked for."""
    if callable(sweeps):
        return ()
    fixed = [one.name for one in sweeps if count_of(one) is None]
    if order.samples is not None and fixed:
        names = ", ".join(f"'{name}'" for name in fixed[:NAMED]) + (
            f" and {len(fixed) - NAMED} more" * (len(fixed) > NAMED)
        )
        if len(fixed) == len(sweeps):
            raise ValueError(
                f"`--samples` cannot change the study '{name}': the designs of its sweeps, {names}, have no "
                "number of samples; leave it out."
            )
        order.say(f"`--samples` changes nothing of {names}: their designs have no number of samples.")
    return compile_sweeps(sweeps, order.samples, arithmetic_of)


def compiled_cases(study: Study, out: Path, order: Order) -> tuple[CompiledCase, ...]:
    """The cases of a study that are known, compiled in the arithmetic asked for, or else in that of the ledger."""
    if callable(study.cases):
        return ()
    about = None if order.fresh else about_in(out)
    held = about.cases.arithmetic.split("; ") if about and about.cases else ()
    names = {one.partition(" ")[0] for one in held}
    return compile_cases(study.cases, order.arithmetic or (names.pop() if len(names) == 1 else None))


def compile_sweeps(
    sweeps: Sequence[Sweep], samples: int | None, arithmetic_of: ArithmeticOf
) -> tuple[CompiledSweep, ...]:
    """Sweeps compiled, with so many samples each."""
    return tuple(compile_sweep(resized(one, samples), arithmetic_of(one.name)) for one in sweeps)
