"""Loops of a file: the one that a verb is asked for, by its name or that of a case, closed by a computer."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from workbench.core import Ode, SampledSystem
    from workbench.core.equations import Loop

USUAL = "loop"


def sampled_of(
    file: Path, name: str | None = None, period: float | None = None, delay: bool = False, case: str | None = None
) -> tuple[str, SampledSystem]:
    """The name of a loop in a Python file, and the loop in a computer; the file is run for it.

    Parameters
    ----------
    name
        A name at the top level of the file; 'loop', or else the last one that is a loop. Without any, the one case of
        its study.
    period, delay
        Of the computer: the period in s, and True if a command waits one. For a loop that has no computer yet.
    case
        A case of the file's study, as 'scenario: law'.

    Raises
    ------
    ValueError
        If the loop needs a period and has none, has one already, or is no loop of blocks.
    LookupError
        If the file has no such loop.
    """
    from workbench.cli import script

    file = script.file_of(file)
    script.check_file(file)
    module = script.module_of(file)
    if case is not None and name is not None:
        raise ValueError(f"`--loop {name}` and `--case {case}` name two loops; leave one of them out.")
    chosen, loop = _case(module, file, case) if case is not None else _loop(module, file, name)
    return chosen, _sampled(chosen, loop, period, delay)


def _loop(module: ModuleType, file: Path, name: str | None) -> tuple[str, Loop | Ode | SampledSystem]:
    """A loop among the names of a file; without any, the one case of its study."""
    from workbench.blocks.loop import ClosedLoop
    from workbench.core import Ode, SampledSystem
    from workbench.core.validation.refusals import known_name

    held = {key: value for key, value in vars(module).items() if isinstance(value, ClosedLoop | SampledSystem | Ode)}
    if name is not None and (held or not _cases(module)):
        chosen = known_name(name, held, f"loops in '{file}'")
        return chosen, held[chosen]
    if held:
        chosen = USUAL if USUAL in held else [*held][-1]
        return chosen, held[chosen]
    cases = _cases(module)
    if len(cases) == 1 and name is None:
        return next(iter(cases.items()))
    if cases:
        raise LookupError(
            f"'{file}' has no loop by a name, but a study with cases: name one by `--case`, as "
            f"`--case '{next(iter(cases))}'`; there are {', '.join(map(repr, cases))}."
        )
    raise LookupError(
        f"'{file}' has no loop: it must define a `ClosedLoop` or a `SampledSystem` by a name, or a `study`."
    )


def _case(module: ModuleType, file: Path, case: str) -> tuple[str, Loop | Ode | SampledSystem]:
    from workbench.core.validation.refusals import known_name

    cases = _cases(module)
    if not cases:
        raise LookupError(f"'{file}' has no study with cases that are there before it is run; name a loop by `--loop`.")
    return known_name(case, cases, f"cases in '{file}'"), cases[case]


def _cases(module: ModuleType) -> dict[str, Loop | Ode | SampledSystem]:
    """The loops of the cases of a file's study; none if they follow from its tunings."""
    from workbench.study import Study

    study = getattr(module, "study", None)
    if not isinstance(study, Study) or callable(study.cases):
        return {}
    return {case.name: case.run.loop for case in study.cases}


def _sampled(name: str, loop: Loop | Ode | SampledSystem, period: float | None, delay: bool) -> SampledSystem:
    """A loop in a computer."""
    from workbench.blocks.loop import ClosedLoop
    from workbench.core import SampledSystem

    if isinstance(loop, SampledSystem):
        if period is not None or delay:
            raise ValueError(
                f"'{name}' runs in a computer already, every {loop.period:g} s; leave `--period` and `--delay` out."
            )
        return loop
    if not isinstance(loop, ClosedLoop):
        raise ValueError(
            f"'{name}' must be a `ClosedLoop`, or what its `digital` makes, as a computer takes the law alone; got "
            f"`{type(loop).__name__}`."
        )
    if period is None:
        raise ValueError(f"'{name}' is in continuous time: say how often the computer runs it, as `--period 0.001`.")
    return loop.digital(period, delay=delay)
