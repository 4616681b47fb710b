"""A transport delay in continuous time: its Pade approximant as a system of states."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, block, initial, parameter
from workbench.core.block import Scalar, Vector
from workbench.core.expressions import refuse_misfit
from workbench.plants.elements import AbstractElement, spread
from workbench.validation.refusals import whole

MOST_ORDER = 50  # each is a state


@block
class PadeDelay(AbstractElement):
    """The Pade approximant [n/n] of a transport delay, exp(-T s), in its balanced realisation, see `pade`.

    Its gain is 1 at all frequencies, and up to omega T = n its phase is -omega T within 0.08 rad. The delay of a
    computer is a number of periods, and is exact: `digital(period, delay=...)`.

    Parameters
    ----------
    time
        T in s, one for all numbers of the signal.
    order
        n, at most 50.
    past
        The constant signal that came in before the start, in its unit.

    Examples
    --------
    >>> wb.Equipped(wb.DCMotor(), actuators=(wb.PadeDelay("v", time=0.1, order=2),)).states.names
    ('omega', 'i', 'v.delayed')
    """

    time: Scalar = parameter(unit="s", low=0, strict=True, symbol="T")
    order: int
    past: Vector = initial(0.0, unit="{unit}", shape=("*",))

    def __post_init__(self) -> None:
        whole("PadeDelay(order=...)", self.order, most=MOST_ORDER)

    def memory(self, entry: Entry) -> Layout:
        """The content of the delay, (n,) or (n, k): at rest the signal, and zeros below it."""
        first = np.eye(self.order)[0]
        past = spread(self.past, entry)
        units = [unit for unit in entry.units for _ in first]
        unit = entry.unit if len(set(units)) == 1 else ", ".join(units)
        return Layout((Entry("delayed", np.multiply.outer(first, past), unit),))

    def output(self, z: Mapping[str, ca.SX], v: ca.SX) -> ca.SX:
        """The signal of about T ago."""
        refuse_misfit("PadeDelay.output", "v", v, z["delayed"].shape[1], 1)
        _, _, C, D = pade(self.order)
        return ca.mtimes(z["delayed"].T, ca.DM(C)) + D * v

    def rate(self, z: Mapping[str, ca.SX], v: ca.SX) -> Mapping[str, ca.SX]:
        """What passes through the delay."""
        refuse_misfit("PadeDelay.rate", "v", v, z["delayed"].shape[1], 1)
        A, B, _, _ = pade(self.order)
        return {"delayed": (ca.mtimes(ca.DM(A), z["delayed"]) + ca.mtimes(ca.DM(B), v.T)) / self.time}


def pade(order: int) -> tuple[Any, Any, Any, float]:
    r"""The Pade approximant [n/n] of exp(-s) as x' = A x + B v, y = C x + D v: (n, n), (n,), (n,) and a number.

    It is (c - 1) / (c + 1), where c is Lambert's continued fraction of coth(s/2) cut after n terms,

        c = 1/w + 1 / (3/w + 1 / (5/w + ...)),   w = s/2,

    a ladder of n integrators; each scaled to the energy that it holds, both Gramians are the unit matrix. A constant
    signal v rests at x = (v, 0, ..., 0).

    References
    ----------
    NIST Digital Library of Mathematical Functions, equation 4.39.1 (tanh, whose reciprocal is c).
    Glover and Yuan (2012), Balanced realisations of all-pass systems using exact arithmetic with application to the
    approximation of delay systems, IEEE Conference on Decision and Control.
    """
    k = np.arange(1, order + 1)
    r = np.sqrt(2.0 * k - 1)
    driven = (k % 2 == order % 2).astype(float)  # those that the signal drives, every second one
    signs = np.where(k[:, None] > k, -1.0, 0.0) * np.outer(driven, 1 - driven)
    A = 2 * np.outer(r, r) * (signs - signs.T - np.outer(driven, driven))
    sign = (-1.0) ** order
    return A, 2 * r * driven, -2 * sign * r * driven, sign
