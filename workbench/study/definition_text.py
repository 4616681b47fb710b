"""The text of a definition, or of a value that it uses: the same in every process, and refused if it cannot be seen.

Functions and classes of a study count by what they do: their instructions and constants, and the values of the module
that they use. Those of a library count by its version.
"""

from __future__ import annotations

import dis
import enum
import functools
import hashlib
import re
import sys
from collections.abc import Collection, Mapping
from dataclasses import fields, is_dataclass
from decimal import Decimal
from fractions import Fraction
from pathlib import PurePath
from types import BuiltinFunctionType, CellType, CodeType, FunctionType, MethodType, ModuleType

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from workbench.core import Ode, SampledSystem, StepMap
from workbench.core.fingerprints import fingerprint_of
from workbench.core.validation.notebook_display import brief

PLAIN = (bool, int, str, bytes, type(None), type(...), range, slice, Fraction, Decimal, PurePath)
# Calls whose result no source tells.
OUT_OF_SIGHT = {"open", "input", "eval", "exec", "compile", "globals", "__import__"}
READERS = {"read_text", "read_bytes", "loadtxt", "genfromtxt", "fromfile", "loadmat", "read_csv", "urlopen"}
# Of a class: what says nothing of what it does, or follows from the rest.
NO_CONTENT = {
    *("__doc__", "__module__", "__qualname__", "__dict__", "__weakref__", "__annotations__", "__annotate_func__"),
    *("__annotations_cache__", "__dataclass_fields__", "__dataclass_params__", "__match_args__", "__firstlineno__"),
    *("__static_attributes__", "__abstractmethods__", "__parameters__", "__orig_bases__", "_abc_impl"),
}
DESCRIPTORS = {"member_descriptor", "getset_descriptor", "_tuplegetter"}  # of slots and of named tuples
WRITTEN_BY_PYTHON = "<string>"  # the file of methods that `dataclass` and `NamedTuple` make

DEEPEST = 100  # of the parts of a value in one another
MAX_LETTERS = 60  # letters of a value in a message

Definition = FunctionType | type


class DigestError(ValueError):
    """The error of a definition that uses what its digest cannot hold."""


