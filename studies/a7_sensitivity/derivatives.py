"""Exact derivatives at the numbers of the card, beside the slopes of runs and the global indices."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from studies.a7_sensitivity.results import LawResults, interval, named, narrow
from studies.a7_sensitivity.sweeps import METRICS, STEPS, UNTIL, free, loop
from workbench.core import Ode
from workbench.study.document.document import Column, Paragraph, Section, Table, Verdict
from workbench.study.uncertainty import Estimate
from workbench.study.uncertainty.factors import Factor
from workbench.study.uncertainty.local import LocalSensitivities, local_sensitivities
from workbench.validation.refusals import Array

NEAR = 0.1  # of a variance: how far a linear share may lie from S1 and still foretell it


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Derivatives at the numbers of the card with respect to d factors that are shares of m numbers.

    Attributes
    ----------
    moves
        (d, m): by how much a factor moves each number, where it rises by its whole value.
    deviations
        (d,), the standard deviations of the factors.
    """

    factors: tuple[str, ...]
    sensitivities: LocalSensitivities
    moves: Array
    deviations: Array

    def shares(self, metric: str, joint: int) -> Array:
        """The parts of the variance (d,) if the metric were linear."""
        moved = self.deviations[:, np.newaxis] * self.moves
        return np.asarray(self.sensitivities.linear_shares(metric, moved)[joint])

    def slopes(self, metric: str) -> str:
        """The number of derivatives whose gradient is the slope of the runs, and that of all."""
        holds = self.sensitivities.holds(metric)
        return f"{holds.sum()} of {holds.size}"


def derivatives(law: str) -> Derivatives:
    """The derivatives of a law with respect to the factors of its Sobol indices."""
    ode, moved = loop(law).ode(), free(law)
    labels = [numbers_of(ode, factor) for factor in moved]
    names = [name for some in labels for name in some]
    found = local_sensitivities(ode, METRICS, names, until=UNTIL, h=STEPS[law])
    moves = np.array([np.where(np.isin(found.labels, some), found.at, 0.0) for some in labels])
    return Derivatives(tuple(factor.name for factor in moved), found, moves, np.array([deviation(f) for f in moved]))


def numbers_of(ode: Ode, factor: Factor) -> Sequence[str]:
    """The numbers of a loop that a share of them moves: not the zeros of a matrix."""
    layouts = [(path, ode.parameters if path in ode.parameters else ode.states) for path in factor.paths]
    return [of.labels[i] for path, of in layouts for i in of.indices(path) if of.default[i] != 0]


def deviation(factor: Factor, cells: int = 4000) -> float:
    """The standard deviation of a factor, from the middles of cells of its unit interval."""
    return float(factor.distribution.quantile((np.arange(cells) + 0.5) / cells).std())


def gap(one: LawResults, near: Derivatives, metric: str, joint: int) -> Estimate:
    """The distance from S1 of the linear share that lies farthest from it; NaN where there is no gradient."""
    first = one.shares[named(metric, joint)].S1
    apart = np.abs(near.shares(metric, joint) - first.value)
    worst = int(np.argmax(apart))  # of NumPy, whose largest value is NaN where one is
    return Estimate(apart[worst], first.half[worst])


def foretold(laws: Mapping[str, LawResults], near: Mapping[str, Derivatives], metric: str = "RMSE") -> Verdict:
    """The derivatives at one point against the indices over the whole range."""
    gaps = {(law, joint): gap(laws[law], near[law], metric, joint) for law in near for joint in (0, 1)}
    sure = {key for key in gaps if narrow(laws[key[0]].shares[named(metric, key[1])].S1)}
    held = [key for key, far in gaps.items() if far.high <= NEAR and key in sure]
    # without a gradient, where the difference is NaN, nothing is foretold
    missed = [key for key, far in gaps.items() if not far.low <= NEAR]
    left = len(gaps) - len(held) - len(missed)
    listed = ", ".join(f"{law} q{joint + 1} {interval(far)}" for (law, joint), far in gaps.items())
    slopes = ", ".join(f"{law} in {one.slopes(metric)}" for law, one in near.items())
    return Verdict(
        "open" if left else "found",
        f"For {len(held)} of {len(gaps)} pairs of law and joint the gradient at the numbers of the card foretells "
        f"every first-order index of the {metric} within {NEAR:g}; for {len(missed)} it is farther off, and for "
        f"{left} the intervals leave it open.",
        f"Largest difference of a linear share from S1, with the interval of that S1: {listed}. The gradient is the "
        f"slope of the runs, of all derivatives at both joints: {slopes}.",
        "S1, of Sobol designs with a quadratic control variate, against the share of a linear function with the exact "
        "gradient.",
        "The ranges of this study, which are alike for all laws.",
        "Wider ranges, over which gains act by curves.",
    )


def derivatives_section(laws: Mapping[str, LawResults], near: Mapping[str, Derivatives]) -> Section:
    """Gradients beside differences, and beside the global indices."""
    text = (
        "The derivative of each metric with respect to each number, from the equations themselves: exact for the steps "
        "that are taken. It is held against runs beside this one, over 0.01 % and over 1 % of the number. Where a law "
        "saturates or switches, the gradient sees the pieces and not the instants between them, and may be no slope "
        "at all."
    )
    return Section("Exact derivatives at the numbers of the card", (Paragraph(text), slopes_table(laws, near)))


def slopes_table(laws: Mapping[str, LawResults], near: Mapping[str, Derivatives]) -> Table:
    """The derivatives of each law that are slopes, and the distance of linear shares from S1."""
    rows = []
    for law, one in near.items():
        for metric in (metric.name for metric in METRICS):
            gaps = [gap(laws[law], one, metric, joint) for joint in (0, 1)]
            cells = (None if np.isnan(far.value) else interval(far) for far in gaps)
            rows.append((law, metric, one.slopes(metric), *cells))
    heads = ("gradient is the slope", "linear share off S1, q1", "q2")
    return Table(
        "slopes",
        "For how many derivatives the gradient is the slope of the runs (within 0.1 % over the narrow and 10 % over "
        "the wide change), and how far a linear share lies at most from S1, with the interval of that S1.",
        (Column("law"), Column("metric"), *(Column(head, align="right") for head in heads)),
        tuple(rows),
    )
