from __future__ import annotations

from fractions import Fraction
from functools import partial
from typing import Any

import casadi as ca

from workbench.core.notation import formula, latex, mathml, normal_form, program, reader, text, typst_math
from workbench.core.notation.formula import Matrix, Number, Relation, Sum, Symbol


def calls() -> dict[str, Any]:
    q = ca.SX.sym("q")
    x, one, two = Symbol("x", "1"), Number(Fraction(1, 3)), Number(2.0)
    total = Sum((x, one))
    relation = Relation(x, "=", total)
    matrix = Matrix(((x, one), (two, total)))
    expression = ca.vertcat(q * ca.sin(q) + 2, ca.SX(1))
    dialect = program.Dialect({"fabs": "abs"}, frozenset({"while"}), 100)
    markups = {"latex": latex.emit, "text": text.emit, "mathml": mathml.emit, "typst_math": typst_math.emit}
    return {
        "Sum": partial(Sum, (x, one)),
        "Call": partial(formula.Call, "sin", (x,)),
        "Cases": partial(formula.Cases, ((x, Relation(x, "<", two)),), one),
        "Matrix": partial(Matrix, ((x, one), (two, total))),
        "System": partial(formula.System, (relation, relation)),
        "name_of": partial(formula.name_of, x),
        "symbols_of": partial(formula.symbols_of, ["a", "b"], {"a": x}),
        "equations": partial(formula.equations, x, matrix),
        **{f"{name}.emit": partial(emit, matrix, width=80) for name, emit in markups.items()},
        **{f"{name}.emit a relation": partial(emit, relation, width=80) for name, emit in markups.items()},
        "identifier": partial(program.identifier, x),
        "latex.display": partial(latex.display, [relation], width=80),
        "read": partial(reader.read, expression, {"q": x}),
        "read_shared": partial(reader.read_shared, expression, {"q": x}),
        "normal_forms": partial(normal_form.normal_forms, expression, {"q": Fraction(1)}),
        "to_formula": partial(normal_form.to_formula, expression, {"q": x}),
        "straight_line": partial(program.straight_line, {"M": expression}, {"q": "q_1"}, dialect),
        "Dialect": partial(program.Dialect, {"fabs": "abs"}, frozenset({"while"}), 100),
    }


def arguments() -> dict[str, Any]:
    return {}
