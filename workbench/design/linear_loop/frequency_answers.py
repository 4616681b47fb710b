"""The frequency answers of a linear loop: of each kind, from signals to signals by name, with exact delays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, one_of, refusal
from workbench.design.frequency.frequency_axis import phases
from workbench.design.frequency.response_kernel import FrequencyAnswers
from workbench.design.linear_loop.feedback_answers import cells, close_inputs, sensitivity
from workbench.design.linear_loop.loop_equations import chosen_places
from workbench.design.linear_loop.loop_model import LoopModel
from workbench.design.matrices import Complex, DesignError

KINDS = ("L", "S", "T", "closed", "open")


class BodeData(NamedTuple):
    """Frequencies (m,) in rad/s, with the magnitude, the magnitude in dB, and the unwrapped phase in degrees.

    The first phase is near 90 degrees times the slope of the gain, so -90 for an integrator. From each frequency to the
    next the phase changes by the least angle. It is NaN where a response is zero or NaN.
    """

    frequencies: Array
    magnitude: Array
    decibels: Array
    phase: Array


@dataclass(frozen=True, eq=False)
@show
class FrequencyResponse:
    """The responses `values` (m, ny, nu), or (N, m, ny, nu) for N rows, at `frequencies` (m,) in rad/s.

    `inputs` and `outputs` are the names of the last two axes. A row without a response is NaN, and True in
    `flagged_rows` (N,); a single loop has no such row. `errors` bound, to first order, how far rounding may have moved
    each value, for the matrices of the loop as they are. `sensitivities` are the changes of the values over the
    relative changes of all entries of these matrices.
    """

    frequencies: Array
    values: Complex
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    flagged_rows: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
    errors: Array
    sensitivities: Array

    @property
    def conditions(self) -> Array:
        """The condition number of each value: its relative change, over the relative changes of the entries."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(self.sensitivities == 0, 0.0, self.sensitivities / np.abs(self.values)))

    def __getitem__(self, names: tuple[str, str]) -> Complex:
        """The answers (m,), or (N, m), of one output to one input, by their names: `response["omega", "v_load"]`."""
        if not (isinstance(names, tuple) and len(names) == 2):
            raise refusal("FrequencyResponse[...]", "the name of an output and the name of an input", names)
        places = []
        for given, labels, of in zip(names, (self.outputs, self.inputs), ("outputs", "inputs"), strict=True):
            found = chosen_places("FrequencyResponse[...]", labels, (given,), f"{of} of this response")
            if len(found) != 1:
                raise LookupError(
                    f"`FrequencyResponse[...]` takes one number; '{given}' has {len(found)}: say '{labels[found[0]]}'."
                )
            places += found
        return np.asarray(self.values[..., places[0], places[1]])

    def bode(self) -> BodeData:
        """Magnitude and phase of each answer, in the shape of `values`."""
        magnitude = np.abs(self.values)
        with np.errstate(divide="ignore", invalid="ignore"):
            decibels = 20 * np.log10(magnitude)
        phase = np.apply_along_axis(lambda values: phases(self.frequencies, values), -3, self.values)
        return BodeData(self.frequencies, magnitude, decibels, phase)


