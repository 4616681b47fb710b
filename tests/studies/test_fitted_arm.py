"""Studies a7 and a8 with an arm from a fit: what is drawn, what the models believe, and what the page says first."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import workbench as wb
from studies.a7_sensitivity import fitted_derivatives, second_looks, sweeps
from studies.a8_fair_comparison import evidence
from studies.paper import fitted_arm, fitted_page
from studies.paper.entrants import BOTH, ENTRANTS, PROPOSED_LAW
from studies.paper.factors import factors, group_of
from studies.paper.scenarios import HELD_OUT

NAMES = ("arm.links[0].mass", "arm.links[1].length", "friction.viscous[0]", "friction.viscous[1]")
CENTRE, ERRORS = np.array([1.1, 0.95, 0.2, 0.05]), np.array([0.02, 0.01, 0.01, 0.005])
CORRELATION = np.eye(4) + 0.6 * np.eye(4)[[1, 0, 3, 2]]
FIT = wb.FittedParameters(
    tuple(f"plant.{name}" for name in NAMES),
    ("kg", "m", "N m s/rad", "N m s/rad"),
    CENTRE,
    CORRELATION * np.outer(ERRORS, ERRORS),
    np.zeros(4),
    np.full(4, 1e9),
    "'arm.csv'",
    ("The residuals are no white noise: q (whiteness).",),
)


@pytest.fixture
def fit(monkeypatch, tmp_path):
    """The fit as the studies read it from a file."""
    FIT.save(tmp_path / "arm.json")
    read = fitted_arm.read_fit(str(tmp_path / "arm.json"))
    for module in (fitted_arm, fitted_page, fitted_derivatives, evidence):
        monkeypatch.setattr(module, "FIT", read)
    return read


def value(ode, path):
    return float(ode.parameters.default[ode.parameters.labels.index(path)])


def test_without_a_fit_each_function_and_loop_is_the_one_that_it_was():
    assert not os.environ.get("FIT")
    assert sweeps.factors is factors
    assert (sweeps.loop.__qualname__, second_looks.Numbers.rows.__qualname__) == ("loop", "Numbers.rows")
    loop = sweeps.loop("PID")
    assert fitted_arm.with_fit(loop) is loop
    page = wb.Page("An answer.", (), ())
    assert fitted_page.fitted_page(page) is page


def test_the_arm_is_drawn_as_the_fit_says_and_the_models_have_its_estimates(fit):
    loop = sweeps.fitted_loop(PROPOSED_LAW)
    ode = loop.ode()
    assert [value(ode, f"plant.{name}") for name in NAMES] == CENTRE.tolist()
    assert value(ode, "controller.model.links[0].mass") == value(ode, "observer.state.model.links[0].mass") == 1.1
    assert value(ode, "plant.arm.links[0].length") == sweeps.loop(PROPOSED_LAW).plant.arm.links[0].length  # not fitted
    moved = fitted_arm.fitted_factors(factors(PROPOSED_LAW), loop)
    names = [factor.name for factor in moved]
    assert {"m2", "l1", "model m1", "Q"} < set(names)
    assert not {"m1", "l2"} & set(names)
    assert [group_of(name) for name in names if "direction" in name] == ["arm"] * 4
    space = wb.uncertainty.Space(moved, ode.parameters, ode.states)
    p, _ = space.rows(wb.uncertainty.MonteCarlo(len(moved), 2000, 3).points())
    places = [ode.parameters.labels.index(f"plant.{name}") for name in NAMES]
    z = (p[:, places] - CENTRE) / ERRORS
    assert np.cov(z.T) == pytest.approx(CORRELATION, abs=4 * np.sqrt(2 / 2000))  # 4 standard errors of a covariance


def test_scenarios_keep_their_payload_and_friction_in_the_ratio_to_the_fit(fit):
    law = next(one for one in ENTRANTS[BOTH.key] if one.name == "PID")
    by_name = {one.name: one for one in HELD_OUT}
    usual, heavy, rough = (
        fitted_arm.with_fit(law.loop(by_name[n])).loop.ode() for n in ("paper", "payload", "friction")
    )
    own = law.loop(by_name["payload"]).loop.ode()
    mass = "plant.arm.links[1].mass"
    assert value(heavy, mass) == value(own, mass) == 2 * value(usual, mass)
    assert value(rough, "plant.friction.viscous[0]") == pytest.approx(10 * 0.2, rel=1e-15)
    assert value(rough, "plant.friction.coulomb[0]") == 2.0  # not fitted: as the scenario has it
    loop = fitted_arm.with_fit(law.loop(by_name["friction"]))
    moved = evidence.uncertain_of_fit(by_name["friction"], loop)
    friction = next(factor for factor in moved if factor.name == "friction")
    assert friction.paths == ("plant.friction.coulomb[0]", "plant.friction.coulomb[1]")
    ways = np.array([factor.direction.changes for factor in moved if factor.direction])
    scaled = ERRORS * [1, 1, 10, 10]
    assert ways.T @ ways == pytest.approx(CORRELATION * np.outer(scaled, scaled), rel=1e-9)


def test_runs_again_and_derivatives_follow_the_directions(fit, monkeypatch):
    monkeypatch.setattr(sweeps, "loop", sweeps.fitted_loop)
    for module in (second_looks, fitted_derivatives):
        monkeypatch.setattr(module, "loop", sweeps.fitted_loop)
    every = sweeps.factors_of_fit("PID")
    monkeypatch.setattr(second_looks, "factors", lambda law: every)
    ode = sweeps.fitted_loop("PID").ode()
    design = wb.uncertainty.MonteCarlo(len(every), 5, 1)
    space = wb.uncertainty.Space(every, ode.parameters, ode.states)
    runs = second_looks.Numbers("PID", tuple(one.name for one in every), space.values(design.points()))
    for again, first in zip(second_looks.rows_of_fit(runs, ode), space.rows(design.points()), strict=True):
        assert np.array_equal(again, first)
    monkeypatch.setattr(fitted_derivatives, "free", lambda law: every)
    near = fitted_derivatives.derivatives_of_fit("PID")
    labels = near.sensitivities.labels
    at = near.factors.index("direction 1")
    column = near.moves[at, [labels.index(f"plant.{name}") for name in NAMES]]
    assert column == pytest.approx(every[at].direction.changes)
    assert near.deviations[at] == pytest.approx(1.0, abs=2e-3)  # a normal number cut off at 4
    shares = near.shares("RMSE", 0)
    assert shares.sum() == pytest.approx(1.0)


def test_the_page_says_first_of_which_log_its_plant_comes(fit):
    finding = wb.Finding("one", "A statement.", information="Exact positions.")
    page = fitted_page.fitted_page(wb.Page("The answer.", (finding,), (wb.Section("Other", ()),)))
    assert "".join(page.answer).startswith("Arm fitted to 'arm.csv'. The answer.")
    assert page.sections[0].heading == "The arm of this page"
    assert "come from a fit of 'arm.csv'. Exact positions." in "".join(page.findings[0].information)
    text, table = page.sections[0].blocks
    assert "no white noise" in text.text
    assert table.rows[0][:4] == ("plant.arm.links[0].mass", "1.1", "0.02", "kg")


@pytest.mark.parametrize(
    ("names", "words"),
    [(("arm.gravity",), "has 'arm.gravity'"), (("J",), "has 'J'"), (("arm.links[5].mass",), r"links\[5\]")],
)
def test_a_fit_of_other_numbers_is_refused(tmp_path, names, words):
    wrong = wb.FittedParameters(names, ("1",), np.ones(1), np.eye(1), np.zeros(1), np.full(1, 9.0))
    wrong.save(tmp_path / "wrong.json")
    with pytest.raises(ValueError, match=words):
        fitted_arm.read_fit(str(tmp_path / "wrong.json"))


def test_links_with_inertias_replace_the_point_masses(fit, monkeypatch):
    names = ("arm.links[0].com", "arm.links[0].inertia")
    heavy = replace(fit.select(NAMES[:2]), names=names, centre=np.array([0.4, 0.02]), covariance=np.diag([1e-6, 1e-8]))
    monkeypatch.setattr(fitted_arm, "FIT", heavy)
    ode = sweeps.fitted_loop("SMC").ode()
    for path, number in (("plant.arm.links[0].com", 0.4), ("controller.model.links[0].inertia", 0.02)):
        assert value(ode, path) == number
    assert value(ode, "plant.arm.links[1].com") == value(ode, "plant.arm.links[1].length")  # as of a point mass


def loaded(program, folder):
    """The lines that a program prints with the fit in its environment."""
    FIT.save(folder / "arm.json")
    root = Path(__file__).parents[2]
    environment = {**os.environ, "FIT": str(folder / "arm.json"), "PYTHONPATH": str(root)}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def test_a7_that_is_loaded_with_a_fit_has_another_name_and_draws_its_directions(tmp_path):
    name, directions, method = loaded(
        "from studies.a7_sensitivity.study import study\n"
        "print(study.name)\n"
        "print([factor.name for factor in study.sweeps[0].factors if factor.direction])\n"
        "print(study.method)",
        tmp_path,
    )
    assert name == "a7_sensitivity_of_fit"
    assert directions == str([f"direction {k}" for k in (1, 2, 3, 4)])
    assert method.startswith("The plant's numbers come from a fit of 'arm.csv'. ")


@pytest.mark.heavy
def test_a8_that_is_loaded_with_a_fit_has_another_name_and_its_arm(tmp_path):
    name, viscous = loaded(
        "from studies.a8_fair_comparison.study import study\n"
        "print(study.name)\n"
        "print(study.tunings[0].trials[0].run.loop.loop.plant.friction.viscous)",
        tmp_path,
    )
    assert name == "a8_fair_comparison_of_fit"
    assert viscous == "[0.2  0.05]"
