"""The search for a run that breaks a claim, against equations whose worst run is known in closed form."""

import casadi as ca
import numpy as np
import pytest

from tests.support.counterexamples import ODE, RANGES, blow_up, late
from workbench.core import Claim
from workbench.core.claim import BlockClaim
from workbench.engine.metrics import ise, peak_error, rmse
from workbench.engine.metrics.contract import Integral
from workbench.proofs.claim_margins import Box, slope_of, violation
from workbench.proofs.falsify import Budget, RunSearch


def at_most(limit: float, *hypotheses: Claim) -> BlockClaim:
    return BlockClaim(Claim("x is small", f"x <= {limit}", "by hand", hypotheses, lambda y: limit - y["x"]))


def weak() -> Claim:
    return Claim("b is small", "|b| <= 0.25", "by hand", (), lambda y: 0.25 - ca.fabs(y["b"]))


def end(a: float, b: float, x0: float, t: float) -> float:
    """The solution in closed form."""
    return x0 * np.exp(-a * t) + b * (np.exp(-a * t) + a * np.sin(t) - np.cos(t)) / (a**2 + 1)


def test_the_worst_corner_of_a_box_is_found_to_all_digits():
    found = RunSearch(ODE, late(0.0), RANGES, 2.0, 0.01).search(1, Budget(16, 6, 3))
    assert found.worst.sought == {"x": 2.0, "b": 1.0}
    assert found.worst.value == pytest.approx(end(1.0, 1.0, 2.0, 2.0), abs=1e-8)  # RK4 at 5 ms


def test_a_claim_that_breaks_is_refuted_and_one_that_holds_is_not():
    worst = end(1.0, 1.0, 2.0, 2.0)
    assert RunSearch(ODE, late(worst - 0.01), RANGES, 2.0, 0.01).search(1, Budget(16, 6, 3)).kind == "refuted"
    held = RunSearch(ODE, late(worst + 0.01), RANGES, 2.0, 0.01).search(1, Budget(16, 6, 3))
    assert held.kind == "not refuted"
    assert held.worst.value == pytest.approx(-0.01, abs=1e-7)


def test_the_gradient_is_that_of_the_closed_form():
    target = late(0.0)
    hunt = RunSearch(ODE, target, RANGES, 2.0, 0.01)
    u = np.array([0.3, 0.8])
    slope = slope_of(hunt.violation_equation, violation(target.claim), hunt.box, u, 2.0, 0.01)
    # dx(2)/du: the box is 4 wide in x(0), 2 wide in b
    np.testing.assert_allclose(slope, [4 * np.exp(-2.0), 2 * end(1.0, 1.0, 0.0, 2.0)], rtol=1e-8)


def test_the_gradient_of_an_integral_is_that_of_its_quadrature():
    metric = Integral("area", "", "", lambda t, y: y["e"], lambda value, horizon: value)
    box = Box.of(ODE, {"x": (0.0, 1.0)})
    slope = slope_of(ODE, metric, box, np.array([0.5]), 1.0, 0.01)
    np.testing.assert_allclose(slope, [1 - np.exp(-1.0)], rtol=1e-9)  # of x0 (1 - e^-1)


def test_a_metric_of_what_the_equation_follows_has_the_gradient_of_its_error():
    box = Box.of(ODE, {"x": (0.5, 1.0)})
    slopes = [slope_of(ODE, metric, box, np.array([0.5]), 1.0, 0.01) for metric in (ise(), ise("e"))]
    assert slopes[0] == slopes[1] > 0


def test_gradients_finish_what_a_small_population_has_begun():
    rough = RunSearch(ODE, late(0.0), RANGES, 2.0, 0.01).search(3, Budget(8, 1, 0)).worst.value
    fine = RunSearch(ODE, late(0.0), RANGES, 2.0, 0.01).search(3, Budget(8, 1, 4)).worst.value
    assert rough < end(1.0, 1.0, 2.0, 2.0) - 1e-3
    assert fine == pytest.approx(end(1.0, 1.0, 2.0, 2.0), abs=1e-8)


