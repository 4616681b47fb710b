"""The structure that proofs of robot control lean on."""

from dataclasses import replace
from fractions import Fraction

import casadi as ca
import numpy as np
import pytest

from studies.paper.printed_arm import PrintedArm
from tests.support.arms import random_arm
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import paper_arm, robot
from workbench.arms.properties import eigenvalues, eigenvalues_along, positive_definite, skew, symmetric
from workbench.core import Entry, Layout
from workbench.proofs import bounds
from workbench.proofs.bounds import extreme_eigenvalue

PAPER = Dynamics.of(PrintedArm())
DERIVED = Dynamics.of(paper_arm())


@pytest.mark.parametrize("joints", [1, 2, 3, 4])
def test_m_dot_minus_two_c_of_a_derived_arm_is_proved_skew(joints):
    verdict = skew(Dynamics.of(robot(f"planar-{joints}r")))
    assert verdict.kind == "proved"
    assert verdict.witness is None


@pytest.mark.parametrize("joints", [1, 2, 3, 4])
def test_m_of_a_derived_arm_is_proved_symmetric(joints):
    assert symmetric(Dynamics.of(robot(f"planar-{joints}r"))).kind == "proved"


def test_the_printed_c_is_refuted_with_a_state_and_its_residual():
    verdict = skew(PAPER)
    assert verdict.kind == "refuted"
    assert str(verdict.witness) == "q = (0.5, 1), qd = (1, -1), nominal parameters"
    # by hand: N12 + N21 = 2 M12' - 2 (C12 + C21), with M12' = C21 = sin 1 and C12 = 1 + cos 1
    np.testing.assert_allclose(verdict.residual, -2 * (1 + np.cos(1.0)) * np.array([[0, 1], [1, 0]]), rtol=1e-14)


def test_the_repaired_c_is_proved_skew():
    assert skew(Dynamics.of(PrintedArm(coriolis="repaired"))).kind == "proved"


def test_another_factorisation_of_the_same_torque_need_not_be_skew():
    d, swap = DERIVED, ca.SX(DERIVED.C)
    swap[0, 0] += d.qd[1]
    swap[0, 1] -= d.qd[0]
    assert skew(replace(d, C=swap)).kind == "refuted"


def test_an_unsymmetric_m_is_refuted():
    M = ca.SX(DERIVED.M)
    M[0, 1] += ca.sin(DERIVED.q[0])
    verdict = symmetric(replace(DERIVED, M=M))
    assert verdict.kind == "refuted"
    np.testing.assert_allclose(verdict.residual, np.sin(0.5) * np.array([[0, 1], [-1, 0]]), rtol=1e-14)


def test_a_fault_that_hides_at_nominal_parameters_is_refuted_at_others():
    d, C = DERIVED, ca.SX(DERIVED.C)
    C[0, 1] += d.symbols[0] - d.symbols[2]  # m1 - m2, which are equal in the paper
    verdict = skew(replace(d, C=C))
    assert verdict.kind == "refuted"
    assert verdict.witness.changed_parameters


def test_what_the_normal_form_cannot_hold_is_said_to_be_open():
    d, C = DERIVED, ca.SX(DERIVED.C)
    u = 2 + ca.cos(d.q[1])
    C[0, 1] += ca.exp(2 * ca.log(u)) - u**2  # zero, but of no trigonometric polynomial
    verdict = skew(replace(d, C=C))
    assert verdict.kind == "not refuted"
    assert "400 samples" in verdict.evidence


@pytest.mark.parametrize("left", [ca.SX(0.1) * 3 - 0.3, 1e-10])  # 6e-17 is what folding of constants leaves
def test_an_identity_that_rounding_may_have_spoilt_is_not_called_proved(left):
    C = ca.SX(DERIVED.C)
    C[0, 1] += left * DERIVED.qd[0]
    assert skew(replace(DERIVED, C=C)).kind == "not refuted"


def test_a_fault_in_a_small_entry_does_not_hide_behind_a_large_one():
    q, qd = DERIVED.q, DERIVED.qd
    large = ca.diag(ca.vertcat(1e13 * (2 + ca.cos(q[1])), 1))
    C = ca.SX.zeros(2, 2)
    C[0, 0], C[0, 1], C[1, 0] = (-5e12 * ca.sin(q[1]) * rate for rate in (qd[1], qd[0], -qd[0]))
    arm = replace(DERIVED, M=large, C=C)
    assert skew(arm).kind == "proved"
    C[1, 1] = 0.05 * qd[0]
    assert skew(replace(arm, C=C)).kind != "proved"


