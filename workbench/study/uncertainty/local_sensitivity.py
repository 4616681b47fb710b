"""Local sensitivities: exact derivatives of a run's metrics, held against differences of neighbouring runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from workbench.core import Entry, Layout, Ode, SampledSystem, StepMap
from workbench.core.bounded_loop import operation_codes
from workbench.core.validation.refusals import Array, describe, known_name, matrix, seconds, vector
from workbench.core.validation.signatures import check_arguments
from workbench.engine import simulate
from workbench.engine.arithmetic import advance_states
from workbench.engine.metrics import AbstractMetric, step_with_metrics
from workbench.engine.metrics.accumulators import final_values
from workbench.engine.metrics.measured_equation import MeasuredEquation

# Widths of differences, relative to the number, and how far, relative to the slope, a gradient may be from them: over
# the narrow one truncation and rounding are about 1e-8, over the wide one it must be of use to a designer.
NARROW, WIDE = (1e-4, 1e-3), (1e-2, 0.1)
SHIFTS = 1e-3 * np.array([-2.0, -1.0, 1.0, 2.0])  # of a difference of fourth order through the last formula of a metric
WEIGHTS = np.array([1.0, -8.0, 8.0, -1.0]) / 12e-3
LEAST_ELASTICITY = (
    1e-3  # an elasticity, percent of the metric by percent of the number, below which a wide slope is not judged
)
SWITCHES = {
    ca.OP_SIGN: "sign",
    ca.OP_FABS: "| |",
    ca.OP_FMIN: "min",
    ca.OP_FMAX: "max",
    ca.OP_FLOOR: "floor",
    ca.OP_CEIL: "ceil",
    ca.OP_FMOD: "mod",
    ca.OP_REMAINDER: "mod",
    ca.OP_LT: "<",
    ca.OP_LE: "<=",
    ca.OP_EQ: "==",
    ca.OP_NE: "!=",
    ca.OP_IF_ELSE_ZERO: "if",
}

Rows = tuple[Array, Array]  # a quantity and its derivatives, (m, k) each, one row a number that is varied


@dataclass(frozen=True, eq=False)
@check_arguments
class LocalSensitivities:
    """Derivatives of metrics at one operating point, by m numbers with `labels`, whose values there are `at` (m,).

    Attributes
    ----------
    value, gradient
        By metric, (k,) and (k, m): its k numbers and their derivatives, exact for the steps taken; NaN if unbounded.
    slope, wide_slope
        By metric, (k, m): difference quotients of neighbouring runs, for changes of each number by 0.01 % and by 1 %.
    switches
        The operations of the equations that jump or have corners, which a derivative does not notice.
    """

    labels: tuple[str, ...]
    at: Array
    value: Mapping[str, Array]
    gradient: Mapping[str, Array]
    slope: Mapping[str, Array]
    wide_slope: Mapping[str, Array]
    switches: tuple[str, ...]

    @check_arguments
    def holds(self, metric: str) -> NDArray[np.bool_]:
        """True where the gradient is the slope of the metric, (k, m).

        The two agree to 0.1 % over the narrow width, and to 10 % over the wide one. Along a run that switches, a
        gradient may be right between two switchings and wrong beyond them.
        """
        known_name(metric, self.gradient, "metrics here")
        gradient, narrow, wide = (held[metric] for held in (self.gradient, self.slope, self.wide_slope))
        unit = np.abs(self.value[metric])[:, np.newaxis] / np.where(self.at == 0, 1.0, np.abs(self.at))
        rounding = 1e3 * np.finfo(float).eps / NARROW[0] * unit
        with np.errstate(invalid="ignore"):  # what is infinite is no slope
            near = np.abs(gradient - narrow) <= NARROW[1] * np.abs(narrow) + rounding
            far = np.abs(gradient - wide) <= WIDE[1] * np.abs(wide) + LEAST_ELASTICITY * unit
        return np.asarray(near & far)

    @check_arguments
    def linear_shares(self, metric: str, deviations: Array) -> Array:
        """The shares (k, d) of the variance due to d factors if the metric were linear, as a check of S1.

        `deviations` (d, m) are the changes of all m numbers by one standard deviation of each factor.
        """
        known_name(metric, self.gradient, "metrics here")
        deviations = matrix("linear_shares(deviations=...)", deviations, columns=len(self.at))
        parts = (self.gradient[metric] @ deviations.T) ** 2
        with np.errstate(invalid="ignore"):  # nothing varies: no number has a part
            return np.asarray(parts / parts.sum(axis=1, keepdims=True))

    @property
    def warnings(self) -> tuple[str, ...]:
        """A sentence for each metric whose gradient is not its slope, and does not predict the effect of a change."""
        said = []
        through = f", which goes through {', '.join(self.switches)}" if self.switches else ""
        for metric in self.gradient:
            off = [self.labels[i] for i in np.flatnonzero(~self.holds(metric).all(axis=0))]
            if off:
                few = ", ".join(off[:3]) + (f" and {len(off) - 3} more" if len(off) > 3 else "")
                said.append(f"the gradient of '{metric}' in {few} is not the slope of its runs{through}.")
        return tuple(said)


@check_arguments
def local_sensitivities(
    equation: Ode | SampledSystem,
    metrics: Sequence[AbstractMetric],
    names: Sequence[str],
    p: Array | None = None,
    x0: Array | None = None,
    *,
    until: float,
    h: float,
) -> LocalSensitivities:
    """Derivatives of every metric with respect to parameters and initial states, exact for the steps that are taken.

        S+ = (dF/dx) S + dF/dtheta,   x+ = F(k, x, p) the loop and its metrics, and from S those of the metrics

    If F jumps or has corners, S is that of the smooth pieces, and misses the effect of shifted switching instants. So
    every derivative is compared with differences of neighbouring runs; see `warnings`.

    `names` are those of parameters and initial states, or of single numbers of either. `p` and `x0` are the operating
    point, by default that of `equation`. `until` and `h` are horizon and step in s, for a sampled loop the substep.

    Raises
    ------
    ValueError
        If no name is given, the run diverges, a number cannot be moved by itself, or `measure` or `simulate` refuses.
    LookupError
        If a name is neither a parameter's nor a state's; the message names the nearest.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> found = wb.uncertainty.local_sensitivities(motor, [wb.effort("omega")], ["R"], until=1.0, h=1e-2)
    >>> found.labels
    ('R',)
    """
    seconds("local_sensitivities(until=...)", until)
    whole = MeasuredEquation.of(equation, metrics, until)
    metrics = whole.metrics
    step, loop = whole.step(h), equation if isinstance(equation, Ode) else equation.flow
    p = vector("local_sensitivities(p=...)", loop.parameters.default if p is None else p, loop.parameters.size, "p")
    x0 = vector("local_sensitivities(x0=...)", loop.states.default if x0 is None else x0, loop.states.size, "states")
    places = _places(loop, names)
    here = np.concatenate([p, x0])
    value, gradient = _gradients(step, metrics, places, p, x0, until)
    slope, wide_slope = (_slopes(step, metrics, loop, places, here, until, width) for width, _ in (NARROW, WIDE))
    labels = loop.parameters.labels + loop.states.labels
    codes = operation_codes(step_with_metrics(equation, (), h).rule.F)
    switches = tuple(dict.fromkeys(SWITCHES[code] for code in codes if code in SWITCHES))
    at = here[places]
    return LocalSensitivities(tuple(labels[i] for i in places), at, value, gradient, slope, wide_slope, switches)


def _places(loop: Ode, names: Sequence[str]) -> list[int]:
    """The places of the numbers in a row of parameters and initial states."""
    both = Layout(tuple({e.name: e for e in loop.parameters.entries + loop.states.entries}.values()))
    places: list[int] = []
    for name in names:
        inside = name in loop.parameters or name in loop.parameters.labels
        offset = 0 if inside else loop.parameters.size
        layout = loop.parameters if inside else loop.states
        both.indices(name)  # refuses what is neither
        places += [offset + i for i in layout.indices(name)]
    if not places or len(set(places)) < len(places):
        raise ValueError(
            f"`local_sensitivities(names=...)` must be numbers, each once, at least one; got {describe(names)}."
        )
    return places


def _gradients(
    step: StepMap, metrics: Sequence[AbstractMetric], places: Sequence[int], p: Array, x0: Array, until: float
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Values (k,) and derivatives (k, m) of the metrics, a run a direction; NaN where a direction leaves all bounds."""
    values = _values(step, metrics, p, x0, until)
    more, start = _along(step, places, p, x0)
    same = np.zeros(len(places), dtype=int)  # all runs are number 0, so that noise is the same in them
    runs = simulate(more, p=p, x0=start, until=until, every=until, noise_keys=same)
    later = advance_states(runs.job, runs.x[:, -1], round(until / more.h), 1)  # a last look, as `final_values` takes it
    gradient = {}
    for metric in metrics:
        integral, own = f"integral of {metric.name}", f"{metric.name}."
        total = [_rows(more, runs.x[:, -1], integral)] if integral in step.states else []
        memory = {n.removeprefix(own): _rows(more, later, n) for n in step.states.names if n.startswith(own)}
        found = _chained(metric, total, memory, len(places), until)
        gradient[metric.name] = np.where(runs.has_diverged, np.nan, found)
    return values, gradient