def test_the_worst_of_a_metric_is_found_and_called_not_refuted():
    found = RunSearch(ODE, rmse("e"), {"x": (-2.0, 1.0)}, 1.0, 0.01).search(0, Budget(8, 6, 3))
    assert found.kind == "not refuted"
    assert found.worst.value == pytest.approx(2 * np.sqrt((1 - np.exp(-2.0)) / 2), abs=1e-8)


def test_a_run_that_breaks_a_hypothesis_does_not_count():
    found = RunSearch(ODE, at_most(9.0, weak()), RANGES, 2.0, 0.01).search(1, Budget(32, 10, 0))
    assert abs(found.worst.sought["b"]) <= 0.25
    assert 0 < found.admissible_runs < found.runs


def test_where_no_run_keeps_the_hypotheses_there_is_no_verdict():
    ranges = {"x": (-2.0, 2.0), "b": (0.5, 1.0)}
    found = RunSearch(ODE, at_most(-9.0, weak()), ranges, 1.0, 0.01).search(1, Budget(8, 2, 0))
    assert (found.kind, found.worst, found.admissible_runs) == ("not checkable", None, 0)
    assert found.why == "no run kept the hypotheses"


def test_a_run_that_escapes_is_the_worst_and_refutes_a_bound():
    claim = BlockClaim(Claim("bounded", "x <= 1000", "by hand", (), lambda y: 1000 - y["x"]))
    found = RunSearch(blow_up(), claim, {"x": (0.0, 3.0)}, 1.0, 1e-3).search(0, Budget(8, 4, 2))
    assert found.kind == "refuted"
    assert found.worst.value == np.inf
    assert found.worst.sought["x"] > 1
    assert found.diverged_runs > 0


def test_the_same_seed_finds_the_same_run():
    a, b = (RunSearch(ODE, late(0.0), RANGES, 2.0, 0.01).search(5, Budget(8, 3, 1)) for _ in range(2))
    assert a.worst == b.worst


def test_a_budget_too_small_for_a_trial_is_refused():
    with pytest.raises(
        ValueError, match=r"`Budget\(population=...\)` must be a whole number of members, .* at least 4; got 3"
    ):
        Budget(population=3)


def test_a_box_names_what_it_does_not_know_and_refuses_what_is_no_range():
    with pytest.raises(LookupError, match="There is no parameter and no state 'bb' in 'decay'"):
        Box.of(ODE, {"bb": (0, 1)})
    with pytest.raises(ValueError, match="finite ends, low <= high"):
        Box.of(ODE, {"b": (1.0, 0.0)})
    with pytest.raises(ValueError, match="'a' must be finite, with 0 <= value; got -1"):
        Box.of(ODE, {"a": (-1.0, 1.0)})
    with pytest.raises(ValueError, match="one range"):
        Box.of(ODE, {})


def test_a_target_without_a_margin_is_refused():
    with pytest.raises(ValueError, match="has none"):
        RunSearch(ODE, BlockClaim(Claim("rest", "it rests", "by hand")), RANGES, 1.0, 0.01).search(0)


def test_a_margin_that_is_not_a_number_is_refused_by_name():
    claim = BlockClaim(Claim("rooted", "sqrt(x) >= 0", "by hand", (), lambda y: ca.sqrt(y["x"])))
    with pytest.raises(ValueError, match="that of 'rooted' is none at some instant"):
        RunSearch(ODE, claim, {"x": (-1.0, 1.0)}, 1.0, 0.01).search(0, Budget(8, 1, 0))


def test_a_hypothesis_that_is_not_a_number_is_not_kept():
    rooted = Claim("rooted", "x has a root", "by hand", (), lambda y: ca.sqrt(y["x"]))
    found = RunSearch(ODE, at_most(9.0, rooted), {"x": (-1.0, 1.0)}, 1.0, 0.01).search(0, Budget(16, 4, 0))
    assert found.worst.sought["x"] >= 0
    assert found.admissible_runs < found.runs


