"""Responses over frequency from logs: they and their regions against the system, and in pictures."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import binom

import workbench as wb
from tests.support.linear_logs import PERIOD, log_of

B, F = [0.0, 0.5, 0.2], [1.0, -1.5, 0.7]


def response(omega):
    z = np.exp(1j * omega * PERIOD)
    return np.polyval(B[::-1], 1 / z) / np.polyval(F[::-1], 1 / z)


def noisy_log(seed, count, u=None):
    rng = np.random.default_rng(seed)
    u = rng.choice([-1.0, 1.0], count) if u is None else u
    return log_of(u, lfilter(B, F, u) + 0.5 * lfilter([1.0], [1, -0.8], rng.standard_normal(count)))


def periodic_log(seed):
    return noisy_log(seed, 6 * 128, np.tile(np.random.default_rng(99).normal(size=128), 6))


ESTIMATES = {
    "H1": lambda seed: wb.linear_models.spectral_response(noisy_log(seed, 4000), "u", "y", segment=250),
    "local polynomials": lambda seed: wb.linear_models.local_polynomial_response(
        noisy_log(seed, 1000), "u", "y", half_width=12
    ),
    "periods": lambda seed: wb.linear_models.periodic_response(periodic_log(seed), "u", "y", 128),
}
# Regions that hold the response at this share of the frequencies: few residual degrees of freedom, and for H1 the
# leakage of a window, lower the 95 % of the normal distribution.
LEAST = {"H1": 0.90, "local polynomials": 0.90, "periods": 0.75}


@pytest.mark.parametrize("name", ESTIMATES)
def test_the_region_holds_the_response_about_as_often_as_it_says(name):
    hits = []
    for seed in range(8):
        estimate = ESTIMATES[name](seed)
        inside = estimate.contains(response(estimate.frequencies))
        hits.append(inside[:: max(1, len(inside) // 40)])  # neighbours are not independent
    hits = np.concatenate(hits)
    assert hits.mean() > binom.ppf(0.0005, len(hits), LEAST[name]) / len(hits)
    assert hits.mean() < binom.ppf(0.9995, len(hits), 0.97) / len(hits)


def test_the_coherence_is_that_of_the_spectra():
    u = np.random.default_rng(1).normal(size=60_000)
    log = log_of(u, u + 0.5 * np.random.default_rng(2).standard_normal(60_000))
    estimate = wb.linear_models.spectral_response(log, "u", "y", segment=200)
    # 600 segments: the error of a coherence of 0.8 is below 0.02 each, and that of the mean far less
    assert estimate.coherence.mean() == pytest.approx(1 / 1.25, abs=0.005)


def test_a_periodic_input_without_noise_gives_the_response_to_rounding():
    u = np.tile(np.random.default_rng(3).normal(size=256), 4)
    log = log_of(u, lfilter(B, F, u))
    estimate = wb.linear_models.periodic_response(log, "u", "y", 256, skip=2)
    # the slowest mode has decayed to 0.84^512
    np.testing.assert_allclose(estimate.values, response(estimate.frequencies), atol=1e-9)


def test_local_polynomials_leave_less_leakage_than_welch_by_a_factor_of_ten():
    u = np.random.default_rng(4).normal(size=2000)
    log = log_of(u, lfilter(B, F, u))
    errors = []
    for estimate in (
        wb.linear_models.spectral_response(log, "u", "y", segment=250),
        wb.linear_models.local_polynomial_response(log, "u", "y"),
    ):
        errors.append(np.sqrt(np.mean(np.abs(estimate.values - response(estimate.frequencies)) ** 2)))
    assert errors[1] < 0.1 * errors[0]


def test_pictures_draw_an_estimate_with_its_region_beside_a_model():
    log = noisy_log(5, 2000)
    estimate = wb.linear_models.spectral_response(log, "u", "y")
    model = wb.linear_models.output_error(log, "u", "y", nb=2, nf=2, starts=0)
    picture = wb.bode({"log": estimate, "model": model.frequency_response(), "system": model.to_ss()})
    marks = picture.figure.panels[0].series
    bands = [mark for mark in marks if type(mark).__name__ == "Band"]
    assert len(bands) == 2
    middle = 20 * np.log10(np.abs(estimate.values))
    assert (bands[0].low < middle).all()
    assert (middle < bands[0].high).all()
    assert "95 %" in picture.caption
    ellipses = wb.nyquist({"log": estimate, "model": model.to_ss()}, margins=False).figure.panels[0].series
    assert any(type(mark).__name__ == "Guides" and len(mark.lines) > 3 for mark in ellipses)


def test_what_cannot_be_averaged_is_refused():
    log = noisy_log(6, 400)
    with pytest.raises(ValueError, match="at least 4 segments"):
        wb.linear_models.spectral_response(log, "u", "y", segment=300)
    with pytest.raises(ValueError, match="does not repeat after 100 samples"):
        wb.linear_models.periodic_response(log, "u", "y", 100, skip=0)
    with pytest.raises(ValueError, match="needs two or more whole periods"):
        wb.linear_models.periodic_response(log, "u", "y", 300)
    with pytest.raises(ValueError, match="must give more than 6 lines"):
        wb.linear_models.local_polynomial_response(log, "u", "y", half_width=2)
    with pytest.raises(LookupError, match="There is no 'v'"):
        wb.linear_models.spectral_response(log, "v", "y")
