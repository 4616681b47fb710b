"""A bounded loop: the values of its passes, its derivatives, its name, and bad arguments."""

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.looped_laws import DrawnLoop, InCasadi, InPython, results
from workbench.core.bounded_loop import called_loop, operation_codes, operation_count


def counted(count, factor=2.0):
    x = ca.SX.sym("x")
    end, powers = wb.bounded_loop(count, lambda c: (factor * c * x, c), ca.SX(1))
    return ca.Function("f", [x], [end, powers])


@pytest.mark.parametrize("seed", range(12))
def test_a_drawn_loop_has_the_values_of_its_passes_in_python(seed):
    drawn, x, at = DrawnLoop(seed), ca.SX.sym("x", 3), [0.4, -1.3, 0.7]
    made = results(drawn, InCasadi(), [x[i] for i in range(3)])
    own = ca.Function("f", [x], [ca.vertcat(ca.SX(0, 1), *made)])(at).elements()
    np.testing.assert_allclose(own, results(drawn, InPython(), at), rtol=1e-12, atol=1e-12)  # of some 1000 roundings


def test_the_derivative_of_a_loop_is_that_of_its_closed_form():
    x = ca.SX.sym("x")
    end, _ = wb.bounded_loop(5, lambda c: (2.0 * c * x, c), ca.SX(1))
    slope = ca.Function("slope", [x], [ca.jacobian(end, x)])
    assert float(slope(0.3)) == pytest.approx(5 * 2.0**5 * 0.3**4, rel=1e-14)


def test_a_backward_loop_gives_each_row_the_place_of_the_row_that_it_read():
    rows = ca.SX(np.arange(4.0)[np.newaxis])
    end, sums = wb.bounded_loop(4, lambda c, r: (c + r, c + r), ca.SX(0), rows, backward=True)
    assert [float(v) for v in ca.Function("f", [], [sums])()["o0"].elements()] == [6.0, 6.0, 5.0, 3.0]
    assert float(ca.Function("f", [], [end])()["o0"]) == 6.0


def test_equal_loops_have_one_name_and_other_bodies_and_counts_have_others():
    def name(function):
        calls = [i for i in range(function.n_instructions()) if function.instruction_id(i) == ca.OP_CALL]
        return called_loop(function.instructions_sx()[calls[0]].which_function()).name

    names = [name(counted(*arguments)) for arguments in ((3,), (3,), (4,), (3, 2.5))]
    assert names[0] == names[1]
    assert len(set(names)) == 3


def test_operations_are_counted_pass_by_pass_or_as_they_are_written():
    written, passed = (operation_count(counted(100), of_passes) for of_passes in (False, True))
    assert passed - written == 99 * 6  # the body: two products, their two factors read, two results
    x = ca.SX.sym("x")
    (end,) = wb.bounded_loop(2, lambda c: (ca.fmax(c, x),), ca.SX(0))
    assert ca.OP_FMAX in operation_codes(ca.Function("f", [x], [end]))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0, lambda c: (c,), ca.SX(1)), r"`bounded_loop\(count=...\)` must be a positive whole number; got 0"),
        ((2, lambda c, r: (c,), ca.SX(1), ca.SX.zeros(1, 3)), r"a column for each of 2 passes; got the shape \(1, 3\)"),
        ((2, lambda c: c, ca.SX(1)), "must return a tuple, the next carried values and its columns"),
        ((2, lambda c: (ca.vertcat(c, c),), ca.SX(1)), "must return as many carried values as it takes, 1; got 2"),
    ],
)
def test_bad_loops_are_refused_in_one_sentence(arguments, message):
    with pytest.raises(ValueError, match=message):
        wb.bounded_loop(*arguments)


def test_a_loop_without_a_slope_has_the_slope_zero():
    x = ca.SX.sym("x", 2)

    def steps(c):
        return wb.bounded_loop(2, lambda d: (ca.floor(d),), c)[0]

    bodies = {
        "floor": (steps(x), np.zeros((2, 2))),
        "within a loop": (wb.bounded_loop(3, lambda c: (c + steps(c),), x)[0], np.eye(2)),
        "choice": (wb.bounded_loop(2, lambda c: (ca.if_else(c > 0, 1.0, 2.0),), x)[0], np.zeros((2, 2))),
    }
    at = np.array([0.7, -1.5])
    for expression, slope in bodies.values():
        J = ca.Function("J", [x], [ca.densify(ca.jacobian(expression, x))])
        np.testing.assert_array_equal(np.array(J(at)), slope)
    np.testing.assert_array_equal(np.array(ca.Function("f", [x], [steps(x)])([0.1, 1e300])).ravel(), [0.0, 1e300])
