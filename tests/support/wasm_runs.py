"""The part of a browser: marches of the data of a live page, in a WebAssembly runtime."""

import base64
import zlib

import numpy as np
import pytest

pytest.importorskip("llvmlite", reason="nothing is compiled for a browser without llvmlite")
wasmtime = pytest.importorskip("wasmtime")

STEPS = 2000  # that share a table of time


def unpacked(text):
    """A module of a page as bytes."""
    return zlib.decompress(base64.b64decode(text), wbits=-15)


class Kernel:
    """A march of a page, in a memory of its own; `record` has the recorded numbers (N, nd) of its steps."""

    def __init__(self, code, march, rows, record=None):
        self.march, self.record = march, record
        sizes = {
            "runs": 1,
            "constants": len(march["constants"]),
            "p": len(march["parameters"]),
            "scratch": march["lanes"],
            "table": march["table"] * STEPS,
            "x": march["states"],
            "out": march["states"] * rows,
            "record": 0 if record is None else record.size,
        }
        self.at, end = {}, 1024
        for name, size in sizes.items():
            self.at[name] = end
            end += (8 * size + 63) // 64 * 64
        self.store = wasmtime.Store()
        pages = wasmtime.MemoryType(wasmtime.Limits(end // 65536 + 1, None))
        self.memory = wasmtime.Memory(self.store, pages)
        module = wasmtime.Module(self.store.engine, code)
        self.functions = wasmtime.Instance(self.store, module, [self.memory]).exports(self.store)

    def run(self, p, x0, rows, begin=0, stride=None, seed=0):
        """The states (rows, nx) behind x0, every `stride` steps, with all parameters p of the loop."""
        march, at = self.march, self.at
        stride = stride or march["stride"]
        p = np.asarray(p, dtype=float)[march["parameters"]]
        for name, numbers in {"constants": march["constants"], "p": p, "x": x0}.items():
            self.memory.write(self.store, np.array(numbers, dtype=float).tobytes(), at[name])
        self.memory.write(self.store, bytes(8), at["runs"])  # run 0
        arrays = [at[name] for name in ("runs", "constants", "p", "scratch", "table", "x", "out")]
        if self.record is not None:
            self.memory.write(self.store, np.ascontiguousarray(self.record).tobytes(), at["record"])
        for row in range(rows):
            for past in range(0, stride, STEPS):
                steps, k = min(STEPS, stride - past), begin + row * stride + past
                if march["table"]:
                    self.functions["workbench_table"](self.store, steps, k, at["constants"], at["p"], at["table"])
                here = [] if self.record is None else [at["record"] + 8 * k * self.record.shape[1]]
                self.functions["workbench_piece"](self.store, 1, 1, steps, k, row, rows, seed, *arrays, *here)
        end = at["out"] + 8 * rows * march["states"]
        return np.frombuffer(self.memory.read(self.store, at["out"], end), float).reshape(rows, -1).copy()
