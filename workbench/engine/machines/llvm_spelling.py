"""LLVM's spelling: an operation as an instruction on vectors, for this processor or any other that LLVM knows."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from functools import lru_cache

from workbench.engine.machines.operations import OPERATIONS

INTRINSICS = ("sqrt", "fabs", "floor", "trunc", "copysign", "fma")
# DOUBLES, WORDS and TRUTHS stand for vectors of a width, TRUE for one whose lanes are all true.
SPELLING: Mapping[str, str] = {
    "add": "fadd DOUBLES {0}, {1}",
    "sub": "fsub DOUBLES {0}, {1}",
    "mul": "fmul DOUBLES {0}, {1}",
    "div": "fdiv DOUBLES {0}, {1}",
    "neg": "fneg DOUBLES {0}",
    **{name: f"call DOUBLES @llvm.{name}.vWIDTHf64(OPERANDS)" for name in INTRINSICS},
    "lt": "fcmp olt DOUBLES {0}, {1}",
    "le": "fcmp ole DOUBLES {0}, {1}",
    "gt": "fcmp ogt DOUBLES {0}, {1}",
    "ge": "fcmp oge DOUBLES {0}, {1}",
    "eq": "fcmp oeq DOUBLES {0}, {1}",
    "ne": "fcmp une DOUBLES {0}, {1}",
    "and": "and TRUTHS {0}, {1}",
    "or": "or TRUTHS {0}, {1}",
    "not": "xor TRUTHS {0}, TRUE",
    "select": "select TRUTHS {0}, DOUBLES {1}, DOUBLES {2}",
    "word_add": "add WORDS {0}, {1}",
    "word_mul": "mul WORDS {0}, {1}",
    "word_and": "and WORDS {0}, {1}",
    "word_or": "or WORDS {0}, {1}",
    "word_xor": "xor WORDS {0}, {1}",
    "shl": "shl WORDS {0}, {1}",
    "lshr": "lshr WORDS {0}, {1}",
    "nonzero": "icmp ne WORDS {0}, zeroinitializer",
    "bits": "bitcast DOUBLES {0} to WORDS",
    "number": "bitcast WORDS {0} to DOUBLES",
    "signed": "sitofp WORDS {0} to DOUBLES",
}


@lru_cache
def instructions(width: int) -> Mapping[str, str]:
    """The instruction of each operation for vectors of a width, with places for its operands."""
    doubles = f"<{width} x double>"
    kinds = {"DOUBLES": doubles, "WORDS": f"<{width} x i64>", "TRUTHS": f"<{width} x i1>"}
    kinds["TRUE"] = f"<{', '.join(['i1 true'] * width)}>"
    kinds["WIDTH"] = str(width)
    found = dict(SPELLING)
    for name in INTRINSICS:
        operands = ", ".join(f"{doubles} {{{i}}}" for i in range(_arity(name)))
        found[name] = SPELLING[name].replace("OPERANDS", operands)
    for kind, text in kinds.items():
        found = {operation: line.replace(kind, text) for operation, line in found.items()}
    return found


def declarations(width: int) -> list[str]:
    """The declarations of the intrinsics."""
    vector = f"<{width} x double>"
    return [f"declare {vector} @llvm.{name}.v{width}f64({', '.join([vector] * _arity(name))})" for name in INTRINSICS]


def _arity(name: str) -> int:
    return len(OPERATIONS[name].operands)


def literal(value: float) -> str:
    """A double as LLVM reads it to the last bit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"
