"""The door to LLVM: functions of a module, compiled once, and kept on disk without ever being wrong."""

import ctypes
import gc
import subprocess
import sys
import threading
import time
import weakref
from collections import OrderedDict

import numpy as np
import pytest

from tests.support.equations import turning

pytest.importorskip("llvmlite")  # there is no wheel of it for some platforms, where CasADi's machine serves

from workbench.core import rk4
from workbench.engine import simulate
from workbench.engine.kernel import llvm

POINTER = ctypes.c_void_p
SCALE = """
define void @test_scale(i64 %n, double %by, ptr %x) {
start:
  br label %round
round:
  %i = phi i64 [ 0, %start ], [ %next, %round ]
  %place = getelementptr double, ptr %x, i64 %i
  %old = load double, ptr %place
  %new = fmul double %old, %by
  store double %new, ptr %place
  %next = add i64 %i, 1
  %more = icmp slt i64 %next, %n
  br i1 %more, label %round, label %end
end:
  ret void
}

define void @test_answer(ptr %x) {
  store double 4.2e1, ptr %x
  ret void
}
"""


@pytest.fixture
def kernels(tmp_path, monkeypatch):
    """The folder of an empty disk cache, and nothing in memory."""
    monkeypatch.setenv("WORKBENCH_CACHE", str(tmp_path / "kernels"))
    monkeypatch.setattr(llvm, "_modules", OrderedDict())
    return tmp_path / "kernels"


@pytest.fixture
def compilations(kernels, monkeypatch):
    """The IR of every module that LLVM was asked to compile."""
    asked, compile_ = [], llvm._object
    monkeypatch.setattr(llvm, "_object", lambda ir, machine: asked.append(ir) or compile_(ir, machine))
    return asked


def forget():
    """Let memory lose every module."""
    llvm._modules.clear()


def scaled(module):
    x = np.array([1.0, 2.0, 0.1])
    module.function("test_scale", ctypes.c_int64, ctypes.c_double, POINTER)(3, 1.1, x.ctypes.data)
    return x.tolist()


RIGHT = [1.0 * 1.1, 2.0 * 1.1, 0.1 * 1.1]


# a module and its functions


def test_a_module_has_several_functions_each_with_its_own_arguments(kernels):
    module = llvm.compile_module(SCALE)
    x = np.zeros(1)
    assert module.function("test_answer", POINTER)(x.ctypes.data) is None
    assert x[0] == 42
    assert scaled(module) == RIGHT


@pytest.mark.parametrize("name", ["test_scales", "step", "printf"])
def test_a_function_that_the_module_has_not_is_refused_even_if_the_process_has_it(kernels, name):
    with pytest.raises(LookupError, match=f"has no function '{name}'"):
        llvm.compile_module(SCALE).function(name, POINTER)


def test_a_function_keeps_its_code_in_memory_and_nothing_else_does(kernels):
    module = llvm.compile_module(SCALE)
    answer, engine = module.function("test_answer", POINTER), weakref.ref(module.engine)
    forget()
    del module
    gc.collect()
    x = np.zeros(1)
    answer(x.ctypes.data)
    assert x[0] == 42
    del answer
    gc.collect()
    assert engine() is None


def test_other_threads_go_on_while_a_function_runs(kernels):
    # waits until the second number is no longer zero, or for some seconds; the third is what it saw
    waiting = """
define void @test_wait(ptr %x) {
start:
  %flag = getelementptr i64, ptr %x, i64 1
  %seen = getelementptr i64, ptr %x, i64 2
  store volatile i64 1, ptr %x
  br label %round
round:
  %i = phi i64 [ 0, %start ], [ %next, %round ]
  %now = load volatile i64, ptr %flag
  %next = add i64 %i, 1
  %set = icmp ne i64 %now, 0
  %late = icmp sgt i64 %next, 10000000000
  %done = or i1 %set, %late
  br i1 %done, label %end, label %round
end:
  store volatile i64 %now, ptr %seen
  ret void
}
"""
    x = np.zeros(3, dtype=np.int64)
    thread = threading.Thread(target=llvm.compile_module(waiting).function("test_wait", POINTER), args=(x.ctypes.data,))
    thread.start()
    while not x[0]:
        time.sleep(1e-4)
    x[1] = 7
    thread.join()
    assert x[2] == 7


# compiled once


