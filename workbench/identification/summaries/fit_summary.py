"""FitSummary: all that the page of a fit shows, as plain data, so that the ledger of a study can keep it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array, known_name
from workbench.core.validation.signatures import check_arguments
from workbench.identification.estimation.fit import Fit
from workbench.identification.estimation.fit_bootstrap import Bootstrap
from workbench.identification.estimation.fit_certificate import FitCertificate
from workbench.identification.estimation.identifiability import Identifiability
from workbench.identification.estimation.profile_likelihood import ProfileLikelihood
from workbench.identification.estimation.residual_tests import ResidualTest
from workbench.identification.experiments import ExperimentDesign
from workbench.identification.summaries.summary_parts import (
    LEVEL,
    ExperimentSummary,
    NumberSummary,
    PlanSummary,
    SensorSummary,
    experiment_summaries,
    number_summaries,
    sensor_summaries,
)

SAME = 1e-9  # relative difference of estimates that come from one fit


@dataclass(frozen=True, eq=False)
class FitSummary:
    """A fit as plain data: what speaks against it, its numbers, sensors, samples and tests.

    `FitSummary.of(fit)` makes one. A `Work` of a study may return it, and `wb.fit_section` shows it.

    Parameters
    ----------
    warnings
        Sentences that speak against the fit, the misfit first.
    numbers, sensors, experiments, tests
        The estimates, the sensors, the samples over time, and the tests of the residuals.
    correlation
        (nz, nz), of the estimates.
    is_noise_known, is_exact
        True if the noise of the sensors was stated, and if the log has none beyond rounding.
    certificate, agreeing, starts, shooting
        The accuracy of the computation, how many of the searches ended in this minimum, and by which road.
    null_sentences
        What cannot be told of the numbers of a larger set, in words.
    larger_set
        The names of that set; empty if none was asked for.
    profiles, bootstrap, plan
        Profile likelihoods, draws and a designed experiment, if they were computed.
    """

    warnings: tuple[str, ...]
    numbers: tuple[NumberSummary, ...]
    sensors: tuple[SensorSummary, ...]
    experiments: tuple[ExperimentSummary, ...]
    tests: tuple[ResidualTest, ...]
    correlation: Array
    is_noise_known: bool
    is_exact: bool
    certificate: FitCertificate
    agreeing: int
    starts: int
    shooting: str
    null_sentences: tuple[str, ...] = ()
    larger_set: tuple[str, ...] = ()
    profiles: tuple[ProfileLikelihood, ...] = ()
    bootstrap: Bootstrap | None = None
    plan: PlanSummary | None = None

    @staticmethod
    @check_arguments
    def of(
        fit: Fit,
        *,
        profiles: Sequence[ProfileLikelihood] = (),
        bootstrap: Bootstrap | None = None,
        plan: ExperimentDesign | None = None,
        larger_set: Identifiability | None = None,
    ) -> FitSummary:
        """The summary of a fit, with what else was computed of it.

        Parameters
        ----------
        fit
            The result of `wb.fit`.
        profiles, bootstrap
            Results of `fit.profile` and `fit.bootstrap`.
        plan
            The result of `wb.design_experiment` for the next experiment, at the estimates.
        larger_set
            The result of `wb.identifiability` for more numbers than were fitted; its null directions are printed.

        Raises
        ------
        ValueError
            If a profile or the draws belong to another fit, the draws are too few for intervals of 95 %, or the plan
            has none of the numbers.

        Examples
        --------
        >>> motor = wb.open_loop(wb.DCMotor())
        >>> t = np.linspace(0.0, 2.0, 101)
        >>> v = 12.0 * np.sign(np.sin(5.0 * t) + 0.1)
        >>> log = wb.Dataset.of(t, {"v": v, "omega": np.cumsum(v) / 400}, {"v": "V", "omega": "rad/s"})
        >>> summary = wb.identification.FitSummary.of(wb.fit(motor, log, ["J", "R"]))
        >>> [number.name for number in summary.numbers]
        ['J', 'R']
        """
        _check_parts(fit, profiles, bootstrap, plan)
        return FitSummary(
            warnings=fit.warnings,
            numbers=number_summaries(fit),
            sensors=sensor_summaries(fit),
            experiments=experiment_summaries(fit),
            tests=fit.residual_tests,
            correlation=fit.correlation,
            is_noise_known=fit.is_noise_known,
            is_exact=fit.is_exact,
            certificate=fit.certificate,
            agreeing=fit.end.agreeing,
            starts=fit.end.starts,
            shooting=fit.end.shooting,
            null_sentences=() if larger_set is None else larger_set.sentences,
            larger_set=() if larger_set is None else larger_set.names,
            profiles=tuple(profiles),
            bootstrap=bootstrap,
            plan=None if plan is None else PlanSummary.of(plan),
        )

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the estimated numbers."""
        return tuple(number.name for number in self.numbers)

    def __repr__(self) -> str:
        count = len(self.warnings)
        return f"<FitSummary of {', '.join(self.names)}; {count or 'no'} warning{'' if count == 1 else 's'}>"


def _check_parts(
    fit: Fit, profiles: Sequence[ProfileLikelihood], bootstrap: Bootstrap | None, plan: ExperimentDesign | None
) -> None:
    """Refuse what was computed of another fit."""
    for profile in profiles:
        known_name(profile.name, fit.names, "numbers of this fit")
        if not np.isclose(profile.estimate, fit.values[profile.name], rtol=SAME):
            raise ValueError(
                f"`FitSummary.of(profiles=...)` must be profiles of this fit, whose '{profile.name}' is "
                f"{fit.values[profile.name]:.6g}; that of the profile is {profile.estimate:.6g}."
            )
    if bootstrap is not None and (
        bootstrap.names != fit.names or not np.allclose(bootstrap.theta, fit.theta, rtol=SAME)
    ):
        raise ValueError("`FitSummary.of(bootstrap=...)` must be drawn from this fit; its estimates are others.")
    if bootstrap is not None:
        bootstrap.intervals(LEVEL)  # refuses too few draws
    if plan is not None and not {*plan.names} & {*fit.names}:
        raise ValueError(
            f"`FitSummary.of(plan=...)` must be a design for numbers of this fit, {', '.join(fit.names)}; it is for "
            f"{', '.join(plan.names)}."
        )
