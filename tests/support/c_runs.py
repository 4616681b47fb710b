"""A law in C, compiled here and called with recorded readings; and the recording, made by the simulation."""

import ctypes
import shutil
import subprocess

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.cases import heavy_but
from workbench.core import Entry, Layout

COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]
EACH_COMPILER = heavy_but(COMPILERS, *COMPILERS[:1])
needs_compiler = pytest.mark.skipif(not COMPILERS, reason="no C compiler here: apt-get install gcc")
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-std=c99", "-Werror")


def recorded(sampled, law, periods, substeps=4, seed=1, arithmetic="portable"):
    """Readings, references, commands and memory (N, ...) of a run in the portable arithmetic, or another one."""
    step, taken = sampled.step(substeps), sampled.computer_input_values
    layout = Layout(tuple(Entry(name, np.zeros(part.numel())) for name, part in taken.items()))
    symbols, parts = ca.SX.sym("taken", layout.size), [ca.vec(part) for part in taken.values()]
    step = step.with_memory(layout, symbols, ca.vertcat(*parts))
    run = wb.simulate(step, until=periods * sampled.period, arithmetic=arithmetic, seed=seed)
    x = run.x[0, 1:]

    def of(names):
        return np.concatenate([x[:, step.states.slice(name)] for name in names] + [np.zeros((len(x), 0))], axis=1)

    y = of(f"y.{name}" for name in law.readings.names)
    r = of(f"r.{name}" for name in law.references.names)
    return y, r, of(f"hold.{name}" for name in law.commands.names), of(law.memory.names)


DRIVER = """
#include "{name}.c" /* one unit, so that a compiler starts once */
#include <string.h>
void drive(int n, const {real} *y, const {real} *r, {real} *u, {real} *z, unsigned *flags)
{{
    {name}_state s;
    {name}_readings readings;
    {references}
    {name}_commands commands;
    (void)r; (void)z;
    {name}_init(&s);
    for (int i = 0; i < n; ++i) {{
        memcpy(&readings, y + i * {ny}, sizeof readings);
        {take}
        flags[i] = {name}_step(&s, &readings{given}, &commands);
        memcpy(u + i * {nu}, &commands, sizeof commands);
        {keep}
    }}
}}
"""


def compiled(code, folder, compiler=None, options=("-O1",)):
    """The law as a function of rows: y, r -> u, z, flags."""
    law, name = code.law, code.name
    code.write(folder)
    wanted = law.references.size > 0
    driver = DRIVER.format(
        name=name,
        real=code.real,
        ny=law.readings.size,
        nu=law.commands.size,
        references=f"{name}_references references;" if wanted else "",
        take=f"memcpy(&references, r + i * {law.references.size}, sizeof references);" if wanted else "",
        given=", &references" if wanted else "",
        keep=" ".join(f"z[i * {law.memory.size} + {i}] = s.{place};" for i, place in enumerate(places(law.memory))),
    )
    (folder / "drive.c").write_text(driver)
    library = folder / f"{name}.so"
    command = [
        compiler or COMPILERS[0],
        *options,
        "-std=c99",
        "-shared",
        "-fPIC",
        "drive.c",
        "-o",
        library,
        *(["-lm"] if code.hardware else []),
    ]
    subprocess.run(command, cwd=folder, check=True, timeout=60)
    call, dtype = ctypes.CDLL(str(library)).drive, np.float32 if code.real == "float" else np.float64

    def run(y, r):
        y, r = (np.ascontiguousarray(part, dtype=dtype) for part in (y, r))
        u, z = np.empty((len(y), law.commands.size), dtype), np.empty((len(y), law.memory.size), dtype)
        flags = np.zeros(len(y), np.uint32)
        call(len(y), *(part.ctypes.data_as(ctypes.c_void_p) for part in (y, r, u, z, flags)))
        return u, z, flags

    return run


def warned(compiler, folder, *files, optimised=True):
    """Refuse what a compiler warns of: GCC knows some of it only as it optimises, Clang all as it reads."""
    way = ("-O2", "-c") if compiler != "clang" and optimised else ("-fsyntax-only",)
    subprocess.run([compiler, *way, *WARNINGS, *files], cwd=folder, check=True, timeout=60)


def places(layout):
    """The members of the state for the numbers of a layout."""
    from workbench.handover.c99.c_names import places_of

    return places_of(layout)


def differing(a, b):
    """The number of entries that differ in a bit; two NaNs do not."""
    a, b = np.ascontiguousarray(a), np.ascontiguousarray(b)
    words = np.uint32 if a.dtype == np.float32 else np.uint64
    return int(((a.view(words) != b.view(words)) & ~(np.isnan(a) & np.isnan(b))).sum())