def _values(step: StepMap, metrics: Sequence[AbstractMetric], p: Array, x0: Array, until: float) -> dict[str, Array]:
    start = np.concatenate([x0, step.states.default[x0.size :]])
    run = simulate(step, p=p, x0=start, until=until, every=until)
    if run.has_diverged[0]:
        raise ValueError(
            f"`local_sensitivities(...)` needs a run that lasts; this one diverged at {run.diverged_at[0]:g} s."
        )
    return {name: value[0] for name, value in final_values(run, metrics).items()}


def _along(step: StepMap, places: Sequence[int], p: Array, x0: Array) -> tuple[StepMap, Array]:
    """The step with a column of S and its direction in p beside its states, and the starts (m, ...) of the runs."""
    rule, n, m = step.rule, step.states.size, len(places)
    moved = [place for place in places if place < p.size]
    more = Layout((Entry("S", np.zeros(n)), *([Entry("direction", np.zeros(len(moved)))] if moved else [])))
    symbols = more.symbols()
    S, direction = symbols[:n], symbols[n:]
    in_p = ca.SX.zeros(p.size)
    in_p[moved] = direction
    update = ca.jtimes(rule.next, ca.vertcat(rule.x, rule.p), ca.vertcat(S, in_p))
    extended = replace(step, rule=rule.written_out).with_memory(
        more, symbols, ca.vertcat(ca.densify(update), direction)
    )
    start = np.tile(np.concatenate([x0, extended.states.default[x0.size :]]), (m, 1))
    for row, place in zip(start, places, strict=True):
        row[n + (n + moved.index(place) if place < p.size else place - p.size)] = 1.0
    return extended, start


