"""The bits of normal numbers: from arrays, from lanes of every width, and from exact arithmetic."""

import ctypes
import operator
import struct
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest

from tests.support.cases import heavy_but
from workbench.engine.kernel.emission import Emission
from workbench.engine.kernel.graph import Graph
from workbench.engine.kernel.noise import normals, normals_on, pair
from workbench.engine.machines.machine import MachineWord


def some_keys(count):
    """Seeds, runs and steps, small and large."""
    rng = np.random.default_rng(4)
    seeds = rng.integers(0, 2**64, count, dtype=np.uint64) >> rng.integers(0, 64, count, dtype=np.uint64)
    runs = rng.integers(0, 2**63, count, dtype=np.uint64) >> rng.integers(0, 63, count, dtype=np.uint64)
    steps = rng.integers(0, 2**32, count, dtype=np.uint64) >> rng.integers(0, 32, count, dtype=np.uint64)
    seeds[:3], runs[:3], steps[:3] = (0, 2**64 - 1, 2**32), (0, 2**63 - 1, 2**32), (0, 2**32 - 1, 2**31)
    return seeds, runs, steps


def one_by_one(seeds, runs, steps, entries):
    """The numbers of every key by a call of its own, (keys, entries)."""
    keys = zip(seeds, runs, steps, strict=True)
    return np.array([normals(int(s), [int(r)], [int(k)], entries)[0, 0] for s, r, k in keys])


def bits(number):
    return struct.unpack("<Q", struct.pack("<d", number))[0]


def root(number):
    with localcontext() as context:
        context.prec = 60  # a root of a double is never so near the middle between two
        return float(Decimal(number).sqrt())


class ExactMachine:
    """A machine in Python's whole numbers and fractions, each of whose operations is rounded once."""

    fused = True  # so that a fused product would be noticed: there is none below
    operations = {
        "add": lambda a, b: float(Fraction(a) + Fraction(b)),
        "sub": lambda a, b: float(Fraction(a) - Fraction(b)),
        "mul": lambda a, b: float(Fraction(a) * Fraction(b)),
        "div": lambda a, b: float(Fraction(a) / Fraction(b)),
        "sqrt": root,
        "bits": bits,
        "number": lambda word: struct.unpack("<d", struct.pack("<Q", word))[0],
        "select": lambda truth, a, b: a if truth else b,
        "nonzero": lambda word: word != 0,
        "word_add": lambda a, b: (a + b) % 2**64,
        "word_mul": lambda a, b: a * b % 2**64,
        "word_and": operator.and_,
        "word_or": operator.or_,
        "word_xor": operator.xor,
        "shl": lambda a, b: (a << b) % 2**64,
        "lshr": operator.rshift,
    }

    def do(self, operation, *operands):
        return self.operations[operation](*operands)

    def constant(self, value):
        return float(value)

    def word(self, value):
        return value


def test_every_bit_is_that_of_exact_arithmetic_rounded_once_an_operation():
    keys = some_keys(100)
    exact = ExactMachine()
    expected = [pair(*(MachineWord(exact, int(word)) for word in (*key, 1))) for key in zip(*keys, strict=True)]
    assert one_by_one(*keys, 4)[:, 2:].tolist() == [[first.value, second.value] for first, second in expected]


def lines(width):
    """A writer of IR that has no graph."""
    return Emission(Graph((), ()), width, True, "v", lambda emission, place: "")


def function_of_normals(width, entries):
    """IR of a function (seeds, runs, steps, out), all pointers, of one vector of keys."""
    w = lines(width)
    keys = (w.line(f"load {w.integers}, ptr %{name}, align 8") for name in ("seeds", "runs", "steps"))
    for i, name in enumerate(normals_on(w, *keys, entries)):
        place = w.line(f"getelementptr {w.type}, ptr %out, i64 {i}")
        w.lines.append(f"  store {w.type} {name}, ptr {place}, align 8")
    head = "define void @workbench_normals(ptr %seeds, ptr %runs, ptr %steps, ptr %out) {"
    return "\n".join([f"declare {w.type} @llvm.sqrt.v{width}f64({w.type})", head, *w.lines, "  ret void", "}"])


def compiled(llvm, ir, processor):
    """The engine that holds the function, for this processor or for the plainest of its family."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    cpu = {"cpu": llvm.get_host_cpu_name(), "features": llvm.get_host_cpu_features().flatten()}
    machine = llvm.Target.from_default_triple().create_target_machine(
        opt=2, jit=True, **(cpu if processor == "this one" else {})
    )
    module = llvm.parse_assembly(ir)
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    module.verify()
    engine = llvm.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    return engine


KEYS = some_keys(400)


@pytest.fixture(scope="module")
def from_arrays():
    return one_by_one(*KEYS, 5)


@pytest.mark.parametrize("processor", heavy_but(["this one", "the plainest"], "this one"))
@pytest.mark.parametrize("width", [1, 4, 8])
def test_the_lanes_hold_the_bits_of_the_arrays(width, processor, from_arrays):
    llvm = pytest.importorskip("llvmlite.binding")  # there is no wheel of it for some platforms
    count, entries = from_arrays.shape
    engine = compiled(llvm, function_of_normals(width, entries), processor)
    address = engine.get_function_address("workbench_normals")
    call = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4)(address)
    out = np.empty((count // width, entries, width))
    for i, made in enumerate(out):
        call(*(key[i * width :].ctypes.data for key in KEYS), made.ctypes.data)
    from_lanes = out.transpose(0, 2, 1).reshape(-1, entries)
    assert np.array_equal(from_lanes.view(np.uint64), from_arrays.view(np.uint64))


def test_the_lanes_know_only_operations_that_round_in_one_way():
    w = lines(8)
    normals_on(w, "%seed", "%runs", "%step", 3)
    operations = {line.split()[2] if "call" not in line else line.split()[6].split("(")[0] for line in w.lines}
    whole = {"add", "mul", "and", "or", "xor", "shl", "lshr", "icmp", "bitcast", "select"}
    assert operations == whole | {"fadd", "fsub", "fmul", "fdiv", "@llvm.sqrt.v8f64"}
    assert not any(flag in line for line in w.lines for flag in ("fast", "contract", "reassoc", "arcp", "afn"))
