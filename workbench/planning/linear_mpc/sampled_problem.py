r"""A problem from a plant in continuous time: exact sampling behind a zero-order hold, with an input delay.

With the delay = d h + theta, 0 <= theta < h, the input that acts in a period changes once, after theta:

    x+ = Phi x + Gamma_1 u_{k-d-1} + Gamma_0 u_{k-d},
    Gamma_0 = int_0^{h - theta} e^{A s} ds B,     Gamma_1 = e^{A (h - theta)} int_0^theta e^{A s} ds B.

Reference: Astrom and Wittenmark (1997), Computer-Controlled Systems, section 2.3.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import expm

from workbench.core.point import OperatingPoint
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, finite, refusal, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.matrices import DesignError, matrix, semidefinite
from workbench.design.riccati.regulators import is_system
from workbench.planning.linear_mpc.cone_limits import cone_about
from workbench.planning.linear_mpc.limit_rows import MpcLimits, bounds, output_labels
from workbench.planning.linear_mpc.linear_problem import LinearMpc, mpc_problem

WHOLE = 1e-9  # of a period: a delay this near to whole periods is whole


@check_arguments
def sampled_mpc(
    system: System, period: float, Q: Numbers, R: Numbers, horizon: int, limits: MpcLimits, *, delay: float = 0.0
) -> LinearMpc:
    """The problem for a linearised plant at its rest, sampled exactly, with limits in the units of the plant.

    Parameters
    ----------
    system
        A `StateSpace` in continuous time, as `linearize` gives it at a rest; one without a point is about zero.
    period, delay
        Of the computer and of its inputs, in s. The state grows by the inputs on their way, oldest first.
    Q, R, horizon
        As in `mpc_problem`, the weights for a period.
    limits
        In the units of the plant; the answer's rows are for deviations from the rest. Rates are changes of a period.

    Raises
    ------
    ValueError
        If an argument is out of its range, or the horizon does not exceed the delay.
    DesignError
        If the system is sampled already, or no gain stabilises it.

    Examples
    --------
    >>> from workbench.planning.linear_mpc import MpcLimits, sampled_mpc
    >>> cart = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    >>> sampled_mpc(cart, 0.02, np.eye(4), [[0.1]], 20, MpcLimits(inputs=(-5.0, 5.0)), delay=0.03)
    <LinearMpc: 6 states, 1 inputs, horizon 20, limits on F>
    """
    h = seconds("sampled_mpc(period=...)", period)
    wait = finite("sampled_mpc(delay=...)", delay, " of seconds", low=0.0, high=1000 * h)
    if not is_system(system):
        raise refusal("sampled_mpc(system=...)", "a `StateSpace` of python-control, as `linearize` gives it", system)
    if system.dt:
        raise DesignError(
            f"`sampled_mpc(system)` must be in continuous time, as its delay is no whole number of periods otherwise; "
            f"this one is sampled at {system.dt} s. Give its matrices to `mpc_problem`."
        )
    A, new, old, whole = delayed_zoh(np.asarray(system.A), np.asarray(system.B), h, wait)
    (nx, nu), q = new.shape, semidefinite("sampled_mpc(Q=...)", "Q", Q, len(A))
    if old.any():
        A = np.block([[A, old], [np.zeros((nu, nx + nu))]])
        new = np.vstack([new, np.eye(nu)])
        q = np.block([[q, np.zeros((nx, nu))], [np.zeros((nu, nx + nu))]])
    names = tuple(system.state_labels), tuple(system.input_labels)
    point = getattr(system, "point", None)
    rest = (point.x0, point.u0) if isinstance(point, OperatingPoint) else (np.zeros(nx), np.zeros(nu))
    own = _about_rest(limits, rest, names, len(A))
    problem = mpc_problem(A, new, q, R, horizon, own, delay=whole, names=names)
    past = (len(problem.A) - nx) // nu
    return replace(problem, x0=np.concatenate([rest[0], *[rest[1]] * past]), u0=rest[1])


def delayed_zoh(A: Array, B: Array, period: float, delay: float) -> tuple[Array, Array, Array, int]:
    """Phi, Gamma_0, Gamma_1 and the whole periods d of a delay, for x' = A x + B u."""
    whole = int(np.floor(delay / period + WHOLE))
    rest = max(delay - whole * period, 0.0)
    rest = 0.0 if rest < WHOLE * period else rest
    first, second = _hold(A, B, period - rest), _hold(A, B, rest)
    return first[0] @ second[0], first[1], first[0] @ second[1], whole


def _hold(A: Array, B: Array, span: float) -> tuple[Array, Array]:
    """e^{A span} and the integral of e^{A s} B."""
    nx, nu = B.shape
    grown = expm(np.block([[A, B], [np.zeros((nu, nx + nu))]]) * span)
    return np.asarray(grown[:nx, :nx]), np.asarray(grown[:nx, nx:])


def _about_rest(
    limits: MpcLimits, rest: tuple[Array, Array], names: tuple[tuple[str, ...], tuple[str, ...]], size: int
) -> MpcLimits:
    """The limits for deviations from a rest, with none on an input that is on its way."""
    x0, u0 = rest
    inputs, states, outputs = limits.inputs, limits.states, limits.outputs
    if inputs is not None:
        low, high = bounds("MpcLimits(inputs=...)", inputs, names[1])
        inputs = low - u0, high - u0
    if states is not None:
        low, high = bounds("MpcLimits(states=...)", states, names[0])
        more = np.full(size - len(x0), np.inf)
        states = np.r_[low - x0, -more], np.r_[high - x0, more]
    if outputs is not None:
        C = matrix("MpcLimits(outputs=...)", "C", outputs[0], columns=len(x0))
        low, high = bounds("MpcLimits(outputs=...)", outputs[1], output_labels(limits, len(C)))
        outputs = C, (low - C @ x0, high - C @ x0)
    values = dict(zip((*names[0], *names[1]), (*x0.tolist(), *u0.tolist()), strict=True))
    cones = tuple(cone_about(cone, values) for cone in limits.cones)
    return replace(limits, inputs=inputs, states=states, outputs=outputs, cones=cones)
