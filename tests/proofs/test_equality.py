"""Are two expressions equal? Proved, refuted at a plain point, or open."""

import casadi as ca
import numpy as np
import pytest

from workbench.proofs.equality import judge_equal

x, y = ca.SX.sym("x"), ca.SX.sym("y")


def test_an_identity_is_proved():
    assert judge_equal(ca.sin(x + y), ca.sin(x) * ca.cos(y) + ca.cos(x) * ca.sin(y)).kind == "proved"


def test_a_difference_is_refuted_at_a_plain_point_with_both_sides():
    found = judge_equal(x * y, x + y)
    assert found.kind == "refuted"
    assert found.point == {"x": 1.0, "y": 1.5}
    np.testing.assert_array_equal([found.left[0], found.right[0]], [1.5, 2.5])
    assert "x = 1, y = 1.5" in found.evidence


def test_a_difference_of_one_entry_is_seen():
    assert judge_equal(ca.vertcat(x, y), ca.vertcat(x, y + x / 1000)).kind == "refuted"


def test_what_the_normal_form_cannot_hold_is_left_open():
    found = judge_equal(ca.exp(x + y), ca.exp(x) * ca.exp(y))
    assert found.kind == "not refuted"
    assert "64 samples" in found.evidence
    assert "not proved" in found.evidence


def test_a_rounding_is_no_difference_and_points_without_a_value_are_passed_over():
    found = judge_equal(ca.exp(ca.log(x)), x)
    assert found.kind == "not refuted"
    assert "64 samples" not in found.evidence  # half of the points are negative


def test_two_shapes_are_refused():
    with pytest.raises(ValueError, match="compares equal shapes"):
        judge_equal(ca.vertcat(x, y), x)


def test_what_rounding_makes_of_terms_that_cancel_refutes_nothing():
    # |x^2 + 1e12| - 1e12 = x^2, but 1e12 has a last place of 1e-4
    found = judge_equal(ca.sqrt((x * x + 1e12) ** 2) - 1e12, x * x)
    assert found.kind == "not refuted"
    assert judge_equal(ca.sqrt((x * x + 1e12) ** 2) - 1e12, x * x + 1).kind == "refuted"
