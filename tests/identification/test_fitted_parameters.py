"""Parameters of a fit apart from its log: in a file and back, in factors, in tunings, and what is refused."""

import json

import numpy as np
import pytest

import workbench as wb
from tests.support.motor_logs import FREE, MOTOR, T, V, X, log

SIGMA = 0.3


@pytest.fixture(scope="module")
def fit():
    return wb.fit(MOTOR, log(T, V, X, SIGMA), [*FREE, "omega(0)"], noise={"omega": SIGMA, "i": SIGMA}, hold_out=0.0)


@pytest.fixture(scope="module")
def written(fit, tmp_path_factory):
    file = tmp_path_factory.mktemp("fits") / "motor.json"
    fit.parameters.save(file)
    return file


def test_a_file_gives_back_every_bit_of_the_parameters_and_their_factors(fit, written):
    back = wb.FittedParameters.from_file(written)
    assert back.names == FREE  # the initial state is no number of the system
    for name in ("centre", "covariance", "low", "high"):
        assert np.array_equal(getattr(back, name), getattr(fit.parameters, name))
    assert (back.units, back.source, back.warnings) == (fit.parameters.units, "log", fit.warnings)
    assert back.values["J"] == fit.values["J"]
    assert back.standard_errors["R"] == fit.standard_errors["R"]
    assert back.factors(path="plant.") == fit.factors(path="plant.")
    assert back.apply(wb.DCMotor()).L == fit.apply(wb.DCMotor()).L == fit.values["L"]


def test_draws_for_a_tuning_have_the_covariance_and_keep_the_bounds(fit):
    plants = fit.parameters.plants(4000, 2, path="plant.")
    assert list(plants[0]) == [f"plant.{name}" for name in FREE]
    draws = np.array([list(plant.values()) for plant in plants])
    z = (draws - fit.parameters.centre) / np.sqrt(np.diag(fit.parameters.covariance))
    assert z.mean(axis=0) == pytest.approx(np.zeros(len(FREE)), abs=4 / np.sqrt(4000))
    expected = fit.correlation[: len(FREE), : len(FREE)]
    assert np.cov(z.T) == pytest.approx(expected, abs=4 * np.sqrt(2 / 4000))  # 4 standard errors of a covariance
    assert plants[:1] == fit.parameters.plants(1, 2, path="plant.") != fit.parameters.plants(1, 3, path="plant.")


def test_a_law_is_tuned_for_all_draws_of_a_fit(fit):
    motor = fit.apply(wb.DCMotor())
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    knobs = (wb.Knob("Kp", "controller.Kp", 1.0, 1e3, log=True), wb.Knob("Ki", "controller.Ki", 1.0, 1e4, log=True))
    limits = wb.Specification(damping=0.5)
    plants = fit.parameters.plants(2, path="plant.")
    tuned = wb.tune(loop, knobs, limits, plants=plants, starts=1)
    assert len(tuned.verdicts) == 3  # the estimate and two draws
    for plant in plants:  # made anew from the law that was tuned
        values = plant | {f"controller.{name}[0]": value for name, value in tuned.values.items()}
        assert limits.check(wb.linear_loop(loop, values=values)).holds


def change(**fields):
    def made(text):
        return json.dumps(json.loads(text) | fields)

    return made


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda text: text[:-10], "in JSON"),
        (lambda text: text.replace("version 1", "version 2"), "with the format"),
        (lambda text: "[1, 2]", "with the format"),
        (change(centre=[1.0]), r"centre=\.\.\."),
        (change(centre=["1", 2.0, 3.0, 4.0]), "numbers as 'centre'"),
        (change(more=1), "also"),
        (lambda text: text.replace('"units"', '"unit"'), "no "),
        (lambda text: text.replace('"low"', '"high"'), "comes twice"),
        (change(source=3), "text as 'source'"),
        (change(names="JbKR"), "list of texts as 'names'"),
        (lambda text: text.replace("null", "NaN", 1), "NaN is no number"),
        (change(covariance=3), "rows of numbers"),
        (change(covariance=[[1.0, 2.0], [3.0]]), "square matrix"),
        (change(covariance=np.ones((4, 4)).tolist()), "positive definite"),
        (change(covariance=(np.eye(4) + np.eye(4, k=1)).tolist()), "symmetric"),
        (change(covariance=(-np.eye(4)).tolist()), "variances above 0"),
        (change(low=[9e9] * 4), "bounds"),
        (change(names=["J", "J", "K", "R"]), "distinct paths"),
    ],
)
def test_a_damaged_file_is_refused_with_what_is_wrong(written, tmp_path, spoil, words):
    file = tmp_path / "damaged.json"
    file.write_text(spoil(written.read_text()))
    with pytest.raises(ValueError, match=words):
        wb.FittedParameters.from_file(file)


def test_a_file_that_is_missing_or_too_large_is_refused(written, tmp_path):
    with pytest.raises(LookupError, match="there is no file"):
        wb.FittedParameters.from_file(tmp_path / "none.json")
    large = tmp_path / "large.json"
    large.write_text(" " * 10_000_001)
    with pytest.raises(ValueError, match="at most 10,000,000 bytes"):
        wb.FittedParameters.from_file(large)
    with pytest.raises(LookupError, match="There is no 'j'"):
        wb.FittedParameters.from_file(written).select(["j"])
