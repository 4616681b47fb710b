"""A stored run: written, read, run again, and refused on other equations."""

import json
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from tests.support.counterexamples import HUNT, ODE, blow_up, worst_run
from workbench.core import Claim
from workbench.core.claim import BlockClaim
from workbench.proofs.counterexample import CounterExample, hypotheses_kept, in_reference_mode
from workbench.proofs.falsify import Budget, RunSearch

WORST = worst_run()


def test_what_is_written_is_read_again_to_the_last_bit(tmp_path):
    WORST.write(tmp_path / "worst.json")
    assert CounterExample.read(tmp_path / "worst.json") == WORST


def test_a_replay_gives_the_stored_value():
    again = HUNT.replay(WORST)
    assert again.same
    assert again.keeps_hypotheses
    assert again.value == WORST.value


def test_a_replay_of_an_escape_says_when():
    claim = BlockClaim(Claim("bounded", "x <= 1000", "by hand", (), lambda y: 1000 - y["x"]))
    hunt = RunSearch(blow_up(), claim, {"x": (2.0, 3.0)}, 1.0, 1e-3)
    worst = hunt.search(0, Budget(8, 1, 0)).worst
    again = hunt.replay(worst)
    assert again.same
    # RK4 goes a few steps beyond the pole at 1 / x0
    np.testing.assert_allclose(again.diverged_at, 1 / worst.sought["x"], atol=0.02)


def test_a_replay_says_that_a_hypothesis_is_broken():
    strict = Claim("b is small", "|b| <= 0.5", "by hand", (), lambda y: 0.5 - ca.fabs(y["b"]))
    hunt = replace(HUNT, hypotheses=(BlockClaim(strict),))
    assert WORST.sought["b"] > 0.5
    assert not hunt.replay(WORST).keeps_hypotheses


def test_a_stored_value_that_is_not_what_the_run_gives_is_seen():
    assert not HUNT.replay(replace(WORST, value=WORST.value + 0.1)).same


def test_other_equations_are_refused_by_their_fingerprint():
    with pytest.raises(ValueError, match="must be given the equation it was found for"):
        WORST.rows(blow_up())


def test_a_missing_number_is_named(tmp_path):
    WORST.write(tmp_path / "worst.json")
    fields = json.loads((tmp_path / "worst.json").read_text())
    del fields["p"]["b"]
    (tmp_path / "worst.json").write_text(json.dumps(fields))
    with pytest.raises(LookupError, match="must give 'b' a number"):
        CounterExample.read(tmp_path / "worst.json").rows(ODE)


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"about": 1}', "[" * 5000, '{"sought": {"x": NaN}}', "null", '"text"', "{'a': 1}"]
)
def test_what_is_no_counter_example_is_refused_in_one_sentence(tmp_path, text):
    (tmp_path / "odd.json").write_text(text)
    with pytest.raises(ValueError, match="`CounterExample.read\\('odd.json'\\)` must hold a counter-example"):
        CounterExample.read(tmp_path / "odd.json")


def test_a_number_that_is_not_finite_is_refused(tmp_path):
    WORST.write(tmp_path / "worst.json")
    fields = json.loads((tmp_path / "worst.json").read_text())
    fields["p"]["b"] = float("nan")
    (tmp_path / "worst.json").write_text(json.dumps(fields))
    with pytest.raises(ValueError, match="not finite"):
        CounterExample.read(tmp_path / "worst.json")


@pytest.mark.parametrize("odd", [float("inf"), float("nan"), "one", None])
def test_a_seed_that_is_no_whole_number_is_refused(tmp_path, odd):
    WORST.write(tmp_path / "worst.json")
    fields = json.loads((tmp_path / "worst.json").read_text())
    (tmp_path / "worst.json").write_text(json.dumps(fields | {"seed": odd}))
    with pytest.raises(ValueError, match="must hold a counter-example"):
        CounterExample.read(tmp_path / "worst.json")


def test_the_reference_mode_sees_the_same_run():
    p, x0 = WORST.rows(ODE)
    y, error = in_reference_mode(HUNT.violation_equation, "e", p[0], x0[0], [2.0])
    assert y[0, 0] == pytest.approx(WORST.value, abs=1e-8)  # the violation of x(2) <= 0 is x(2)
    assert error[0, 0] < 1e-8


def test_the_hypotheses_that_a_run_keeps_at_every_step_are_named():
    held = BlockClaim(Claim("x is small", "x <= 1", "by hand", (), lambda y: 1 - y["x"]))  # x(0) = 1, and x falls
    broken = BlockClaim(Claim("x is large", "x >= 0.2", "by hand", (), lambda y: y["x"] - 0.2))  # until ln 5 s = 1.61 s
    assert hypotheses_kept(ODE, (held, broken), 1.5, 0.01) == ("x is small", "x is large")
    assert hypotheses_kept(ODE, (held, broken), 1.7, 0.01) == ("x is small",)
