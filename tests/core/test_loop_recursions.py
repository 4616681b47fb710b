"""Loops on paper: a recursion with its index and number of passes, whatever the number of passes is."""

from fractions import Fraction

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from workbench.core.notation import latex, mathml, text, typst_math
from workbench.core.notation.build import substitute
from workbench.core.notation.formula import Cases, Matrix, Number, Relation, Symbol

X, V = ca.SX.sym("x"), ca.SX.sym("v")


def lines(expression, names=None):
    return text.emit(wb.notation.formula_of(expression, names or {})).splitlines()


@pytest.mark.parametrize("count", [2, 500])
def test_a_loop_is_printed_once_with_its_index_and_its_number_of_passes(count):
    (end,) = wb.bounded_loop(count, lambda c: (c / 2 + X / c,), V)
    assert lines(end + 1) == [
        "c_0 = v",
        "c_i+1 = 1/2*c_i + x/c_i",
        f"i = 0, ..., {count - 1}",
        f"f = c_{count} + 1",
    ]


def test_a_backward_loop_runs_to_pass_zero_and_another_loop_reads_what_it_made():
    _, K = wb.bounded_loop(9, lambda P, r: (P * X + r, P + r), X**2, ca.SX.sym("r", 1, 9), backward=True)
    end, _ = wb.bounded_loop(9, lambda c, k: (ca.vertcat(c[0] + k * c[1], c[1] * V), c[0]), ca.vertcat(X, V), K)
    assert lines(end[0]) == [
        "c_9 = x^2",
        "[[c_tilde_0, c_tilde_1, c_tilde_2, ..., c_tilde_8]] = [[r_0, r_1, r_2, ..., r_8]]",
        "c_i = c_i+1*x + c_tilde_i",
        "c_bar_i = c_i+1 + c_tilde_i",
        "i = 8, ..., 0",
        "s_1_0 = x",
        "s_2_0 = v",
        "s_1_i+1 = s_1_i + c_bar_i*s_2_i",
        "s_2_i+1 = s_2_i*v",
        "s_bar_i = s_1_i",
        "i = 0, ..., 8",
        "f = s_1_9",
    ]


def test_a_loop_inside_a_loop_has_an_index_of_its_own():
    def outer(c):
        (end,) = wb.bounded_loop(3, lambda d: (d * X,), c)
        return (end + 1,)

    assert lines(wb.bounded_loop(5, outer, V)[0]) == [
        "c_0 = v",
        "s_0 = c_i",
        "s_j+1 = s_j*x",
        "j = 0, ..., 2",
        "c_i+1 = s_3 + 1",
        "i = 0, ..., 4",
        "f = c_5",
    ]


def test_a_letter_of_the_equation_is_not_taken_for_a_loop():
    (end,) = wb.bounded_loop(4, lambda c: (c * X,), V)
    assert lines(end, {"x": "c", "v": "s_1"})[1] == "v_i+1 = v_i*c"


def predictive_law():
    plant = wb.CartPole()
    model = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(4), at_rest=True)
    weights = np.diag([10.0, 1.0, 10.0, 1.0]), [[0.1]]
    design = wb.predictive_design(model, 0.02, *weights, 20, limits={"F": (-3.0, 3.0)}, sweeps=7, modes=2)
    return wb.ModelPredictive.of(plant, design)


def nonlinear_law():
    plant = wb.CartPole()
    model = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(4), at_rest=True)
    weights = np.diag([10.0, 1.0, 10.0, 1.0]), [[0.1]]
    design = wb.nonlinear_predictive_design(model, 0.02, *weights, 20, limits={"F": (-3.0, 3.0)}, sweeps=7)
    return wb.NonlinearPredictive.of(plant, design)


@pytest.mark.parametrize("law", [predictive_law(), nonlinear_law()], ids=["linear", "nonlinear"])
def test_a_predictive_law_is_printed_on_a_few_pages_with_its_stages_and_sweeps(law):
    parts = (wb.Signals(layout.view(layout.symbols())) for layout in (law.memory, law.reads))
    command = law.command(0.0, *parts, wb.Signals())
    printed = lines(law.drives.flatten(command))
    assert len(printed) < 250
    assert any(line.endswith(" = 0, ..., 19") for line in printed)  # stages
    assert any(line.endswith(" = 0, ..., 6") for line in printed)  # sweeps


def test_each_markup_writes_the_next_pass():
    (end,) = wb.bounded_loop(6, lambda c: (c * X,), V)
    formula = wb.notation.formula_of(end, {})
    assert "c_{i+1}" in latex.emit(formula)
    assert "c_(i + 1)" in typst_math.emit(formula)
    assert "<mi>i</mi><mo" in mathml.emit(formula)


def test_a_call_that_is_no_loop_is_refused_by_its_name():
    square = ca.Function("square", [X], [X**2], {"never_inline": True})
    with pytest.raises(ValueError, match="no way to write a call of the function 'square'"):
        wb.notation.formula_of(square.call([V])[0], {})


def test_a_symbol_is_replaced_in_matrices_and_in_conditions():
    a, b = Symbol("a"), Symbol("b")
    one = Number(Fraction(1))
    formula = Matrix(((a, one), (Cases(((one, Relation(a, "<", one)),), a), a)))
    assert substitute(formula, {a: b}) == Matrix(((b, one), (Cases(((one, Relation(b, "<", one)),), b), b)))
