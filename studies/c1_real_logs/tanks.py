"""The cascaded tanks with overflow, whose sensor ends at 10 V: output errors of a model of both levels."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

import workbench as wb
from studies.c1_real_logs.logs import TANKS, log_path
from studies.c1_real_logs.thin_summary import thin_out

UNITS = {"u": "V", "h2": "V"}
PERIOD, LIMIT = 4.0, 10.0  # s between samples, and V where the sensor ends
EDGE, WEIR, SMALL = 0.1, 1.0, 0.1  # V of the edge of a tank, 1/s of its overflow, and V^0.5 that rounds the root at 0
SHOWN = 4  # samples of the record for one in a picture
FREE = ("k1", "k2", "k3", "k4", "k6", "d", "h1(0)", "h2(0)")


@wb.block
class CascadedTanks(wb.Plant):
    """Two tanks, whose levels are in volts of the sensor; what flows over the upper one falls into the lower one.

    h1' = k4 u + k6 u^2 - k1 sqrt(h1) - o(h1),    h2' = k2 sqrt(h1) - k3 sqrt(h2 + d) + o(h1) - o(h2)
    """

    k1: float = wb.parameter(default=0.06, unit="V^0.5/s", low=0)
    k2: float = wb.parameter(default=0.06, unit="V^0.5/s", low=0)
    k3: float = wb.parameter(default=0.06, unit="V^0.5/s", low=0)
    k4: float = wb.parameter(default=0.05, unit="1/s", low=0)
    k6: float = wb.parameter(default=0.0, unit="1/(V s)")
    d: float = wb.parameter(default=0.0, unit="V", low=-2)
    h1: float = wb.initial(default=5.0, unit="V")
    h2: float = wb.initial(default=5.2, unit="V")

    inputs = wb.layout(u="V")
    outputs = wb.layout(h2="V")

    def rate(self, t, x, u):  # type: ignore[no-untyped-def]
        """The flows into and out of both tanks."""
        upper, lower = over(x.h1), over(x.h2)
        first = self.k4 * u.u + self.k6 * u.u**2 - self.k1 * root(x.h1) - upper
        return {"h1": first, "h2": self.k2 * root(x.h1) - self.k3 * root(x.h2 + self.d) + upper - lower}


def over(level: ca.SX) -> ca.SX:
    """The flow over the edge of a tank at 10 V, with a smooth beginning."""
    above = level - LIMIT
    return WEIR * (EDGE * ca.log(1 + ca.exp(-ca.fabs(above) / EDGE)) + ca.fmax(above, 0))


def root(level: ca.SX) -> ca.SX:
    """The square root of a level, rounded at zero."""
    return ca.sqrt(ca.fmax(level, 0) + SMALL**2) - SMALL


@dataclass(frozen=True)
class TankFit:
    """The numbers of the tanks, and the errors in V."""

    values: dict[str, float]
    standard_errors: dict[str, float]
    error: float
    hold_out_error: float  # of all samples of the second record, the model cut off at 10 V as the sensor is
    marked_samples: tuple[int, int]
    summary: wb.identification.FitSummary


def read() -> tuple[wb.Dataset, wb.Dataset]:
    """The records of the fit and of the hold-out, with samples at the limit of the sensor marked."""
    logs = []
    for end, name in (("Est", "estimation"), ("Val", "hold-out")):
        names = {f"u{end}": "u", f"y{end}": "h2"}
        log = wb.Dataset.from_csv(log_path(TANKS), ["u", "h2"], names=names, units=UNITS, time=PERIOD, name=name)
        logs.append(log.mark_limits("h2", high=LIMIT))
    return logs[0], logs[1]


def tank_fit(what: str) -> TankFit:
    """The fit on the first record; of the second one it sees nothing but two initial levels are estimated there."""
    log, other = read()
    system = wb.open_loop(CascadedTanks())
    fit = wb.fit(system, log, FREE, hold_out=0.0)
    start = {name.removesuffix("(0)"): value for name, value in fit.values.items()}
    again = wb.fit(system, other, ["h1(0)", "h2(0)"], start=start, hold_out=0.0)
    measured = other.experiments[0]["h2"]
    model = np.minimum(again.errors[0][:, 0] + measured, LIMIT)
    counts = tuple(int(one.experiments[0].marks.sum()) for one in (log, other))
    return TankFit(
        fit.values,
        fit.standard_errors,
        fit.root_mean_squares["h2"],
        float(np.sqrt(np.mean((model - measured) ** 2))),
        (counts[0], counts[1]),
        thin_out(fit, SHOWN),
    )
