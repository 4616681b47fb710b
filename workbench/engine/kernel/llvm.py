"""The one door to llvmlite: IR in, native functions out, at most once compiled on this processor."""

from __future__ import annotations

import ctypes
import os
import platform
import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import overload

import llvmlite
import llvmlite.binding as llvm

from workbench.engine.kernel import cache as disk

OPTIMISATION = 2  # of the code generator; the IR is written as it shall run, and no pass goes over it
HASTE = 0  # the same for code that is wanted at once: made in a quarter of the time, and half as fast
MOST_MODULES = 128  # modules that stay in memory after their last user

llvm.initialize_native_target()
llvm.initialize_native_asmprinter()


@cache
def lanes() -> int:
    """The number of doubles that a vector register of this processor holds, but at least four."""
    return 8 if llvm.get_host_cpu_features().get("avx512f") else 4


@cache
def has_fma() -> bool:
    """True if this processor multiplies and adds with one rounding in one instruction."""
    # x86 says so among its features; 64-bit ARM always does, and does not say so
    return bool(llvm.get_host_cpu_features().get("fma", platform.machine().lower() in ("aarch64", "arm64")))


@cache
def processor() -> str:
    """The platform, its processor and the LLVM version, on which machine code depends besides its IR."""
    name, features = _host()
    return f"{llvm.get_process_triple()} {name} {features} {_version()}"


def _version() -> str:
    return f"LLVM {'.'.join(map(str, llvm.llvm_version_info))} llvmlite {llvmlite.__version__}"


@dataclass(frozen=True, eq=False)
class Native:
    """A compiled module, in the engine that keeps its code in memory."""

    engine: llvm.ExecutionEngine

    @overload
    def function(self, name: str, *arguments: type) -> Callable[..., None]: ...
    @overload
    def function(self, name: str, *arguments: type, result: type[ctypes.c_bool]) -> Callable[..., bool]: ...
    def function(
        self, name: str, *arguments: type, result: type[ctypes.c_bool] | None = None
    ) -> Callable[..., bool | None]:
        """A function of the module, of arguments and a result of these ctypes; other threads go on while it runs."""
        address = self.engine.get_function_address(name)
        if not address:
            raise LookupError(f"The compiled module has no function '{name}'.")
        made = ctypes.CFUNCTYPE(result, *arguments)(address)
        vars(made)["engine"] = self.engine  # else the code would go when the module goes
        return made


_modules: OrderedDict[str, Native] = OrderedDict()
_turn = threading.Lock()


def _fresh_turn() -> None:
    """Replace the lock in the child of a fork, where the thread that held it does not exist."""
    global _turn
    _turn = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_fresh_turn)


def compile_module(ir: str, haste: bool = False) -> Native:
    """The module of some IR: from memory, else from disk, else from LLVM; in `haste` it may be slower code."""
    levels = (OPTIMISATION, HASTE) if haste else (OPTIMISATION,)
    with _turn:  # LLVM serves one caller at a time; a second one who wants the same module shall find it made
        for level in levels:
            key = disk.key(ir, processor(), f"codegen {level}")
            module = _modules.get(key)
            if module is None and (code := disk.load(key)) is not None:
                module = _in_memory(code)
            if module is not None:
                break
        else:
            code = _object(ir, _machine(level))
            disk.store(key, code)
            module = _in_memory(code)
        _modules[key] = module
        _modules.move_to_end(key)
        if len(_modules) > MOST_MODULES:
            _modules.popitem(last=False)
        return module


def _in_memory(code: bytes) -> Native:
    """The module of an object file, in an engine of its own."""
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine(OPTIMISATION))
    # The engine's own module is empty and stays IR: `finalize_object` would first compile it. Asking for an
    # address finalises what was added.
    engine.add_object_file(llvm.object_file.ObjectFileRef.from_data(code))
    return Native(engine)


def object_for(ir: str, triple: str, features: str, haste: bool = False) -> bytes:
    """The object file of some IR for another machine, at most once made on this one; in `haste` slower code."""
    level = HASTE if haste else OPTIMISATION
    key = disk.key(ir, f"{triple} {features} {_version()}", f"codegen {level}")
    with _turn:
        if (code := disk.load(key)) is None:
            llvm.initialize_all_targets()
            llvm.initialize_all_asmprinters()
            machine = llvm.Target.from_triple(triple).create_target_machine("generic", features, opt=level)
            disk.store(key, code := _object(ir, machine))
    return code


def _object(ir: str, machine: llvm.TargetMachine) -> bytes:
    module = llvm.parse_assembly(ir)
    module.triple = machine.triple
    module.data_layout = str(machine.target_data)
    module.verify()
    return bytes(machine.emit_object(module))


def _machine(level: int) -> llvm.TargetMachine:
    """A new description of this processor, as each engine takes ownership of its own."""
    name, features = _host()
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(cpu=name, features=features, opt=level, jit=True)


@cache
def _host() -> tuple[str, str]:
    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
