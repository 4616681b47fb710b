"""The data of the specifications of a live page: the loops whose gains follow them, and the channel of each."""

from __future__ import annotations

from collections.abc import Sequence

from workbench.core.validation.refusals import known_name
from workbench.report.live.page_data import Plain
from workbench.study.design_knob import DesignKnob
from workbench.study.knob import Knob
from workbench.study.pid_specification import PidSpecification


def specification_data(
    specifications: Sequence[PidSpecification], knobs: Sequence[Knob | DesignKnob], loops: Sequence[Plain]
) -> list[Plain]:
    """An entry for each specification and each loop that has its gains and a linear answer.

    A loop without a linear answer says why where its pictures would be.

    Raises
    ------
    ValueError, LookupError
        If a gain is no knob, no loop with linear pictures has them, or the channel is unknown.
    """
    found: list[Plain] = []
    for one in specifications:
        places = one.places(knobs)
        own = [i for i, loop in enumerate(loops) if set(places[:2]) <= _turned(loop)]
        if not any(loops[i]["linear"] or loops[i]["linear_refused"] for i in own):
            raise ValueError(
                f"`PidSpecification({one.name!r}, ...)` needs a loop on this page with linear pictures and with the "
                f"PID '{one.law}': add `wb.loop_gain_pictures(outcome)` of its case to a section."
            )
        found += [
            {**one.data, "loop": i, "knobs": list(places), "channel": _channel(one, loops[i])}
            for i in own
            if loops[i]["linear"]
        ]
    return found


def _turned(loop: Plain) -> set[int]:
    """The knobs that move a loop."""
    moves = loop["moves"]
    assert isinstance(moves, list)
    return {move["knob"] for move in moves}


def _channel(one: PidSpecification, loop: Plain) -> int:
    """The place of the channel of a specification in a loop."""
    linear = loop["linear"]
    assert isinstance(linear, dict)
    names: list[str] = linear["channels"]
    if not one.channel and len(names) > 1:
        raise ValueError(
            f"`PidSpecification({one.name!r}, channel=...)` must name the input of the plant at which the loop is cut; "
            f"this loop has {', '.join(map(repr, names))}."
        )
    return names.index(known_name(one.channel, names, "channels of this loop")) if one.channel else 0
