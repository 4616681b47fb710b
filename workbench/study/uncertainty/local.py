"""Local sensitivities: exact derivatives of a run's metrics, held against differences of neighbouring runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode, Sampled
from workbench.core.expressions import instructions
from workbench.metrics import AbstractMetric, measured
from workbench.metrics.accumulators import resolved
from workbench.study.uncertainty.gradients import gradients, slopes
from workbench.validation.refusals import Array, described, known, seconds, vector
from workbench.validation.signatures import door

# Widths of differences, relative to the number, and how far, relative to the slope, a gradient may be from them: over
# the narrow one truncation and rounding are about 1e-8, over the wide one it must be of use to a designer.
NARROW, WIDE = (1e-4, 1e-3), (1e-2, 0.1)
UNFELT = 1e-3  # an elasticity, percent of the metric by percent of the number, below which a wide slope is not judged
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


@dataclass(frozen=True, eq=False)
@door
class LocalSensitivities:
    """Derivatives of metrics at one operating point with respect to m numbers.

    Attributes
    ----------
    labels
        The m numbers: of parameters, or of initial states.
    at
        (m,), their values at the operating point.
    value, gradient
        By metric, (k,) and (k, m) for its k joints: the derivatives of the very numbers that the run computes. NaN
        where they leave all bounds, as they do along a run that chatters.
    slope, wide_slope
        By metric, (k, m): those of neighbouring runs, over changes of each number by 0.01 % and by 1 %.
    switches
        The operations of the equations across which a derivative does not see.
    """

    labels: tuple[str, ...]
    at: Array
    value: Mapping[str, Array]
    gradient: Mapping[str, Array]
    slope: Mapping[str, Array]
    wide_slope: Mapping[str, Array]
    switches: tuple[str, ...]

    @door
    def holds(self, metric: str) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """True where the gradient is the slope of the metric, (k, m): to 0.1 % over the narrow width, 10 % the wide.

        Along a run that switches a gradient may hold between two switchings and say nothing beyond them.
        """
        known(metric, self.gradient, "metrics here")
        gradient, narrow, wide = (held[metric] for held in (self.gradient, self.slope, self.wide_slope))
        unit = np.abs(self.value[metric])[:, np.newaxis] / np.where(self.at == 0, 1.0, np.abs(self.at))
        rounding = 1e3 * np.finfo(float).eps / NARROW[0] * unit
        with np.errstate(invalid="ignore"):  # what is infinite is no slope
            near = np.abs(gradient - narrow) <= NARROW[1] * np.abs(narrow) + rounding
            far = np.abs(gradient - wide) <= WIDE[1] * np.abs(wide) + UNFELT * unit
        return np.asarray(near & far)

    @door
    def linear_shares(self, metric: str, deviations: Array) -> Array:
        """The parts of the variance that factors would have were the metric linear: beside S1 a check.

        Parameters
        ----------
        deviations
            (d, m), by how much one standard deviation of each of d factors moves all the numbers together, for parts
            (k, d).
        """
        known(metric, self.gradient, "metrics here")
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


@door
def local_sensitivities(
    equation: Ode | Sampled,
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

    Where F jumps or has corners S is that of the pieces between them, and misses what the instants of the corners
    add: so every derivative is held against differences of runs beside this one; see `warnings`.

    Parameters
    ----------
    names
        Parameters, initial states, or single numbers of either.
    p, x0
        (np,) and (nx,): the operating point, the defaults if not given.
    until, h
        Horizon and step, in s; of a sampled loop the substep.

    Raises
    ------
    ValueError
        If no name is given, the run diverges, a number cannot be moved by itself, or `measured` or `simulate` refuses.
    LookupError
        If a name is neither a parameter's nor a state's; the message names the nearest.
    """
    seconds("local_sensitivities(until=...)", until)
    metrics = resolved(equation, metrics, until)
    step, loop = measured(equation, metrics, h), equation if isinstance(equation, Ode) else equation.flow
    p = vector("local_sensitivities(p=...)", loop.parameters.default if p is None else p, loop.parameters.size, "p")
    x0 = vector("local_sensitivities(x0=...)", loop.states.default if x0 is None else x0, loop.states.size, "states")
    places = _places(loop, names)
    here = np.concatenate([p, x0])
    value, gradient = gradients(step, metrics, places, p, x0, until)
    slope, wide_slope = (slopes(step, metrics, loop, places, here, until, width) for width, _ in (NARROW, WIDE))
    labels = loop.parameters.labels + loop.states.labels
    found = instructions(measured(equation, (), h).rule.F)
    switches = tuple(dict.fromkeys(SWITCHES[line[0]] for line in found if line[0] in SWITCHES))
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
            f"`local_sensitivities(names=...)` must be numbers, each once, at least one; got {described(names)}."
        )
    return places
