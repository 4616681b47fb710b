"""The stable part of a system with integrators or unstable modes, which can be reduced, and the rest, which is kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.frequency.exact_systems import is_stable
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import EPS, DesignError

NEAR = 1e-8  # relative to A, or to one: a mode at this distance from the limit of stability counts as on it
MOST_GROWTH = 1e6  # of the states, by the transformation that separates both parts


@dataclass(frozen=True, eq=False)
@show
class StableSplit:
    """A system as the sum of a `stable` part, which has the direct term, and the `rest`, both `StateSpace`."""

    stable: System
    rest: System

    @check_arguments
    def join(self, model: System) -> System:
        """A model of the stable part and the rest in parallel: its error is that of the model.

        The bound of `balanced_truncation`, and its certified error, hold for the sum as they stand.

        Raises
        ------
        ValueError
            If the model has other inputs, outputs or another period than the system.
        """
        import control

        call = "StableSplit.join(model)"
        A, B, C, D = state_space(call, model)
        F, G, H, _ = state_space(call, self.rest)
        if D.shape != self.rest.D.shape or model.dt != self.rest.dt:
            raise ValueError(
                f"`{call}`: the model must have {self.rest.ninputs} inputs, {self.rest.noutputs} outputs and period "
                f"{self.rest.dt}; got {D.shape[1]}, {D.shape[0]} and {model.dt}."
            )
        both = linalg.block_diag(A, F).reshape(len(A) + len(F), -1) if len(A) + len(F) else np.zeros((0, 0))
        names = {"inputs": list(self.rest.input_labels), "outputs": list(self.rest.output_labels)}
        matrices = both, np.vstack([B, G]), np.hstack([C, H]), D
        return control.StateSpace(*matrices, model.dt, remove_useless_states=False, **names)


@check_arguments
def stable_part(system: System) -> StableSplit:
    """The stable part of a `StateSpace`, continuous or discrete, apart from its integrators and unstable modes.

    An ordered Schur form and Sylvester's equation separate them. Reduce the stable part by any method of
    `wb.reduction`, and `join` the model with the rest. A mode within 1e-8 of the limit of stability, relative to the
    norm of A (in discrete time, to one), belongs to the rest.

    Raises
    ------
    ValueError
        If the system is not a `StateSpace` with finite matrices.
    DesignError
        If modes of both parts lie so near to each other that rounding decides, or the stable part is not stable.

    Examples
    --------
    >>> import control
    >>> servo = control.ss([[0.0, 1.0], [0.0, -2.0]], [[0.0], [1.0]], [[1.0, 0.0]], 0.0)
    >>> parts = wb.reduction.stable_part(servo)
    >>> parts.stable.poles(), parts.rest.poles()
    (array([-2.+0.j]), array([0.+0.j]))
    """
    import control

    A, B, C, D = state_space("stable_part", system)
    discrete, n = bool(system.isdtime(strict=True)), len(A)
    limit = NEAR * (1.0 if discrete else float(np.linalg.norm(A))) if n else 0.0

    def stays(real: float, imaginary: float) -> bool:
        return bool(np.hypot(real, imaginary) < 1 - limit if discrete else real < -limit)

    T, Z, k = linalg.schur(A, sort=stays) if n else (A, A, 0)
    X = np.zeros((k, n - k))
    if 0 < k < n:
        X[:] = linalg.solve_sylvester(T[:k, :k], -T[k:, k:], -T[:k, k:])
    inputs, outputs = Z.T @ B, C @ Z
    if not np.linalg.norm(X) < MOST_GROWTH or not _is_solved(T, X, k) or not is_stable(T[:k, :k], discrete):
        raise DesignError(
            f"`stable_part(system)`: rounding decides which modes of '{system.name}' are stable, as some lie at the "
            "limit and near to others; shift one, or choose other units."
        )
    stable = T[:k, :k], inputs[:k] - X @ inputs[k:], outputs[:, :k], D
    rest = T[k:, k:], inputs[k:], outputs[:, :k] @ X + outputs[:, k:], np.zeros_like(D)
    names = {"inputs": list(system.input_labels), "outputs": list(system.output_labels)}
    parts = [
        control.StateSpace(*m, system.dt, name=f"{system.name} {which}", remove_useless_states=False, **names)
        for which, m in (("stable", stable), ("rest", rest))
    ]
    return StableSplit(*parts)


def _is_solved(T: Array, X: Array, k: int) -> bool:
    """True if the transformation separates both parts but for rounding."""
    left = T[:k, :k] @ X - X @ T[k:, k:] + T[:k, k:]
    size = float(np.linalg.norm(T)) * (1 + float(np.linalg.norm(X)))
    return bool(np.linalg.norm(left) <= 64 * max(len(T), 1) * EPS * size)
