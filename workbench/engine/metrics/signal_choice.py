"""The signals of an equation that a metric is of: named one by one, or all that a loop follows or drives.

A metric asks by a name or by a `SignalChoice`; `choose` answers with the `SignalColumn` of one equation, and `column`
takes the column's expression from the outputs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import casadi as ca

from workbench.core import Ode
from workbench.core.validation.refusals import describe, known_name, nearest
from workbench.core.validation.signatures import check_arguments

BOOK = "e"  # the error of an equation that was made by hand and declares nothing


@dataclass(frozen=True)
@check_arguments
class SignalChoice:
    """A signal that is looked up in an equation: by its name, or all that follow a reference or drive the plant.

    "error" means the errors of the outputs that follow a reference, "level" these outputs with their references, and
    "input" the signals that act on the plant where it is driven.

    Examples
    --------
    >>> wb.metrics.SignalChoice("error", "omega").of
    'error'
    """

    of: Literal["error", "level", "input"]
    signal: str | None = None


@dataclass(frozen=True)
@check_arguments
class SignalColumn:
    """Outputs one below the other, less their `references`, with unit and label of each number.

    A description calls the column by its `words`, and ends with the `remark`.
    """

    outputs: tuple[str, ...]
    references: tuple[str, ...]
    units: tuple[str, ...]
    labels: tuple[str, ...]
    words: str
    remark: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """The outputs and their references."""
        return self.outputs + self.references


Signal = str | SignalChoice | SignalColumn


def names_of(signal: Signal) -> tuple[str, ...]:
    """The outputs of a signal, as far as they are known before an equation is."""
    if isinstance(signal, SignalColumn):
        return signal.names
    name = signal.signal if isinstance(signal, SignalChoice) else signal
    return () if name is None else (name,)


def column(signal: Signal, y: Mapping[str, ca.SX]) -> ca.SX:
    """The column of a signal, (k, 1), from the outputs y by name."""
    actual, wanted = levels(signal, y)
    return actual - wanted if wanted.numel() else actual


def levels(signal: Signal, y: Mapping[str, ca.SX]) -> tuple[ca.SX, ca.SX]:
    """A signal and its reference, each (k, 1), from the outputs y by name."""
    outputs, wanted = names_of(signal), tuple[str, ...]()
    if isinstance(signal, SignalColumn):
        outputs, wanted = signal.outputs, signal.references
    parts = {name: y[known_name(name, y, "outputs")] for name in outputs + wanted}
    return ca.vertcat(*(parts[name] for name in outputs)), ca.vertcat(*(parts[name] for name in wanted))


def choose(metric: str, signal: Signal, ode: Ode) -> SignalColumn:
    """The column of numbers of an equation that a metric of this name is of.

    Raises
    ------
    LookupError
        If the equation does not have the signal, or no signal is named and it follows or drives nothing.
    """
    if isinstance(signal, SignalColumn):
        return signal
    among = _Outputs(metric, ode)
    if isinstance(signal, str):
        return among.plain((signal,))
    match signal.of:
        case "error":
            return among.error(signal.signal)
        case "level":
            return among.level(signal.signal)
        case "input":
            return among.input(signal.signal)


def refuse_unknown(metric: str, signal: str, ode: Ode) -> None:
    """Refuse an output that an equation does not have."""
    if signal not in ode.outputs:
        known = nearest(signal, ode.outputs.names) or f" It has: {', '.join(ode.outputs.names) or 'none'}."
        raise LookupError(
            f"The metric {describe(metric)} needs the output {describe(signal)}, which '{ode.name}' does not "
            f"have.{known}"
        )


@dataclass(frozen=True)
class _Outputs:
    """The outputs of an equation, among which a metric finds its signal."""

    metric: str
    ode: Ode

    def error(self, name: str | None) -> SignalColumn:
        """The error of a signal, or of all that follow a reference, by the outputs that are these errors, if any."""
        if name is not None and f"{name}_ref" not in self.ode.outputs:
            of_itself = name == BOOK or name in self.ode.differences
            return self.plain((name,), remark="" if of_itself else f", which is from 0, as {name} follows nothing")
        names = self._followed_outputs if name is None else (name,)
        if not names and BOOK in self.ode.outputs:
            return self.plain((BOOK,))
        outputs = tuple(map(self._difference, self._some(names, "follows")))
        return self.plain(outputs, names) if all(outputs) else self.less(names)

    def level(self, name: str | None) -> SignalColumn:
        """A signal with its reference, or all signals that have one."""
        return self.less(self._some(self._followed_outputs, "follows") if name is None else (name,))

    def input(self, name: str | None) -> SignalColumn:
        """A signal, or all inputs as they act on the plant."""
        if name is not None:
            return self.plain((name,))
        outputs, applied = self.ode.outputs, "_applied"
        names = self.ode.drives or tuple(n.removesuffix(applied) for n in outputs.names if n.endswith(applied))
        acting = (f"{n}{applied}" if f"{n}{applied}" in outputs else n for n in self._some(names, "drives"))
        return self.plain(tuple(acting), names)

    def plain(self, outputs: tuple[str, ...], with_labels: tuple[str, ...] = (), remark: str = "") -> SignalColumn:
        """Outputs as they are, whose labels may be those of other outputs."""
        units = self._units(outputs)
        return SignalColumn(
            outputs, (), units, self._labels(outputs, with_labels or outputs), _list_words(outputs), remark
        )

    def less(self, names: tuple[str, ...]) -> SignalColumn:
        """Outputs less their references."""
        wanted = tuple(f"{name}_ref" for name in names)
        self._units(wanted)
        words = _list_words([f"{name} - {name}_ref" for name in names])
        return SignalColumn(names, wanted, self._units(names), self._labels(names, names), words)

    @property
    def _followed_outputs(self) -> tuple[str, ...]:
        outputs = self.ode.outputs
        return self.ode.follows or tuple(name for name in outputs.names if f"{name}_ref" in outputs)

    def _difference(self, name: str) -> str:
        """The output that is the difference of a signal and its reference; empty if the equation declares none."""
        pairs = self.ode.differences.items()
        return next((error for error, pair in pairs if pair == (name, f"{name}_ref") and error in self.ode.outputs), "")

    def _some(self, names: tuple[str, ...], does: str) -> tuple[str, ...]:
        if not names:
            raise LookupError(
                f"The metric {describe(self.metric)} without a signal is of what a loop {does}, and "
                f"'{self.ode.name}' {does} nothing: name a signal. It has: "
                f"{', '.join(self.ode.outputs.names) or 'none'}."
            )
        return names

    def _units(self, names: tuple[str, ...]) -> tuple[str, ...]:
        for name in names:
            refuse_unknown(self.metric, name, self.ode)
        return tuple(unit for name in names for unit in self.ode.outputs[name].units)

    def _labels(self, outputs: tuple[str, ...], with_labels: tuple[str, ...]) -> tuple[str, ...]:
        """The names of signals, with their numbers where they have several, and with what the plant counts by them."""
        labels: list[str] = []
        for output, name in zip(outputs, with_labels, strict=True):
            size, counts = self.ode.outputs[output].size, self.ode.counts
            several = [f"{counts} {i + 1}" if counts else f"{name}[{i}]" for i in range(size)]
            labels += [name] if size == 1 else several
        return tuple(labels)


def _list_words(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"({', '.join(words)})"
