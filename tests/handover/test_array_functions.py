"""Laws without memory as functions of arrays, in C, Python and CasADi."""

import ctypes
import subprocess
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from tests.support.digital_laws import motor_law
from tests.support.targets_here import needs_gcc
from workbench.core import Entry, Layout, SampledLaw
from workbench.handover.array_functions import array_functions

K, B, A = ca.SX.sym("k"), ca.SX.sym("b", 2), ca.SX.sym("A", 2, 3)
X, S, T = ca.SX.sym("x", 3), ca.SX.sym("s"), ca.SX.sym("t")
PARAMETERS = Layout((Entry("gain[0]", np.array(2.0)), Entry("b", np.array([0.5, -0.25]))))


def law(name="affine", reads=("A", "x", "s"), gives=("Y", "z"), **changes):
    """Y = [A x, b] and z = k sin(s), of a matrix, a vector and a number."""
    shapes = ((2, 3), (3,), ())
    law = SampledLaw(
        name=name,
        period=1.0,
        memory=Layout(),
        readings=Layout(tuple(Entry(*each) for each in zip(reads, map(np.zeros, shapes), strict=True))),
        references=Layout(),
        commands=Layout((Entry(gives[0], np.zeros((2, 2))), Entry(gives[1], np.array(0.0)))),
        parameters=PARAMETERS,
        k=T,
        z=ca.SX(0, 1),
        y=ca.vertcat(ca.vec(A), X, S),
        r=ca.SX(0, 1),
        p=ca.vertcat(K, B),
        command=ca.vertcat(ca.vec(ca.horzcat(A @ X, B)), K * ca.sin(S)),
        update=ca.SX(0, 1),
        notes=("Y = [A x, b].",),
    )
    return replace(law, **changes)


NOTES = ("a gain */ of k", 'b """', "b ??/")
MATRIX, VECTOR, NUMBER = np.arange(6.0).reshape(2, 3) + 0.1, np.array([1.0, -2.0, 0.5]), 0.7
WANTED = np.column_stack([MATRIX @ VECTOR, [0.5, -0.25]]), 2.0 * np.sin(0.7)
FLAT = [MATRIX.ravel(order="F"), VECTOR, np.array([NUMBER])]  # matrices lie column by column in a port


@pytest.mark.parametrize("form", ["python", "casadi"])
def test_a_module_gives_the_values_of_a_law(form, tmp_path):
    (tmp_path / "made.py").write_text(array_functions([law()], form, ["a line"], NOTES), encoding="utf-8")
    space = {"__name__": "made"}
    exec((tmp_path / "made.py").read_text(encoding="utf-8"), space)
    Y, z = space["affine"](*FLAT, *([space["NOMINAL"]] if form == "casadi" else []))
    np.testing.assert_allclose(np.array(Y), WANTED[0], rtol=1e-15)  # a sum of three products
    np.testing.assert_allclose(np.array(z).ravel(), WANTED[1], rtol=1e-15)


@needs_gcc
def test_a_file_in_c_gives_them_row_by_row(tmp_path):
    (tmp_path / "made.c").write_text(array_functions([law()], "c", ["a line"], NOTES, {"SIZE": 3}), encoding="utf-8")
    strict = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror", "-shared", "-fPIC"]
    subprocess.run(["gcc", *strict, "made.c", "-o", "made.so"], cwd=tmp_path, check=True, timeout=60)
    library, doubles = ctypes.CDLL(str(tmp_path / "made.so")), ctypes.POINTER(ctypes.c_double)
    nominal = np.array((ctypes.c_double * 3).in_dll(library, "workbench_nominal"))
    made = np.zeros(4), np.zeros(1)
    library.workbench_affine(*(x.ctypes.data_as(doubles) for x in (*FLAT, nominal, *made)))
    np.testing.assert_allclose(made[0], WANTED[0].ravel(), rtol=1e-15)
    np.testing.assert_allclose(made[1], WANTED[1], rtol=1e-15)
    assert "#define WORKBENCH_SIZE 3\n#define WORKBENCH_PARAMETERS 3\n" in (tmp_path / "made.c").read_text()


@pytest.mark.parametrize(
    ("laws", "notes", "sentence"),
    [
        ([], NOTES, "must be one law or more, with the same parameters"),
        ([law(), law("other", parameters=PARAMETERS.with_prefix("a."))], NOTES, "with the same parameters"),
        ([law()], NOTES[:2], "one line for each of the 3 numbers of the parameters; got 2"),
        ([motor_law().law()], ["a"] * motor_law().law().parameters.size, "must be laws without memory"),
        ([law(command=T * ca.vertcat(K, B, B))], NOTES, "must be laws without memory, references and time"),
        ([law(reads=("A", "x", "np"))], NOTES, "a different name .* 'affine' has 'np'"),
        ([law(reads=("A", "x", "sine"))], NOTES, "'affine' has 'sine'"),
        ([law(reads=("A", "x", "lambda"))], NOTES, "'affine' has 'lambda'"),
        ([law(reads=("A", "x", "int"))], NOTES, "must be an identifier of C"),
        ([law(gives=("x", "z"))], NOTES, "'affine' has 'x'"),
    ],
)
def test_what_is_no_function_or_has_an_odd_name_is_refused(laws, notes, sentence):
    with pytest.raises(ValueError, match=sentence):
        array_functions(laws, "c", [], notes)


def test_another_form_is_refused_by_name():
    with pytest.raises(LookupError, match="There is no 'rust' among the 3 forms of functions"):
        array_functions([law()], "rust", [], NOTES)
