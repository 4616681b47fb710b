"""WebAssembly: a plan as a module that a browser runs, with the bits of the portable arithmetic.

LLVM makes a relocatable object, whose functions nobody can call yet. `callable_module` gives it an export section, and
keeps nothing but code: a module that needs more than memory, as a function of the browser's own, is refused by name.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

from workbench.engine.kernel import llvm
from workbench.engine.kernel.loop_emission import room_of
from workbench.engine.kernel.lowering import lower
from workbench.engine.kernel.plan import KernelPlan
from workbench.engine.machines.webassembly_spelling import FEATURES, TRIPLE, WIDTH

MOST_ORDERED = 1000  # operations of a step with loops that LLVM has a second for
MEMORY = "env", "__linear_memory"
MAGIC = b"\0asm\1\0\0\0"
CUSTOM, TYPES, IMPORTS, FUNCTIONS, EXPORTS, CODE = 0, 1, 2, 3, 7, 10  # sections, by WebAssembly 1.0, section 5.5
SYMBOLS, FUNCTION, UNDEFINED_FLAG = 8, 0, 0x10  # of the "linking" section, by the tools' conventions for objects


@lru_cache(maxsize=64)
def compile_plan(plan: KernelPlan) -> bytes:
    """The module of a plan: it imports its memory, and exports the functions of `lowering`, without fused products.

    Raises
    ------
    ValueError
        If the code needs more than memory.
    """
    ir = lower(plan, WIDTH, fused_products=False, stack="")
    # the time of LLVM's own order of values grows with the square of a block that reads and writes memory
    haste = room_of(plan.graph) > 0 and len(plan.graph.nodes) > MOST_ORDERED
    return callable_module(llvm.object_for(ir, TRIPLE, FEATURES, haste))


def callable_module(code: bytes) -> bytes:
    """The module of an object file, its own functions exported by their names."""
    parts = dict(_sections(code))
    names = [name for name in _imports(parts[IMPORTS]) if name != MEMORY]
    strangers = set(parts) - {CUSTOM, TYPES, IMPORTS, FUNCTIONS, CODE}
    if names or strangers:
        needs = ", ".join([*map(".".join, names), *(f"section {number}" for number in strangers)])
        raise ValueError(f"`compiled(plan)` must need nothing but memory in a browser; its code needs {needs}.")
    exports = [_text(name) + b"\0" + _leb(index) for name, index in _defined_functions(parts[CUSTOM])]
    parts[EXPORTS] = _leb(len(exports)) + b"".join(exports)
    kept = (TYPES, IMPORTS, FUNCTIONS, EXPORTS, CODE)
    return MAGIC + b"".join(bytes([number]) + _leb(len(parts[number])) + parts[number] for number in kept)


class _Reader:
    """The bytes of a section, read from its start."""

    def __init__(self, data: bytes, place: int = 0) -> None:
        self.data, self.place = data, place

    def number(self) -> int:
        """An unsigned number in LEB128."""
        value = shift = 0
        while True:
            byte = self.data[self.place]
            self.place += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    def bytes(self, size: int) -> bytes:
        """So many bytes."""
        self.place += size
        return self.data[self.place - size : self.place]

    def text(self) -> str:
        """A text behind its length."""
        return self.bytes(self.number()).decode()

    def limits(self) -> None:
        """The least and most size of a memory or a table, which are passed over."""
        for _ in range(1 + (self.number() & 1)):
            self.number()

    @property
    def more(self) -> bool:
        """True before the end."""
        return self.place < len(self.data)


def _sections(code: bytes) -> Iterator[tuple[int, bytes]]:
    """The sections by their numbers; of the custom ones the symbol table alone."""
    reader = _Reader(code, len(MAGIC))
    while reader.more:
        number = reader.number()
        part = reader.bytes(reader.number())
        if number != CUSTOM:
            yield number, part
        elif (inner := _Reader(part)).text() == "linking":
            yield CUSTOM, part[inner.place :]


def _imports(section: bytes) -> Iterator[tuple[str, str]]:
    """The names of all imports, each with its module."""
    reader = _Reader(section)
    for _ in range(reader.number()):
        yield reader.text(), reader.text()
        kind = reader.number()
        if kind == 0:  # a function of a type
            reader.number()
        elif kind == 3:  # a global of a type, which may change or not
            reader.bytes(2)
        else:  # a memory; or a table of a type
            reader.bytes(int(kind == 1))
            reader.limits()


def _defined_functions(section: bytes) -> Iterator[tuple[str, int]]:
    """The functions that the symbol table defines, with their indices."""
    reader = _Reader(section)
    reader.number()  # the version
    while reader.more:
        kind, inner = reader.number(), _Reader(reader.bytes(reader.number()))
        for _ in range(inner.number() if kind == SYMBOLS else 0):
            if inner.number() != FUNCTION:
                return  # functions come first
            flags, index = inner.number(), inner.number()
            if not flags & UNDEFINED_FLAG:
                yield inner.text(), index


def _leb(value: int) -> bytes:
    """An unsigned number in LEB128."""
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*out, value])


def _text(text: str) -> bytes:
    return _leb(len(text)) + text.encode()
