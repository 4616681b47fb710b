"""The certificate of a plan: the march from node to node and from the start, limits between nodes, and the optimum."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.planning.trajectories.marching import STEPS, defects, march, ranges, run_from_start
from workbench.planning.trajectories.passed_limits import violations_of
from workbench.planning.trajectories.plan_search import PlanSearchEnd

BETWEEN = 1e-3  # of the size of a limit, by which a state may pass it between nodes


@dataclass(frozen=True)
@show
class PlanCertificate:
    """The checks of a plan. Distances are shares of the range of each state.

    Parameters
    ----------
    defect
        The largest distance by which the simulator, started at a node with the inputs of the plan, misses the next one.
    run_defect
        The same in one run from the start to the end, which an unstable plant enlarges.
    march_error
        The largest change of the march by half its step.
    violations
        By limit, the largest excess on the march, nodes and between, as a share of the size of the limit.
    kkt
        The residual of the optimality conditions in the solver's scaling.
    objective_error
        The relative change of the objective by the last cut of all intervals; of held inputs a third of it, as their
        error falls with the square of the length.
    tolerance, objective_tolerance
        What was asked of `defect` and of `objective_error`.
    status
        The solver's word for its end.
    """

    defect: float
    run_defect: float
    march_error: float
    violations: Mapping[str, float]
    kkt: float
    objective_error: float
    tolerance: float
    objective_tolerance: float
    status: str

    def __repr__(self) -> str:
        word = "passed" if self.is_passed else "failed"
        return f"<PlanCertificate: {word}, misses a node by at most {self.defect:.1g} of the range of a state>"

    @property
    def is_passed(self) -> bool:
        """True if the march keeps the plan and its limits, and the objective has settled."""
        return not self.failures

    @property
    def failures(self) -> tuple[str, ...]:
        """Sentences on what does not hold."""
        checks = {
            f"The march misses a node by {self.defect:.2g} of a range; {self.tolerance:.2g} was asked": self.defect
            <= self.tolerance,
            f"Half the step changes the march by {self.march_error:.2g}": self.march_error <= self.tolerance,
            f"The objective changed by {self.objective_error:.2g} with the last mesh; {self.objective_tolerance:.2g} "
            "was asked": self.objective_error <= self.objective_tolerance,
        }
        worst = max(self.violations, key=lambda name: self.violations[name], default="")
        if worst:
            sentence = f"'{worst}' is passed by {self.violations[worst]:.2g} of its size"
            checks[sentence] = self.violations[worst] <= BETWEEN
        return tuple(f"{sentence}." for sentence, holds in checks.items() if not holds)


def certify(end: PlanSearchEnd, tolerance: float, objective_tolerance: float) -> PlanCertificate:
    """The certificate of the end of a search."""
    problem, values = end.problem, end.program.values
    finer = march(problem, values, 2 * STEPS)
    size = ranges(values)
    changes = [np.abs(a.x[:, -1] - b.x[:, -1]) / size for a, b in zip(end.runs, finer, strict=True)]
    runs = run_from_start(problem, values)
    apart = max(float((np.abs(run - arc.x) / size).max()) for run, arc in zip(runs, values, strict=True))
    return PlanCertificate(
        max(float(miss.max()) for miss in defects(values, finer)),
        apart,
        max(float(change.max()) for change in changes),
        violations_of(problem, values, finer),
        end.program.kkt,
        end.objective_error,
        tolerance,
        objective_tolerance,
        end.program.status,
    )
