"""Elementary effects and tornadoes: the change of outputs as one factor moves, along paths of Morris or by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.array_shapes import require_shapes
from workbench.core.validation.refusals import Array, Integers
from workbench.core.validation.signatures import check_arguments
from workbench.study.uncertainty.designs import MorrisDesign, OneAtATime
from workbench.study.uncertainty.outputs import Estimate, of_output, outputs_of, t_quantile

FEW = 50  # trajectories, below which intervals are too narrow


@dataclass(frozen=True, eq=False)
@check_arguments
class MorrisEffects:
    """Elementary effects of d factors on k outputs, or on a single one without the axis k.

    `mu`, `mu_star` and `sigma` (k, d) are the mean of the effects, of their sizes, and their standard deviation, in the
    unit of the output per whole range of the factor. `refusals` has the reason for each output without effects, whose
    numbers are NaN.
    """

    names: tuple[str, ...]
    factors: tuple[str, ...]
    mu: Estimate
    mu_star: Estimate
    sigma: Estimate
    refusals: Mapping[str, str]
    remarks: tuple[str, ...]

    @check_arguments
    def __getitem__(self, name: str) -> MorrisEffects:
        """The effects on one output; one that was refused is refused again, with its reason."""
        return of_output(self, name, "mu", "mu_star", "sigma")


@check_arguments
def morris(
    design: MorrisDesign,
    outputs: object,
    names: Sequence[str] | None = None,
    *,
    factors: Sequence[str] | None = None,
    errors: object = None,
    confidence: float = 0.95,
) -> MorrisEffects:
    """Morris's mu, mu* and sigma of every output, with the jackknife's intervals over the trajectories.

    Morris (1991), Technometrics 33; mu*: Campolongo, Cariboni and Saltelli (2007), Environmental Modelling and
    Software 22.

        effect_i = (y(u + delta e_i) - y(u)) / delta,  u the point of the unit cube

    Effects over a grid have few values, some of them rare: with 10 trajectories, an interval of 95 % may contain the
    truth in only 8 cases of 10. A remark says this below 50 trajectories.

    Parameters
    ----------
    outputs
        (N,) or (N, k) in the order of the design's points.
    errors
        The errors of the outputs, of the same shape, NaN where they are not known; a remark says where they matter.

    Raises
    ------
    ValueError
        If an argument has the wrong kind or shape, or if every output is refused: for failed runs, infinities, or
        no variation beyond rounding.

    Examples
    --------
    >>> from workbench.study.uncertainty import MorrisDesign, morris
    >>> design = MorrisDesign(2, 8)
    >>> values = design.points() @ [1.0, 2.0]
    >>> morris(design, values, ("error",), factors=("k", "m"), errors=1e-6 * values, confidence=0.9).mu_star.value
    array([[1., 2.]])
    """
    held = outputs_of("morris", design, outputs, names, factors, errors)
    t = t_quantile("morris", confidence, design.trajectories - 1)
    effects = _effects(design, held.scaled_columns)
    scale = np.where(held.is_accepted, held.spread, np.nan)
    found = (_mean(effects, t), _mean(np.abs(effects), t), _deviation(effects, t))
    mu, mu_star, sigma = (Estimate(value * scale[:, np.newaxis], half * scale[:, np.newaxis]) for value, half in found)
    few = f"{design.trajectories} trajectories are few: the intervals, of sigma above all, are too narrow."
    remarks = held.remarks + ((few,) if design.trajectories < FEW else ())
    return MorrisEffects(held.names, held.factors, mu, mu_star, sigma, held.refusals, remarks)


def _effects(design: MorrisDesign, y: Array) -> Array:
    """The effect of every factor in every trajectory on columns (N, k), (trajectories, k, d)."""
    d, r = design.dimensions, design.trajectories
    moves = np.diff(design.points().reshape(r, d + 1, d), axis=1)
    moved = np.abs(moves).argmax(axis=2)  # the factor of each step of each trajectory
    direction = np.take_along_axis(np.sign(moves), moved[:, :, np.newaxis], axis=2)
    steps = np.diff(y.reshape(r, d + 1, -1), axis=1) * direction / design.delta
    effects = np.empty_like(steps)
    np.put_along_axis(effects, np.broadcast_to(moved[:, :, np.newaxis], steps.shape), steps, axis=1)
    return np.swapaxes(effects, 1, 2)


def _mean(effects: Array, t: float) -> tuple[Array, Array]:
    """The mean over trajectories and half of its interval."""
    return effects.mean(axis=0), t * effects.std(axis=0, ddof=1) / len(effects) ** 0.5


def _deviation(effects: Array, t: float) -> tuple[Array, Array]:
    """The standard deviation over trajectories, and half of its interval by the jackknife."""
    r = len(effects)
    squares = (effects - effects.mean(axis=0)) ** 2
    total = squares.sum(axis=0)
    value = np.sqrt(total / (r - 1))
    if r == 2:  # without one of two trajectories there is no deviation
        return value, np.where(value > 0, np.inf, 0.0)
    # leaving a trajectory out takes r / (r - 1) of its square from the sum of squares
    without = np.sqrt(np.maximum(total - squares * r / (r - 1), 0) / (r - 2))
    return value, t * np.sqrt((r - 1) * without.var(axis=0))


@dataclass(frozen=True, eq=False)
@check_arguments
class Tornado:
    """Outputs of one-at-a-time runs: `base` (k,) with no factor moved, and `moved_outputs` (k, d, levels).

    A single output has no axis k. `refusals` has the reason for each output that was refused; its numbers are NaN.
    """

    names: tuple[str, ...]
    factors: tuple[str, ...]
    levels: tuple[float, ...]
    base: Array
    moved_outputs: Array
    refusals: Mapping[str, str]

    def __post_init__(self) -> None:
        outputs = (len(self.names),) if self.base.ndim else ()
        bars = (*outputs, len(self.factors), len(self.levels))
        require_shapes(self, {"base": outputs, "moved_outputs": bars}, "of outputs, factors and levels in this order")

    @property
    def swing(self) -> Array:
        """The distance between the outermost outputs of each factor, with the output of the base among them, (k, d)."""
        base = np.broadcast_to(self.base[..., None, None], (*self.moved_outputs.shape[:-1], 1))
        return np.asarray(np.ptp(np.concatenate([self.moved_outputs, base], -1), axis=-1))

    @property
    def order(self) -> Integers:
        """The places of the factors, the widest bar first, (k, d)."""
        return np.argsort(-self.swing, axis=-1, kind="stable")

    @check_arguments
    def __getitem__(self, name: str) -> Tornado:
        """The tornado of one output; one that was refused is refused again, with its reason."""
        return of_output(self, name, "base", "moved_outputs")


@check_arguments
def tornado(
    design: OneAtATime,
    outputs: object,
    names: Sequence[str] | None = None,
    *,
    factors: Sequence[str] | None = None,
) -> Tornado:
    """The outputs of a one-at-a-time design, by factor and level; they say nothing about interactions.

    Raises
    ------
    ValueError
        As `morris`, which takes the same arguments.

    Examples
    --------
    >>> from workbench.study.uncertainty import OneAtATime, tornado
    >>> design = OneAtATime(2)
    >>> tornado(design, design.points() @ [1.0, 2.0], ("error",), factors=("k", "m")).order
    array([[1, 0]])
    """
    held = outputs_of("tornado", design, outputs, names, factors)
    values = np.where(held.is_accepted, held.columns, np.nan)
    moved = values[1:].reshape(design.dimensions, len(design.levels), -1)
    return Tornado(held.names, held.factors, design.levels, values[0], np.moveaxis(moved, -1, 0), held.refusals)
