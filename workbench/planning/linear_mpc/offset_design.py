"""The disturbance observer and the target of a predictive design whose outputs follow references without offset."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from workbench.core.point import OperatingPoint
from workbench.core.validation.refusals import Array, refusal
from workbench.design.control_system import System
from workbench.planning.linear_mpc.disturbance_observer import OffsetFree, offset_free
from workbench.planning.linear_mpc.limit_rows import MpcLimits
from workbench.planning.linear_mpc.linear_problem import LinearMpc, mpc_problem
from workbench.planning.linear_mpc.named_limits import output_map
from workbench.planning.linear_mpc.sampled_problem import delayed_zoh

NOISE = 1e-6  # variance of a period on a state of the plant; an input that is known has none
OF_DISTURBANCE = 1e-4  # of a change of the disturbance, that of a reading: faster ones were lost to wrong delays


class OutputPoint(NamedTuple):
    """The names of the outputs that are followed and of those that are read, and the values of both at the rest."""

    names: tuple[str, ...]
    y0: Array
    readings: tuple[str, ...]
    readings_y0: Array


def offset_design(
    system: System, problem: LinearMpc, period: float, delay: float, names: tuple[str, ...]
) -> tuple[OffsetFree, OutputPoint]:
    """The numbers of observer and target for the outputs of `names`; the observer reads all outputs.

    An observer of a loop is told the input that acts, so that whole periods of a delay are no states of its model. A
    part of a period is one, whose input it knows. The target is for the states of the problem.
    """
    if len(set(names)) < len(names):
        raise refusal("predictive_design(offset_free=...)", "names of outputs, each once", names)
    call = "predictive_design(offset_free=...)"
    output_map(call, system, names)
    readings = tuple(
        name for name, row in zip(system.output_labels, np.asarray(system.D), strict=True) if not row.any()
    )
    C, _ = output_map(call, system, readings)
    A, B = np.asarray(system.A), np.asarray(system.B)
    (nx, nu), ny = B.shape, len(C)
    Q, R, follow = problem.Q[:nx, :nx], problem.R, tuple(readings.index(name) for name in names)
    phi, gamma = delayed_zoh(A, B, period, 0.0)[:2]
    plain = mpc_problem(phi, gamma, Q, R, 1, MpcLimits())
    own = offset_free(plain, C, disturbance_noise=OF_DISTURBANCE, follow=follow)
    target, past = own.target, (len(problem.A) - nx) // nu
    phi, new, old, _ = delayed_zoh(A, B, period, delay)
    if old.any():
        late = mpc_problem(
            np.block([[phi, old], [np.zeros((nu, nx + nu))]]),
            np.vstack([new, np.eye(nu)]),
            np.block([[Q, np.zeros((nx, nu))], [np.zeros((nu, nx + nu))]]),
            R,
            1,
            MpcLimits(),
        )
        noise = np.zeros((nx + nu, nx + nu))
        noise[:nx, :nx] = NOISE * np.eye(nx)
        Bd, wide, how = np.vstack([own.Bd, np.zeros((nu, ny))]), np.hstack([C, np.zeros((ny, nu))]), OF_DISTURBANCE
        own = offset_free(late, wide, Bd=Bd, Cd=own.Cd, process_noise=noise, disturbance_noise=how, follow=follow)
    point = getattr(system, "point", None)
    places = [list(system.output_labels).index(name) for name in readings]
    y0 = point.y0[places] if isinstance(point, OperatingPoint) else np.zeros(ny)
    target = np.vstack([target[:nx], *[target[nx:]] * (past + 1)])
    return replace(own, target=target), OutputPoint(tuple(names), y0[list(follow)], readings, y0)
