"""Estimates from logs of the arm: by output errors, and by the regression of torques."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.c0_identify_arm.arm import (
    BEGIN,
    FREE,
    PERIOD,
    PUSH,
    SPEED,
    START,
    TRUTH,
    Conditions,
    Numbers,
    arm_of,
    plant_of,
)

BASE_WORDS = ("(m1 + m2) l1²", "(m1 + m2) l1", "m2 l2²", "m2 l2")  # then the frictions
REGRESSED = ("link1.I_zz", "link1.mc_x", "link2.I_zz", "link2.mc_x")  # the same in a regression
REGRESSED_FRICTIONS = ("link1.viscous", "link2.viscous", "link1.coulomb", "link2.coulomb")
CUTOFFS = (5.0, 10.0, 20.0, 40.0)  # Hz
THINNED = 5  # samples of a log for one in a picture


@dataclass(frozen=True)
class LogFit:
    """A fit by output errors, as numbers."""

    theta: wb.Array  # (8,), in the order of `FREE`
    covariance: wb.Array  # (8, 8)
    directions: wb.Array  # (8, 8), row by row the changes of the factors that `Fit.factors` gives
    misfit: tuple[tuple[str, float], ...]
    hold_out: tuple[tuple[str, float], ...]
    tests: tuple[tuple[str, str, float], ...]  # about, kind and p-value
    warnings: tuple[str, ...]
    certificate: str

    @property
    def errors(self) -> wb.Array:
        """(8,), the standard errors."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def numbers(self) -> Numbers:
        """The estimates in the order of `FREE`."""
        return tuple(self.theta.tolist())


@dataclass(frozen=True)
class Curves:
    """A log and the model along it: t (N,), readings and torques (N, 2), and errors of the model (N, 2)."""

    t: wb.Array
    q: wb.Array
    tau: wb.Array
    errors: wb.Array


@dataclass(frozen=True)
class RepeatedFits:
    """Fits of B logs that differ by their noise: estimates and standard errors (B, k) in the order of names."""

    names: tuple[str, ...]
    theta: wb.Array
    errors: wb.Array
    distances: wb.Array  # (B,), squares of the distance to the truth in the covariance: chi-square of k if all is right
    worst_misfit: wb.Array  # (B,), of both sensors, in units of the noise that was stated
    has_warning: wb.Array  # (B,), 1 if the fit has a warning
    refusals: tuple[str, ...]  # of logs without a fit


def output_error(log: wb.Dataset, case: Conditions, hold_out: float = 0.2) -> wb.identification.Fit:
    """The fit of a log from the paper's masses and lengths, and small frictions, with the noise of the data sheet."""
    numbers, knows = (1.0, 1.0, 1.0, 1.0, *((BEGIN,) * 4)), any(name in case.free for name in PUSH)
    plant = plant_of(numbers, knows, case.speed, case.pose or START)
    start = {name: 0.0 for name in FREE if name not in case.free} | {name: BEGIN for name in PUSH if knows}
    noise = dict.fromkeys(("q[0]", "q[1]"), case.sigma)
    return wb.fit(wb.open_loop(plant), log, case.free, noise=noise, start=start, hold_out=hold_out)


def as_numbers(fit: wb.identification.Fit) -> LogFit:
    """A fit as numbers."""
    return LogFit(
        fit.theta,
        fit.covariance,
        np.array([factor.direction.changes for factor in fit.factors() if factor.direction]),
        tuple(fit.misfit.items()),
        tuple(fit.hold_out.items()),
        tuple((test.about, test.kind, test.p_value) for test in fit.residual_tests),
        fit.warnings,
        str(fit.certificate),
    )


def curves_of(log: wb.Dataset, fit: wb.identification.Fit) -> Curves:
    """The curves of a picture."""
    t = log.experiments[0].t
    return Curves(t[::THINNED], log["q"][::THINNED], log["tau"][::THINNED], fit.errors[0][::THINNED])


def repeated_output_errors(logs: Iterator[wb.Dataset], case: Conditions) -> RepeatedFits:
    """The fits of some logs by output errors; a log whose fit is refused is counted."""
    truth, rows, refusals = np.array(case.true_values), [], []
    for log in logs:
        try:
            fit = output_error(log, case, hold_out=0.0)
        except ValueError as refused:
            refusals.append(str(refused))
            continue
        own = [i for i, name in enumerate(case.free) if name in FREE]  # a disturbance has two pairs of the same meaning
        z = (fit.theta - truth)[own]
        distance = float(z @ np.linalg.solve(fit.covariance[np.ix_(own, own)], z))
        said = [text for text in fit.warnings if not text.startswith("No sample was held out")]
        rows.append(
            (fit.theta, np.sqrt(np.diag(fit.covariance)), distance, max(fit.misfit.values()), float(bool(said)))
        )
    theta, errors, distances, misfits, has_warning = (np.array(part) for part in zip(*rows, strict=True))
    return RepeatedFits(case.free, theta, errors, distances, misfits, has_warning, tuple(refusals))


def repeated_regressions(logs: Iterator[wb.Dataset], cutoff: float) -> RepeatedFits:
    """The regressions of the torques of some logs through a filter of a cutoff in Hz, and their standard errors."""
    terms = wb.arms.log_regression.JointTerms(drive=False, smoothing=SPEED)
    rows, names = [], (*REGRESSED, *REGRESSED_FRICTIONS)
    refusals: list[str] = []
    for log in logs:
        fit = wb.fit_inverse_dynamics(
            arm_of(TRUTH),
            log,
            ["q[0]", "q[1]"],
            ["tau[0]", "tau[1]"],
            cutoff=cutoff,
            terms=terms,
            delay=PERIOD / 2,  # of a torque that is held for a period
            physical="ignore",
            even_if_refused=True,
        )
        refusals += fit.reasons_to_refuse[:1]
        rows.append(([fit.values[name] for name in names], [fit.standard_errors[name] for name in names]))
    theta, errors = (np.array(part) for part in zip(*rows, strict=True))
    unknown = np.full(len(rows), np.nan)
    return RepeatedFits(names, theta, errors, unknown, unknown, unknown, tuple(refusals))


def base_numbers(numbers: wb.Array) -> wb.Array:
    """The base parameters and frictions (B, 8) of numbers (B, 8) in the order of `FREE`."""
    m1, m2, l1, l2 = numbers[:, :4].T
    base = np.column_stack([(m1 + m2) * l1**2, (m1 + m2) * l1, m2 * l2**2, m2 * l2])
    return np.hstack([base, numbers[:, 4:]])
