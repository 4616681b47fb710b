"""`d2c`: the system in continuous time whose samples behind a zero-order hold a sampled system gives."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import expm, logm

from workbench.core.validation.refusals import refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import Complex, DesignError

if TYPE_CHECKING:
    import control

ZERO = 1e-9  # of the largest pole, at least 1: a pole in z that is nearer to zero has no logarithm
REAL = 1e-10  # relative: a pole in z with a smaller imaginary part is a real one
EXACT = 1e-8  # relative error of the system that is sampled again


@check_arguments
def d2c(system: control.StateSpace) -> control.StateSpace:
    """The system in continuous time that `c2d` with a zero-order hold samples to this one, by a logarithm.

    exp([[A, B], [0, 0]] h) = [[Ad, Bd], [0, I]]. Names and operating point are the same. The answer is the one whose
    poles have imaginary parts below Nyquist's frequency pi / h. It is sampled again and compared.

    Parameters
    ----------
    system
        A `StateSpace` in discrete time with a period in s.

    Raises
    ------
    ValueError
        If the system is not in discrete time, or its period is not known.
    DesignError
        If there is no such system: a pole at z = 0, as that of a delay, or on the negative real axis has no real
        logarithm; or the logarithm is not exact.

    References
    ----------
    Franklin, Powell and Workman (1998), Digital Control of Dynamic Systems, section 4.3; Higham (2008), Functions of
    Matrices, theorem 1.23.

    Examples
    --------
    >>> motor = wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0])
    >>> np.allclose(wb.frequency.d2c(wb.c2d(motor, 0.01)).A, motor.A)
    True
    """
    import control

    from workbench.design.linear.pointed_systems import PointedSpace, point_of

    if not isinstance(system, control.StateSpace) or not system.isdtime(strict=True) or system.dt is True:
        raise refusal("d2c(system=...)", "a `StateSpace` in discrete time whose `dt` is a number of seconds", system)
    A, B, Cy, D = state_space("d2c", system)
    _refuse_poles(system.name, np.linalg.eigvals(A).astype(complex))
    nx, nu, h = len(A), B.shape[1], float(system.dt)
    whole = np.block([[A, B], [np.zeros((nu, nx)), np.eye(nu)]])
    root = np.asarray(logm(whole))
    size = float(np.abs(root).max(initial=1.0))
    again = expm(root.real)
    error = float(np.abs(again - whole).max(initial=0.0)) / float(np.abs(whole).max(initial=1.0))
    turning = float(np.abs(root.imag).max(initial=0.0)) if np.iscomplexobj(root) else 0.0
    if turning > EXACT * size or not error < EXACT:
        raise DesignError(
            f"`d2c(system=...)`: the logarithm of '{system.name}' is not exact; sampled again it differs by "
            f"{error:.2g} of its largest number. Use the system in discrete time."
        )
    names = {"states": system.state_labels, "inputs": system.input_labels, "outputs": system.output_labels}
    root = root.real / h
    answer = control.ss(root[:nx, :nx], root[:nx, nx:], Cy, D, name=f"{system.name}$continuous", **names)
    point = point_of(system)
    return answer if point is None else PointedSpace(answer, point)


def _refuse_poles(name: str, poles: Complex) -> None:
    """Refuse poles in z without a real logarithm."""
    scale = max(1.0, float(np.abs(poles).max(initial=0.0)))
    if len(poles) and np.abs(poles).min() <= ZERO * scale:
        raise DesignError(
            f"`d2c(system=...)`: '{name}' has a pole at z = 0, as that of a delay, which no system in continuous time "
            "of finite order has. Take the delay out first, or use the system in discrete time."
        )
    negative = poles[(poles.real < 0) & (np.abs(poles.imag) <= REAL * np.abs(poles))]
    if len(negative):
        raise DesignError(
            f"`d2c(system=...)`: '{name}' has a pole at z = {float(negative[0].real):.6g}; a negative real pole is of "
            "no system in continuous time of the same order. Use the system in discrete time, or a lower order or "
            "a shorter period."
        )
