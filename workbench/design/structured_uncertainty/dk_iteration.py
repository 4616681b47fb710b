"""Controllers for a small structured singular value: synthesis and scalings in turn, then a proved peak."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.matrices import EPS, Complex, DesignError, one_thread
from workbench.design.structured_uncertainty.balanced_states import in_balanced_states
from workbench.design.structured_uncertainty.magnitude_fit import MagnitudeFit
from workbench.design.structured_uncertainty.robustness_over_frequency import StructuredPeak, robustness_over_frequency
from workbench.design.structured_uncertainty.scaled_plants import (
    SampledScalings,
    sampled_scalings,
    scaled_plant,
    single_blocks,
)
from workbench.design.structured_uncertainty.uncertainty_blocks import UncertaintyBlock
from workbench.design.synthesis.controller_systems import controller_system, is_stable, loop_poles
from workbench.design.synthesis.generalized_plant import GeneralizedPlant, PlantParts, sampled_matrices
from workbench.design.synthesis.nearly_least import nearly_least_controller
from workbench.design.synthesis.normal_plant import Controller

CALL = "dk_iteration"
FREQUENCIES = 50
ABOVE = 1e-3  # relative distance of each controller from its least gamma, which keeps its modes slow
FALL = 1e-3  # relative: a peak that falls less ends the rounds, if it does so twice
MOST_STEP = 8.0  # times the change of the logarithm of D: small changes that go one way are enlarged
WIDTH = 5e-3  # relative, of the proved peak: mu is flat where it is least
MOST_ORDER = 6


@dataclass(frozen=True)
@show
class DkRound:
    """One round: the `gamma` of the scaled plant, and the `peak` of the bound of mu over the grid, at a `frequency`.

    The frequency is in rad/s. `misfit` is the largest error of a fitted scaling: the root mean square of the difference
    of logarithms over the grid. It is zero in the first round, which has no scalings.
    """

    gamma: float
    peak: float
    frequency: float
    misfit: float


@dataclass(frozen=True, eq=False)
@show
class DkIteration:
    """The controller with the smallest peak of mu in all rounds, from y to u, with the feedback sign inside.

    `peak` encloses the supremum of mu over frequency by `robustness_over_frequency`, for the blocks as they were given,
    with a width of 0.5 %. For this proof the closed loop is taken to balanced states in doubles, if that changes no
    gain on the grid by more than 1e-9. `orders` are those of the scalings of each block but the last. `poles` are those
    of the closed loop.
    """

    controller: System
    peak: StructuredPeak
    rounds: tuple[DkRound, ...]
    orders: tuple[int, ...]
    poles: Complex


@check_arguments
def dk_iteration(
    plant: GeneralizedPlant,
    blocks: Sequence[UncertaintyBlock],
    order: int = 3,
    rounds: int = 10,
    frequencies: Sequence[float] | None = None,
) -> DkIteration:
    """A controller that makes the peak of mu small: H-infinity synthesis and scalings D(s) in turn.

    In each round D is computed at each frequency, fitted by stable functions with stable inverses, and put on both
    sides of the plant. For the design a real block counts as complex, and a repeated scalar as separate ones. The
    rounds end when the peak no longer falls. The result may be a local minimum.

    Parameters
    ----------
    plant, blocks
        The plant, whose channels w and z are those of the blocks of Delta in their order, and these blocks. The last
        one is the demand on performance.
    order, rounds
        The order of each function of D, from 0 to 6, which the controller has twice; and the largest number of rounds.
    frequencies
        The grid in rad/s, at least two, positive and ascending; for a sampled plant values of v = tan(omega dt / 2). By
        default 50, from 1/30 of the slowest pole of the plant to 100 times the fastest.

    Raises
    ------
    ValueError
        If the blocks do not fit the channels, or an order, a number or a frequency is out of its range.
    DesignError
        If the plant breaks a condition of `hinf_controller`, or the loop has too many states for a proof.

    References
    ----------
    Doyle (1985), Structured uncertainty in control system design, Proc. 24th CDC. Skogestad and Postlethwaite (2005),
    Multivariable Feedback Control, section 8.12.

    Examples
    --------
    >>> import control
    >>> mu = wb.structured_uncertainty
    >>> lag = control.ss([[-1.0]], [[1.0, 0.0, 1.0]], [[0.0], [1.0], [-1.0]], [[0, 0, 0.5], [0, 0.2, 0], [0, -1, 0]])
    >>> plant = wb.synthesis.GeneralizedPlant.of(lag, measurements=1, controls=1)
    >>> answer = mu.dk_iteration(plant, [mu.FullBlock(1), mu.FullBlock(1)], order=1, rounds=3)
    >>> answer.peak.upper < 1.01 * answer.rounds[0].peak
    True
    """
    _refuse(plant, blocks, order, rounds)
    with one_thread(), np.errstate(all="ignore"):
        parts = plant.parts if plant.dt is None else _without_rounding(plant.parts.bilinear(CALL))
        omega = _grid(parts) if frequencies is None else _given(frequencies)
        history, matrices = _rounds(parts, single_blocks(blocks), order, rounds, omega)
        sampled = matrices if plant.dt is None else sampled_matrices(*matrices)
        controller = controller_system(plant, sampled, "dk controller")
        loop = plant.close(controller)
        if not is_stable(loop):
            raise DesignError(f"`{CALL}`: rounding leaves no stable loop; choose a lower order or other units.")
        best = int(np.argmin([entry.peak for entry in history]))
        orders = (order if best else 0,) * (len(single_blocks(blocks)) - 1)
        peak = _proved_peak(plant, loop, blocks, omega)
    return DkIteration(controller, peak, tuple(history), orders, loop_poles(loop))


def _rounds(
    parts: PlantParts, blocks: list[UncertaintyBlock], order: int, rounds: int, omega: Array
) -> tuple[list[DkRound], Controller]:
    """All rounds, and the controller of the one with the smallest peak."""
    history: list[DkRound] = []
    fits: list[MagnitudeFit] = []
    best: tuple[Controller, SampledScalings, Array] | None = None
    idle, step, used = 0, 1.0, np.ones((len(blocks) - 1, len(omega)))
    while len(history) < rounds and idle < 2:
        try:
            matrices, gamma = nearly_least_controller(CALL, scaled_plant(parts, blocks, fits), ABOVE)
        except DesignError:
            if best is None:
                raise
            if step == 1:  # the scalings are too stiff for the synthesis: the best controller so far is the answer
                break
            step = 1.0
            fits, used = _next(best, order, step)
            continue
        sampled = sampled_scalings(parts.close(*matrices), blocks, omega)
        history.append(_entry(gamma, sampled, fits))
        if best is None or sampled.peak < best[1].peak:
            idle = 0 if best is None or sampled.peak < best[1].peak * (1 - FALL) else idle + 1
            best, step = (matrices, sampled, used), min(2 * step, MOST_STEP) if len(history) > 2 else 1.0
        else:
            idle, step = idle + 1, 1.0
        fits, used = _next(best, order, step)
    assert best is not None
    return history, best[0]


def _next(best: tuple[Controller, SampledScalings, Array], order: int, step: float) -> tuple[list[MagnitudeFit], Array]:
    """The scalings after the best controller, and their magnitudes on the grid."""
    _, sampled, used = best
    fits = sampled.fits(order, used, step)
    return fits, np.exp(np.array([fit.log_magnitude(sampled.omega) for fit in fits]).reshape(used.shape))


def _proved_peak(
    plant: GeneralizedPlant, loop: System, blocks: Sequence[UncertaintyBlock], omega: Array
) -> StructuredPeak:
    """The peak of the closed loop, in balanced states where rounding allows it."""
    import control

    if plant.dt is None and (balanced := in_balanced_states((loop.A, loop.B, loop.C, loop.D), omega)) is not None:
        loop = control.ss(*balanced, remove_useless_states=False)
    return robustness_over_frequency(loop, blocks, WIDTH)


def _entry(gamma: float, sampled: SampledScalings, fits: list[MagnitudeFit]) -> DkRound:
    frequency = float(sampled.omega[sampled.bounds.argmax()])
    return DkRound(gamma, sampled.peak, frequency, max((fit.misfit for fit in fits), default=0.0))


def _without_rounding(p: PlantParts) -> PlantParts:
    """The plant with direct terms of the size of roundings set to zero, as they would join modes that are apart."""
    names = ("D11", "D12", "D21", "D22")
    size = max(float(np.abs(getattr(p, name)).max()) for name in names)
    return replace(
        p, **{name: np.where(np.abs(getattr(p, name)) > 16 * EPS * size, getattr(p, name), 0.0) for name in names}
    )


def _grid(parts: PlantParts) -> Array:
    """Frequencies over the sizes of the poles, without those far below the others: they stand for integrators."""
    sizes = np.abs(np.linalg.eigvals(parts.A))
    sizes = sizes[sizes > max(1e-4 * float(np.median(sizes)), 1e-12 * float(sizes.max(initial=0.0)))]
    low, high = (float(sizes.min()), float(sizes.max())) if len(sizes) else (1.0, 1.0)
    return np.geomspace(low / 30, high * 100, FREQUENCIES)


def _given(frequencies: Sequence[float]) -> Array:
    omega = np.asarray(frequencies, dtype=float)
    if len(omega) < 2 or not (np.isfinite(omega).all() and omega[0] > 0 and (np.diff(omega) > 0).all()):
        raise ValueError(
            f"`{CALL}(frequencies=...)` must be at least two positive numbers in ascending order; got {frequencies!r}."
        )
    return omega


def _refuse(plant: GeneralizedPlant, blocks: Sequence[UncertaintyBlock], order: int, rounds: int) -> None:
    _, nw, _, nz, _ = plant.sizes
    wanted = sum(block.shape[0] for block in blocks), sum(block.shape[1] for block in blocks)
    if len(blocks) == 0 or wanted != (nw, nz):
        raise ValueError(
            f"`{CALL}(plant, blocks)`: the {len(blocks)} blocks have {wanted[0]} rows and {wanted[1]} columns, so the "
            f"plant must have as many w and z; it has {nw} and {nz}."
        )
    if not 0 <= order <= MOST_ORDER:
        raise ValueError(f"`{CALL}(order=...)` must lie between 0 and {MOST_ORDER}; got {order}.")
    if rounds < 1:
        raise ValueError(f"`{CALL}(rounds=...)` must be at least 1; got {rounds}.")
