"""The generalized plant of mixed sensitivity: weights on S, K S and T of one loop."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy import linalg

from workbench.core.point import OperatingPoint
from workbench.core.validation.refusals import Array, describe, finite
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import EPS, DesignError, pole_text
from workbench.design.synthesis.generalized_plant import GeneralizedPlant

if TYPE_CHECKING:
    import control

CALL = "mixed_sensitivity(plant)"
UNSURE = 16.0  # roundings of A within which a pole counts as one on the axis
Matrices = tuple[Array, Array, Array, Array]


@check_arguments
def mixed_sensitivity(
    plant: control.StateSpace | control.TransferFunction,
    W1: control.StateSpace | control.TransferFunction | float | None = None,
    W2: control.StateSpace | control.TransferFunction | float | None = None,
    W3: control.StateSpace | control.TransferFunction | float | None = None,
    input_disturbance: float = 0.0,
) -> GeneralizedPlant:
    """The generalized plant whose closed loop is [W1 S; W2 K S; W3 T], for `hinf_controller` or `h2_controller`.

    The sign of the feedback is inside K, as for `lqg`: u = K y. So S = (I - G K)^-1 and T = -G K S. The disturbance w
    is added to the output, y = G u + w, and the errors are W1 y, W2 u and W3 G u. A plant with poles on the imaginary
    axis needs an `input_disturbance`: a second part of w, multiplied by this number, which is added to the control.

    Parameters
    ----------
    plant
        A `StateSpace`, or a proper `TransferFunction` of one channel. It may be sampled; then the weights are, too.
    W1, W2, W3
        Weights of y, u and G u: a number, a system of one channel for all of them, or one with a channel for each.
        They must be stable and proper. None leaves the error out.
    input_disturbance
        The size of the disturbance at the control, in the unit of u; 0 for none.

    Raises
    ------
    ValueError
        If a weight is improper, not stable or of another size, or all are None.
    DesignError
        If the plant has poles on the imaginary axis and no `input_disturbance`.

    References
    ----------
    Kwakernaak (1993), Robust control and H-infinity optimization, Automatica 29. Skogestad, Postlethwaite (2005),
    Multivariable Feedback Control, section 9.3.

    Examples
    --------
    >>> import control
    >>> G = control.tf([1.0], [1.0, 2.0, 1.0])
    >>> plant = wb.mixed_sensitivity(G, W1=control.tf([0.5, 1.0], [1.0, 0.01]), W2=0.1)
    >>> plant.sizes, round(wb.hinf_controller(plant).gamma.value, 9)
    ((3, 1, 1, 2, 1), 0.800532011)
    """
    G, period = _proper(plant, "plant"), float(plant.dt) if plant.dt else None
    size = finite("mixed_sensitivity(input_disturbance=...)", input_disturbance, low=0.0)
    weights = _weights({"W1": W1, "W2": W2, "W3": W3}, G[3].shape, period)
    if size == 0:
        _check_axis(G[0], period)
    joined = _join(G, weights, size)
    names = tuple(plant.output_labels), tuple(plant.input_labels)
    return replace(joined, dt=period, measurements=names[0], controls=names[1], point=_point(plant))


def _weights(
    weights: dict[str, System | float | None], size: tuple[int, ...], period: float | None
) -> list[tuple[str, Matrices]]:
    """The weights that are not None, by their names."""
    ny, nu = size
    channels = {"W1": ny, "W2": nu, "W3": ny}
    found = [
        (name, _weight(name, weight, channels[name], period)) for name, weight in weights.items() if weight is not None
    ]
    if not found:
        raise ValueError(f"`{CALL}`: at least one of W1, W2 and W3 must be given, or there is no error to make small.")
    return found


def _point(plant: System) -> OperatingPoint | None:
    from workbench.design.linear.pointed_systems import point_of

    return point_of(plant) if hasattr(plant, "A") else None


def _join(G: Matrices, weights: list[tuple[str, Matrices]], size: float) -> GeneralizedPlant:
    """The states of the plant and of its weights one below the other; each weight reads y, u or G u."""
    A, B, C, D = G
    n, (ny, nu) = len(A), D.shape
    states = linalg.block_diag(A, *(W[0] for _, W in weights))
    total = len(states)
    nw = ny + (nu if size else 0)
    into = size * np.eye(nu) if size else np.zeros((nu, 0))  # of the second part of w into u
    B1, B2 = np.zeros((total, nw)), np.zeros((total, nu))
    B1[:n, ny:], B2[:n] = B @ into, B
    at = n
    errors = []
    for name, (Aw, Bw, Cw, Dw) in weights:
        reads_x = np.zeros((nu, n)) if name == "W2" else C
        reads_u = np.eye(nu) if name == "W2" else D
        reads_w = np.hstack([np.eye(ny) if name == "W1" else np.zeros((len(reads_x), ny)), reads_u @ into])
        if name == "W2":
            reads_w = np.zeros((nu, nw))  # the command itself, without its disturbance
        rows = slice(at, at + len(Aw))
        states[rows, :n] = Bw @ reads_x
        B1[rows], B2[rows] = Bw @ reads_w, Bw @ reads_u
        C1 = np.zeros((len(Cw), total))
        C1[:, :n], C1[:, rows] = Dw @ reads_x, Cw
        errors.append((C1, Dw @ reads_w, Dw @ reads_u))
        at += len(Aw)
    C1, D11, D12 = (np.vstack(parts) for parts in zip(*errors, strict=True))
    C2 = np.hstack([C, np.zeros((ny, total - n))])
    D21 = np.hstack([np.eye(ny), D @ into])
    return GeneralizedPlant(states, B1, B2, C1, C2, D11, D12, D21, D)


def _weight(name: str, weight: System | float, channels: int, period: float | None) -> Matrices:
    """A stable and proper weight with so many channels."""
    if isinstance(weight, float | int):
        value = finite(f"mixed_sensitivity({name}=...)", weight)
        return np.zeros((0, 0)), np.zeros((0, channels)), np.zeros((channels, 0)), value * np.eye(channels)
    W = _proper(weight, name)
    if (float(weight.dt) if weight.dt else None) != period:
        raise ValueError(f"`{CALL}`: {name} must have the period of the plant, {period}; it has {weight.dt}.")
    if W[3].shape == (1, 1) and channels > 1:
        one = np.eye(channels)
        A, B, C, D = (np.asarray(np.kron(one, part), dtype=float) for part in W)
        W = A, B, C, D
    if W[3].shape[1] != channels:
        raise ValueError(f"`{CALL}`: {name} must have 1 or {channels} channels; it has {W[3].shape[1]} inputs.")
    modes = np.linalg.eigvals(W[0]) if len(W[0]) else np.zeros(0, complex)
    inside = modes.real < 0 if period is None else np.abs(modes) < 1
    for mode in modes[~inside]:
        region = "left of the imaginary axis" if period is None else "inside the unit circle"
        raise ValueError(
            f"`{CALL}`: {name} must be stable, as no controller moves its poles; {pole_text(complex(mode))} does not "
            f"lie {region}. Shift the pole: (s/M + w)/(s + w e) with a small e stands for an integrator."
        )
    return W


def _proper(system: object, name: str) -> Matrices:
    """The matrices of a `StateSpace`, or of a proper `TransferFunction` of one channel by its companion matrix."""
    if hasattr(system, "A"):
        return state_space(CALL, system)
    import control  # takes seconds

    if not isinstance(system, control.TransferFunction) or not system.issiso():
        raise ValueError(
            f"`{CALL}`: {name} must be a `StateSpace`, or a `TransferFunction` of one channel; got {describe(system)}."
        )
    num, den = (np.trim_zeros(np.asarray(part[0][0], dtype=float), "f") for part in (system.num, system.den))
    if not (np.isfinite(num).all() and np.isfinite(den).all()):
        raise ValueError(f"`{CALL}`: {name} must have finite coefficients.")
    if len(num) > len(den):
        raise ValueError(
            f"`{CALL}`: {name} must be proper; its numerator has degree {len(num) - 1}, its denominator "
            f"{len(den) - 1}. Add the poles that it has in truth."
        )
    n = len(den) - 1
    num = np.concatenate([np.zeros(n + 1 - len(num)), num]) / den[0]
    den = den / den[0]
    A = np.vstack([-den[1:], np.eye(n)[:-1]]) if n else np.zeros((0, 0))
    B = np.eye(n)[:, :1] if n else np.zeros((0, 1))
    return A, B, (num[1:] - num[0] * den[1:])[np.newaxis, :], num[:1, np.newaxis]


def _check_axis(A: Array, period: float | None) -> None:
    """Refuse a plant with poles on the imaginary axis: the disturbance at the output does not drive them."""
    modes = np.linalg.eigvals(A) if len(A) else np.zeros(0, complex)
    size = np.abs(modes).max(initial=0.0)
    apart = np.abs(modes.real if period is None else np.abs(modes) - 1)
    for mode in modes[apart <= UNSURE * EPS * size]:
        raise DesignError(
            f"`{CALL}`: the plant has the pole {pole_text(complex(mode))} on the limit of stability, which a "
            "disturbance at the output does not drive. Give an input_disturbance above 0, 0.01 say."
        )
