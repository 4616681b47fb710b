"""`design_experiment`: the input that tells most about some numbers of a system within its limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.equations import Loop
from workbench.core.validation.refusals import one_of, whole
from workbench.core.validation.refusals import seed as check_seed
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import one_thread
from workbench.identification.estimation.fit_system import start_values
from workbench.identification.estimation.input_record import HOLDS
from workbench.identification.estimation.system_equations import continuous_system
from workbench.identification.experiments.design_problem import CALL, InputSchedule, dataset_of, problem_of
from workbench.identification.experiments.design_search import DesignEnd, search
from workbench.identification.experiments.experiment_design import DesignCertificate, ExperimentDesign
from workbench.identification.experiments.information_criterion import CRITERIA
from workbench.identification.experiments.plain_excitations import PlainExcitation, plain_excitations

ROUNDS = 10  # of the last search


@check_arguments
@one_thread()
def design_experiment(
    system: Ode | SampledSystem | Loop,
    free: Sequence[str],
    inputs: Sequence[str],
    outputs: Sequence[str],
    *,
    noise: Mapping[str, float],
    limits: Mapping[str, tuple[float, float]],
    until: float,
    every: float,
    period: float | None = None,
    harmonics: int | Sequence[int] = 5,
    steps: int | None = None,
    criterion: str = "D",
    hold: str = "hold",
    start: Mapping[str, float] | None = None,
    starts: int = 4,
    seed: int = 0,
) -> ExperimentDesign:
    """Design inputs that make the expected covariance P of estimates small, within limits, before anything is measured.

        min over c of log det P (D) or trace P (A),   P = (sum_k J_k^T J_k)^-1,   J_k = (dy(t_k)/dz) / sigma

    Parameters
    ----------
    system, free, start
        As for `wb.fit`; delays need hold "linear". P counts relative to the sizes of z, and is exact at its values.
    inputs, outputs, noise, limits
        Names of the inputs that are designed and of the outputs that are measured, with standard deviations of their
        noise; and low and high ends of inputs, states, outputs and rates by name, as "rate of omega".
    until, every, period, harmonics, steps
        Duration, time between samples, and period in s, which divides the duration. The harmonics of the period by
        count or orders, of which 0 is the constant; or the number of steps in a period.
    criterion, hold, starts, seed
        "D" or "A"; "hold" if an input keeps its value until the next sample, or "linear"; searches and their key.

    Raises
    ------
    ValueError
        If no input tells the numbers apart, limits cross or leave no room, or an argument is out of its bounds.
    LookupError
        If a name is unknown.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> design = wb.design_experiment(
    ...     motor, ["J", "R"], ["v"], ["omega"], noise={"omega": 0.01}, limits={"v": (-12.0, 12.0)},
    ...     until=4.0, every=0.05, steps=4, starts=1)
    >>> design.active_limits
    ('v',)
    >>> design.ratios["chirp"]["J"] > 1.0  # its interval is longer than that of the design
    True
    """
    ode, schedule = continuous_system(system, CALL), InputSchedule.of(until, every, period, harmonics, steps)
    which = one_of(f"{CALL}(criterion=...)", criterion, CRITERIA), one_of(f"{CALL}(hold=...)", hold, HOLDS)
    problem = problem_of(ode, free, inputs, outputs, noise, limits, schedule, *which, start_values(CALL, start))
    count, key = whole(f"{CALL}(starts=...)", starts), check_seed(f"{CALL}(seed=...)", seed)
    generator = np.random.default_rng(key)
    end = search(problem, count, ROUNDS, generator, tuple(inputs))
    return _design_of(end, schedule, tuple(inputs), plain_excitations(end.problem, generator))


def _design_of(
    end: DesignEnd, schedule: InputSchedule, inputs: tuple[str, ...], plain: Mapping[str, PlainExcitation]
) -> ExperimentDesign:
    """The answer at the end of a search."""
    problem, c = end.problem, end.c
    model, finer = problem.response.model, problem.response.at_half_step()
    margins = np.min(finer.margins(c), axis=(0, 2))
    J = finer.derivatives(c)
    named = dict(zip(problem.response.limits.all_names, margins.tolist(), strict=True))
    return ExperimentDesign(
        dataset=dataset_of(model.ode, inputs, schedule.t, problem.response.basis @ c.T),
        criterion=problem.criterion.name,
        value=problem.criterion.value(J),
        names=tuple(number.name for number in model.numbers),
        values=model.starts,
        sizes=problem.criterion.sizes,
        covariance=problem.criterion.covariance(J),
        shape=problem.shape,
        coefficients=c,
        period=schedule.period,
        plain=plain,
        certificate=DesignCertificate(named, end.by_half_step, end.goals),
    )
