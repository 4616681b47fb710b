"""Loops that a computer closes: a fit takes those without random numbers whose commands do not jump by themselves.

The outputs of a loop that rounds its readings are constant in a parameter until a reading passes to its next step, and
jump there. Their derivatives, zero nearly everywhere, say nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import casadi as ca
import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.validation.refusals import Array
from workbench.identification.datasets import Dataset
from workbench.identification.estimation.sampling_instants import SAME
from workbench.identification.estimation.unknown_numbers import UnknownNumber

ROUGH = {ca.OP_FLOOR: "rounds", ca.OP_CEIL: "rounds", ca.OP_SIGN: "switches by a sign"}


Operations = Callable[[SampledSystem, Array, Sequence[int]], list[str]]  # of a jump
ONE_A_PERIOD = 0.01  # relative distance of the time between two samples from whole periods


def refuse_random_computer(call: str, system: Ode | SampledSystem, p: Array, argument: str) -> None:
    """Refuse a computer with random numbers at the parameters p (np,), which an argument of the call changes."""
    if not isinstance(system, SampledSystem) or not _random_numbers(system, p, ()):
        return
    names = _causes(system, p, (), _random_numbers)
    raise ValueError(
        f"`{call}(system=...)` must have a computer without random numbers, as one run stands for the log; hold "
        f"{names or 'the noise of its instruments'} at 0 by `{argument}`."
    )


def refuse_rough_computer(call: str, system: Ode | SampledSystem, p: Array, numbers: Sequence[UnknownNumber]) -> None:
    """Refuse a computer whose jump is no smooth function of states and unknown numbers, and delays of what it reads."""
    if not isinstance(system, SampledSystem):
        return
    if delays := [number.name for number in numbers if number.kind == "delay"]:
        raise ValueError(
            f"`{call}(free=...)` must have no delay where a computer closes the loop, as what it reads at an instant "
            f"may jump with the delay; got '{delays[0]}': shift the signal in the log."
        )
    labels = system.parameters.labels
    free = tuple(labels.index(number.label) for number in numbers if number.kind == "parameter")
    if not (kinds := _rough_operations(system, p, free)):
        return
    names = _causes(system, p, free, _rough_operations)
    raise ValueError(
        f"`{call}(system=...)` must have a computer whose commands change smoothly with states and parameters, as a "
        f"search needs derivatives; this one {kinds[0]}: "
        f"{f'hold {names} at 0 by `start`' if names else 'give the loop without that'}."
    )


def timing_remarks(system: Ode | SampledSystem, dataset: Dataset) -> tuple[str, ...]:
    """A remark on a log with a sample each period of a computer, or each few, that lie beside its instants."""
    if not isinstance(system, SampledSystem):
        return ()
    beside = 0.0
    for experiment in dataset:
        periods = (experiment.t - experiment.t[0]) / system.period
        apart = float(np.median(np.diff(periods)))
        if round(apart) >= 1 and abs(apart / round(apart) - 1) <= ONE_A_PERIOD:
            beside = max(beside, float(np.abs(periods - np.round(periods)).max()))
    if beside <= SAME:
        return ()
    return (
        f"Samples lie up to {beside * system.period:.2g} s beside the instants of the computer, which are "
        f"{system.period:g} s apart from the first sample on; one before an instant shows the command before it.",
    )


def _jump_at(system: SampledSystem, p: Array, free: Sequence[int]) -> ca.Function:
    """The jump as a function of (k, w, x, p), with numbers in the place of parameters but those at the places `free`.

    So nothing is left of an instrument whose step or noise is 0.
    """
    fixed, flow = [i for i in range(p.size) if i not in free], system.flow
    jump = ca.substitute(system.jump, flow.p[fixed], ca.SX(p[fixed])) if fixed else system.jump
    return ca.Function("jump", [system.k, system.w, flow.x, flow.p], [ca.densify(jump)])


def _random_numbers(system: SampledSystem, p: Array, free: Sequence[int]) -> list[str]:
    """The random numbers that the jump uses."""
    function = _jump_at(system, p, free)
    used = [function.instruction_id(line) == ca.OP_INPUT for line in range(function.n_instructions())]
    places = [function.instruction_input(line) for line in np.flatnonzero(used).tolist()]
    return [f"w[{place[1]}]" for place in places if place[0] == 1]


def _rough_operations(system: SampledSystem, p: Array, free: Sequence[int]) -> list[str]:
    """The ways in which the jump rounds, or takes the sign of, a state or a free parameter, as clauses."""
    function, kinds = _jump_at(system, p, free), list[str]()
    moving = dict[int, bool]()
    for line in range(function.n_instructions()):
        code, reads = function.instruction_id(line), function.instruction_input(line)
        if code == ca.OP_OUTPUT:
            continue
        moves = reads[0] >= 2 if code == ca.OP_INPUT else code != ca.OP_CONST and any(moving[i] for i in reads)
        if moves and code in ROUGH:
            kinds.append(ROUGH[code])
        moving.update(dict.fromkeys(function.instruction_output(line), moves))
    return kinds


def _causes(
    system: SampledSystem,
    p: Array,
    free: Sequence[int],
    count: Callable[[SampledSystem, Array, Sequence[int]], list[str]],
) -> str:
    """The parameters without which there would be less of something in the jump, by name."""
    every, names = len(count(system, p, free)), []
    for i in np.flatnonzero(p).tolist():
        less = p.copy()
        less[i] = 0.0
        if len(count(system, less, free)) < every:
            names.append(f"'{system.parameters.labels[i]}'")
    return ", ".join(names)
