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
    """A loop linearised about the state x0 (nx,), as `linear_loop` makes it, with all its responses by kind.

    The kinds are "L", the loop gain at the cut with the sign of negative feedback; "S" = (I + L)^-1 and "T" = L (I +
    L)^-1 there; "closed", from added signals (`x_ref`, `u_load`, `y_noise`) to all signals; and "open", the same with
    the loop cut, where 'drive' replaces the cut signal. `corner_signals` have a corner at x0, and no linear response.
    """

    point: LoopPoint
    models: CutModels
    corner_signals: tuple[
        str, ...
    ] = ()  # signals with a corner or a jump at this state, and so without a linear answer

    @property
    def x0(self) -> Array:
        """The states (nx,) about which the loop is linearised."""
        return self.point.x

    @property
    def p0(self) -> Array:
        """The parameters (np,) with which the loop is linearised."""
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
        """The signals whose responses are known."""
        return self.models.closed_model.outputs

    @property
    def channels(self) -> tuple[str, ...]:
        """The signals at which the loop is cut."""
        return tuple(self.point.equations.drive[i] for i in self.models.channels)

    @check_arguments
    def system(self, of: str = "L", inputs: Names = None, outputs: Names = None) -> control.StateSpace:
        """The system of kind `of`, from `inputs` to `outputs` (all by default), as a `StateSpace` of python-control.

        Raises
        ------
        ValueError
            If there is no such kind, or the loop has a delay, which no `StateSpace` has.
        LookupError
            If a name is not an input or output of this kind.
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
        """Sentences on poles near the limit of stability, modes hidden from the cut, and signals with a corner."""
        late = bool(self.models.delays.any())
        L = None if late or self.models.open_model is None else self.L
        return loop_remarks(
            self.models.closed_model, () if late else self.poles, L, self.point.at_rest, self.corner_signals
        )

    @check_arguments
    def response(
        self, frequencies: Array, of: str = "L", inputs: Names = None, outputs: Names = None
    ) -> FrequencyResponse:
        """The frequency response of kind `of` at `frequencies` (m,) in rad/s, which must rise and not be negative.

        Raises
        ------
        ValueError
            If a frequency is missing, not finite, negative, falling or above Nyquist's; or if there is no such kind.
        LookupError
            If a name is not an input or output of this kind.
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
        """The gang of six at `frequencies` (m,) in rad/s: the responses named "TF", "CSF", "PS", "T", "CS" and "S".

        TF and CSF go from the references to the outputs and inputs of the plant, PS and T from loads to the same
        signals, and CS and S from the noise of the readings to inputs and readings. Without a reference there is no TF
        and CSF.

        Raises
        ------
        ValueError
            As `response`; or if the loop was made from equations alone, which do not say what a load is.

        References
        ----------
        Åström and Murray (2021), Feedback Systems, 2nd edition, section 12.1.
        """
        omega = checked_frequencies("LinearLoop.gang_of_six(frequencies=...)", frequencies, self.period)
        return gang(self.point.equations, self.models, omega)

    @check_arguments
    def margins(self) -> dict[str, StabilityMargins]:
        """The margins at each signal at which the loop is cut, while the loop is closed at the others.

        With several channels, read `disk_margin` too: it is for changes of all channels at once.

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
        """The bandwidth of kind `of`, from one input to one output: its gain first falls 3 dB below that at zero.

        With of="S" it is the frequency at which |S| first rises above -3 dB. At a cut with several channels, name one
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
        """The numbers of the step response from one input to one output, see `wb.step_info`.

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
        """The H-infinity norm of kind `of`, enclosed from both sides, see `wb.hinf_norm`."""
        return hinf_norm(self.system(of, inputs, outputs))

    @check_arguments
    def h2_norm(self, of: str = "closed", inputs: Names = None, outputs: Names = None) -> MeanGain:
        """The H2 norm of kind `of`, see `wb.h2_norm`; with several periods, the mean over the common period."""
        norm, share = h2_norm(self.system(of, inputs, outputs)), math.sqrt(self.models.closed_model.count)
        if share == 1 or math.isinf(norm.gain.value):
            return norm
        return MeanGain(enclosure(norm.gain.low / share, norm.gain.high / share, steps=2), norm.reason)

    @check_arguments
    def rows(self, values: Values) -> LinearRows:
        """The loop linearised for each of N rows of parameters or states, given by name: `{"plant.m": masses}`.

        Numbers that are not named keep their values here. If this loop is at rest, the rest state of each row is sought
        from `x0`. A row without an answer is flagged, with the reason; the other rows are not affected.

        Raises
        ------
        LookupError
            If a name is neither a parameter nor a state.
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
            If there is no such kind, an option does not fit, or the loop has no such picture (no poles with a delay).
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
