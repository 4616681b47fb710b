"""The simulation of a loop or of a step: many runs, at a step that is named, or chosen for a tolerance."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TypedDict

from workbench.core import Ode, SampledSystem, StepMap, rk4
from workbench.core.equations import LOOP, Loop, equations_of, is_loop
from workbench.core.methods import RK4
from workbench.core.validation import refusals
from workbench.core.validation.refusals import Array, Integers
from workbench.core.validation.signatures import check_arguments
from workbench.engine.batch import progress_of, rows_of, run_step
from workbench.engine.job import Progress
from workbench.engine.pilot_selection import pilot_runs
from workbench.engine.state_changes import state_change
from workbench.engine.step_choice import Make, Pilots, search_step
from workbench.engine.trajectories import Trajectories

TOLERANCE = 1e-3  # for which a step is chosen
NAMED_TOLERANCE = 1e-2  # against which one that the user names is held
TIMES = 1000  # that are kept of an `Ode`, unless `every` is given


class SharedOptions(TypedDict):
    """The options of `run_step` that a run and its pilots have in common."""

    until: float
    seed: int
    noise_keys: Integers | None
    progress: Progress | None
    arithmetic: str | None
    engine: str | None


@check_arguments
def simulate(
    step: StepMap | Ode | SampledSystem | Loop,
    p: Array | None = None,
    x0: Array | None = None,
    *,
    until: float,
    every: float | None = None,
    tolerance: float | None = None,
    seed: int = 0,
    noise_keys: Integers | None = None,
    progress: Progress | None = None,
    arithmetic: str | None = None,
    engine: str | None = None,
) -> Trajectories:
    """Run B copies of a loop from time 0 to `until`, each with its own parameters and initial state.

    A run depends only on its rows of p and x0, its key in `noise_keys`, seed, arithmetic and step, not on other runs.
    `Trajectories.warnings` says if the step is beyond its stability limit, or changes the result.

    Parameters
    ----------
    step
        The system: a loop, an `Ode` or a `SampledSystem`, whose step size pilot runs choose, or a `StepMap`.
    p, x0
        (B, np) and (B, nx), as `pack` of their layouts gives; one row serves all. Do not change arrays above 64 MB
        later: they are not copied.
    until, every
        Horizon and time between kept states, in s; by default each step of a `StepMap`, 1000 intervals of an `Ode`.
    tolerance
        The allowed change of a state when the step is halved, over its largest value: 0.001, or 0.01 for a `StepMap`.
    seed, noise_keys
        The keys of the noise: a whole number, and one number (B,) for each run, by default 0, 1, 2, ...
    progress
        Called with the share of the work that is done, from 0 to 1.
    arithmetic, engine
        Names as in `workbench.engine.arithmetic`; by default those that run the step fastest.

    Raises
    ------
    ValueError
        If an argument is out of its bounds, a time is no multiple of the step, no step keeps the tolerance, or the runs
        take too much memory or time. A run that diverges is only marked.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> p = motor.parameters.pack({"v": np.array([1.0, 2.0, 3.0])})
    >>> runs = wb.simulate(motor, p, until=5.0)
    >>> runs["omega"].shape, runs["omega"][:, -1].round(3)
    ((3, 1001), array([0.1, 0.2, 0.3]))
    >>> wb.simulate(wb.rk4(motor, 1e-3), p, until=5.0)
    <3 runs of 'plant' at 5001 times to 5 s>
    """
    how = SharedOptions(
        until=until, seed=seed, noise_keys=noise_keys, progress=progress, arithmetic=arithmetic, engine=engine
    )
    tolerance = None if tolerance is None else refusals.positive("simulate(tolerance=...)", tolerance)
    if isinstance(step, StepMap):
        return replace(run_step(step, p, x0, every=every, **how), tolerance=tolerance or NAMED_TOLERANCE)
    return _at_chosen_step(_equations(step), p, x0, every, tolerance or TOLERANCE, how)


def _equations(step: Ode | SampledSystem | Loop) -> Ode | SampledSystem:
    """The equations of a loop; what is neither a loop nor a step is refused."""
    if not is_loop(step):
        raise refusals.refusal("simulate(step=...)", f"a `StepMap`, {LOOP}", step)
    return equations_of(step, "loop")


def _at_chosen_step(
    equation: Ode | SampledSystem,
    p: Array | None,
    x0: Array | None,
    every: float | None,
    tolerance: float,
    how: SharedOptions,
) -> Trajectories:
    until = refusals.seconds("simulate(until=...)", how["until"])
    (equation.flow if isinstance(equation, SampledSystem) else equation).refuse_beyond("simulate(until=...)", until)
    kept = _kept_spacing(equation, until, every)
    unit = equation.period if isinstance(equation, SampledSystem) else kept
    p_rows, x_rows = rows_of("simulate", _step(equation, unit), p, x0)
    progress_of("simulate", how["progress"])  # one that fails costs no pilot
    few = pilot_runs(p_rows, x_rows)
    make: Make = cache(lambda h, method: _step(equation, h))
    methods = (RK4.name,)  # as that of a page
    pilots = Pilots(
        equation, make, state_change, p_rows[few], x_rows[few], until, unit, how["seed"], how["arithmetic"], methods
    )
    made = run_step(make(search_step(pilots, tolerance).h, RK4.name), p, x0, every=kept, **how)
    return replace(made, tolerance=tolerance, is_step_chosen=True)


def _step(equation: Ode | SampledSystem, h: float) -> StepMap:
    """The step of length h [s] of an equation; of a sampled loop its period in substeps of that length."""
    return equation.step(equation.substeps(h)) if isinstance(equation, SampledSystem) else rk4(equation, h)


def _kept_spacing(equation: Ode | SampledSystem, until: float, every: float | None) -> float:
    """The distance of the kept times in s, of which the horizon is a multiple."""
    unit = equation.period if isinstance(equation, SampledSystem) else None
    if unit is not None:
        refusals.multiple("simulate(until=...)", until, unit, "the sampling period")
    if every is None:
        return until / TIMES if unit is None else unit
    every = refusals.seconds("simulate(every=...)", every)
    refusals.multiple("simulate(until=...)", until, every, "`every`,")
    if unit is not None:
        refusals.multiple("simulate(every=...)", every, unit, "the sampling period")
    return every