class Reader:
    """The reader of values used at one place: it writes each as text, and lists the definitions among them."""

    def __init__(self, definitions: list[Definition], place: str) -> None:
        self.found, self.place = definitions, place
        self._open: set[int] = set()  # values that are being written

    def text(self, value: object) -> str:
        """A value as text; of a definition its name, as its content follows."""
        if isinstance(value, enum.Enum):
            return f"{self.text(type(value))}.{value.name}"
        if isinstance(value, PLAIN):
            return f"{type(value).__name__} {value!r}"
        if isinstance(value, re.Pattern):
            return f"pattern {value.pattern!r} {value.flags}"
        if isinstance(value, float | complex | np.generic):
            return self._of_array(np.asarray(value), type(value).__name__)
        if isinstance(value, np.ndarray):
            return self._of_array(value, "array")
        if isinstance(value, type | FunctionType):
            return self._named(value)
        if id(value) in self._open:
            raise self._unseen(value, "a value that holds itself")
        if len(self._open) >= DEEPEST:
            raise self._unseen(value, f"a value with parts more than {DEEPEST} deep in one another")
        self._open.add(id(value))
        try:
            return self._of_parts(value)
        finally:
            self._open.discard(id(value))

    def _of_parts(self, value: object) -> str:
        if isinstance(value, tuple | list | set | frozenset | Mapping):
            return self._of_container(value)
        if isinstance(value, ca.SX | ca.MX | ca.DM | ca.Function):
            return self._of_expression(value)
        if isinstance(value, Ode | SampledSystem | StepMap):
            return self._of_equation(value)
        return self._of_callable(value) or self._of_object(value)

    def _of_array(self, value: NDArray[np.generic], kind: str) -> str:
        if value.dtype.hasobject or np.ma.is_masked(value):
            raise self._unseen(
                value, "an array that is masked in part" if np.ma.is_masked(value) else "an array of objects"
            )
        data = np.ascontiguousarray(value).tobytes()
        return f"{kind} {value.dtype.str} {value.shape} {data.hex() if len(data) <= 16 else _sha(data)}"

    def _of_container(self, value: Collection[object]) -> str:
        kind = type(value)
        name = kind.__name__ if kind in (tuple, list, dict, set, frozenset) else self.text(kind)
        if isinstance(value, Mapping):
            return f"{name} {[(self.text(key), self.text(held)) for key, held in value.items()]}"
        parts = [self.text(part) for part in value]
        return f"{name} {sorted(parts) if isinstance(value, set | frozenset) else parts}"

    def _of_expression(self, value: ca.SX | ca.MX | ca.DM | ca.Function) -> str:
        if isinstance(value, ca.DM):
            return f"DM {value.sparsity().get_triplet()} {self.text(np.array(value.nonzeros()))}"
        if isinstance(value, ca.Function):
            if not value.is_a("SXFunction"):
                arguments = [ca.SX.sym("x", value.sparsity_in(i)) for i in range(value.n_in())]
                value = ca.Function("called", arguments, value.call(arguments, False, True))
            return f"Function {fingerprint_of(b'', value)}"
        if isinstance(value, ca.MX):
            raise self._unseen(value, "an expression of CasADi's MX")
        symbols = ca.symvar(value)
        names = [symbol.name() for symbol in symbols]
        return f"SX {value.shape} {names} {fingerprint_of(b'', ca.Function('value', symbols, [value]))}"

    def _of_equation(self, value: Ode | SampledSystem | StepMap) -> str:
        numbers = [self.text(layout.default) for layout in (value.parameters, value.states)]
        if isinstance(value, StepMap):
            rule, names = value.rule, [layout.labels for layout in (value.parameters, value.states)]
            parts = [fingerprint_of(b"", part) for part in (rule.parts, rule.segment_parts) if part is not None]
            return f"Step {value.h.hex()} {names} {parts} {numbers}"
        flow = value.flow if isinstance(value, SampledSystem) else value
        signals = (flow.inputs, flow.follows, flow.drives, flow.measures, flow.counts, flow.horizon)
        return f"{type(value).__name__} {value.name} {signals} {value.fingerprint} {numbers}"

    def _of_callable(self, value: object) -> str:
        """The text of whatever else can be called; empty if it cannot."""
        if isinstance(value, ModuleType):
            if _is_library(value.__name__):
                return _versioned(value.__name__)
            raise self._unseen(value, "a module of the study as a whole; name what is used of it")
        if isinstance(value, functools.partial):
            return f"partial {self.text(value.func)} {self.text(value.args)} {self.text(value.keywords)}"
        if isinstance(value, MethodType):
            return f"method {self.text(value.__func__)} of {self.text(value.__self__)}"
        if isinstance(value, staticmethod | classmethod):
            return f"{type(value).__name__} {self.text(value.__func__)}"
        if isinstance(value, property):
            return f"property {[self.text(part) for part in (value.fget, value.fset, value.fdel)]}"
        if isinstance(value, functools.cached_property):
            return f"cached {self.text(value.func)}"
        if isinstance(value, functools._lru_cache_wrapper):
            return f"cache {self.text(value.__wrapped__)}"
        if isinstance(value, BuiltinFunctionType) and not isinstance(value.__self__, ModuleType | type | None):
            return f"method {value.__name__} of {self.text(value.__self__)}"
        name = getattr(value, "__qualname__", None) or getattr(value, "__name__", None)
        home = getattr(value, "__module__", None) or "builtins"
        if isinstance(name, str) and callable(value) and _is_library(home):  # builtins, slots, ufuncs
            return f"{_versioned(home)}: {name}"
        if type(value).__module__ in ("typing", "types") or type(value).__qualname__ in DESCRIPTORS:
            return repr(value)
        return ""

    def _of_object(self, value: object) -> str:
        kind = type(value)
        if is_dataclass(value):
            held = {field.name: getattr(value, field.name) for field in fields(value)}
        elif _is_library(kind.__module__) or not hasattr(value, "__dict__"):
            raise self._unseen(value, f"a `{kind.__name__}`")
        else:
            cached = {name for one in kind.__mro__ for name, part in vars(one).items() if _is_cached(part)}
            held = {name: part for name, part in vars(value).items() if name not in cached}
        return f"{self.text(kind)} {[(name, self.text(part)) for name, part in held.items()]}"

    def _named(self, definition: Definition) -> str:
        module = definition.__module__
        if isinstance(definition, FunctionType):  # a decorator's wrapper has the module of the function it wraps
            module = str(definition.__globals__.get("__name__", module))
        if not _is_library(module):
            self.found.append(definition)
            return f"{module}.{definition.__qualname__}"
        if isinstance(definition, type) or not definition.__closure__:
            return f"{_versioned(module)}: {definition.__qualname__}"
        cells = [self._of_cell(cell, lenient=True) for cell in definition.__closure__]  # a study's own may be in it
        return f"{_versioned(module)}: {definition.__code__.co_qualname} {cells}"

    def _of_cell(self, cell: CellType, lenient: bool = False) -> str:
        try:
            return self.text(cell.cell_contents)
        except DigestError:
            if lenient:
                return "unseen"
            raise
        except ValueError:
            return "empty"

    def of_function(self, function: FunctionType) -> str:
        """The content of a function: its instructions, defaults, enclosed values, and all that it calls."""
        parts = [self._of_code(function.__code__, function), self.text(function.__defaults__)]
        parts += [self.text(function.__kwdefaults__), *map(self._of_cell, function.__closure__ or ())]
        return f"function {parts}\n"

    def of_class(self, kind: type) -> str:
        """The content of a class: its bases, fields, methods and constants."""
        parts = [self.text(base) for base in kind.__bases__]
        for field in fields(kind) if is_dataclass(kind) else ():
            defaults = (field.default, field.default_factory)
            given = [self.text(default) for default in defaults if type(default).__name__ != "_MISSING_TYPE"]
            parts.append(f"{field.name}: {field.type} {given} {self.text(dict(field.metadata))}")
        for name, value in sorted(vars(kind).items()):
            code = getattr(value, "__code__", None)
            if name not in NO_CONTENT and (code is None or code.co_filename != WRITTEN_BY_PYTHON):
                parts.append(f"{name} {self.text(value)}")
        return f"class {parts}\n"

    def _of_code(self, code: CodeType, function: FunctionType) -> str:
        """The instructions and constants of a code, and the values that its names have in the function's module."""
        parts = [str((code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags))]
        parts += [code.co_code.hex(), code.co_exceptiontable.hex()]
        parts += [str((code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars))]
        for i, constant in enumerate(code.co_consts):
            if i == 0 and isinstance(constant, str) and constant == function.__doc__:
                continue
            parts.append(self._of_code(constant, function) if isinstance(constant, CodeType) else self.text(constant))
        if unseen := READERS & set(code.co_names):
            raise self._unseen_name(f"`{min(unseen)}`", "reads what may change: read it when the module is loaded")
        instructions = list(dis.get_instructions(code))
        for i, one in enumerate(instructions):
            if one.opname in ("STORE_GLOBAL", "DELETE_GLOBAL"):
                raise self._unseen_name(f"`{one.argval}`", "is changed there: hand it on as an argument")
            if one.opname == "IMPORT_NAME" and not _is_library(str(one.argval)):
                raise self._unseen_name(f"`import {one.argval}`", "stands inside of the function: put it at the top")
            if one.opname.startswith("LOAD_") and one.opname.endswith(("GLOBAL", "GLOBALS", "NAME")):
                parts.append(self._of_global(str(one.argval), function, instructions[i + 1 :]))
        return f"{parts}"

    def _of_global(self, name: str, function: FunctionType, rest: list[dis.Instruction]) -> str:
        if name not in function.__globals__:
            if name in OUT_OF_SIGHT:
                raise self._unseen_name(f"`{name}`", "reaches what no source tells: hand it on in `over`")
            return f"builtin {name}"
        value = function.__globals__[name]
        for one in rest:  # of a module of the study, what is used of it
            if not (isinstance(value, ModuleType) and not _is_library(value.__name__)):
                break
            if one.opname not in ("LOAD_ATTR", "LOAD_METHOD"):
                break
            name = f"{name}.{one.argval}"
            value = getattr(value, str(one.argval))
        try:
            return f"{name} = {self.text(value)}"
        except DigestError as error:
            if name in str(error):
                raise
            raise DigestError(f"{error} It is reached by `{name}`.") from None

    def _unseen(self, value: object, kind: str) -> DigestError:
        shown = object.__repr__(value) if isinstance(value, Mapping | list | tuple) else brief(value, MAX_LETTERS)
        return DigestError(
            f"{self.place} uses {shown if len(shown) <= MAX_LETTERS else shown[: MAX_LETTERS - 3] + '...'}, {kind}, "
            "whose contents cannot be seen: two works that differ in it could not be told apart. Use numbers, text, "
            "arrays, tuples, frozen dataclasses and functions at the top of a module."
        )

    def _unseen_name(self, name: str, why: str) -> DigestError:
        return DigestError(f"{self.place} uses {name}, which {why}.")


def _sha(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _is_cached(part: object) -> bool:
    return isinstance(part, functools.cached_property)


@functools.cache
def _is_library(module: str) -> bool:
    """True if a module is of Python, of the workbench, or installed: not a file of the user's own."""
    top = module.partition(".")[0]
    if top == "__main__":
        return False
    if top in ("workbench", "builtins") or top in sys.stdlib_module_names:
        return True
    file = getattr(sys.modules.get(top), "__file__", None) or getattr(sys.modules.get(module), "__file__", None)
    return file is not None and bool({"site-packages", "dist-packages"} & set(PurePath(file).parts))


def _versioned(module: str) -> str:
    """The name of a module of a library, with the version of the library."""
    version = getattr(sys.modules.get(module.partition(".")[0]), "__version__", "")
    return f"{module} {version}" if isinstance(version, str) else module
