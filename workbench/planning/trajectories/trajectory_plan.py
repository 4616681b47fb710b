"""Plan: a trajectory of least cost with its inputs, what holds it back, and how far the simulator agrees."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from workbench.core import Layout
from workbench.core.motion_record import MotionRecord
from workbench.core.plot_registry import draw
from workbench.core.validation.notebook_display import show, table_to_html
from workbench.core.validation.refusals import Array, known_name, numbers
from workbench.core.validation.signatures import check_arguments
from workbench.planning.trajectories.marching import objective
from workbench.planning.trajectories.plan_certificate import PlanCertificate
from workbench.planning.trajectories.plan_items import PlanItem
from workbench.planning.trajectories.plan_multipliers import active_spans, multipliers
from workbench.planning.trajectories.plan_problem import PlanProblem
from workbench.planning.trajectories.plan_search import PlanSearchEnd
from workbench.planning.trajectories.plan_values import Values

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
@show
class Plan:
    """A trajectory of least cost within its limits, and the inputs that make it.

    `wb.plan` makes one. Rows are nodes; between two phases there are two at one time. `plan["F"]` is a state or input
    by its name.

    Parameters
    ----------
    inputs
        The inputs with their units.
    search
        The problem and the end of the search for it.
    certificate
        The checks by the simulator and by the solver.

    References
    ----------
    Betts (2010), Practical Methods for Optimal Control and Estimation Using Nonlinear Programming, chapter 4.
    """

    inputs: Layout
    search: PlanSearchEnd
    certificate: PlanCertificate

    @property
    def problem(self) -> PlanProblem:
        """The problem that it solves."""
        return self.search.problem

    @property
    def values(self) -> Values:
        """The numbers of each phase."""
        return self.search.program.values

    @property
    def states(self) -> Layout:
        """The states with their units."""
        return self.problem.ode.states

    @property
    def hold(self) -> str:
        """The inputs between nodes: "zero" for constant ones, "linear" for straight lines."""
        return self.problem.hold

    @cached_property
    def t(self) -> Array:
        """(M,), the times of the nodes in s."""
        begins = np.concatenate([[0.0], np.cumsum(self.durations)])
        return np.concatenate([a + arc.T * arc.shares for a, arc in zip(begins[:-1], self.values, strict=True)])

    @cached_property
    def x(self) -> Array:
        """(M, nx), the states at the nodes."""
        return np.concatenate([arc.x for arc in self.values])

    @cached_property
    def u(self) -> Array:
        """(M, nu), the inputs from each node on; at the end of a phase whose inputs are held, the last ones again."""
        return np.concatenate([np.vstack([arc.begins, arc.ends[-1:]]) for arc in self.values])

    @property
    def durations(self) -> tuple[float, ...]:
        """The duration of each phase in s."""
        return tuple(arc.T for arc in self.values)

    @property
    def until(self) -> float:
        """The time of the end in s."""
        return float(sum(self.durations))

    @cached_property
    def objective(self) -> float:
        """The objective, as the march from node to node has it."""
        return objective(self.problem, self.values, self.search.runs)

    @cached_property
    def multipliers(self) -> dict[str, float]:
        """By limit, boundary value and duration, the derivative of the objective with respect to its number."""
        return {str(item): value for item, value in self.item_multipliers.items()}

    @cached_property
    def item_multipliers(self) -> Mapping[PlanItem, float]:
        """The same by item."""
        return multipliers(self.search.program)

    @cached_property
    def active_limits(self) -> dict[str, tuple[tuple[float, float], ...]]:
        """The limits that are reached, with the spans of time in s."""
        return active_spans(self.search.program)

    def __getitem__(self, name: str) -> Array:
        """A state or an input (M,), or (M, n) if it has several numbers."""
        layout = self.states + self.inputs
        known_name(name, (*layout.names, *layout.labels), "states and inputs of this plan")
        places = layout.indices(name)
        values = np.hstack([self.x, self.u])[:, places]
        is_one = name not in layout or not layout[name].shape
        return np.asarray(values[:, 0] if is_one else values)

    @check_arguments
    def at(self, times: Array) -> tuple[Array, Array]:
        """States (K, nx) and inputs (K, nu) at times (K,) in s, by the polynomials of the intervals."""
        t = np.atleast_1d(numbers("Plan.at(times=...)", times))
        if not ((t >= 0) & (t <= self.until * (1 + 1e-12))).all():
            raise ValueError(
                f"`Plan.at(times=...)` must lie from 0 to {self.until:.6g} s; got {t.min():g} to {t.max():g}."
            )
        ends = np.cumsum(self.durations)
        which = np.minimum(np.searchsorted(ends, t, side="right"), len(ends) - 1)
        x, u = np.empty((len(t), self.x.shape[1])), np.empty((len(t), self.u.shape[1]))
        for i, arc in enumerate(self.values):
            rows = which == i
            shares = np.clip((t[rows] - (ends[i] - arc.T)) / arc.T, 0.0, 1.0)
            x[rows], u[rows] = arc.states_at(shares), arc.inputs_at(shares)
        return x, u

    @cached_property
    def motion(self) -> MotionRecord:
        """States, their rates and inputs over time, as `wb.PlannedReference` and `wb.TrajectoryFeedback` take them."""
        begins = np.concatenate([arc.begins for arc in self.values])
        ends = np.concatenate([arc.ends for arc in self.values])
        firsts = np.concatenate([arc.x[:-1] for arc in self.values])
        lasts = np.concatenate([arc.x[1:] for arc in self.values])
        t0 = np.concatenate([[0.0], np.cumsum(self.durations)])
        nodes = [a + arc.T * arc.shares for a, arc in zip(t0[:-1], self.values, strict=True)]
        instants = np.concatenate([[0.0], *[node[1:] for node in nodes]])
        rates = [self._rates(i, node) for i, node in enumerate(nodes)]
        first_rates, last_rates = (np.concatenate([rate[k] for rate in rates]) for k in (0, 1))
        return MotionRecord(instants, self.states, self.inputs, firsts, lasts, first_rates, last_rates, begins, ends)

    def _rates(self, i: int, nodes: Array) -> tuple[Array, Array]:
        """The rates (N, nx) of the states at the begin and at the end of each interval of a phase."""
        arc, rate = self.values[i], self.problem.phases[i].rate
        pairs = ((nodes[:-1], arc.x[:-1], arc.begins), (nodes[1:], arc.x[1:], arc.ends))
        first, last = (np.array(rate(t[np.newaxis], x.T, u.T)[0]).T for t, x, u in pairs)
        return first, last

    @check_arguments
    def table(self, name: str) -> tuple[Array, Array]:
        """The times (M,) in s and the values (M,) or (M, n) of a state or an input, as for `wb.Table`.

        Held inputs need `interpolation="hold"`. A plan of several phases has two rows where they meet; the first is
        left out.
        """
        values = self[name]
        kept = np.append(np.diff(self.t) > 0, True)
        return self.t[kept], values[kept]

    def to_frame(self) -> pd.DataFrame:
        """The states and inputs at the nodes as a table, with the time in s as its index."""
        import pandas as pd

        labels = (*self.states.labels, *self.inputs.labels)
        return pd.DataFrame(np.hstack([self.x, self.u]), index=pd.Index(self.t, name="t"), columns=list(labels))

    @check_arguments
    def plot(self, *names: str) -> object:
        """The picture of states and inputs over time, one panel each, with their limits; by default of all."""
        return draw(self, *names)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences on what speaks against the plan."""
        run = self.certificate.run_defect
        loose = f"One run from the start ends {run:.2g} of a range away: follow the plan with feedback."
        return (*self.certificate.failures, *([loose] if run > 1e-3 else []))

    def __str__(self) -> str:
        nodes, phases = len(self.t), len(self.values)
        several = f" in {phases} phases" if phases > 1 else ""
        active = [*self.active_limits]
        at = f"; at {', '.join(active[:3])}{', ...' if len(active) > 3 else ''}" if active else ""
        failed = "" if self.certificate.is_passed else "; its certificate has failures"
        return f"objective {self.objective:.6g} over {self.until:.6g} s{several}, {nodes} nodes{at}{failed}"

    def __repr__(self) -> str:
        return f"<Plan of '{self.problem.ode.name}': {self}>"

    def _repr_html_(self) -> str:
        rows = [(name, f"{value:.6g}") for name, value in self.multipliers.items()]
        return table_to_html(repr(self)[1:-1], ("limit or value", "change of the objective by one unit"), rows)
