"""The value of a metric as a program: a list of operations with which another machine finds the same bits.

A program has only operations whose result IEEE 754 fixes to the last bit. It is found by calling the metric's `value`
with arrays that write down what is done with them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import EllipsisType
from typing import TYPE_CHECKING, NamedTuple, SupportsIndex, TypeAlias

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import NDArray

from workbench.core import Layout, StepMap
from workbench.core.validation.refusals import Array, error_text, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.engine.machines.numpy_spelling import SPELLING
from workbench.engine.machines.operations import OPERATIONS, Kind, Role, gives_truth, with_role
from workbench.engine.metrics.contract import AbstractMetric, value_as_written
from workbench.engine.metrics.measured_equation import accumulators_in

Places = NDArray[np.intp]
Key = SupportsIndex | slice | EllipsisType | Places | None
if TYPE_CHECKING:
    # An operation and the numbers of its operands, or "const" and a number.
    Written: TypeAlias = tuple[str, *tuple[float, ...]]
else:
    Written = tuple[object, ...]

RESHAPE_FUNCTIONS: tuple[Callable[..., Places], ...] = (np.reshape, np.ravel, np.transpose, np.broadcast_to)
JOIN_FUNCTIONS: tuple[Callable[..., Places], ...] = (np.concatenate, np.hstack, np.stack, np.column_stack)
PROGRAM = with_role(Role.PROGRAM)
OF_NUMPY = {SPELLING[name].__name__: name for name in PROGRAM if isinstance(SPELLING[name], np.ufunc)}
OF_NUMPY |= {"absolute": "fabs", "maximum": "max", "minimum": "min"}
OF_NUMPY |= {"bitwise_and": "and", "bitwise_or": "or", "invert": "not"}


@dataclass(frozen=True)
@check_arguments
class MetricProgram:
    """The k numbers of a metric from places in the states of a step.

    Node i is input i; behind the inputs come the `nodes`, whose operands are nodes before them. A truth is 1 or 0.

    Attributes
    ----------
    inputs
        ("x", place) of the states at the horizon, or ("z", place) of the states one step later.
    results
        The nodes that are the numbers of the metric.
    """

    inputs: tuple[tuple[str, int], ...]
    nodes: tuple[Written, ...]
    results: tuple[int, ...]

    @check_arguments
    def evaluate(self, x: Array, z: Array) -> Array:
        """The numbers (B, k) of the metric from states (B, nx) at the horizon, x, and one step later, z."""
        rows = {"x": x, "z": z}
        values = [rows[name][:, place] for name, place in self.inputs]
        with np.errstate(all="ignore"):
            for operation, *operands in self.nodes:
                if operation == "const":
                    values.append(np.full(len(x), operands[0]))
                else:
                    kinds = zip(map(int, operands), OPERATIONS[operation].operands, strict=True)
                    given = (values[i] != 0 if kind is Kind.TRUTH else values[i] for i, kind in kinds)
                    values.append(np.asarray(SPELLING[operation](*given), dtype=float))
        return np.stack([values[i] for i in self.results], axis=1)

    def plain(self) -> dict[str, object]:
        """The program as lists, texts and numbers for JSON, where a number that is not finite is a text."""
        return {
            "inputs": [list(place) for place in self.inputs],
            "nodes": [[node[0], *map(_plain, node[1:])] for node in self.nodes],
            "results": list(self.results),
        }


def _plain(number: float) -> float | str:
    return number if math.isfinite(number) else {math.inf: "Infinity", -math.inf: "-Infinity"}.get(number, "NaN")


@check_arguments
def program_of(step: StepMap, metric: AbstractMetric, horizon: float) -> MetricProgram:
    """The program of a metric of a measured step, with the bits of its `value` at a horizon in s.

    Of two zeros with unlike signs, NumPy's larger one differs from machine to machine; that of a program is +0.

    Raises
    ------
    ValueError
        If the value of the metric needs an operation that a program does not have, or branches on a number.
    """
    horizon, tape = seconds("program_of(horizon=...)", horizon), _Tape({})
    held, name = accumulators_in(step, [metric]), f"integral of {metric.name}"
    parts = {entry: _inputs(tape, step.states, entry, "x" if entry == name else "z") for entry in held.names}
    integral = parts.pop(name, _TracedArray(tape, np.zeros((1, 0), dtype=np.intp)))
    z = {entry.removeprefix(f"{metric.name}."): part for entry, part in parts.items()}
    try:
        with np.errstate(all="ignore"):
            answer = tape.of(value_as_written(metric)(integral, z, horizon))
        if answer.truth or answer.places.ndim != 2 or len(answer) != 1 or not answer.places.size:
            raise _UntraceableError(f"an answer of shape {answer.shape}")
    except Exception as error:  # a metric of the user's may raise anything when it meets other things than arrays
        cause = error.__cause__ or error
        why = str(cause) if isinstance(cause, _UntraceableError) else f"an operation that raised {error_text(error)}"
        raise ValueError(
            f"The value of the metric '{metric.name}' cannot be written as a program: it needs {why}. A program knows "
            f"{', '.join(PROGRAM)}, of numbers one by one."
        ) from error
    return tape.program(answer.places[0].tolist())


def _inputs(tape: _Tape, states: Layout, name: str, of: str) -> _TracedArray:
    """A quantity of a single run, (1, ...), as inputs of a program."""
    places = states.unpack(np.arange(states.size, dtype=float)[np.newaxis])[name]
    return _TracedArray(tape, _each(lambda place: tape.node(of, int(place)), places))


def _each(function: Callable[..., int], *arrays: Places | Array) -> Places:
    """A whole number for each place of some arrays, which are broadcast."""
    alike = np.broadcast_arrays(*arrays)
    numbers = [function(*(array[i] for array in alike)) for i in np.ndindex(alike[0].shape)]
    return np.array(numbers, dtype=np.intp).reshape(alike[0].shape)


class _UntraceableError(Exception):
    """The error of an operation that a program does not have; its text is the operation."""


class _Node(NamedTuple):
    """An operation with the numbers of its operands; "x" or "z" with a place; or "const" with a number as text."""

    operation: str
    operands: tuple[int, ...] = ()
    constant: str = ""


@dataclass(frozen=True, eq=False)
class _Tape:
    """The nodes written so far, each once, with their numbers."""

    numbers: dict[_Node, int]

    def node(self, operation: str, *operands: int) -> int:
        """The number of an operation, or of an input."""
        return self._number(_Node(operation, operands))

    def constant(self, number: float) -> int:
        """The number of a constant."""
        return self._number(_Node("const", constant=number.hex()))

    def _number(self, node: _Node) -> int:
        return self.numbers.setdefault(node, len(self.numbers))

    def of(self, value: object) -> _TracedArray:
        """An array of nodes, or numbers as constants."""
        if isinstance(value, np.ndarray) and value.dtype == object and value.ndim == 0:
            value = value[()]  # made by `np.asarray`
        if isinstance(value, _TracedArray):
            return value
        array = np.asarray(value)
        if array.dtype.kind not in "biuf" or array.dtype.itemsize > 8:
            raise _UntraceableError(f"numbers of kind {array.dtype}")
        places = _each(lambda number: self.constant(float(number)), array.astype(np.float64))
        return _TracedArray(self, places, array.dtype.kind == "b")

    def program(self, results: Sequence[int]) -> MetricProgram:
        """The program of what the results need, inputs first."""
        nodes, needed = list(self.numbers), set(results)
        for i in reversed(range(len(nodes))):
            if i in needed and nodes[i].operation in PROGRAM:
                needed.update(nodes[i].operands)
        inputs = [i for i in sorted(needed) if nodes[i].operation in ("x", "z")]
        others = [i for i in sorted(needed) if i not in inputs]
        place = {i: new for new, i in enumerate([*inputs, *others])}

        def renumber(node: _Node) -> Written:
            if node.operation == "const":
                return node.operation, float.fromhex(node.constant)
            return node.operation, *(place[i] for i in node.operands)

        return MetricProgram(
            tuple((nodes[i].operation, nodes[i].operands[0]) for i in inputs),
            tuple(renumber(nodes[i]) for i in others),
            tuple(place[i] for i in results),
        )


@dataclass(frozen=True, eq=False)
class _TracedArray(NDArrayOperatorsMixin):
    """An array of nodes, which writes down the operations that NumPy is asked to do with it."""

    tape: _Tape
    places: Places
    truth: bool = False

    @property
    def shape(self) -> tuple[int, ...]:
        shape: tuple[int, ...] = self.places.shape
        return shape

    @property
    def ndim(self) -> int:
        return self.places.ndim

    def __len__(self) -> int:
        return len(self.places)

    def __getitem__(self, key: Key | tuple[Key, ...]) -> _TracedArray:
        return replace(self, places=np.asarray(self.places[key]))

    def reshape(self, *shape: SupportsIndex) -> _TracedArray:
        return replace(self, places=self.places.reshape(*shape))

    def __bool__(self) -> bool:
        raise _UntraceableError("a branch on a number of the run")

    def __float__(self) -> float:
        raise _UntraceableError("a number of the run as a `float`")

    def __array__(self, dtype: object = None, copy: bool | None = None) -> NDArray[np.object_]:
        whole = np.empty((), dtype=object)
        whole[()] = self
        return whole

    def __pow__(self, power: object) -> _TracedArray:
        if not isinstance(power, int | float) or power not in (2, 0.5):
            raise _UntraceableError(f"a power of {power if isinstance(power, int | float) else 'a changing number'}")
        return self._apply("multiply", self, self) if power == 2 else self._apply("sqrt", self)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: object, **options: object) -> _TracedArray:
        if method != "__call__" or options:
            called = "" if method == "__call__" else f".{method}"
            raise _UntraceableError(f"`np.{ufunc.__name__}{called}`{''.join(f' with `{name}`' for name in options)}")
        return self._apply(ufunc.__name__, *map(self.tape.of, inputs))

    def __array_function__(
        self,
        function: Callable[..., Places],
        types: object,
        arguments: tuple[Iterable[object], ...],
        options: Mapping[str, object],
    ) -> _TracedArray:
        if function is np.where and len(arguments) == 3:
            return self._select(*map(self.tape.of, arguments))
        if function in RESHAPE_FUNCTIONS:
            return replace(self, places=function(self.places, *arguments[1:], **options))
        if function in JOIN_FUNCTIONS:
            parts = [self.tape.of(part) for part in arguments[0]]
            if len({part.truth for part in parts}) == 1:
                return replace(parts[0], places=function([part.places for part in parts], *arguments[1:], **options))
        raise _UntraceableError(f"`np.{function.__name__}`")

    def _apply(self, name: str, *operands: _TracedArray) -> _TracedArray:
        """An operation by NumPy's name."""
        match name:
            case "square":
                return self._apply("multiply", *operands, *operands)
            case "positive":
                return operands[0]
            case "isfinite" | "isinf":
                size = self._apply("absolute", *operands)
                return self._apply("less" if name == "isfinite" else "equal", size, self.tape.of(np.inf))
        operation, truths = OF_NUMPY.get(name), [operand.truth for operand in operands]
        # of truths alone NumPy's arithmetic has rules of its own
        if operation is None or (not all(truths) if operation in ("and", "or", "not") else all(truths)):
            raise _UntraceableError(f"`np.{name}`" + (" of truths" if all(truths) else ""))
        return self._record(operation, *operands, truth=gives_truth(operation))

    def _select(self, truth: _TracedArray, a: _TracedArray, b: _TracedArray) -> _TracedArray:
        if not truth.truth:
            raise _UntraceableError("`np.where` of a number that is not a comparison")
        return self._record("select", truth, a, b, truth=a.truth and b.truth)

    def _record(self, operation: str, *operands: _TracedArray, truth: bool) -> _TracedArray:
        places = _each(lambda *nodes: self.tape.node(operation, *map(int, nodes)), *(of.places for of in operands))
        return _TracedArray(self.tape, places, truth)
