"""The one door to llvmlite: IR in, a native function out."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import llvmlite.binding as llvm

POINTER, COUNT = ctypes.c_void_p, ctypes.c_int64
SIGNATURE = ctypes.CFUNCTYPE(None, COUNT, COUNT, POINTER, POINTER, POINTER, POINTER, POINTER)

llvm.initialize_native_target()
llvm.initialize_native_asmprinter()


def lanes() -> int:
    """How many doubles a vector register of this processor holds, but at least four."""
    return 8 if llvm.get_host_cpu_features().get("avx512f") else 4


@dataclass(frozen=True, eq=False)
class Native:
    """A compiled function and the engine that keeps it alive."""

    march: Any
    engine: Any


@lru_cache(maxsize=128)
def compiled(ir: str) -> Native:
    """The function `workbench_march` of some IR, compiled for this processor."""
    target = llvm.Target.from_default_triple()
    machine = target.create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=2, jit=True
    )
    module = llvm.parse_assembly(ir)
    module.triple = machine.triple
    module.data_layout = str(machine.target_data)
    module.verify()
    engine = llvm.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    return Native(SIGNATURE(engine.get_function_address("workbench_march")), engine)