def test_many_threads_that_want_one_module_compile_it_once(compilations):
    start, modules = threading.Barrier(8), []

    def want():
        start.wait()
        modules.append(llvm.compile_module(SCALE))

    threads = [threading.Thread(target=want) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(compilations) == 1
    assert len(modules) == 8
    assert len(set(map(id, modules))) == 1


def test_memory_keeps_the_modules_used_last(compilations, monkeypatch):
    monkeypatch.setenv("WORKBENCH_CACHE", "off")
    monkeypatch.setattr(llvm, "MOST_MODULES", 2)
    first, second, third = (SCALE.replace("4.2e1", number) for number in ("1.0", "2.0", "3.0"))
    for ir in (first, second, first, third, first, second):
        llvm.compile_module(ir)
    assert compilations == [first, second, third, second]


def test_a_kernel_on_disk_is_not_compiled_again(compilations):
    llvm.compile_module(SCALE)
    forget()
    assert scaled(llvm.compile_module(SCALE)) == RIGHT
    assert compilations == [SCALE]


def test_a_loop_from_disk_gives_the_bits_of_a_fresh_one(compilations):
    starts = np.column_stack([np.linspace(-3, 3, 11), np.linspace(-1, 1, 11)])
    runs = []
    for _ in range(2):
        forget()
        runs.append(simulate(rk4(turning(2.0), 1e-2), x0=starts, until=5.0, engine="native").x)
    assert len(compilations) == 1
    np.testing.assert_array_equal(runs[0], runs[1])


def test_off_compiles_every_time_and_writes_nothing(compilations, kernels, monkeypatch):
    monkeypatch.setenv("WORKBENCH_CACHE", "off")
    for _ in range(2):
        forget()
        assert scaled(llvm.compile_module(SCALE)) == RIGHT
    assert len(compilations) == 2
    assert not kernels.exists()


@pytest.mark.parametrize(("name", "value"), [("processor", lambda: "another one"), ("OPTIMISATION", 1)])
def test_what_was_compiled_for_another_processor_or_otherwise_is_not_used(compilations, monkeypatch, name, value):
    llvm.compile_module(SCALE)
    forget()
    monkeypatch.setattr(llvm, name, value)
    llvm.compile_module(SCALE)
    assert len(compilations) == 2


# a cache that cannot be trusted


def flipped(file, other):
    content = bytearray(file.read_bytes())
    content[-len(content) // 4] ^= 1
    file.write_bytes(content)


DAMAGE = {
    "one bit": flipped,
    "cut off": lambda file, other: file.write_bytes(file.read_bytes()[:-1]),
    "empty": lambda file, other: file.write_bytes(b""),
    "of another kernel": lambda file, other: file.write_bytes(other.read_bytes()),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_kernel_is_compiled_anew_and_replaced(compilations, kernels, damage):
    llvm.compile_module(SCALE)
    (file,) = kernels.iterdir()
    good = file.read_bytes()
    llvm.compile_module(SCALE.replace("%old, %by", "%old, %old"))
    (other,) = set(kernels.iterdir()) - {file}
    DAMAGE[damage](file, other)
    forget()
    assert scaled(llvm.compile_module(SCALE)) == RIGHT
    assert compilations[2:] == [SCALE]
    assert file.read_bytes() == good


def test_a_folder_that_cannot_be_made_costs_a_compilation_and_no_more(compilations, tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("WORKBENCH_CACHE", str(tmp_path / "file" / "kernels"))
    assert scaled(llvm.compile_module(SCALE)) == RIGHT
    assert len(compilations) == 1


def test_two_processes_that_start_together_on_an_empty_folder_both_get_the_kernel(kernels):
    text = f"""
import ctypes
from workbench.engine.kernel import llvm
print("ready", flush=True)
input()
x = (ctypes.c_double * 3)(1.0, 2.0, 0.1)
module = llvm.compile_module({SCALE!r})
module.function("test_scale", ctypes.c_int64, ctypes.c_double, ctypes.c_void_p)(3, 1.1, ctypes.addressof(x))
print(list(x))
"""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    twins = [subprocess.Popen([sys.executable, "-W", "error", "-c", text], **pipes) for _ in range(2)]
    for twin in twins:
        assert twin.stdout.readline() == "ready\n"
    for twin in twins:
        twin.stdin.write("\n")
        twin.stdin.flush()
    assert [twin.communicate(timeout=60) for twin in twins] == [(f"{RIGHT}\n", "")] * 2
    assert [file.suffix for file in kernels.iterdir()] == [".kernel"]


# the processor


@pytest.mark.parametrize(
    ("machine", "features", "answer"),
    [
        ("x86_64", {"fma": True}, True),
        ("AMD64", {"fma": False, "avx512f": False}, False),
        ("x86_64", {}, False),  # nothing is known of it
        ("arm64", {"neon": True}, True),
        ("aarch64", {}, True),
    ],
)
def test_an_x86_processor_says_whether_it_has_fma_and_arm_has_it(monkeypatch, machine, features, answer):
    monkeypatch.setattr(llvm.llvm, "get_host_cpu_features", lambda: features)
    monkeypatch.setattr(llvm.platform, "machine", lambda: machine)
    assert llvm.has_fma.__wrapped__() is answer  # it is asked once a process


def test_the_processor_is_named_with_its_features_and_the_version_of_llvm():
    name = llvm.processor()
    for part in (llvm.llvm.get_host_cpu_name(), llvm.llvm.get_host_cpu_features().flatten(), llvm.llvmlite.__version__):
        assert part in name
    assert f"LLVM {llvm.llvm.llvm_version_info[0]}." in name
