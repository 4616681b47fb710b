"""The rooms that judge equations take what they can use, and name anything else in a sentence of their own."""

from fractions import Fraction

import casadi as ca
import numpy as np
import pytest

from tests.support.equations import decay
from workbench.arms.dynamics import Dynamics
from workbench.arms.identity_proofs import judge_zero
from workbench.arms.mechanics import robot
from workbench.arms.paper_equations.arm_letters import fix_parameters
from workbench.arms.properties import eigenvalues_along
from workbench.cli.derive import FORMS, text_of
from workbench.core import Claim
from workbench.core.claim import BlockClaim
from workbench.proofs.bounds import bound_text, enclose, extreme_eigenvalue
from workbench.proofs.claim_ledger import ClaimLedger
from workbench.proofs.claim_margins import Box, SignalsOf, with_violations
from workbench.proofs.counterexample import CounterExample
from workbench.proofs.differential_evolution import TrialValues, evolve
from workbench.proofs.exact_arithmetic import characteristic_polynomial, exact_values
from workbench.proofs.falsify import Budget, RunSearch
from workbench.proofs.rest_points import growing_modes, rest_point

ARM, ODE = Dynamics.of(robot("planar-1r")), decay()
X = ca.SX.sym("x", 2)
NONE = Claim("it holds", "It holds.", "a book", (), lambda signals: None)

REFUSED = [
    (lambda: enclose(X[0], 2 * X, 0, 1), r"`enclose\(symbols=...\)` must be a column of symbols"),
    (lambda: enclose(X[0], X, -1.7e308, 1.7e308), "finite low < high"),
    (lambda: enclose(X[0], X, 0, 1, boxes=0), r"`enclose\(boxes=...\)` must be a positive whole number"),
    (lambda: extreme_eigenvalue(X[0], X, 0, 1, 1, numbers={"x": "1"}), r"at \['x'\]"),
    (lambda: bound_text(0.1, 0), "1 for a bound from below or -1 for one from above; got 0"),
    (lambda: Box.of(ODE, {"x": (0.0, None)}), r"must give \(low, high\) for 'x'"),
    (lambda: Box.of(ODE, {"x": (0.0, 1.0)}).rows(np.zeros(3)), r"`Box.rows\(theta=...\)` must be a matrix"),
    (lambda: ClaimLedger.of([(NONE, lambda: True)]), "`The check of 'it holds'` must be a `Ruling`; got True"),
    (lambda: evolve(lambda u: u, 1, 4, 1, np.random.default_rng(1)), "must be a `TrialValues`; got an array"),
    (lambda: evolve(lambda u: TrialValues(np.ones(1), np.ones(1)), 1, 4, 1, np.random.default_rng(1)), "it judged 1"),
    (lambda: TrialValues(np.ones(2), np.ones(3)), "two vectors of one number a trial"),
    (lambda: exact_values(ca.SX(np.nan), {}), "knows no rational value of it: A normal form has finite"),
    (lambda: exact_values(X[0] ** 10**9, {"x_0": Fraction(3)}), "knows no rational value of"),
    (lambda: characteristic_polynomial([[], []]), "must be square"),
    (lambda: RunSearch(ODE, BlockClaim(NONE), {"x": (0, 1)}, 1.0, 0.3), "must be a multiple of the step h"),
    (lambda: RunSearch(ODE, BlockClaim(NONE), {"x": (0, 1)}, 1.0, 0.1).search(-1), "the key of a generator; got -1"),
    (lambda: with_violations(ODE, [BlockClaim(NONE)]), "`The margin of 'it holds'` must be an? `SX`; got None"),
    (lambda: fix_parameters(ARM, {"links[0].mass": np.inf}), "must be a finite number; got inf"),
    (lambda: judge_zero(X[0], X[0], ARM), "it has none for 'x_0'"),
    (lambda: judge_zero(np.zeros((0, 2)), 1, ARM), "must have 1 to 20000 entries; got 0"),
    (lambda: eigenvalues_along(ARM, 1, np.eye(2)), "must be a vector of numbers"),
    (lambda: rest_point(ODE, [1.0, 2.0]), r"must have shape \(1,\)"),
    *((lambda form=form: text_of("rr", form), "must be a `Dynamics`; got 'rr'") for form in FORMS),
]
UNKNOWN = [
    (lambda: SignalsOf(ODE)[3], "go by names, which are text; got 3"),
    (lambda: growing_modes(ODE, {"y": Fraction(1)}), "There is no 'y' among the 2 numbers of 'decay'"),
    (lambda: fix_parameters(ARM, {"links[0].mas": 1.0}), "Did you mean 'links\\[0\\].mass'"),
    (lambda: ClaimLedger(())[1.5], "go by names, which are text; got 1.5"),
    (lambda: CounterExample.read("nowhere.json"), "there is no such file"),
]


@pytest.mark.parametrize(("call", "says"), REFUSED)
def test_what_cannot_be_used_is_refused_by_name(call, says):
    with pytest.raises((ValueError, LookupError), match=says):
        call()


@pytest.mark.parametrize(("call", "says"), UNKNOWN)
def test_a_name_that_nothing_has_is_a_lookup_error(call, says):
    with pytest.raises(LookupError, match=says):
        call()


def test_numbers_of_numpy_are_numbers():
    assert enclose(X[0], X, np.float32(0), np.int8(1), boxes=np.int64(100)).complete
    assert Budget(np.int64(8), np.int8(2), np.uint64(1)) == Budget(8, 2, 1)
    assert eigenvalues_along(ARM, np.int8(1), [0, 1]).shape == (2, 1)