def _rows(more: StepMap, ends: Array, name: str) -> Rows:
    S = ends[:, more.states.slice("S")]
    return ends[:, more.states.slice(name)], S[:, more.states.slice(name)]


def _chained(
    metric: AbstractMetric, integral: Sequence[Rows], memory: Mapping[str, Rows], m: int, until: float
) -> Array:
    """The derivatives (k, m) of the formula that a metric is of its integral and memory, by differences."""
    held = [*integral, *memory.values()]
    # how far to go along each direction: until one of the quantities has changed by about itself
    change = [np.abs(dz) / np.where(z == 0, 1.0, np.abs(z)) for z, dz in held]
    fastest = np.max([part.max(axis=1, initial=0.0) for part in change], axis=0)
    reach = (1 / np.where(fastest > 0, fastest, 1.0))[:, np.newaxis]

    def value(shift: float) -> Array:
        total = [z + shift * reach * dz for z, dz in integral] or [np.zeros((m, 0))]
        z = {name: z + shift * reach * dz for name, (z, dz) in memory.items()}
        return metric.value(total[0], z, until)

    with np.errstate(invalid="ignore"):  # what is infinite has no derivative
        return np.asarray((sum(w * value(s) for w, s in zip(WEIGHTS, SHIFTS, strict=True)) / reach).T)


def _slopes(
    step: StepMap,
    metrics: Sequence[AbstractMetric],
    loop: Ode,
    places: Sequence[int],
    here: Array,
    until: float,
    width: float,
) -> dict[str, Array]:
    """Slopes (k, m) over changes by `width`, relative to numbers but 0, extrapolated from the whole and half of it."""
    ends = np.array([_ends(loop, here, place, width) for place in places])
    shifts = ends[:, [0, 1, 0, 1]] * [1.0, 1.0, 0.5, 0.5]
    table, split = np.tile(here, (4 * len(places), 1)), loop.parameters.size
    table[np.arange(len(table)), np.repeat(places, 4)] += shifts.ravel()
    start = np.hstack([table[:, split:], np.tile(step.states.default[loop.states.size :], (len(table), 1))])
    same = np.zeros(len(table), dtype=int)  # all runs are number 0, so that noise is the same in them
    runs = simulate(step, p=table[:, :split], x0=start, until=until, every=until, noise_keys=same)
    spans = ends[:, 1] - ends[:, 0]
    order = np.where(ends.all(axis=1), 4.0, 2.0)  # how much less wrong half the width is, by the sides it goes to
    found = {}
    for name, value in final_values(runs, metrics).items():
        at = value.reshape(len(places), 4, -1).transpose(1, 2, 0)  # (4, k, m), in the order of the shifts
        with np.errstate(invalid="ignore"):  # what is infinite has no slope
            whole, half = (at[1] - at[0]) / spans, (at[3] - at[2]) / (spans / 2)
            found[name] = (order * half - whole) / (order - 1)
    return found


def _ends(loop: Ode, here: Array, place: int, width: float) -> tuple[float, float]:
    """The shifts of a number down and up; 0 to the side where that is not allowed."""
    by = width * (abs(here[place]) or 1.0)
    low, high = (_allows(loop, here, place, shift) for shift in (-by, by))
    if not low and not high:
        label = (loop.parameters.labels + loop.states.labels)[place]
        raise ValueError(f"`local_sensitivities(names=...)`: '{label}' cannot be moved by itself within its bounds.")
    return (-by if low else 0.0), (by if high else 0.0)


def _allows(loop: Ode, here: Array, place: int, shift: float) -> bool:
    row = here[np.newaxis].copy()
    row[0, place] += shift
    try:
        loop.parameters.check(row[:, : loop.parameters.size])
        loop.states.check(row[:, loop.parameters.size :])
    except ValueError:
        return False
    return True
