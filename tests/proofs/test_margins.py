"""Claims as margins along a run: what they see, and that a broken one is seen."""

import casadi as ca
import numpy as np
import pytest

from workbench.core import Claim, Entry, Layout, Ode, rk4
from workbench.core.claim import BlockClaim
from workbench.engine import simulate
from workbench.engine.metrics import measure
from workbench.proofs.claim_margins import SignalsOf, derivative, violation, with_violations


def oscillator() -> Ode:
    """x'' = -k x as a loop would have it: a state and a parameter below a path."""
    states = Layout((Entry("body.x", 1.0), Entry("body.v", 0.0)))
    parameters = Layout((Entry("body.k", 4.0),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    rates = {"body.x": x[1], "body.v": -p[0] * x[0]}
    return Ode.of("oscillator", states, parameters, (t, x, p), rates, {"energy": p[0] * x[0] ** 2 / 2 + x[1] ** 2 / 2})


ODE = oscillator()


def test_a_block_sees_its_own_names_the_outputs_and_all_paths():
    y = SignalsOf(ODE, "body.")
    assert set(y) == {"x", "v", "k", "body.x", "body.v", "body.k", "energy", "t"}


def test_a_prime_is_the_derivative_along_the_solution():
    y = SignalsOf(ODE, "body.")
    value = ca.Function("rate", [ODE.x, ODE.p], [y["x'"], y["energy'"], y["x''"]])([0.3, 0.7], [4.0])
    np.testing.assert_allclose([float(v) for v in value], [0.7, 0.0, -1.2], atol=1e-15)  # x'' = -4 * 0.3


def test_the_derivative_counts_explicit_time():
    assert float(ca.evalf(ca.substitute(derivative(ODE, ODE.t**2), ODE.t, 3.0))) == 6.0


def test_a_signal_that_is_not_there_is_named_with_the_nearest():
    with pytest.raises(
        LookupError, match="There is no 'enrgy' among the .* signals of 'oscillator'. Did you mean 'energy'?"
    ):
        SignalsOf(ODE)["enrgy"]


def test_the_violation_of_a_run_is_the_largest_negative_margin():
    claim = Claim("small x", "|x| <= 0.5", "by hand", (), lambda y: 0.5 - ca.fabs(y["x"]))
    watched = with_violations(ODE, [BlockClaim(claim, "body.")])
    value = measure(watched, (violation(claim),), until=3.0, h=0.01).score("violation of small x").value
    assert value[0] == pytest.approx(0.5, abs=1e-6)  # |cos 2t| reaches 1 at the start


def test_a_violation_keeps_its_sign_where_the_claim_holds():
    claim = Claim("bounded", "|x| <= 3", "by hand", (), lambda y: 3 - ca.fabs(y["body.x"]))
    watched = with_violations(ODE, [BlockClaim(claim)])
    value = measure(watched, (violation(claim),), until=3.0, h=0.01).score("violation of bounded").value
    assert value[0] == pytest.approx(-2.0, abs=1e-6)


def test_watching_leaves_the_motion_as_it_is():
    claim = Claim("bounded", "|x| <= 3", "by hand", (), lambda y: 3 - ca.fabs(y["body.x"]))
    plain, watched = (simulate(rk4(ode, 0.01), until=1.0).x for ode in (ODE, with_violations(ODE, [BlockClaim(claim)])))
    np.testing.assert_array_equal(plain, watched)


def test_a_claim_without_a_margin_cannot_be_watched():
    with pytest.raises(ValueError, match="needs margins, which a run can break; the claim 'rest' has none"):
        with_violations(ODE, [BlockClaim(Claim("rest", "it comes to rest", "by hand"))])
