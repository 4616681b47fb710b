"""The linear answers of a loop at a point: L, S and T at a cut, and from any signal to any other by name."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from workbench.core import Layout
from workbench.core.validation.number_types import Values
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.core.views import NotebookPicture, picture_of
from workbench.design.frequency import Bandwidth, CertifiedPeak, MeanGain, StabilityMargins, h2_norm, hinf_norm
from workbench.design.frequency.certified_values import enclosure
from workbench.design.frequency.frequency_axis import checked_frequencies
from workbench.design.linear import DiskMargin, Pole, poles
from workbench.design.linear_loop.cut_margins import channel_margins, common_margin, kind_bandwidth
from workbench.design.linear_loop.frequency_answers import CutModels, FrequencyResponse, refuse_pole, response_of
from workbench.design.linear_loop.gang_of_six import gang
from workbench.design.linear_loop.loop_point import LoopPoint
from workbench.design.linear_loop.loop_refusals import refuse_corner_signals, refuse_delay, refuse_late_channels
from workbench.design.linear_loop.loop_remarks import decay_of, doubt_of, loop_remarks
from workbench.design.linear_loop.loop_rows import LinearRows, linear_rows
from workbench.design.step_response import StepInfo, step_info

if TYPE_CHECKING:
    import control


Names = str | tuple[str, ...] | None  # of inputs or outputs; all of them if None


@dataclass(frozen=True, eq=False)
class LinearLoop:
    """A loop that is linear about the state x0 (nx,), as `linear_loop` makes it, in all the kinds that it can answer.

    The kinds are "L", the loop gain at the cut with the sign of negative feedback; "S" = (I + L)^-1 and "T" = L (I +
    L)^-1 there; "closed", from signals that are added (`x_ref`, `u_load`, `y_noise`) to all signals; and "open", the
    same with the loop cut, where 'drive' acts in the place of what is cut.
    """

    point: LoopPoint
    models: CutModels
    corner_signals: tuple[
        str, ...
    ] = ()  # signals with a corner or a jump at this state, and so without a linear answer

    @property
    def x0(self) -> Array:
        """The states (nx,) about which it is linear."""
        return self.point.x

    @property
    def p0(self) -> Array:
        """The parameters (np,) of it."""
        return self.point.p

    @property
    def period(self) -> float | None:
        """The period of the computer in s; None in continuous time."""
        return self.models.closed_model.period

    @property
    def states(self) -> Layout:
        """The states that move, in the order of x0."""
        return self.point.equations.closed_loop.states

    @property
    def parameters(self) -> Layout:
        """The parameters, signals from outside and frozen states included, in the order of p0."""
        return self.point.equations.closed_loop.parameters

    @property
    def inputs(self) -> tuple[str, ...]:
        """The signals from outside that are added to those of the closed loop."""
        return self.models.closed_model.inputs

    @property
    def outputs(self) -> tuple[str, ...]:
        """The signals that answer."""
        return self.models.closed_model.outputs

    @property
    def channels(self) -> tuple[str, ...]:
        """The signals at which the loop is cut."""
        return tuple(self.point.equations.drive[i] for i in self.models.channels)

    @check_arguments
    def system(self, of: str = "L", inputs: Names = None, outputs: Names = None) -> control.StateSpace:
        """A kind of this loop as a `StateSpace` of python-control, from some of its inputs to some of its outputs.

        Raises
        ------
        ValueError
            If there is no such kind, or the loop has a delay, which no `StateSpace` has.
        LookupError
            If a name is none of an input or an output of this kind.
        """
        refuse_delay("LinearLoop.system(...)", self.models)
        refuse_corner_signals("LinearLoop.system", self.corner_signals, _names(outputs))
        model = self.models.select_model("LinearLoop.system", of, _names(inputs), _names(outputs))
        return model.system(f"{of} of {self.point.equations.closed_loop.name}")

    @property
    def L(self) -> control.StateSpace:
        """The loop gain at the cut, with the sign of negative feedback."""
        return self.system("L")

    @property
    def S(self) -> control.StateSpace:
        """The sensitivity (I + L)^-1 at the cut."""
        return self.system("S")

    @property
    def T(self) -> control.StateSpace:
        """The complementary sensitivity L (I + L)^-1 at the cut."""
        return self.system("T")

    @cached_property
    def poles(self) -> tuple[Pole, ...]:
        """The poles of the closed loop, the slowest first; of the map over the common period in a computer."""
        refuse_delay("LinearLoop.poles", self.models)
        return poles(self.models.closed_model.system())

    @property
    def stable(self) -> bool:
        """True if every pole of the closed loop decays, by more than rounding may have moved it."""
        if self.models.delays.any():
            refuse_late_channels(self.models)
            return all(one.stable for one in self.margins().values())
        discrete, size = self.period is not None, float(np.linalg.norm(self.models.closed_model.A[0], 2))
        return all(decay_of(pole, discrete) > doubt_of(pole.condition, size, len(self.poles)) for pole in self.poles)

    @cached_property
    def remarks(self) -> tuple[str, ...]:
        """Sentences on what is near the axis, hidden from the cut, or without an answer, by name."""
        late = bool(self.models.delays.any())
        L = None if late or self.models.open_model is None else self.L
        return loop_remarks(
            self.models.closed_model, () if late else self.poles, L, self.point.at_rest, self.corner_signals
        )

    @check_arguments
    def response(
        self, frequencies: Array, of: str = "L", inputs: Names = None, outputs: Names = None
    ) -> FrequencyResponse:
        """The answers of a kind at frequencies (m,) in rad/s that rise from zero on, in a computer up to Nyquist's.

        Raises
        ------
        ValueError
            If the frequencies are none, not finite, negative, falling or above Nyquist's; or there is no such kind.
        LookupError
            If a name is none of an input or an output of this kind.
        DesignError
            If there is a pole at one of the frequencies.
        """
        call = "LinearLoop.response"
        omega = checked_frequencies(f"{call}(frequencies=...)", frequencies, self.period)
        refuse_corner_signals(call, self.corner_signals, _names(outputs))
        found, seen, shown = self.models.response(call, of, omega, _names(inputs), _names(outputs))
        return refuse_pole(f"{call}(...)", response_of(omega, found, seen, shown))

    @check_arguments
    def gang_of_six(self, frequencies: Array) -> dict[str, FrequencyResponse]:
        """The gang of six at frequencies (m,) in rad/s: by "TF", "CSF", "PS", "T", "CS" and "S" their answers.

        From the references to the outputs of the plant (TF) and its inputs (CSF), from loads to both (PS and T), and
        from the noise of the readings to the inputs (CS) and the readings (S), with the signs of one channel. A loop
        that follows nothing has no TF and CSF.

        Raises
        ------
        ValueError
            As `response`; or if these are equations alone, which do not say what is a load.

        References
        ----------
        Åström and Murray (2021), Feedback Systems, 2nd edition, section 12.1.
        """
        omega = checked_frequencies("LinearLoop.gang_of_six(frequencies=...)", frequencies, self.period)
        return gang(self.point.equations, self.models, omega)

    @check_arguments
    def margins(self) -> dict[str, StabilityMargins]:
        """The margins at each signal at which the loop is cut, while the loop is closed at the others.

        With several channels they are to be read beside `disk_margin`, which changes all at once.

        Raises
        ------
        ValueError
            If a delay acts at another channel, or the blocks of a computer run at several periods.
        DesignError
            As `stability_margins`.
        """
        return channel_margins("LinearLoop.margins()", self.models, self.channels)

    @property
    def disk_margin(self) -> DiskMargin:
        """The disk margin of all channels of the cut at once; refused if the closed loop is not stable."""
        refuse_delay("LinearLoop.disk_margin", self.models)
        return common_margin("LinearLoop.disk_margin", self.models)

    @check_arguments
    def bandwidth(self, of: str = "T", inputs: Names = None, outputs: Names = None) -> Bandwidth:
        """The bandwidth of a kind from one input to one output: where its gain first falls 3 dB below that at zero.

        With of="S" it is the frequency at which |S| first rises above -3 dB. Of a cut with several channels name one,
        as both input and output; the others are closed.

        Raises
        ------
        ValueError
            If there are several inputs or outputs, the blocks of a computer run at several periods, or as `system`.
        DesignError
            As `workbench.design.frequency.bandwidth`.
        """
        return kind_bandwidth(self._one_answer("LinearLoop.bandwidth", of, inputs, outputs), of)

    @check_arguments
    def step_info(self, inputs: Names = None, outputs: Names = None, of: str = "closed") -> StepInfo:
        """The figures of the step response from one input to one output, see `workbench.design.step_response`.

        Raises
        ------
        ValueError
            If there are several inputs or outputs, the blocks of a computer run at several periods, or as `system`.
        DesignError
            As `workbench.design.step_response.step_info`.
        """
        return step_info(self._one_answer("LinearLoop.step_info", of, inputs, outputs))

    @check_arguments
    def hinf_norm(self, of: str = "closed", inputs: Names = None, outputs: Names = None) -> CertifiedPeak:
        """The H-infinity norm of a kind, enclosed from both sides, see `workbench.design.frequency.hinf_norm`."""
        return hinf_norm(self.system(of, inputs, outputs))

    @check_arguments
    def h2_norm(self, of: str = "closed", inputs: Names = None, outputs: Names = None) -> MeanGain:
        """The H2 norm of a kind, see `workbench.design.frequency.h2_norm`; of lifted periods the mean over them."""
        norm, share = h2_norm(self.system(of, inputs, outputs)), math.sqrt(self.models.closed_model.count)
        if share == 1 or math.isinf(norm.gain.value):
            return norm
        return MeanGain(enclosure(norm.gain.low / share, norm.gain.high / share, steps=2), norm.reason)

    @check_arguments
    def rows(self, values: Values) -> LinearRows:
        """The same answers for each of N rows of parameters or states, by name: `{"plant.m": masses}`.

        What is not named stays as it is here. Each row rests at a state of its own, sought from `x0`, if this one
        rests. A row that has no answer is flagged, with its reason, and the others stand.

        Raises
        ------
        LookupError
            If a name is none of a parameter or a state.
        ValueError
            If the values have different numbers of rows, or no row has an answer.
        """
        return linear_rows(self.point, self.corner_signals, values)

    def plot(self, kind: str = "", **options: object) -> NotebookPicture:
        """A picture, by default Bode and Nyquist plots with margins, and the poles; a notebook shows it.

        Parameters
        ----------
        kind
            "bode", "nyquist", "nichols", "poles", "root_locus" (`over` as in {"plant.m": values}), "step", "impulse",
            "gang_of_six", "singular_values", "determinant", "characteristic_loci" or "relative_gains".
        options
            `frequencies` (m,) in rad/s; `of`, `inputs` and `outputs` as of `response`; `until` in s; `asymptotes`,
            `bounds`, `forbidden` and `reach` as of `wb.bode` and `wb.nyquist`.

        Raises
        ------
        ValueError
            If there is no such kind, an option does not fit, or the loop has no such picture, as poles with a delay.
        """
        return picture_of(self, kind, **options)

    def __repr__(self) -> str:
        cut = f" cut at {', '.join(self.channels)}" if self.channels else ""
        time = "in continuous time" if self.period is None else f"in a computer, every {self.period:g} s"
        name, states = self.point.equations.closed_loop.name, len(self.models.closed_model.states)
        return f"<LinearLoop '{name}'{cut}: {states} states, {time}>"

    def _one_answer(self, call: str, of: str, inputs: Names, outputs: Names) -> control.StateSpace:
        refuse_delay(call, self.models)
        refuse_corner_signals(call, self.corner_signals, _names(outputs))
        model = self.models.single(call, of, _names(inputs), _names(outputs))
        return model.system(f"{of} of {self.point.equations.closed_loop.name}")


def _names(names: Names) -> tuple[str, ...] | None:
    return (names,) if isinstance(names, str) else names
