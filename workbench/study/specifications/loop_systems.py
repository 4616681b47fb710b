"""The systems of a loop whose figures are limited: its margins, S and T at the cut, an answer, and that of noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.core import Layout
from workbench.core.validation.refusals import refusal
from workbench.design.control_system import System
from workbench.design.frequency import StabilityMargins, stability_margins
from workbench.design.frequency.pole_figures import PoleFigures, closed_pole_figures, pole_figures
from workbench.design.linear import DiskMargin, disk_margin
from workbench.design.linear.feedback_loops import complementary_sensitivity as complementary
from workbench.design.linear.feedback_loops import one_loop, sensitivity
from workbench.design.linear.system_answers import lti
from workbench.design.linear_loop import LinearLoop
from workbench.design.linear_loop.loop_equations import flow_of, labels_of

LOOP = (
    "a `LinearLoop`, as `linear_loop` makes it, or the loop gain L of negative feedback as a system of python-control"
)


@dataclass(frozen=True, eq=False)
class LoopSystems:
    """A loop, a `LinearLoop` or a loop gain L of python-control, and the answer of which time and bandwidth are told.

    `answer` is the name of an input and of an output of the closed loop; without it the answer is T at the cut.
    """

    loop: LinearLoop | System
    answer: tuple[str, str] | None

    @staticmethod
    def of(call: str, loop: LinearLoop | System, inputs: str | None, outputs: str | None) -> LoopSystems:
        """The systems of a loop; without names the answer is that of the one number which follows a reference.

        Raises
        ------
        ValueError
            If it is neither, or a name is given without the other.
        LookupError
            If a name is none of an input or an output of the closed loop.
        """
        if isinstance(loop, LinearLoop):
            if (inputs is None) != (outputs is None):
                raise ValueError(f"`{call}` needs the names of an input and of an output, or neither; got one of them.")
            if inputs is not None and outputs is not None:
                loop.models.select_model(call, "closed", (inputs,), (outputs,))
                return LoopSystems(loop, (inputs, outputs))
            return LoopSystems(loop, _followed(loop))
        try:
            lti(call, loop)
        except ValueError:
            raise refusal(f"{call}", LOOP, loop) from None
        if loop.dt and loop.ninputs > 1:
            raise ValueError(
                f"`{call}` takes a sampled loop gain with one channel; got one with {loop.ninputs}. Give the "
                "`LinearLoop` of a `DigitalLoop`, or a loop gain in continuous time."
            )
        if inputs is not None or outputs is not None:
            raise ValueError(
                f"`{call}` takes names of signals of a `LinearLoop`; a system of python-control has T alone."
            )
        return LoopSystems(loop, None)

    @property
    def channels(self) -> int:
        """The number of channels of the cut."""
        return len(self.loop.channels) if isinstance(self.loop, LinearLoop) else int(self.loop.ninputs)

    @property
    def answer_words(self) -> str:
        """The answer whose bandwidth and step are told, in words."""
        return f"from {self.answer[0]} to {self.answer[1]}" if self.answer else "of T at the cut"

    @property
    def stable(self) -> bool:
        """True if the closed loop is stable."""
        if isinstance(self.loop, LinearLoop):
            return self.loop.stable
        return all(one.stable for one in self.margins)

    @property
    def unstable_words(self) -> str:
        """The reason why the loop is not stable."""
        if isinstance(self.loop, LinearLoop) and not self.loop.models.delays.any():
            found = [one for one in self.loop.remarks if "not stable" in one or "to within rounding" in one]
            return found[0] if found else "The closed loop is not stable."
        return "The closed loop is not stable."

    @cached_property
    def margins(self) -> tuple[StabilityMargins, ...]:
        """The margins of each channel, while the loop is closed at the others."""
        if isinstance(self.loop, LinearLoop):
            return tuple(self.loop.margins().values())
        if self.channels == 1:
            return (stability_margins(self.loop),)
        return tuple(stability_margins(one_loop(self.loop, i)) for i in range(self.channels))

    @property
    def disk_margin(self) -> DiskMargin:
        """The disk margin of all channels at once."""
        return self.loop.disk_margin if isinstance(self.loop, LinearLoop) else disk_margin(self.loop)

    @cached_property
    def poles(self) -> PoleFigures:
        """The decay and the damping of the closed loop."""
        if isinstance(self.loop, LinearLoop):
            closed = self.loop.system("closed")
            return pole_figures(np.asarray(closed.A, dtype=float), float(closed.dt) or None)
        if self.channels == 1:
            return closed_pole_figures(self.loop)
        S = sensitivity(self.loop)
        return pole_figures(np.asarray(S.A, dtype=float), float(S.dt) or None)

    def system(self, kind: str) -> System:
        """S or T at the cut."""
        if isinstance(self.loop, LinearLoop):
            return self.loop.system(kind)
        return sensitivity(self.loop) if kind == "S" else complementary(self.loop)

    @cached_property
    def scalar_answer(self) -> System:
        """The system of one channel whose bandwidth and step are told."""
        if self.answer is not None:
            return self.loop.system("closed", *self.answer)
        if self.channels > 1:
            raise ValueError(
                "a loop with several channels has an answer for each pair of signals: name two, as "
                "`check(linear, inputs='x_ref', outputs='x')`"
            )
        return self.system("T")

    @property
    def noise(self) -> System:
        """The system from the noise of the readings to the inputs of the plant."""
        if not isinstance(self.loop, LinearLoop):
            raise ValueError("a loop gain alone does not tell what noise does; give a `linear_loop`")
        inputs, outputs = noise_signals(self.loop)
        if not inputs or not outputs:
            raise ValueError("this loop has no reading to which noise is added, or no input that it moves")
        return self.loop.system("closed", inputs, outputs)


def noise_signals(linear: LinearLoop) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The noises of the readings, and the inputs of the plant, by the names of their numbers."""
    flow = flow_of(linear.point.equations.closed_loop)
    drives = labels_of(Layout(tuple(flow.outputs[name] for name in flow.drives)))
    noises = tuple(name for name in linear.inputs if name.partition("[")[0].endswith("_noise"))
    return noises, tuple(name for name in drives if name in linear.outputs)


def _followed(linear: LinearLoop) -> tuple[str, str] | None:
    """The one reference of a loop and the signal that follows it; None where there is none, or where there are more."""
    stems = {name: name.replace("_ref", "", 1) for name in linear.inputs if "_ref" in name}
    pairs = [(name, stem) for name, stem in stems.items() if stem in linear.outputs]
    return pairs[0] if len(pairs) == 1 else None