def fixed(M: ca.SX, **numbers: float) -> Dynamics:
    """A mass matrix with parameters of its own."""
    layout = Layout(tuple(Entry(name, value) for name, value in numbers.items()))
    q, qd = DERIVED.q, DERIVED.qd
    return Dynamics("odd", q, qd, M, ca.SX.zeros(2, 2), ca.SX.zeros(2, 1), layout, layout.symbols())


@pytest.fixture
def brief(monkeypatch):
    """A tenth of the boxes: what rounding would prove, it proves at the first of them."""
    monkeypatch.setattr(bounds, "WORK", bounds.WORK // 10)


# with a function that has no normal form, intervals do the work
@pytest.mark.parametrize("outside", [0.0, pytest.param(1.0, marks=pytest.mark.heavy)])
def test_nominal_parameters_are_not_rounded_before_the_proof(brief, outside):
    # exactly I - m l^2 = -8e-17 in these doubles, which floating point makes 4e-16
    inertia, mass, length = Fraction(3.1827), Fraction(0.75), Fraction(2.06)
    assert inertia - mass * length**2 < 0 < 3.1827 - 0.75 * 2.06**2
    arm = fixed(ca.SX.eye(2), I=3.1827, m=0.75, l=2.06)
    body = arm.symbols[0] - arm.symbols[1] * arm.symbols[2] ** 2
    M = ca.diag(ca.vertcat(body, 1 + outside * ca.tanh(arm.q[0]) ** 2))
    assert positive_definite(replace(arm, M=M)).kind != "proved"


@pytest.mark.parametrize("outside", [0.0, pytest.param(1.0, marks=pytest.mark.heavy)])
def test_numbers_that_cancel_are_not_swallowed_before_the_proof(brief, outside):
    arm = fixed(ca.SX.eye(2), a=1e16, b=1.0)
    a, b = arm.symbols[0], arm.symbols[1]  # (a - b) - a + 0.5 is -0.5, and 0.5 in doubles
    M = ca.diag(ca.vertcat((a - b) - a + 0.5, 1 + outside * ca.tanh(arm.q[0]) ** 2))
    assert positive_definite(replace(arm, M=M)).kind != "proved"


def test_the_extreme_eigenvalues_of_the_paper_arm_are_those_of_the_stretched_arm():
    verdict = positive_definite(DERIVED)
    # M(q2 = 0) = [[5, 2], [2, 1]] has 3 -+ 2 sqrt 2; the eigenvalue itself carries a rounding of alpha2
    assert verdict.alpha1 == pytest.approx(3 - np.sqrt(8), abs=1e-14)
    assert verdict.alpha2 == pytest.approx(3 + np.sqrt(8), abs=1e-14)
    assert verdict.q_least[1] == verdict.q_greatest[1] == 0.0
    assert verdict.kind == "proved"
    assert "over q2 in [-3.142, 3.142], and none below 0.171572873" in verdict.evidence


def test_alpha1_and_alpha2_of_the_paper_arm_are_proved_on_the_torus_to_six_digits():
    verdict = positive_definite(DERIVED)
    low, high = verdict.beyond
    # the tolerance is 1e-8 of each; a certificate beyond the exact value would be no certificate
    assert 3 - np.sqrt(8) - 1.001e-8 * 0.172 < low < 3 - np.sqrt(8)
    assert 3 + np.sqrt(8) < high < 3 + np.sqrt(8) + 1.001e-8 * 5.83
    assert min(verdict.digits) >= 6


@pytest.mark.parametrize("seed", range(8))
def test_the_bounds_over_any_band_of_the_second_joint_are_those_of_the_closed_form(seed):
    low, high = np.sort(np.random.default_rng(seed).uniform(-np.pi, np.pi, 2))
    verdict = positive_definite(DERIVED, np.array([-1.0, low]), np.array([1.0, high]))
    # the characteristic polynomial of M gives 2 + c -+ sqrt 2 (1 + c), c = cos q2: both extreme at the largest c
    c = 1.0 if low <= 0 <= high else max(np.cos(low), np.cos(high))
    exact = 2 + c - np.sqrt(2) * (1 + c), 2 + c + np.sqrt(2) * (1 + c)
    assert verdict.beyond[0] < exact[0] < exact[1] < verdict.beyond[1]
    np.testing.assert_allclose(verdict.beyond, exact, rtol=1.001e-8)  # the tolerance


@pytest.mark.parametrize("joints", [3, pytest.param(4, marks=pytest.mark.release)])
def test_the_bounds_of_longer_arms_are_proved_to_six_digits(joints):
    verdict = positive_definite(Dynamics.of(robot(f"planar-{joints}r")))
    assert verdict.kind == "proved"
    assert min(verdict.digits) >= 6


@pytest.mark.parametrize("seed", range(2))
def test_no_eigenvalue_of_a_random_arm_lies_beyond_what_is_proved(seed):
    d = Dynamics.of(random_arm(3, np.random.default_rng(seed)))
    verdict = positive_definite(d)
    assert verdict.kind == "proved"
    seen = eigenvalues(d, np.random.default_rng(9).uniform(-np.pi, np.pi, (20_000, 3)))
    assert verdict.beyond[0] <= verdict.alpha1 <= seen.min()
    assert verdict.beyond[1] >= verdict.alpha2 >= seen.max()


def test_a_mass_matrix_of_no_trigonometric_polynomial_is_proved_as_well():
    M = ca.SX(DERIVED.M)
    M[0, 0] += ca.tanh(DERIVED.q[1]) ** 2
    verdict = positive_definite(replace(DERIVED, M=M))
    q = np.linspace(-np.pi, np.pi, 10_001)
    seen = eigenvalues(replace(DERIVED, M=M), np.stack([0 * q, q], axis=1))
    assert verdict.kind == "proved"
    # the nearest points of that grid lie 3e-4 from an extreme, which is flat: 1e-7 of the value
    np.testing.assert_allclose(verdict.beyond, [seen.min(), seen.max()], rtol=1e-6)
    assert verdict.beyond[0] < seen.min() <= seen.max() < verdict.beyond[1]


def test_extremes_are_sought_in_the_box_that_is_asked_for():
    low, high = np.array([-1.0, 0.5]), np.array([1.0, 1.5])
    verdict = positive_definite(DERIVED, low, high)
    assert verdict.q_least[1] == verdict.q_greatest[1] == 0.5
    assert "over q2 in [0.5, 1.5]" in verdict.evidence
    np.testing.assert_allclose(verdict.alpha1, eigenvalues(DERIVED, np.array([[0.0, 0.5]]))[0, 0], rtol=1e-14)


def test_a_constant_matrix_whose_last_digit_cannot_be_had_is_bounded_without_it():
    M = ca.SX(ca.DM([[2.0, 0.3], [0.3, 1.0]]))
    least = extreme_eigenvalue(M, DERIVED.q, -1.0, 1.0, 1, tolerance=1e-16)
    exact = 1.5 - np.sqrt(0.34)  # the first of two proofs, within 30 %, is what remains
    assert 0.69 * exact < least.bound < exact


def test_an_arm_of_one_joint_needs_one_sample_of_each_kind():
    verdict = positive_definite(Dynamics.of(robot("planar-1r")))
    assert (verdict.alpha1, verdict.alpha2, verdict.samples) == (1 / 3, 1 / 3, 2)
    assert "M depends on no joint" in verdict.evidence


def test_a_mass_matrix_that_is_not_positive_definite_somewhere_is_refuted_with_the_place():
    M = ca.SX(DERIVED.M)
    M[1, 1] = 0.5 * DERIVED.symbols[2]
    broken = replace(DERIVED, M=M)
    verdict = positive_definite(broken)
    assert verdict.kind == "refuted"
    given = {"dynamics": broken}
    exec(verdict.witness.replay, given)  # the line that the witness prints
    # two roads to M round their last digits differently
    assert np.linalg.eigvalsh(given["M"])[0] == pytest.approx(verdict.alpha1, abs=1e-14)
    assert verdict.alpha1 < 0


def test_the_eigenvalues_over_one_joint_are_those_of_its_matrices():
    angles = np.linspace(-np.pi, np.pi, 7)
    along = eigenvalues_along(DERIVED, 2, angles)
    for angle, pair in zip(angles, along, strict=True):
        M = [[3 + 2 * np.cos(angle), 1 + np.cos(angle)], [1 + np.cos(angle), 1]]
        np.testing.assert_allclose(pair, np.linalg.eigvalsh(M), rtol=1e-13)


@pytest.mark.parametrize(
    ("call", "error", "says"),
    [
        (lambda: positive_definite(DERIVED, 1.0, -1.0), ValueError, "finite low < high; got 1.0 and -1.0"),
        (lambda: positive_definite(DERIVED, -np.inf, 1.0), ValueError, "finite low < high"),
        (lambda: eigenvalues_along(DERIVED, 0, np.zeros(1)), LookupError, "joints from 1 to 2; got 0"),
        (lambda: eigenvalues_along(DERIVED, 3, np.zeros(1)), LookupError, "got 3"),
        (
            lambda: positive_definite(replace(DERIVED, M=DERIVED.M / ca.sin(DERIVED.q[1]))),
            ValueError,
            "finite numbers all over the box; it has none at",
        ),
    ],
)
def test_what_cannot_be_judged_is_refused(call, error, says):
    with pytest.raises(error, match=says):
        call()
