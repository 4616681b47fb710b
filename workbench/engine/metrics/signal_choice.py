"""The column of numbers that a metric looks at: outputs of an equation, each with its unit and its label."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import casadi as ca

from workbench.core import Ode
from workbench.core.validation.refusals import described, nearest
from workbench.core.validation.signatures import door

ERROR = re.compile(r"ed?(_hat)?|e_.+|.+_error")  # what loops call errors, which are from 0 anyway
FACTOR = re.compile(r"([^\W\d_]+|%|1)(?:\^(-?\d+))?")
POWER_UNITS = ({"N": 1, "m": 1, "s": -1}, {"V": 1, "A": 1}, {"W": 1}, {"N": 1, "m": 1, "rad": 1, "s": -1})


@dataclass(frozen=True)
@door
class Choice:
    """A signal to be resolved in an equation: by its name, or all signals that follow a reference or drive the plant.

    An "error" is that of the outputs that follow a reference, a "level" such outputs with their references, an "input"
    the signals that act on the plant where it is driven.

    Examples
    --------
    >>> wb.metrics.Choice("error", "omega").of
    'error'
    """

    of: Literal["error", "level", "input"]
    signal: str | None = None


@dataclass(frozen=True)
@door
class Watched:
    """Outputs one below the other, less their references `wanted`, with unit and label of each number.

    A description calls the column by its `words`, and ends with the `remark`.
    """

    outputs: tuple[str, ...]
    wanted: tuple[str, ...]
    units: tuple[str, ...]
    labels: tuple[str, ...]
    words: str
    remark: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """The outputs and their references."""
        return self.outputs + self.wanted


Signal = str | Choice | Watched


def names_of(signal: Signal) -> tuple[str, ...]:
    """The outputs of a signal, as far as they are known before an equation is."""
    if isinstance(signal, Watched):
        return signal.names
    named = signal.signal if isinstance(signal, Choice) else signal
    return () if named is None else (named,)


def column(signal: Signal, y: Mapping[str, ca.SX]) -> ca.SX:
    """The column of a signal, (k, 1), from the outputs y by name."""
    actual, wanted = levels(signal, y)
    return actual - wanted if wanted.numel() else actual


def levels(signal: Signal, y: Mapping[str, ca.SX]) -> tuple[ca.SX, ca.SX]:
    """A signal and its reference, each (k, 1), from the outputs y by name."""
    outputs, wanted = (signal.outputs, signal.wanted) if isinstance(signal, Watched) else (names_of(signal), ())
    return ca.vertcat(*(y[name] for name in outputs)), ca.vertcat(*(y[name] for name in wanted))


def watched(metric: str, signal: Signal, ode: Ode) -> Watched:
    """A signal of an equation."""
    if isinstance(signal, Watched):
        return signal
    if isinstance(signal, str):
        return _plain(metric, ode, (signal,))
    match signal.of:
        case "error":
            return _error(metric, signal.signal, ode)
        case "level":
            names = followed(ode) if signal.signal is None else (signal.signal,)
            if not names:
                raise _nothing(metric, ode, "follows")
            return _less(metric, ode, names)
    if signal.signal is not None:
        return _plain(metric, ode, (signal.signal,))
    inputs = ode.drives or tuple(n.removesuffix("_applied") for n in ode.outputs.names if n.endswith("_applied"))
    if not inputs:
        raise _nothing(metric, ode, "drives")
    outputs = tuple(f"{name}_applied" if f"{name}_applied" in ode.outputs else name for name in inputs)
    return _plain(metric, ode, outputs, inputs)


def followed(ode: Ode) -> tuple[str, ...]:
    """The outputs of an equation that follow a reference."""
    return ode.follows or tuple(name for name in ode.outputs.names if f"{name}_ref" in ode.outputs)


def _error(metric: str, name: str | None, ode: Ode) -> Watched:
    """The error of a signal, or of all that follow a reference, by the outputs that show it if there are any."""
    if name is not None and f"{name}_ref" not in ode.outputs:
        remark = "" if ERROR.fullmatch(name) else f", which is from 0, as {name} follows nothing"
        return _plain(metric, ode, (name,), remark=remark)
    names = followed(ode) if name is None else (name,)
    if not names and "e" in ode.outputs:  # an equation made by hand, whose error is called as in the book
        return _plain(metric, ode, ("e",))
    if not names:
        raise _nothing(metric, ode, "follows")
    y = ode.outputs.view(ode.output)
    shown = tuple(next((e for e in (f"e_{x}", "e") if _is_error(y, e, x)), "") for x in names)
    return _plain(metric, ode, shown, names) if all(shown) else _less(metric, ode, names)


def _is_error(y: Mapping[str, ca.SX], error: str, name: str) -> bool:
    if error not in y or y[error].shape != y[name].shape:
        return False
    pairs = zip(ca.vertsplit(y[error]), ca.vertsplit(y[name] - y[f"{name}_ref"]), strict=True)
    return all(ca.is_equal(one, other, 2) for one, other in pairs)


def _plain(metric: str, ode: Ode, outputs: tuple[str, ...], called: tuple[str, ...] = (), remark: str = "") -> Watched:
    """Outputs as they are, whose labels may be those of other outputs."""
    units = _units(metric, ode, outputs)
    return Watched(outputs, (), units, _labels(ode, outputs, called or outputs), _words(outputs), remark)


def _less(metric: str, ode: Ode, names: tuple[str, ...]) -> Watched:
    wanted = tuple(f"{name}_ref" for name in names)
    _units(metric, ode, wanted)
    units = _units(metric, ode, names)
    return Watched(names, wanted, units, _labels(ode, names, names), _words([f"{x} - {x}_ref" for x in names]))


def _words(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"({', '.join(names)})"


def _units(metric: str, ode: Ode, names: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        refuse_unknown(metric, name, ode)
    return tuple(unit for name in names for unit in ode.outputs[name].units)


def _labels(ode: Ode, outputs: tuple[str, ...], called: tuple[str, ...]) -> tuple[str, ...]:
    """The names of signals, with their numbers where they have several, and with what the plant counts by them."""
    labels: list[str] = []
    for output, name in zip(outputs, called, strict=True):
        size = ode.outputs[output].size
        if ode.counts and size > 1:
            labels += [f"{ode.counts} {i + 1}" for i in range(size)]
        else:
            labels += [name] if size == 1 else [f"{name}[{i}]" for i in range(size)]
    return tuple(labels)


def refuse_unknown(metric: str, signal: str, ode: Ode) -> None:
    """Refuse an output that an equation does not have."""
    if signal not in ode.outputs:
        known = nearest(signal, ode.outputs.names) or f" It has: {', '.join(ode.outputs.names) or 'none'}."
        raise LookupError(
            f"The metric {described(metric)} needs the output {described(signal)}, which '{ode.name}' does not "
            f"have.{known}"
        )


def _nothing(metric: str, ode: Ode, does: str) -> LookupError:
    return LookupError(
        f"The metric {described(metric)} without a signal is of what a loop {does}, and '{ode.name}' {does} nothing: "
        f"name a signal. It has: {', '.join(ode.outputs.names) or 'none'}."
    )


def product(*units: tuple[str, int]) -> str:
    """The product of units, each with its power: ("rad", 2), ("s", 1) is "rad^2 s", and ("N m", 1), ("s", -1) "N m/s".

    A unit that is no product of words, such as "V/sqrt(Hz)", stands in brackets; an unknown unit stays unknown.
    """
    if any(unit == "?" for unit, _ in units):
        return "?"
    powers: Counter[str] = Counter()
    for unit, power in units:
        words = _factors(unit)
        for word, n in ({f"({unit})": 1} if words is None else words).items():
            powers[word] += n * power
    above = [_power(word, n) for word, n in powers.items() if n > 0]
    below = [_power(word, -n) for word, n in powers.items() if n < 0]
    if not below:
        return " ".join(above)
    divisor = below[0] if len(below) == 1 else f"({' '.join(below)})"
    return f"{' '.join(above) or '1'}/{divisor}"


def work(effort: str, flow: str) -> str:
    """The unit of effort times flow times seconds: J where that is an energy."""
    power = product((effort, 1), (flow, 1))
    return "J" if _factors(power) in POWER_UNITS else product((power, 1), ("s", 1))


def _power(word: str, n: int) -> str:
    return word if n == 1 else f"{word}^{n}"


def _factors(unit: str) -> dict[str, int] | None:
    """The words of a unit with their powers; None if the unit is no product of words."""
    over, _, under = unit.partition("/")
    powers: Counter[str] = Counter()
    for part, sign in ((over, 1), (under.removeprefix("(").removesuffix(")"), -1)):
        for word in part.split():
            if (read := FACTOR.fullmatch(word)) is None:
                return None
            powers[read[1]] += sign * int(read[2] or 1)
    return {word: n for word, n in powers.items() if word != "1" and n}
