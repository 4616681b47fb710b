"""Causes of divergence: for each run that a computer loses, its integrator or its law.

If finer steps of the integrator keep a run finite, the integrator lost it. If every way to step loses it, the law did.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.core import Layout, SampledSystem
from workbench.core.equations import Loop, equations_of
from workbench.core.validation.refusals import Array, Integers, known_name, refusal, require, vector
from workbench.core.validation.signatures import check_arguments
from workbench.engine import simulate
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.run_and_sweep import Sweep

FINE = "fine"


@dataclass(frozen=True, eq=False)
@check_arguments
class Causes:
    """Repetitions of B runs that diverged, from the same rows and noise, with other ways to step the memories.

    `diverges` has (B,) numbers for each way: 1 for a run that diverges in this way, too. The way "fine" is near the
    exact flow of the memories of the computer.

    Raises
    ------
    LookupError
        If no way is called "fine".
    ValueError
        If the ways are not of equally many runs.

    Examples
    --------
    >>> len(wb.evidence.Causes({"fine": np.array([0, 1])}).diverges)
    1
    """

    diverges: Mapping[str, Integers]

    def __post_init__(self) -> None:
        known_name(FINE, self.diverges, "ways to step the computer's memories")
        for way, lost in self.diverges.items():
            vector(f"Causes(diverges={{{way!r}: ...}})", lost, self.diverges[FINE].size, "lost runs")

    @property
    def by_integrator(self) -> int:
        """The number of runs that stay finite under "fine": they diverged because of the integrator."""
        return int((self.diverges[FINE] == 0).sum())

    @property
    def by_law(self) -> int:
        """The number of runs that diverge in every way: they diverge because of the law."""
        return int(np.min(list(self.diverges.values()), axis=0).sum())

    @property
    def undecided_runs(self) -> int:
        """The number of runs that diverge under "fine" and stay finite in another way."""
        return len(self.diverges[FINE]) - self.by_integrator - self.by_law

    @property
    def sentence(self) -> str:
        """The counts in words."""
        open_ = f", unsettled: {self.undecided_runs}" if self.undecided_runs else ""
        return f"by the integrator: {self.by_integrator}, by the law: {self.by_law}{open_}"


@check_arguments
def causes(
    ways: Mapping[str, SampledSystem],
    p: Array,
    x0: Array | None = None,
    *,
    until: float,
    substeps: int = 1,
    seed: int = 0,
    noise_keys: Integers | None = None,
) -> Causes:
    """The causes of divergence: each lost run is run again in every way that a computer may step its memories.

    Parameters
    ----------
    ways
        One loop by the names of ways: `ClosedLoop.digital(..., integrator="fine")` under "fine", and under other
        names that of blocks with another `integrator`.
    p, x0
        (B, np) and (B, nx), the rows of the lost runs, or one row for all.
    substeps
        The steps of the plant in a period.
    seed, noise_keys
        The keys of the noise that they had, as `simulate` takes them.

    Raises
    ------
    LookupError
        If no way is called "fine".
    ValueError
        If a way is no `SampledSystem`, has other states or parameters than the others, or `simulate` refuses.
    """
    if FINE not in ways:
        raise LookupError(f"`causes(ways)` needs the way '{FINE}' to tell law from integrator; got {sorted(ways)}.")
    lost = {}
    for name, sampled in ways.items():
        require(f"causes(ways={{'{name}': ...}})", sampled, SampledSystem)
        if [part.labels for part in _layouts(sampled)] != [part.labels for part in _layouts(ways[FINE])]:
            raise ValueError(
                f"`causes(ways)` must hold one loop in several ways; '{name}' has other states or parameters than "
                f"'{FINE}'."
            )
        step = sampled.step(substeps)
        ended = simulate(step, p, x0, until=until, every=until, seed=seed, noise_keys=noise_keys)
        lost[name] = np.isfinite(ended.diverged_at).astype(int)
    return Causes(lost)


@check_arguments
def causes_in_sweep(sweep: Sweep, diverged_runs: Integers, ways: Mapping[str, Loop]) -> Causes:
    """The causes of divergence of runs of a sweep: each run is repeated with its row and noise in each of the ways.

    `diverged_runs` (B,) are the numbers of the runs, and `ways` has a loop for each way by name.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=10.0, Ki=20.0)
    >>> loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> run = wb.Run(loop.digital(0.01), (wb.rmse(),), until=0.1, h=0.01)
    >>> gain = wb.Factor("gain", ("controller.Kp",), wb.Uniform(5.0, 20.0))
    >>> sweep = wb.Sweep("gain", run, (gain,), wb.uncertainty.MonteCarlo(1, 4))
    >>> ways = {"fine": loop.digital(0.01, integrator="fine")}
    >>> wb.evidence.causes_in_sweep(sweep, np.array([0, 2]), ways).sentence
    'by the integrator: 2, by the law: 0'
    """
    runs = sweep.design.size
    if diverged_runs.ndim != 1 or not diverged_runs.size or diverged_runs.min() < 0 or diverged_runs.max() >= runs:
        raise refusal(
            "causes_in_sweep(diverged_runs=...)", f"numbers (B,) of the {runs} runs, one at least", diverged_runs
        )
    made = compile_sweep(sweep)
    equation = require("causes_in_sweep(sweep=...) of a loop", made.equation, SampledSystem)
    rows = [made.rows(int(run), int(run) + 1) for run in diverged_runs]
    p = np.concatenate([row[0] for row in rows])
    x0 = np.concatenate([row[1][:, : equation.states.size] for row in rows])
    loops = {
        name: require(f"causes(ways={{'{name}': ...}})", equations_of(loop, name), SampledSystem)
        for name, loop in ways.items()
    }
    substeps = equation.substeps(made.h)
    keys = np.zeros_like(diverged_runs) if sweep.common else diverged_runs
    return causes(loops, p, x0, until=sweep.run.until, substeps=substeps, seed=sweep.run.seed, noise_keys=keys)


def _layouts(sampled: SampledSystem) -> tuple[Layout, Layout]:
    return sampled.states, sampled.parameters
