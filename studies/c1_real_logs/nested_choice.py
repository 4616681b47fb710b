"""The choice of a model of friction and sensors by logs inside the training set, so that no hold-out is in view.

Every variant is fitted without each log and without each pair of logs. For a log that is held out, the variant is taken
whose fits on three of the other four logs are best on the fourth, and its fit on all four is tried on the hold-out.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

import workbench as wb
from studies.c1_real_logs.logs import EXCITATIONS, name_of
from studies.c1_real_logs.pendulum import DELAYS, POSITIONS, TORQUES, pendulum_arm, read, read_log

STRIBECK = 0.3  # rad/s, of the friction that falls with the speed
COULOMB = 11  # the first column of the Coulomb friction, behind eight of bodies, one drive and two of viscous friction
ROUNDS = 2  # of weights by joint behind the first fit
LEAST = 1e-10  # of the largest singular value: what is below is rounding


@dataclass(frozen=True)
class Variant:
    """The parts of a model beside rigid bodies, a drive at the elbow, and viscous and Coulomb friction."""

    cutoff: float  # Hz
    smoothing: float  # rad/s, of the sign in the Coulomb friction
    least_speed: float  # rad/s, below which a sample has no weight
    has_stribeck: bool  # friction that falls with the speed
    has_offset: bool  # a constant torque at each joint
    has_load: bool  # friction in proportion to the torque of the model without it
    scale: float  # of the elbow's torque constant, relative to the shoulder's

    def __str__(self) -> str:
        terms = (
            f"{self.cutoff:g} Hz",
            f"sign over {self.smoothing:g} rad/s",
            "" if self.least_speed else "slow samples, too",
            "Stribeck" if self.has_stribeck else "",
            "offset" if self.has_offset else "",
            "load" if self.has_load else "",
            f"elbow x {self.scale:g}" if self.scale != 1 else "",
        )
        return ", ".join(filter(None, terms))

    @property
    def columns(self) -> list[int]:
        """The columns in use, but for the load: those of bodies and drive, then two for each term of the joints."""
        active = [True] * COULOMB + [True] * 2 + [self.has_stribeck] * 2 + [self.has_offset] * 2
        return [i for i, is_used in enumerate(active) if is_used]

    @property
    def equations(self) -> tuple[float, float, float]:
        """The numbers that variants with the same equations share."""
        return self.cutoff, self.smoothing, self.least_speed


VARIANTS = tuple(
    itertools.starmap(
        Variant,
        itertools.product(
            (4.0, 8.0, 16.0),
            (0.02, 0.1, 0.3),
            (0.0, 0.05),
            (False, True),
            (False, True),
            (False, True),
            (0.85, 1.0, 1.15),
        ),
    )
)
USUAL = Variant(8.0, 0.02, 0.05, False, False, False, 1.0)
LEFT_OUT: tuple[tuple[str, ...], ...] = tuple((one,) for one in EXCITATIONS) + tuple(
    itertools.combinations(EXCITATIONS, 2)
)


@dataclass(frozen=True)
class Rows:
    """The equations of a motion: columns (N, 2, b), filtered torques (N, 2), and the weights (N, 2) in s."""

    columns: wb.Array
    torques: wb.Array
    weights: wb.Array

    @cached_property
    def products(self) -> wb.Array:
        """(2, b + 1, b + 1), the weighed products of columns and torque by joint."""
        both = np.concatenate([self.columns, self.torques[:, :, np.newaxis]], axis=2).transpose(1, 0, 2)
        return np.asarray((both * self.weights.T[:, :, np.newaxis]).transpose(0, 2, 1) @ both)


Motion: TypeAlias = wb.arms.log_regression.PreparedMotion
Bodies: TypeAlias = dict[str, wb.Array]  # the columns (N, 2, b) of rigid bodies and a drive by motion


def rows_of(variant: Variant, motion: Motion, bodies: wb.Array) -> Rows:
    """The equations of a motion with the columns of all terms but the load."""
    direction = np.tanh(motion.qd / variant.smoothing)
    stribeck = direction * np.exp(-((motion.qd / STRIBECK) ** 2))
    terms = (motion.qd, direction, stribeck, np.ones_like(motion.qd))
    columns = [bodies, *(term[:, :, np.newaxis] * np.eye(2) for term in terms)]
    moves = motion.weighs[:, np.newaxis] & (np.abs(motion.qd) >= variant.least_speed)
    return Rows(np.concatenate(columns, axis=2), motion.filtered_tau, np.asarray(motion.period * moves, dtype=float))


def with_load(rows: Rows, theta: wb.Array) -> Rows:
    """The equations with friction under load: the torque of a model without it, in the direction of the speed."""
    direction = rows.columns[:, [0, 1], [COULOMB, COULOMB + 1]]
    load = direction * np.abs(rows.columns @ theta)
    return Rows(np.concatenate([rows.columns, load[:, :, np.newaxis] * np.eye(2)], axis=2), rows.torques, rows.weights)


def solve(parts: Sequence[Rows], active: list[int], scale: float) -> tuple[wb.Array, wb.Array]:
    """The least squares (b,) with weights by joint, zero but for the columns in use, and what is left (2,) by joint."""
    scales, total = np.array([1.0, scale]), np.sum([part.weights.sum(axis=0) for part in parts], axis=0)
    products = np.sum([part.products for part in parts], axis=0)
    products[:, -1] *= scales[:, np.newaxis]
    products[:, :, -1] *= scales[:, np.newaxis]
    sigma, theta = np.ones(2), np.zeros(products.shape[1] - 1)
    for _ in range(ROUNDS + 1):
        normal = np.sum(products / sigma[:, np.newaxis, np.newaxis] ** 2, axis=0)
        unit = np.sqrt(np.diag(normal)[active])
        unit[unit == 0] = 1.0
        scaled = normal[np.ix_(active, active)] / np.outer(unit, unit)
        theta[active] = np.linalg.lstsq(scaled, normal[active, -1] / unit, rcond=LEAST)[0] / unit
        both = np.append(theta, -1.0)
        left = np.array([both @ part @ both for part in products])
        sigma = np.sqrt(np.maximum(left, LEAST * products[:, -1, -1]) / total)  # rounding may be below zero
    return theta, sigma


def errors_of(variant: Variant, every: dict[str, Rows], motions: dict[str, Motion], names: Sequence[str]) -> wb.Array:
    """The errors (M, 2) in N m of the measured torques of some motions, by a fit of all others."""
    active, training = variant.columns, [rows for name, rows in every.items() if name not in names]
    theta, _ = solve(training, active, variant.scale)
    rows = {name: every[name] for name in names}
    if variant.has_load:
        rows = {name: with_load(one, theta) for name, one in rows.items()}
        training, last = [with_load(one, theta) for one in training], training[0].columns.shape[2]
        theta, _ = solve(training, [*active, last, last + 1], variant.scale)
    left = [rows[name].columns @ theta / np.array([1.0, variant.scale]) - motions[name].tau for name in names]
    return np.array(
        [np.sqrt(np.mean(one[motions[name].weighs] ** 2, axis=0)) for one, name in zip(left, names, strict=True)]
    )


def motions_of(log: wb.Dataset, cutoff: float, delay: float) -> dict[str, Motion]:
    """The motions of a log by name."""
    every = wb.arms.log_regression.prepare_motion(log, POSITIONS, TORQUES, cutoff, delay=delay)
    return {one.name: one for one in every}


def bodies_of(motion: Motion) -> wb.Array:
    """The columns (N, 2, 9) of rigid bodies and of a drive at the elbow."""
    rows = wb.regressor(pendulum_arm(0.3, 0.2)).at(motion.q, motion.qd, motion.qdd).reshape(len(motion.t), 2, -1)
    drive = np.stack([np.zeros(len(motion.t)), motion.qdd[:, 1]], axis=1)
    return np.concatenate([rows, drive[:, :, np.newaxis]], axis=2)


def errors_in(log: wb.Dataset, names: Sequence[str], variants: Sequence[Variant]) -> wb.Array:
    """The errors (V, M, 2) of variants on some logs, by fits of all others with the delay that is best there."""

    def misfit(delay: float) -> float:
        every = motions_of(log, USUAL.cutoff, delay).items()
        training = [rows_of(USUAL, one, bodies_of(one)) for name, one in every if name not in names]
        return float(np.log(solve(training, USUAL.columns, USUAL.scale)[1]).sum())

    delay, answers = min(DELAYS, key=misfit), []
    for (cutoff, _, _), group in itertools.groupby(variants, lambda one: one.equations):
        same, every = list(group), motions_of(log, cutoff, delay)
        rows = {name: rows_of(same[0], one, bodies_of(one)) for name, one in every.items()}
        answers += [errors_of(variant, rows, every, names) for variant in same]
    return np.array(answers)


def errors_without(held_out: tuple[str, ...]) -> wb.Array:
    """The errors (V, M, 2) of all variants on some of the five logs, by fits of the others."""
    return errors_in(read(EXCITATIONS), [name_of(file) for file in held_out], VARIANTS)


def errors_on(path: str, variant: Variant) -> wb.Array:
    """The errors (2,) in N m of shoulder and elbow on another log of the machine, by a fit of all five."""
    log = read(EXCITATIONS).with_experiments(read_log(path, "another"))
    return np.asarray(errors_in(log, ["another"], [variant])[0, 0])


@dataclass(frozen=True)
class NestedChoice:
    """The variant that four logs choose, and its errors (2,) in N m on the fifth; `usual` are those of USUAL."""

    name: str
    variant: Variant
    errors: wb.Array
    usual: wb.Array


def choose(tables: Sequence[wb.Array]) -> tuple[NestedChoice, ...]:
    """For each excitation the choice by the other four, from the answers of `errors_without` for LEFT_OUT."""
    known, answers = dict(zip(LEFT_OUT, tables, strict=True)), []
    for file in EXCITATIONS:
        score = np.zeros(len(VARIANTS))
        for pair, table in known.items():
            if len(pair) == 2 and file in pair:
                score += np.log(table[:, 1 - pair.index(file)]).sum(axis=1)
        best = int(np.argmin(score))
        outer = known[(file,)][:, 0]
        answers.append(NestedChoice(name_of(file), VARIANTS[best], outer[best], outer[VARIANTS.index(USUAL)]))
    return tuple(answers)


def choose_by_all(tables: Sequence[wb.Array]) -> Variant:
    """The variant that is best over all five logs, each held out once: the one for a log that is not here."""
    score = np.sum([np.log(table).sum(axis=(1, 2)) for table in tables if table.shape[1] == 1], axis=0)
    return VARIANTS[int(np.argmin(score))]
