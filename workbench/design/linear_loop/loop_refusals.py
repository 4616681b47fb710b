"""Refusals of answers that a linear loop does not have: of a delay as states, and of signals with a corner."""

from __future__ import annotations

from collections.abc import Sequence

from workbench.design.linear_loop.frequency_answers import CutModels
from workbench.design.matrices import DesignError


def refuse_delay(call: str, models: CutModels) -> None:
    """Refuse what needs finitely many states of a loop with a delay."""
    if models.delays.any():
        raise DesignError(
            f"`{call}` needs a finite number of states, and a delay has infinitely many. Use `response` or `margins`, "
            "which are exact, or replace the delay by a `PadeDelay` of `EquippedPlant`."
        )


def refuse_corner_signals(call: str, corner_signals: Sequence[str], outputs: Sequence[str] | None) -> None:
    """Refuse outputs that have a corner or a jump at the state of the loop."""
    for name in outputs or ():
        if name in corner_signals:
            raise DesignError(
                f"`{call}(outputs=...)`: '{name}' has a corner or a jump at this state, so it has no linear answer. "
                "Take another output, another state, or a `side`."
            )


def refuse_late_channels(models: CutModels) -> None:
    """Refuse the stability of a loop with several channels and a delay."""
    if len(models.delays) > 1:
        raise ValueError(
            "`LinearLoop.stable` cannot be decided for a loop with several channels and a delay. Cut the loop only "
            "where the delay acts, or replace the delay by a `PadeDelay` of `EquippedPlant`."
        )
