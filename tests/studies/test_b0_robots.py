"""The roads that the study of the catalogue holds our arms against."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from studies.b0_robots import measurements, study
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import CATALOGUE, PlanarArm, robot
from workbench.arms.mechanics.arm_catalogue import planar


def test_equal_operations_are_counted_once():
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    # sin(x), times y, and the square of that; x itself and a constant are no operations
    entries = ca.horzcat(ca.sin(x) * y, (ca.sin(x) * y) ** 2, x, 3)
    assert measurements.operations(entries) == 3


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_catalogue_obeys_lagranges_equation_of_its_energies(name):
    arm = robot(name)
    # rounding of some hundred operations, relative to the largest term
    assert measurements.by_energies(arm, Dynamics.of(arm, symbolic=False)) < 1e-14


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_catalogue_moves_as_in_mujoco(name):
    pytest.importorskip("mujoco")
    arm = robot(name)
    # rounding, and the moments of 2e-15 kg m^2 that a point mass is given there
    assert measurements.by_mujoco(arm, Dynamics.of(arm, symbolic=False)) < 1e-13


def test_an_error_in_the_equations_would_be_seen():
    heavier = PlanarArm(planar(2).links, gravity=9.82)
    assert measurements.by_energies(heavier, Dynamics.of(planar(2), symbolic=False)) > 1e-4


@pytest.mark.parametrize(
    "method", [pytest.param("kane", marks=pytest.mark.release), pytest.param("lagrange", marks=pytest.mark.heavy)]
)
def test_sympy_derives_the_same_chain(method):
    pytest.importorskip("sympy")
    from studies.b0_robots import sympy_chain as chain

    found = chain.measure(method, 2)
    for letter, ours in zip("MCG", Dynamics.of(planar(2)).matrices(*chain.values(2)), strict=True):
        # numbers of size 1 to 20, a dozen operations each
        np.testing.assert_allclose(found["at"][letter], ours, rtol=0, atol=1e-13)
    bias = np.array(found["at"]["C"]) @ chain.values(2)[1] + found["at"]["G"]
    np.testing.assert_allclose(found["at"]["bias"], bias, rtol=0, atol=1e-13)


def test_the_bar_beside_sympy_is_reached_by_long_chains_alone(monkeypatch):
    short = measurements.Chain(2, 0.004, (0.08, 0.13), (0.1, 0.15), 1e-16)
    long = measurements.Chain(6, 0.03, (0.6, 7.0), (3.1, 9.8), 4e-16)
    monkeypatch.setattr(study, "chains", lambda: (short, long))
    (finding,) = study.sympy_findings()
    assert (finding.answer, finding.kind) == ("reached", "depends")
    assert {one.words: one.answer for one in finding.variations} == {
        "2 links": "missed",
        "Kane, M, C and G": "reached",
        "Lagrange, M, C and G": "reached",
        "Kane, M and the bias only": "missed",
        "Lagrange, M and the bias only": "reached",
    }
    monkeypatch.setattr(study, "chains", lambda: (replace(short, matrices=(None, None)),))
    assert study.sympy_findings() == ()


def arms(monkeypatch, **panda):
    one = measurements.Robot("pelican", 2, 11, (1,) * 6, (1e-3,), (1e-3,), (0.01,), 2e-16, 5e-16)
    monkeypatch.setattr(study, "robots", lambda: (one, replace(one, name="panda", **panda)))


def test_errors_are_rounding_of_every_arm_or_named(monkeypatch):
    arms(monkeypatch, by_energies=1e-6)
    finding = study.error_finding()
    assert (finding.answer, [one.words for one in finding.reversals]) == ("below 1e-13", ["panda, energies"])
    arms(monkeypatch, by_mujoco=1e-6)  # MuJoCo alone shares nothing with us, and decides
    finding = study.error_finding()
    assert finding.answer == "not below 1e-13"
    assert "1e-06 against MuJoCo, and 2e-16 against Lagrange's equation of the arm's energies" in finding.statement
    arms(monkeypatch, by_mujoco=None)
    assert "MuJoCo" in study.error_finding().statement  # of the pelican, where it is known


def test_repetitions_on_both_sides_of_the_bar_are_named(monkeypatch):
    arms(monkeypatch, derivation_seconds=(0.2, 0.2, 0.3), differentiation_seconds=(0.25, 0.28, 0.4))
    finding = study.time_finding()
    assert (finding.answer, finding.kind, [one.words for one in finding.reversals]) == (
        "reached",
        "depends",
        ["repetition 3"],
    )


def test_a_time_that_is_shorter_than_that_of_a_part_of_its_work_leaves_the_bar_open(monkeypatch):
    arms(monkeypatch, derivation_seconds=(0.30,), differentiation_seconds=(0.24,))
    finding = study.time_finding()
    assert finding.kind == "open"
    assert "Without derivatives the time was 0.3 s" in finding.evidence


def test_the_answer_gives_the_range_over_all_chains_and_not_the_largest_ratio(monkeypatch):
    arms(monkeypatch)
    short = measurements.Chain(2, 0.004, (0.08, 0.13), (0.1, 0.15), 1e-16)
    long = measurements.Chain(6, 0.03, (0.6, 7.0), (3.1, 9.8), 4e-16)
    monkeypatch.setattr(study, "chains", lambda: (short, long))
    assert "derived 25 to 103 times as fast as by SymPy; all 2 arms agree with MuJoCo to 5e-16" in study.answer()
