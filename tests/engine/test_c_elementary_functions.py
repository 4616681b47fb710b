"""Elementary functions in C: the bits that they have on every other machine."""

import ctypes
import subprocess

import numpy as np
import pytest

from tests.support.c_runs import COMPILERS, differing, needs_compiler
from workbench.engine.machines.c_elementary_functions import Lines, definitions
from workbench.engine.machines.c_real import DOUBLE
from workbench.engine.machines.formula_table import IN_DOUBLE
from workbench.engine.machines.machine import MachineNumber
from workbench.engine.machines.numpy_spelling import Arrays
from workbench.engine.machines.operations import OPERATIONS, Role, with_role

FUNCTIONS = """
#include <stdbool.h>
#include <stdint.h>
{texts}
void each(int n, const double *a, const double *b, double *out)
{{
    (void)b;
    for (int i = 0; i < n; ++i) {{
        out[i] = {call};
    }}
}}
"""


@needs_compiler
@pytest.mark.parametrize("name", [*with_role(Role.FUNCTION), "sqrt", "floor", "copysign"])
def test_an_elementary_function_in_c_has_the_bits_of_every_machine(name, tmp_path):
    rng = np.random.default_rng(3)
    special = np.array(
        [0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan, 5e-324, 1e-310, 2.5, -2.5, 1e300, 4503599627370497.5]
    )
    a = np.concatenate([np.repeat(special, len(special)), rng.normal(0, 10, 20000), rng.uniform(0, 1e3, 5000)])
    a = np.concatenate([a, np.exp(rng.uniform(-700, 700, 5000))])
    b = np.concatenate([np.tile(special, len(special)), rng.normal(0, 3, len(a) - len(special) ** 2)])
    texts = definitions("x", DOUBLE, [name])
    call = f"x_{name}({', '.join(('a[i]', 'b[i]')[: len(OPERATIONS[name].operands)])})"
    (tmp_path / "f.c").write_text(FUNCTIONS.format(texts="\n".join(texts), call=call))
    options = ["-O2", "-std=c99", "-shared", "-fPIC", "-ffp-contract=off"]
    subprocess.run([COMPILERS[0], *options, "f.c", "-o", "f.so"], cwd=tmp_path, check=True, timeout=60)
    out = np.empty_like(a)
    address = [part.ctypes.data_as(ctypes.c_void_p) for part in (a, b, out)]
    ctypes.CDLL(str(tmp_path / "f.so")).each(len(a), *address)
    machine = Arrays(False)
    given = [MachineNumber(machine, part) for part in (a, b)][: len(OPERATIONS[name].operands)]
    with np.errstate(all="ignore"):
        expected = IN_DOUBLE.of(name, *given).value
    assert differing(out, expected) == 0


def test_the_machine_of_lines_writes_one_operation_a_line():
    machine = Lines(DOUBLE, "x")
    machine.do("add", "a", machine.constant(-0.5))
    assert machine.lines == ["const double v0 = a + (-0.5);"]
