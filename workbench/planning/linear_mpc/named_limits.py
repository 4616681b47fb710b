"""Limits by the names of a linear plant's signals, checked, as limits of a problem."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.core.point import OperatingPoint
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, known_name, refusal
from workbench.design.control_system import System
from workbench.design.matrices import definite, semidefinite
from workbench.planning.linear_mpc.cone_limits import ConeLimit
from workbench.planning.linear_mpc.limit_rows import RATE, MpcLimits, Pair, bounds
from workbench.planning.linear_mpc.linear_problem import LinearMpc

Names = tuple[tuple[str, ...], tuple[str, ...]]


def signal_names(system: System, Q: Numbers, R: Numbers) -> Names:
    """The names of states and inputs of a linear system; another object and unfit weights are refused."""
    if not hasattr(system, "state_labels"):
        raise refusal("predictive_design(system)", "a linear plant, as `linearize` returns it", system)
    states, inputs = tuple(system.state_labels), tuple(system.input_labels)
    semidefinite("predictive_design(Q=...)", "Q", Q, len(states))
    definite("predictive_design(R=...)", "R", R, len(inputs))
    return states, inputs


def refuse_rest(problem: LinearMpc) -> None:
    """Refuse limits that exclude the rest, about which the law plans, and inputs that cannot be moved into a cone."""
    for cone in problem.rows.cones:
        beyond = float(np.linalg.norm(cone.centre)) - cone.offset
        if not beyond < 0:
            raise ValueError(
                f"`predictive_design(cones=...)` must leave the rest of the plant inside; it lies {beyond:.4g} outside "
                f"of the {cone.name}. Take another rest, or widen the cone."
            )
        for i, value in zip(cone.inputs, cone.centre, strict=False):
            if not problem.rows.low[i] <= value <= problem.rows.high[i]:
                raise ValueError(
                    f"`predictive_design(limits=..., cones=...)` must have the axis of the {cone.name} within the "
                    f"limits of '{problem.rows.names[i]}', so that inputs can be drawn to it. Widen these limits."
                )
    for name, low, high in zip(problem.rows.names, problem.rows.low, problem.rows.high, strict=True):
        if not low <= 0.0 <= high:
            limits = "rate_limits" if name.startswith(RATE) else "limits"
            raise ValueError(
                f"`predictive_design({limits}=...)` must leave the rest of the plant inside; that of '{name}' lies "
                f"{low if low > 0 else -high:.4g} outside. Take another rest, or widen the limit."
            )


def named_limits(
    system: System,
    names: Names,
    limits: Mapping[str, Pair],
    rate_limits: Mapping[str, Pair],
    soft_weight: Numbers | None,
    cones: tuple[ConeLimit, ...] = (),
) -> MpcLimits:
    """The limits of a problem from those by name."""
    states, inputs = names
    outputs = tuple(name for name in system.output_labels if name not in (*states, *inputs))
    if not limits and not rate_limits and not cones:
        raise refusal("predictive_design(limits=...)", "a limit at least, else take `lqr`", limits)
    if rate_limits and any(name in inputs for cone in cones for name in cone.names):
        raise ValueError(
            "`predictive_design(rate_limits=..., cones=...)` must not limit both changes and cones of inputs, as a "
            "command is moved into one of them only. Leave out one."
        )
    for name in limits:
        known_name(name, (*states, *inputs, *outputs), "states, inputs and outputs of the plant")
    for name in rate_limits:
        known_name(name, inputs, "inputs of the plant")
    limited = tuple(name for name in outputs if name in limits)
    return MpcLimits(
        inputs=_ends("limits", inputs, limits),
        states=_ends("limits", states, limits),
        outputs=_outputs(system, limited, limits) if limited else None,
        rates=_ends("rate_limits", inputs, rate_limits),
        soft_weight=soft_weight,
        output_names=limited,
        cones=cones,
    )


def output_map(call: str, system: System, names: tuple[str, ...]) -> tuple[Array, Array]:
    """C (n, nx) of some outputs, and the values (n,) of the plant's outputs less C x at its rest."""
    places = [list(system.output_labels).index(known_name(name, system.output_labels, "outputs")) for name in names]
    C, D = np.asarray(system.C, dtype=float)[places], np.asarray(system.D, dtype=float)[places]
    if direct := [name for name, row in zip(names, D, strict=True) if row.any()]:
        raise ValueError(
            f"`{call}` must name outputs on which no input acts at once; '{direct[0]}' has such an input. Give the "
            "plant an actuator with a state, or limit the input."
        )
    point = getattr(system, "point", None)
    return C, point.y0[places] - C @ point.x0 if isinstance(point, OperatingPoint) else np.zeros(len(names))


def _outputs(system: System, names: tuple[str, ...], limits: Mapping[str, Pair]) -> tuple[Array, Pair]:
    C, beyond = output_map("predictive_design(limits=...)", system, names)
    ends = _ends("limits", names, limits)
    assert ends is not None
    return C, (ends[0] - beyond, ends[1] - beyond)


def _ends(field: str, names: tuple[str, ...], limits: Mapping[str, Pair]) -> tuple[Array, Array] | None:
    """The two ends of the limits of some signals, infinite where there are none; None without any."""
    if not any(name in limits for name in names):
        return None
    for name in (name for name in names if name in limits):
        bounds(f"predictive_design({field}={{{name!r}: ...}})", limits[name], (name,))
    pairs = [limits.get(name, (-np.inf, np.inf)) for name in names]
    low, high = (np.array([pair[i] for pair in pairs], dtype=float) for i in (0, 1))
    return low, high
