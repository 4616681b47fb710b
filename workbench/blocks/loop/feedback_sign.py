"""The sign of a linear system that closes a loop as it stands: whether its input was meant as y or as the error."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.blocks.loop.linear_blocks import LinearLaw
from workbench.core import LinearSystem, Ode, SampledSystem
from workbench.core.validation.refusals import Array

SUBSTEPS = 8  # of a period: enough to tell a mode that grows from one that decays
ROUNDING = 1e-9  # of a growth, relative to the size of the matrix


def opposite(law: LinearLaw) -> LinearLaw:
    """The law with the opposite sign, about the same point: u = u0 - C z - D v."""
    system = law.system
    turned = {letter: -matrix for letter in "CD" if (matrix := getattr(system, letter)) is not None}
    return replace(law, system=replace(system, **turned))


def refuse_wrong_sign(system: LinearSystem, loop: Ode | SampledSystem, reversed_loop: Ode | SampledSystem) -> None:
    """Refuse a `loop` that is unstable near its start, and stable as `reversed_loop`, with the other sign of its law.

    A compensator that was designed for negative feedback of the error is so where it is given y.
    """
    if not (_grows(loop) and not _grows(reversed_loop)):
        return
    read, driven = (", ".join(port.names) for port in (system.inputs, system.outputs))
    raise ValueError(
        f"`ClosedLoop(controller=...)`: a system of python-control as it stands is given '{read}' and not its error, "
        f"and '{driven}' is what comes out; so this loop is unstable, and with the opposite sign it is stable. Take "
        "`LinearLaw(C, error=True)` and a reference, which may be a `Constant` at zero, where C is a compensator of "
        f"the error; or `LinearLaw(C)` where the command is C {read} all the same."
    )


def _grows(loop: Ode | SampledSystem) -> bool:
    """True if the loop, linearised at its start, has a mode that grows."""
    matrix = _matrix(loop)
    if not np.isfinite(matrix).all():
        return False
    modes = np.linalg.eigvals(matrix)
    growth = modes.real if isinstance(loop, Ode) else np.abs(modes) - 1
    return bool(growth.max(initial=-np.inf) > ROUNDING * (1 + np.abs(matrix).max(initial=0.0)))


def _matrix(loop: Ode | SampledSystem) -> Array:
    """The Jacobian of the rate at the start or, of a loop that a computer closes, of the state after a period."""
    x, p = loop.states.default, loop.parameters.default
    if isinstance(loop, Ode):
        return np.array(loop.A(0.0, x, p))
    rule = loop.step(SUBSTEPS).rule
    slope = ca.jacobian(rule.without_crossings(rule.update), rule.x)
    after = ca.Function("after", [rule.k, rule.x, rule.p, rule.w], [slope])
    return np.array(ca.densify(after(0.0, x, p, np.zeros(rule.w.shape))))
