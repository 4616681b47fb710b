"""PidSpecification: limits of the peaks of S and T that a reader of a page turns, and that gains of a PID follow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.signatures import check_arguments
from workbench.study.design_knob import DesignKnob
from workbench.study.knob import Knob

USUAL = 1.4  # the Ms at which a reader begins, if it is in the range


@dataclass(frozen=True)
@check_arguments
class PidSpecification:
    """Limits |S| <= Ms and |T| <= Mt that a reader of the page turns, and that the gains of a PID follow.

    For each turn, the page computes the PI with the largest Ki that meets both limits, or the PID with the largest Ki,
    and turns the knobs of Kp, Ki and Kd there. Everything else in the loop stays as the reader has turned it.

    Attributes
    ----------
    law
        The path of the PID in the loop. One of several components is `controller[0]`.
    channel
        The input of the plant at which the loop is cut; '' for the only one.
    Ms, Mt
        The range of each limit. Without the range of Mt, T has no limit.

    Raises
    ------
    ValueError
        If there is no name or no law, or a range does not begin above 1 and rise.

    Examples
    --------
    >>> wb.PidSpecification("robustness", Ms=(1.2, 2.0)).paths
    ('controller.Kp', 'controller.Ki', 'controller.Kd')
    """

    name: str
    law: str = "controller"
    channel: str = ""
    Ms: tuple[float, float] = (1.2, 2.5)
    Mt: tuple[float, float] | None = (1.05, 2.5)

    def __post_init__(self) -> None:
        for part in ("name", "law"):
            if not getattr(self, part).strip():
                raise ValueError(f"`PidSpecification({part}=...)` must not be empty.")
        for part, ends in (("Ms", self.Ms), ("Mt", self.Mt)):
            if ends is not None and not 1 < ends[0] < ends[1] < np.inf:
                raise ValueError(
                    f"`PidSpecification({self.name!r}, {part}=...)` must be a range, 1 < low < high; got {ends[0]:g} "
                    f"and {ends[1]:g}."
                )

    @property
    def paths(self) -> tuple[str, str, str]:
        """The paths of Kp, Ki and Kd."""
        law, bracket, component = self.law.partition("[")
        Kp, Ki, Kd = (f"{law}.{gain}{bracket}{component}" for gain in ("Kp", "Ki", "Kd"))
        return Kp, Ki, Kd

    @check_arguments
    def places(self, knobs: Sequence[Knob | DesignKnob]) -> tuple[int, ...]:
        """The places of the knobs of Kp, Ki and, if it is one, Kd among all knobs.

        Raises
        ------
        ValueError
            If Kp or Ki is no knob.
        """
        own = [next((i for i, knob in enumerate(knobs) if path in knob.paths), None) for path in self.paths]
        for path, place in zip(self.paths[:2], own[:2], strict=True):
            if place is None:
                raise ValueError(
                    f"`PidSpecification({self.name!r}, ...)` turns '{path}', which is no knob of this page: write "
                    f'`Knob("{path.rpartition(".")[2]}", "{path}", low, high)` beside it.'
                )
        found = tuple(place for place in own if place is not None)
        for place in found:
            if not isinstance(knobs[place], Knob) or knobs[place].share or len(knobs[place].paths) > 1:
                raise ValueError(
                    f"`PidSpecification({self.name!r}, ...)` computes one gain, and the knob '{knobs[place].name}' "
                    "turns a share, or several numbers: give the gain a knob of its own."
                )
        return found

    @property
    def data(self) -> dict[str, object]:
        """The ranges, with the numbers at which a reader begins."""
        limits: dict[str, object] = {"Mt": None}
        for name, ends in (("Ms", self.Ms), ("Mt", self.Mt)):
            if ends is not None:
                value = min(max(USUAL, ends[0]), ends[1]) if name == "Ms" else ends[1]
                limits[name] = {"name": name, "low": ends[0], "high": ends[1], "value": value}
        return {"name": self.name, **limits}


Control = Knob | DesignKnob | PidSpecification


def knobs_among(controls: Sequence[Control] | None) -> tuple[Knob | DesignKnob, ...]:
    """The knobs of a page among all that a reader turns."""
    return tuple(one for one in controls or () if isinstance(one, Knob | DesignKnob))


def specifications_among(controls: Sequence[Control] | None) -> tuple[PidSpecification, ...]:
    """The specifications of a page among all that a reader turns."""
    return tuple(one for one in controls or () if isinstance(one, PidSpecification))
