from itertools import pairwise
from math import comb

import casadi as ca
import numpy as np

from workbench.blocks.loop.contracts import AbstractObserver, Inputs, Parts, Reads
from workbench.blocks.observers.observer_model import HAT, phi, with_hats
from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Number, Scalar
from workbench.core.units import ANY
from workbench.core.validation.refusals import name as checked_name


@block
class ExtendedStateObserver(AbstractObserver):
    """A linear extended-state observer of a plant y^(n) = d + b u, in which d is the sum of all other terms:

        x_hat_i' = x_hat_(i+1) + l_i (y - x_hat_1),    i < n
        x_hat_n' = d_hat + b u + l_n (y - x_hat_1)
        d_hat'   = l_(n+1) (y - x_hat_1),              l_i = (n + 1 choose i) omega_o^i

    With these gains each pole of the error is -omega_o. For a constant d the error converges to zero; for |d'| <= D it
    is bounded by D times a power of 1 / omega_o. If a computer holds y and u for a period T, the step of the
    observer is exact while T omega_o < 40.

    Parameters
    ----------
    chain
        Names of the output y and of its derivatives up to order n - 1, as ("theta", "omega") for n = 2.
    input
        Name of the input u of the plant, which must be one number.
    b
        Gain b of the input, in the unit of y^(n) over that of u.
    omega_o
        Bandwidth of the observer.
    unit
        Unit of y. The units of the derivatives and of d follow from it. By default they fit any unit.
    disturbance
        Name of the estimate d_hat among the estimates.

    References
    ----------
    Han (2009), From PID to active disturbance rejection control, IEEE Transactions on Industrial Electronics 56(3).
    Gao (2003), Scaling and bandwidth-parameterization based controller tuning, American Control Conference.
    Miklosovic, Radke and Gao (2006), Discrete implementation and generalization of the extended state observer, ACC.

    Examples
    --------
    >>> observer = wb.ExtendedStateObserver(("omega",), input="v", b=2.0, omega_o=50.0, unit="rad/s")
    >>> observer.reads.names, observer.gives.names
    (('omega',), ('omega', 'd'))
    """

    chain: tuple[str, ...]
    input: str
    b: Scalar = parameter(unit=ANY, symbol="b")
    omega_o: Scalar = parameter(unit="rad/s", low=0, strict=True, symbol="omega_o")
    unit: str = ANY
    disturbance: str = "d"

    def __post_init__(self) -> None:
        names = [checked_name("ExtendedStateObserver(chain=...)", name) for name in (*self.chain, self.disturbance)]
        if not self.chain or len(set(names)) < len(names):
            raise ValueError(
                "`ExtendedStateObserver(chain=..., disturbance=...)` must be names that differ, that of the output "
                f"first; got {names}."
            )

    @property
    def reads(self) -> Layout:
        return Layout(self.gives.entries[:1])

    @property
    def inputs(self) -> Layout:
        return Layout((Entry(self.input, np.array(0.0), ANY),))

    @property
    def gives(self) -> Layout:
        orders = ("", "/s", *(f"/s^{i}" for i in range(2, len(self.chain) + 1)))
        units = (ANY if self.unit == ANY else f"{self.unit}{order}" for order in orders)
        names = (*self.chain, self.disturbance)
        return Layout(tuple(Entry(n, np.array(0.0), unit) for n, unit in zip(names, units, strict=True)))

    @property
    def memory(self) -> Layout:
        return with_hats(self.gives)

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        return Signals({name: z[f"{name}{HAT}"] for name in self.gives.names})

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        names, error = self.memory.names, y[self.chain[0]] - z[f"{self.chain[0]}{HAT}"]
        rates = {name: l * error for name, l in zip(names, self._gains(), strict=True)}
        for name, after in pairwise(names):
            rates[name] += z[after]
        rates[names[-2]] += self.b * u[self.input]
        return rates

    @property
    def method(self) -> str:
        return "exact step of the observer"

    def advance(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs, period: float) -> Parts:
        rates = self.memory.flatten(self.rate(t, z, y, est, u))
        n = rates.numel()
        F = ca.vertcat(ca.horzcat(ca.SX.zeros(n - 1, 1), ca.SX.eye(n - 1)), ca.SX.zeros(1, n))
        F[:, 0] -= ca.vertcat(*self._gains())
        moved = self.memory.flatten({name: z[name] for name in self.memory.names}) + period * phi(period * F) @ rates
        return self.memory.view(moved)

    def _gains(self) -> list[ca.SX]:
        n = len(self.chain) + 1
        return [comb(n, i) * self.omega_o**i for i in range(1, n + 1)]