def test_a_step_that_is_too_long_is_no_refutation():
    stiff = {"a": (400.0, 400.0), "x": (0.5, 1.0)}  # at 10 ms RK4 grows, at 5 ms it decays
    found = RunSearch(ODE, at_most(2.0), stiff, 10.0, 0.01).search(0, Budget(8, 1, 0))
    assert (found.kind, found.worst) == ("not checkable", None)
    assert found.diverged_runs == found.runs
    assert found.why.startswith("the step is too long")


@pytest.mark.parametrize("until", [1.0, 0.005])  # long enough to overflow, and not
def test_what_decays_and_diverges_at_both_steps_is_no_refutation(until):
    stiff = {"a": (1e5, 1e5), "x": (0.5, 1.0)}  # RK4 decays only below 2.785 / a = 28 us
    found = RunSearch(ODE, at_most(2.0), stiff, until, 1e-3).search(0, Budget(8, 1, 0))
    assert (found.kind, found.worst) == ("not checkable", None)
    assert found.why.startswith("the step is too long")


def test_a_violation_that_changes_much_with_the_step_is_no_refutation():
    # exact is x <= 1; RK4 rings to 0.5 h^4 a^4 / 12 and the like at a h = 3
    found = RunSearch(ODE, at_most(1.0), {"a": (300.0, 300.0), "x": (0.9, 1.0)}, 0.1, 0.01).search(0, Budget(8, 1, 0))
    assert found.kind != "refuted"


def test_metrics_without_a_gradient_are_left_to_the_population():
    assert slope_of(ODE, peak_error(), Box.of(ODE, RANGES), np.array([0.5, 0.5]), 1.0, 0.01) is None


def test_a_witness_keeps_its_verdict_in_as_few_decimals_as_show_it():
    hunt = RunSearch(ODE, late(0.0), {"x": (0.0, 1.23456), "b": (-1.0, 0.98765)}, 2.0, 0.01)
    found = hunt.search(1, Budget(16, 6, 3))
    short = hunt.shorten(found)
    assert found.worst.sought == pytest.approx({"x": 1.23456, "b": 0.98765}, rel=1e-15)
    # by hand: x(2) = 0.135 x(0) + 0.730 b, of which one decimal, 1.2 and 0.9, keeps 92 %, and two keep 99 %
    assert short.worst.sought == {"x": 1.23, "b": 0.98}
    assert short.kind == found.kind == "refuted"
    assert found.worst.value > short.worst.value > 0.95 * found.worst.value
    # the digits alone give it again
    assert hunt.at(short.worst.sought).value == short.worst.value


def test_a_witness_is_not_cut_where_that_breaks_a_hypothesis():
    narrow = Claim("b is narrow", "b >= 0.9876", "by hand", (), lambda y: y["b"] - 0.9876)
    hunt = RunSearch(ODE, at_most(0.5, narrow), {"x": (0.0, 1.0), "b": (0.98761, 0.98769)}, 2.0, 0.01)
    short = hunt.shorten(hunt.search(1, Budget(16, 6, 0)))
    assert short.worst.sought["b"] >= 0.9876
    assert hunt.at(short.worst.sought).excess <= 0


def test_a_run_is_told_whether_it_keeps_its_hypotheses():
    hunt = RunSearch(ODE, at_most(0.5, weak()), RANGES, 2.0, 0.01)
    assert hunt.at({"x": 2.0, "b": 0.2}).excess < 0
    assert hunt.at({"x": 2.0, "b": 0.3}).excess == pytest.approx(0.05)
    with pytest.raises(LookupError, match="no parameter and no state 'c'"):
        hunt.at({"c": 1.0})


def test_the_worst_run_of_another_search_is_refused():
    other = RunSearch(ODE, late(0.0), {"x": (-2.0, 2.0)}, 2.0, 0.01).search(1, Budget(8, 2, 0))
    with pytest.raises(LookupError, match="There is no 'b' among the 1 numbers of the worst run"):
        RunSearch(ODE, late(0.0), RANGES, 2.0, 0.01).shorten(other)
