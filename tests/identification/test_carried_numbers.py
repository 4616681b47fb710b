"""Initial states of a fit go into sweeps and blocks where they are asked for, and what is of the log does not."""

import numpy as np
import pytest

import workbench as wb
from tests.support.motor_logs import FREE, MOTOR, T, V, log, motion
from workbench.core.number_replacement import replace_initial_states

SIGMA = 0.3
MORE = [*FREE, "omega(0)", "offset of i", "delay of v"]


@pytest.fixture(scope="module")
def fit():
    x = motion(T, V, x0=(3.0, 0.0))
    noise = {"omega": SIGMA, "i": SIGMA}
    return wb.fit(MOTOR, log(T, V, x, SIGMA), MORE, noise=noise, start={"delay of v": 0.01}, hold_out=0.0)


def test_draws_of_parameters_and_an_initial_state_have_the_covariance_of_the_fit(fit):
    names = ["J", "R", "omega(0)"]
    factors = fit.factors(names)
    p, x0 = wb.uncertainty.Space(factors, MOTOR.parameters, MOTOR.states).rows(
        np.random.default_rng(1).random((4000, len(factors)))
    )
    draws = np.column_stack([p[:, MOTOR.parameters.labels.index(name)] for name in ("J", "R")] + [x0[:, 0]])
    at = [fit.names.index(name) for name in names]
    errors = np.sqrt(np.diag(fit.covariance)[at])
    z = (draws - fit.theta[at]) / errors
    assert z.mean(axis=0) == pytest.approx(np.zeros(3), abs=4 / np.sqrt(4000))
    # 4 standard errors of a covariance, and what a cut at 4 standard deviations takes away
    assert np.cov(z.T) == pytest.approx(fit.correlation[np.ix_(at, at)], abs=4 * np.sqrt(2 / 4000) + 1e-3)


def test_a_sweep_begins_in_the_states_that_were_drawn(fit):
    loop = wb.ClosedLoop(
        wb.DCMotor(),
        controller=wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=1.0, Ki=2.0),
        reference=wb.Constant("omega", "rad/s", 0.0),
    ).ode()
    factors = fit.factors(["omega(0)"], path="plant.")
    _, x0 = wb.uncertainty.Space(factors, loop.parameters, loop.states).rows(np.array([[0.5], [0.9]]))
    assert x0[0, loop.states.labels.index("plant.omega")] == pytest.approx(fit.values["omega(0)"], rel=1e-12)
    assert x0[1, loop.states.labels.index("plant.omega")] > x0[0, loop.states.labels.index("plant.omega")]


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (["J", "offset of i"], "'offset of i' is an error of the log's sensor"),
        (["delay of v"], "'delay of v' is a delay of the log's input; give the loop `delay=...`"),
        (["J", "J"], "each once"),
        (["K"], "There is no 'K'"),
    ],
)
def test_numbers_of_the_log_and_unknown_ones_are_no_factors(fit, names, words):
    with pytest.raises((ValueError, LookupError), match=words):
        fit.factors(names)


def test_an_experiment_is_named_to_apply_its_initial_states(fit):
    assert fit.apply(wb.DCMotor()).omega == 0.0
    begun = fit.apply(wb.DCMotor(), experiment="log")
    assert (begun.omega, begun.J) == (fit.values["omega(0)"], fit.values["J"])
    equation = fit.apply(MOTOR, experiment="log", values={"omega(0)": 1.5})
    assert equation.states.default.tolist() == [1.5, 0.0]
    with pytest.raises(LookupError, match="experiments with estimated initial states"):
        fit.apply(wb.DCMotor(), experiment="another")


def test_one_state_of_two_experiments_is_no_factor():
    first, second = (log(T, V, motion(T, V, x0=(speed, 0.0)), SIGMA) for speed in (2.0, -1.0))
    both = first.with_experiments(
        wb.Dataset.of(
            T, {n: second[n] for n in ("v", "omega", "i")}, {"v": "V", "omega": "rad/s", "i": "A"}, name="again"
        )
    )
    found = wb.fit(MOTOR, both, ["J", "omega(0)"])
    with pytest.raises(ValueError, match="of one experiment, as a run begins once"):
        found.factors(["J", "omega(0) of log", "omega(0) of again"])
    assert len(found.factors(["J", "omega(0) of again"])) == 2
    assert found.apply(MOTOR, experiment="again").states.default[0] == found.values["omega(0) of again"]


def test_an_initial_state_is_put_where_a_block_declares_it_and_nowhere_else():
    assert replace_initial_states(wb.DCMotor(), {"omega": 2.0}).omega == 2.0
    with pytest.raises(LookupError, match="no field for an initial state 'J'"):
        replace_initial_states(wb.DCMotor(), {"J": 2.0})
    with pytest.raises(LookupError, match="no field for an initial state 'speed'"):
        replace_initial_states(wb.DCMotor(), {"speed": 2.0})
    with pytest.raises(LookupError, match="speed"):
        replace_initial_states(MOTOR, {"speed": 2.0})
    with pytest.raises(ValueError, match="a block or an `Ode`"):
        replace_initial_states(3.0, {"speed": 2.0})
