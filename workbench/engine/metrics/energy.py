"""The energy that an effort moves along its flow: the integral of the size of their product."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca

from workbench.core import Ode
from workbench.core.units import SECOND, in_base_units, read
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.engine.metrics.contract import AbstractMetric, Integral


@dataclass(frozen=True)
@check_arguments
class Energy(AbstractMetric):
    """The integral of |u v| dt of an effort u and a flow v: a pair of outputs, or what a plant declares."""

    power: tuple[str, str] | None = None

    @property
    def watches(self) -> tuple[str, ...]:
        """The effort and the flow, as far as they are known before an equation is."""
        return self.power or ()

    @check_arguments
    def of(self, ode: Ode) -> AbstractMetric:
        """The integral for this equation."""
        pair = self.power or ode.power
        if not pair:
            raise LookupError(
                f"The metric '{self.name}' without a pair is of the power that the plant of a loop declares, and "
                f"'{ode.name}' declares none: name a pair whose product is a power, as in `energy(power=('v', 'i'))`. "
                f"It has: {', '.join(ode.outputs.names) or 'none'}."
            )
        u, v = pair

        def power(t: ca.SX, y: Mapping[str, ca.SX]) -> ca.SX:
            return ca.fabs(y[u] * y[v])

        about = f"integral of |{u} {v}|, nothing recovered"
        return Integral(self.name, "", about, power, _whole, (u, v), measure=unit_of_work).of(ode)

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The integral."""
        return integral


def _whole(integral: Array, horizon: float) -> Array:
    return integral


def unit_of_work(effort: str, flow: str) -> str:
    """The unit of effort times flow times seconds: J where that is an energy."""
    power = read(effort) * read(flow)
    watts = in_base_units(power, angles=False) == in_base_units(read("W"))
    return "J" if watts else str(power * SECOND)
