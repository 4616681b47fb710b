"""PID laws of the least IAE, and the largest ki of the batch, against searches that share no code with them."""

import control
import numpy as np
import pytest

import workbench as wb
from studies.d1_benchmarks.batch import batch
from tests.design.exhaustive_pid import Loop, exhaustive
from workbench.design.pid_design import pi_optimum, pid_optimum

LAGS = ([1.0], [1.0, 3.0, 3.0, 1.0])
N = 20.0
BATCH = {  # of the batch of Astrom and Hagglund: a lag, a lag much longer than its delay, six lags, an inverse response
    "P1": ([1.0], [8.0, 1.0], 1.0),
    "P7": ([1.0], [0.98, 1.98, 1.0], 0.02),
    "P4": ([1.0], [1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0], 0.0),
    "P8": ([-0.6, 1.0], [1.0, 3.0, 3.0, 1.0], 0.0),
}


def absolute_errors(gains, end, count=6000):
    """The IAE of three lags with each law (k, ki, kd), by the eigenvalues of the closed loop."""
    t = np.linspace(0, end, count)
    found = []
    for k, ki, kd in gains:
        law = control.tf([k + kd * N, k * N + ki, ki * N], [1, N, 0])
        loop = control.ss(control.feedback(control.tf(*LAGS), law))
        rates, modes = np.linalg.eig(loop.A)
        weights = (loop.C @ modes).ravel() * np.linalg.solve(modes, loop.B.astype(complex)).ravel() / rates
        e = (weights[:, np.newaxis] * (np.exp(np.outer(rates, t)) - 1)).sum(axis=0).real
        found.append(np.trapezoid(np.abs(e), t))
    return np.array(found)


def test_the_least_iae_is_below_that_of_every_law_of_a_dense_sample():
    design = pid_optimum(control.tf(*LAGS), 1.4, 1.4, N=N, criterion="IAE")
    assert design.method == "least IAE"
    assert design.certificate.Ms.gain.value <= 1.4
    own = absolute_errors([(design.k, design.ki, design.kd)], 40.0)[0]
    assert abs(own - design.IAE) <= design.IAE_error < 0.005 * own
    assert own >= design.IE >= 1 / design.bound
    largest = pid_optimum(control.tf(*LAGS), 1.4, 1.4, N=N)
    assert own < 0.9 * largest.IAE  # the law with the largest ki oscillates
    rng = np.random.default_rng(1)
    near = np.array([design.k, design.ki, design.kd]) * np.exp(0.12 * rng.standard_normal((3000, 3)))
    far = np.array([largest.k, largest.ki, largest.kd]) * rng.uniform(0.2, 1.8, (3000, 3))
    gains = np.concatenate([near, far])
    loop = Loop(*LAGS, 0.0, N, 1.4, 1.4)
    met = gains[loop.good(*gains.T) & (gains[:, 1] > 1 / own)]
    assert len(met) > 50
    assert absolute_errors(met[:150], 40.0, 1500).min() > 0.997 * own


def test_tune_pid_takes_the_least_iae_and_says_what_a_weight_cannot_do():
    plant = control.tf(*LAGS)
    design = wb.tune_pid(plant, form="PID", N=N)
    assert design.method == "least IAE"
    assert design.b == 0
    assert "even with b = 0" in design.remarks[0]
    assert wb.tune_pid(plant).remarks == ()
    with pytest.raises(ValueError, match="is for a PID law"):
        wb.tune_pid(plant, criterion="IAE")
    with pytest.raises(ValueError, match="criterion"):
        pid_optimum(plant, N=N, criterion="ISE")


def test_an_iae_that_is_not_known_is_refused():
    late = wb.pid_design.lambda_tuning(control.tf([1.0], [1.0, 1.0]), wb.pid_design.StepModel(1.0, 1.0, 1.0), 0.01)
    assert late.IAE_error < 0.02 * late.IAE
    hardly = pi_optimum(control.tf([1.0], [1.0, 2e-6, 1.0]), 3.0, 3.0, 0.0)
    with pytest.raises(ValueError, match="too large for a figure"):
        _ = hardly.IAE


@pytest.mark.release
def test_the_least_iae_keeps_a_noise_gain():
    design = pid_optimum(control.tf(*LAGS), 1.6, 1.6, noise_gain=8.0, criterion="IAE")
    assert 7.7 < design.noise_gain <= 8.0 * (1 + 1e-6)


def ratio(num, den, delay):
    """The largest ki of an exhaustive search over ours, with the filter that `tune_pid` takes, at Ms = Mt = 1.4."""
    plant = control.tf(num, den)
    filter_ = 10 * pi_optimum(plant, 1.4, 1.4, delay).contacts[0].frequency
    design = pid_optimum(plant, 1.4, 1.4, delay, N=filter_)
    gains = exhaustive(Loop(num, den, delay, filter_, 1.4, 1.4))
    assert design.certificate.stable
    return gains[1] / design.ki


def test_an_exhaustive_search_finds_no_larger_ki():
    assert 0.99 < ratio(*BATCH["P7"]) < 1.001


@pytest.mark.heavy
@pytest.mark.parametrize("family", BATCH)
def test_an_exhaustive_search_of_some_of_the_batch_finds_no_larger_ki(family):
    assert 0.99 < ratio(*BATCH[family]) < 1.001


@pytest.mark.release
@pytest.mark.parametrize("process", batch(), ids=lambda process: process.name)
def test_an_exhaustive_search_of_the_whole_batch_finds_no_larger_ki(process):
    assert (
        0.99 < ratio(list(process.num), list(process.den), process.delay) < 1.01
    )  # the cells of the search are coarse
