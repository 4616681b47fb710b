"""The table of operations: every language spells every row that it must, and none that has no row."""

import re

import casadi as ca
import numpy as np
import pytest

from tests.house.sources import ROOT
from workbench.engine.kernel import llvm, webassembly
from workbench.engine.kernel.casadi_to_graph import OPERATIONS as READ
from workbench.engine.kernel.graph import CONSTANT_FOLDS, LEVELS
from workbench.engine.machines import (
    c_elementary_functions,
    c_primitives,
    c_spelling,
    formula_table,
    llvm_spelling,
    numpy_spelling,
    python_elementary_functions,
    python_spelling,
    webassembly_spelling,
)
from workbench.engine.machines.operations import OPERATIONS, Kind, Role, with_role
from workbench.handover.single.loop_bounds import ALL_RULES

MACHINE, NODE, SHORT, FUNCTION, PROGRAM = (set(with_role(role)) for role in Role)
IN_PYTHON = {*python_spelling.SPELLING, *python_elementary_functions.NAMES, *python_elementary_functions.TURNS}
IN_C = {*c_spelling.SPELLING, *c_primitives.PRIMITIVES, *c_primitives.HARDWARE, *c_elementary_functions.ABOUT}
PAGE = (ROOT / "workbench/report/templates/live/tables.js").read_text(encoding="utf-8")
IN_A_PAGE = re.findall(r"^  (\w+): ", PAGE[PAGE.index("PROGRAM_OPERATIONS = {") : PAGE.index("};")], re.MULTILINE)
# What each language must have; what it has beside that is no operation of the table.
LANGUAGES = {
    "LLVM": (MACHINE, llvm_spelling.SPELLING),
    "a browser": (MACHINE - {"fma"}, webassembly_spelling.SPELLING),
    "NumPy": (MACHINE | PROGRAM, numpy_spelling.SPELLING),
    "NumPy in single precision": ((MACHINE | PROGRAM) - {"fma"}, numpy_spelling.IN_SINGLE),
    "C": (MACHINE | SHORT | FUNCTION, IN_C),
    "Python": (
        MACHINE | SHORT | FUNCTION,
        {*python_spelling.SPELLING, *python_elementary_functions.NAMES, *python_elementary_functions.TURNS},
    ),
    "a page": (PROGRAM, IN_A_PAGE),
    "formulas in double": (NODE, {*formula_table.IN_DOUBLE.formulas, *formula_table.QUARTERS}),
    "formulas in single": (NODE, {*formula_table.IN_SINGLE.formulas, *formula_table.QUARTERS}),
    "bounds of rounding": (NODE - {"barrier"}, ALL_RULES),  # a law has no barriers
}
BESIDE = {"finite", "defined", "turn"}  # of C: checks of results, and the pair of sine and cosine


def lacking(name):
    must, has = LANGUAGES[name]
    return sorted(must - set(has)), sorted(set(has) - must - BESIDE)


@pytest.mark.parametrize("name", LANGUAGES)
def test_a_language_spells_each_operation_of_the_table_and_no_other(name):
    missing, unknown = lacking(name)
    assert not missing, f"{name} lacks {', '.join(missing)}: write a line for each"
    assert not unknown, f"{name} spells {', '.join(unknown)}, which the table does not have"


def test_a_row_without_its_line_is_named(monkeypatch):
    monkeypatch.setitem(LANGUAGES, "LLVM", (MACHINE | {"cbrt"}, llvm_spelling.SPELLING))
    assert lacking("LLVM") == (["cbrt"], [])


def test_a_spelling_has_a_place_for_each_operand():
    texts = {
        "LLVM": llvm_spelling.instructions(4),
        "Python": python_spelling.SPELLING,
        "C": {name: form.text for name, form in c_spelling.SPELLING.items()},
    }
    for language, spelling in texts.items():
        for name, text in spelling.items():
            places = re.findall(r"\{\d?\}", text)
            assert len(set(places) if "{0}" in places else places) == len(OPERATIONS[name].operands), (language, name)


def test_numpy_gives_the_kind_of_result_that_the_table_says():
    kinds = {Kind.NUMBER: np.float64, Kind.TRUTH: np.bool_, Kind.WORD: np.uint64}
    given = {Kind.NUMBER: np.array([1.5, 2.0]), Kind.TRUTH: np.array([True, False]), Kind.WORD: np.uint64([3, 0])}
    for name, function in numpy_spelling.SPELLING.items():
        row = OPERATIONS[name]
        assert np.asarray(function(*(given[kind] for kind in row.operands))).dtype == kinds[row.result], name


def test_a_formula_gives_the_kind_of_result_that_the_table_says():
    machine = numpy_spelling.Arrays(fused_products=False)
    given = {
        Kind.NUMBER: formula_table.MachineNumber(machine, np.array([0.5, 0.25])),
        Kind.TRUTH: formula_table.MachineTruth(machine, np.array([True, False])),
    }
    for name in NODE:
        row = OPERATIONS[name]
        with np.errstate(all="ignore"):
            made = formula_table.IN_DOUBLE.of(name, *(given[kind] for kind in row.operands))
        assert isinstance(
            made, formula_table.MachineTruth if row.result is Kind.TRUTH else formula_table.MachineNumber
        ), name


def test_a_symmetric_operation_has_one_result_in_both_orders():
    draws = np.random.default_rng(0).normal(size=(2, 200)).round(1)
    truths = draws > 0
    for name in (name for name, row in OPERATIONS.items() if row.symmetric):
        a, b = truths if OPERATIONS[name].operands[0] is Kind.TRUTH else draws
        function = numpy_spelling.SPELLING[name]
        np.testing.assert_array_equal(function(a, b), function(b, a), err_msg=name)


def test_every_operation_of_casadi_that_is_read_has_a_row_and_every_folded_one_too():
    assert set(READ.values()) <= NODE
    assert set(CONSTANT_FOLDS) <= NODE
    assert not set(LEVELS) & set(OPERATIONS), "a source of a graph is no operation"
    assert READ[ca.OP_SIN] == "sin"


@pytest.mark.parametrize("name", sorted(webassembly_spelling.SPELLING))
def test_a_browser_needs_no_library_for_an_operation(name):
    row, width = OPERATIONS[name], webassembly_spelling.WIDTH
    types = {kind: f"<{width} x {text}>" for kind, text in zip(Kind, ("double", "i1", "i64"), strict=True)}
    arguments = ", ".join(f"{types[kind]} %a{i}" for i, kind in enumerate(row.operands))
    line = webassembly_spelling.SPELLING[name].format(*(f"%a{i}" for i in range(len(row.operands))))
    function = f"define {types[row.result]} @f({arguments}) {{\n  %r = {line}\n  ret {types[row.result]} %r\n}}"
    ir = "\n".join([*llvm_spelling.declarations(width), function])
    code = llvm.object_for(ir, webassembly_spelling.TRIPLE, webassembly_spelling.FEATURES)
    assert webassembly.callable_module(code)