@dataclass(frozen=True, eq=False)
class CutModels:
    """The models of N rows of a loop that is closed, and of the same one cut at all drives, the first of its inputs.

    `channels` are the places of the drives at which it is cut; the others are closed again. What arrives at a drive
    acts there by its one of the `delays` (nd,) in s later.
    """

    closed_model: LoopModel
    open_model: LoopModel | None
    channels: tuple[int, ...]
    delays: Array

    def kind(self, call: str, of: str) -> LoopModel:
        """The model of a kind, without delays."""
        one_of(f"{call}(of=...)", of, KINDS)
        if of == "closed":
            return self.closed_model
        others = [i for i in range(len(self.delays)) if i not in self.channels]
        if of == "open":
            return self._cut_model(call, of).closed_at(others)
        L = self.open_drives(call, of).closed_at(others).part(self.channels, range(len(self.channels))).negative()
        L = replace(L, inputs=L.outputs)
        return L if of == "L" else feedback(L, of)

    def open_drives(self, call: str, of: str = "L") -> LoopModel:
        """The model from all drives to what arrives at them."""
        drives = range(len(self.delays))
        return self._cut_model(call, of).part(drives, drives)

    def response(
        self, call: str, of: str, omega: Array, inputs: Sequence[str] | None, outputs: Sequence[str] | None
    ) -> tuple[FrequencyAnswers, tuple[str, ...], tuple[str, ...]]:
        """The answers (N, m, ny, nu) of a kind, with the names of the inputs and outputs."""
        one_of(f"{call}(of=...)", of, KINDS)
        if self.delays.any():
            return self._late(call, of, omega, inputs, outputs)
        model = self.select_model(call, of, inputs, outputs)
        return model.answers(omega), model.inputs, model.outputs

    def select_model(
        self, call: str, of: str, inputs: Sequence[str] | None, outputs: Sequence[str] | None
    ) -> LoopModel:
        """The model of a kind, without delays, with some of its inputs and outputs."""
        model = self.kind(call, of)
        return model.part(*_places(call, of, model.outputs, model.inputs, outputs, inputs))

    def single(self, call: str, of: str, inputs: Sequence[str] | None, outputs: Sequence[str] | None) -> LoopModel:
        """The model of a kind from one input to one output, of a loop that is the same at each instant."""
        model = self.select_model(call, of, inputs, outputs)
        for argument, labels in (("inputs", model.inputs), ("outputs", model.outputs)):
            if len(labels) != 1:
                raise ValueError(
                    f"`{call}({argument}=...)` must name one number; of={of!r} has {len(labels)} {argument} here: take "
                    f"one of {', '.join(labels)}."
                )
        if model.count > 1:
            raise ValueError(
                f"`{call}` needs a loop that is the same at each instant; here blocks run at several periods, and the "
                "answer depends on the instant at which a signal comes. Ask for `response` or the norms, or give all "
                "blocks one period."
            )
        return model

    def _cut_model(self, call: str, of: str) -> LoopModel:
        if self.open_model is None:
            raise ValueError(
                f"`{call}(of={of!r})` needs a loop that can be cut, a `ClosedLoop` or a `DigitalLoop`; these are "
                "equations alone, which have of='closed'."
            )
        return self.open_model

    def _late(
        self, call: str, of: str, omega: Array, inputs: Sequence[str] | None, outputs: Sequence[str] | None
    ) -> tuple[FrequencyAnswers, tuple[str, ...], tuple[str, ...]]:
        """The answers of a loop with delays: what arrives is turned by exp(-j omega delay) where it acts."""
        opened, nd = self._cut_model(call, of), len(self.delays)
        turn = np.exp(-1j * np.multiply.outer(omega, self.delays))
        again = [i for i in range(nd) if of == "closed" or i not in self.channels]
        left = [i for i in range(len(opened.inputs)) if i not in again]
        answer = close_inputs(opened.answers(omega), turn, again, left)
        names, labels = tuple(opened.inputs[i] for i in left), opened.outputs
        if of not in ("closed", "open"):
            channels = list(self.channels)
            cut = cells(answer, channels, range(len(channels)))
            L = FrequencyAnswers(-turn[:, channels, np.newaxis] * cut.values, cut.errors, cut.sensitivities)
            answer = L if of == "L" else sensitivity(L, of)
            names = labels = tuple(opened.outputs[i] for i in channels)
        rows, columns = _places(call, of, labels, names, outputs, inputs)
        return (
            cells(answer, rows, columns),
            tuple(names[i] for i in columns),
            tuple(labels[i] for i in rows),
        )


def feedback(L: LoopModel, of: str) -> LoopModel:
    """S = (I + L)^-1 or T = L (I + L)^-1 of a square model L."""
    eye = np.eye(L.D.shape[-1])
    with np.errstate(all="ignore"):
        E = np.asarray(np.linalg.inv(eye + L.D), dtype=float)
    model = replace(L, A=L.A - L.B @ E @ L.Cy, B=L.B @ E)
    if of == "S":
        return replace(model, Cy=-E @ L.Cy, D=E)
    return replace(model, Cy=E @ L.Cy, D=np.asarray(eye - E))


def _places(
    call: str,
    of: str,
    output_labels: Sequence[str],
    input_labels: Sequence[str],
    outputs: Sequence[str] | None,
    inputs: Sequence[str] | None,
) -> tuple[list[int], list[int]]:
    return (
        chosen_places(f"{call}(outputs=...)", output_labels, outputs, f"outputs of of={of!r}"),
        chosen_places(f"{call}(inputs=...)", input_labels, inputs, f"inputs of of={of!r}, which come from outside"),
    )


def response_of(
    omega: Array, of: FrequencyAnswers, inputs: tuple[str, ...], outputs: tuple[str, ...]
) -> FrequencyResponse:
    """The response of a single loop."""
    unflagged = np.zeros(1, dtype=bool)
    return FrequencyResponse(omega, of.values[0], inputs, outputs, unflagged, of.errors[0], of.sensitivities[0])


def refuse_pole(call: str, response: FrequencyResponse) -> FrequencyResponse:
    """Refuse the answer of one loop at a frequency at which it has a pole."""
    bad = ~np.isfinite(response.values).all(axis=(-2, -1))
    if bad.any():
        raise DesignError(
            f"`{call}`: there is a pole at {response.frequencies[int(np.argmax(bad))]:.6g} rad/s, where there is no "
            "answer; leave that frequency out."
        )
    return response
