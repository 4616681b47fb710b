"""ExperimentDesign: an input, what it tells before it is run, and how near it comes to its limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import stats

from workbench.core.validation.notebook_display import table_to_html
from workbench.core.validation.refusals import Array, finite, known_name
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets import Dataset
from workbench.identification.experiments.input_shapes import InputShape
from workbench.identification.experiments.plain_excitations import PlainExcitation

ACTIVE = 0.01  # margin, as a share of the range, below which a limit holds the experiment back
STEP_ERROR = 1e-3  # relative change of a standard error by half the step that is passed


@dataclass(frozen=True)
class DesignCertificate:
    """The checks of a design, on steps half as long as those of its search.

    Parameters
    ----------
    margins
        By limit, the least distance to an end, as a share of the range.
    by_half_step
        The largest relative change of a standard error by half the step.
    goal_at_starts
        The criterion at the end of each search, from the least on; their spread says whether more starts would help.
    """

    margins: Mapping[str, float]
    by_half_step: float
    goal_at_starts: tuple[float, ...]

    @property
    def is_passed(self) -> bool:
        """True if all limits hold and half the step changes no standard error by a thousandth."""
        return min(self.margins.values()) >= 0 and self.by_half_step <= STEP_ERROR


@dataclass(frozen=True, eq=False)
class ExperimentDesign:
    """An input of least expected covariance within limits, and what it tells if the system is as stated.

    `wb.design_experiment` makes one. The errors are those of the Cramér-Rao bound at the values of the system.

    Parameters
    ----------
    dataset
        The inputs over time, to be run.
    criterion
        "D" or "A".
    value
        The criterion: log det or trace of the covariance of the estimates relative to their sizes.
    names
        The nz numbers that are to be estimated.
    values, sizes
        (nz,), their values in the system, and the units in which they count: these values, or 1 where they are zero.
    covariance
        (nz, nz), expected of the estimates.
    shape, coefficients
        The shape of the inputs, and the coefficients (nu, nb) of each.
    plain
        By kind, the best of several plain excitations within the same limits: 12 of random steps, and 4 chirps.
    certificate
        The checks of limits and step.

    References
    ----------
    Goodwin and Payne (1977), Dynamic System Identification, chapter 6.
    Swevers, Ganseman, Tükel, de Schutter and van Brussel (1997), IEEE Trans. Robotics and Automation 13(5), 730-740.
    """

    dataset: Dataset
    criterion: str
    value: float
    names: tuple[str, ...]
    values: Array
    sizes: Array
    covariance: Array
    shape: InputShape
    coefficients: Array
    period: float
    plain: Mapping[str, PlainExcitation]
    certificate: DesignCertificate

    @cached_property
    def standard_errors(self) -> dict[str, float]:
        """The expected standard errors by name."""
        return dict(zip(self.names, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @check_arguments
    def intervals(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """The expected intervals by name, about the values of the system, for noise that is known."""
        level = finite("ExperimentDesign.intervals(level=...)", level)
        if not 0 < level < 1:
            raise ValueError(f"`ExperimentDesign.intervals(level=...)` must lie between 0 and 1; got {level:g}.")
        quantile, errors = float(stats.norm.ppf((1 + level) / 2)), self.standard_errors
        return {
            name: (value - quantile * errors[name], value + quantile * errors[name])
            for name, value in zip(self.names, self.values.tolist(), strict=True)
        }

    @property
    def ratios(self) -> dict[str, dict[str, float]]:
        """By plain excitation and name, the length of its interval divided by that of the design."""
        own = np.sqrt(np.diag(self.covariance))
        return {
            kind: dict(zip(self.names, (plain.errors / own).tolist(), strict=True))
            for kind, plain in self.plain.items()
        }

    @property
    def mean_ratios(self) -> dict[str, float]:
        """By plain excitation, the ratio that the criterion counts.

        For D it is the geometric mean of the axes of the ellipsoid, for A the quadratic mean of the relative errors.
        """
        if self.criterion == "D":
            return {kind: float(np.exp((p.value - self.value) / 2 / len(self.names))) for kind, p in self.plain.items()}
        return {kind: float(np.sqrt(p.value / self.value)) for kind, p in self.plain.items()}

    @property
    def active_limits(self) -> tuple[str, ...]:
        """The limits that the experiment reaches to one per cent of their range."""
        return tuple(name for name, margin in self.certificate.margins.items() if margin < ACTIVE)

    @check_arguments
    def table(self, name: str) -> tuple[Array, Array]:
        """The times (N,) in s and the values (N,) or (N, n) of an input, as for `wb.Table`."""
        known_name(name, self.dataset.signals.names, "inputs of this design")
        return self.dataset.experiments[0].t, self.dataset[name]

    @check_arguments
    def sines(self, label: str) -> tuple[float, Array, Array, Array]:
        """The constant of an input, and amplitudes, frequencies in rad/s and phases of its sines, as for `wb.Sines`.

        Raises
        ------
        ValueError
            If the inputs are steps.
        """
        labels = self.dataset.signals.labels
        known_name(label, labels, "inputs of this design")
        if self.shape.names[0] != "constant":
            raise ValueError("`ExperimentDesign.sines(label=...)` needs an input of harmonics; this one has steps.")
        own = self.coefficients[labels.index(label)]
        sine, cosine = own[1::2], own[2::2]
        orders = np.array([float(name.split()[1]) for name in self.shape.names[1::2]])
        return float(own[0]), np.hypot(sine, cosine), 2 * np.pi / self.period * orders, np.arctan2(cosine, sine)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences on what speaks against the design."""
        better = [
            f"The best {kind} told more: the design's errors are {1 / ratio:.3g} times as large; allow more harmonics, "
            "steps or starts."
            for kind, ratio in self.mean_ratios.items()
            if ratio < 1
        ]
        failed = "A limit is broken, or the step is too long for the errors to be exact: see `certificate`."
        return (*better, *([] if self.certificate.is_passed else [failed]))

    def __repr__(self) -> str:
        names = ", ".join(self.names) if len(self.names) <= 4 else f"{len(self.names)} numbers"
        active = self.active_limits
        limits = ", ".join(active) if len(active) <= 3 else f"{len(active)} limits"
        return (
            f"<ExperimentDesign: {self.criterion} = {self.value:.6g} for {names}{f'; at {limits}' if limits else ''}>"
        )

    def _repr_html_(self) -> str:
        ratios, ends = self.ratios, self.intervals()
        head = ("", "value", "expected 95 % interval", *(f"interval of {plain} / this" for plain in ratios))
        body = [
            (
                name,
                f"{value:.6g}",
                f"{ends[name][0]:.6g} to {ends[name][1]:.6g}",
                *(f"{by[name]:.3g}" for by in ratios.values()),
            )
            for name, value in zip(self.names, self.values.tolist(), strict=True)
        ]
        return table_to_html(repr(self)[1:-1], head, body)
