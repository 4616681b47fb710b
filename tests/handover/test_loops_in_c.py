"""A law with bounded loops on other machines: C that keeps its loops, Python, and single precision with its bound."""

import re
import runpy

import numpy as np
import pytest

import workbench as wb
from tests.support.c_runs import EACH_COMPILER, compiled, differing, needs_compiler, recorded
from tests.support.looped_laws import HORIZON, TRUTHS, predictive_loop
from workbench.handover.c99.c_files import c_code
from workbench.handover.programs.python_law import python_law
from workbench.handover.single.rounding_bounds import rounding_bound
from workbench.handover.single.single_precision import single_precision

PERIODS = 400


@pytest.fixture(scope="module")
def law():
    return predictive_loop().law(truths=TRUTHS)


@pytest.fixture(scope="module")
def run(law):
    """Readings, references, commands and memory of the loop."""
    return recorded(predictive_loop(), law, PERIODS, substeps=1)


@needs_compiler
@pytest.mark.parametrize("compiler", EACH_COMPILER)
def test_loops_in_c_have_the_bits_of_the_simulation(compiler, law, run, tmp_path):
    y, r, u, z = run
    code = c_code(law, "predictive")
    made, memory, flags = compiled(code, tmp_path, compiler)(y, r)
    assert not flags.any()
    assert differing(made, u) == differing(memory, z) == 0
    assert np.abs(u).max() == 3.0  # the limit acts


def test_a_loop_is_written_as_a_loop_and_its_arrays_are_in_the_state(law):
    code = c_code(law, "predictive")
    loops = re.findall(r"for \(int (pass_\d+) = (\d+); \1 (<|>=) (\d+); (?:\+\+|--)\1\)", code.source)
    assert sorted(loops) == [
        ("pass_1", "0", "<", "3"),
        ("pass_2", str(HORIZON - 1), ">=", "0"),
        ("pass_3", "0", "<", str(HORIZON)),
    ]
    assert re.search(r"double loop_room\[\d+\]; /\* of the loops of a call \*/", code.header)


def test_the_operations_of_a_call_are_counted_pass_by_pass(law):
    said = re.search(r"A call makes (\d+) sums, (\d+) products", c_code(law, "predictive").source)
    sums, products = map(int, said.groups())
    # of a stage: closed' p, K' w, B' p and the inverse; then K x, A x + B u; and what is made once, A - B K
    assert products == 3 * HORIZON * (16 + 4 + 4 + 1 + 4 + 16 + 4 + 1) + 16
    assert sums == 3 * HORIZON * (12 + 4 + 4 + 4 + 16 + 3) + 16


def test_python_has_the_bits_of_a_loop(law, run):
    y, _, u, _ = run
    space = {}
    exec(python_law(law), space)  # the module that a user would import
    machine = space["Law"]()
    commands = [machine.step(dict(zip(law.readings.names, row, strict=True)))["F"] for row in y.tolist()[:100]]
    assert differing(np.array(commands), u[:100, 0]) == 0


def test_single_precision_of_a_loop_stays_within_its_bound(law):
    rng = np.random.default_rng(3)
    y, z = rng.uniform(-0.3, 0.3, (40, 4)), rng.uniform(-0.2, 0.2, (40, law.memory.size))
    bound = rounding_bound(law, 0, z, y)
    after, u = single_precision(law, 0, z, y)
    assert bound.has_bound.all()
    assert np.all(np.abs(u - bound.u) <= bound.u_bound)
    assert np.all(np.abs(after - bound.z_next) <= bound.z_bound)
    assert (
        bound.u_bound.max() < 0.01 * 3.0
    )  # of the limit: errors grow with A and K, not with A - B K, in a running bound


def test_a_law_with_loops_is_stored_as_a_function_of_casadi(law, tmp_path):
    (file,) = wb.export(law, "casadi", tmp_path)
    stored = runpy.run_path(str(file))["law"]
    row = [np.linspace(-0.5, 0.5, port.size) for port in (law.memory, law.readings, law.references)]
    ours, theirs = (function(1, *row, law.parameters.default) for function in (law.F, stored))
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_array_equal(np.array(one), np.array(other))
