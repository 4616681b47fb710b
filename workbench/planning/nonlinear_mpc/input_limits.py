"""Limits of the change of inputs by name, and the delay of inputs in whole periods."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.core.validation.refusals import Array, finite, known_name
from workbench.planning.linear_mpc.limit_rows import NO_LIMIT, Pair, bounds

CALL = "nonlinear_predictive_design"
WHOLE = 1e-9  # of a period: a delay this near to whole periods is whole


def rate_ends(limits: Mapping[str, Pair], inputs: tuple[str, ...]) -> tuple[Array, Array] | None:
    """The ends (nu,) of the change of each input in a period, of size 1e30 where there is none; None without limits."""
    if not limits:
        return None
    low, high = np.full(len(inputs), -NO_LIMIT), np.full(len(inputs), NO_LIMIT)
    for name, value in limits.items():
        known_name(name, inputs, "inputs of the plant")
        ends = bounds(f"{CALL}(rate_limits={{{name!r}: ...}})", value, (name,))
        a, b = (float(np.clip(end[0], -NO_LIMIT, NO_LIMIT)) for end in ends)
        if not a <= 0.0 <= b:
            raise ValueError(
                f"`{CALL}(rate_limits=...)` must leave the plant at rest, so that zero lies within; '{name}' has {a:g} "
                f"and {b:g}."
            )
        low[inputs.index(name)], high[inputs.index(name)] = a, b
    return low, high


def whole_periods(delay: float, period: float, horizon: int) -> int:
    """The number of periods in a delay [s], below the horizon; another delay is refused."""
    call = f"{CALL}(delay=...)"
    periods = finite(call, delay, " of seconds", low=0.0) / period
    count = round(min(periods, 1e6))
    if abs(periods - count) > WHOLE * max(1.0, periods):
        raise ValueError(
            f"`{call}` must be a whole number of periods of {period:g} s, as the law predicts stages of a period; got "
            f"{delay:g} s. Take the next whole one, or `predictive_design`."
        )
    if count >= horizon:
        raise ValueError(
            f"`{call}` must be below the horizon, as no input of a plan would act otherwise; got {count} periods and "
            f"{horizon} stages."
        )
    return count
