"""The study of chattering: one line of its table, and its findings where nothing oscillates."""

from dataclasses import replace
from functools import cache

import numpy as np

from studies import b1_chattering as study
from workbench.study.case_runs import run


@cache
def study_row(lag, period):
    """The row of a lag and a period, from its own runs."""
    cases = tuple(study.case(lag, period, switch) for switch in study.SWITCHES)
    results = run(replace(study.study, cases=cases))
    runs = map(study.recorded, results.outcomes)
    return study.Row.of((lag, period), study.predict((lag, period)), *runs)


def test_a_layer_that_is_too_thin_chatters_as_foreseen():
    found = study_row(1e-2, 5e-3)
    foreseen, seen = found.layer
    assert foreseen.least_phi > study.PHI
    (oscillation,) = foreseen.oscillations
    # a third harmonic of 3 %, and a half period that is no whole number of instants
    np.testing.assert_allclose(
        [oscillation.frequency, oscillation.amplitude], [seen.frequency, seen.amplitude], rtol=0.05
    )
    _, relay = found.relay
    assert found.cycle.samples == 4
    assert found.cycle.amplitude * (1 - 1e-3) < relay.amplitude < found.cycle.highest


def test_a_layer_that_is_wide_enough_rests_as_foreseen():
    found = study_row(2e-3, 2e-3)
    assert found.layer[0].oscillations == ()
    assert study.table([found]).rows[0][-2:] == ("rest", "rest")


def test_what_is_found_of_chattering_follows_its_rows():
    rows = [study_row(2e-3, 2e-3), study_row(1e-2, 5e-3)]
    assert [r.agreed for r in rows] == [True, True]
    assert "in 2 of 2 pairs" in study.findings(rows)[0].statement
    assert "in 2 of 2 pairs" in study.findings(rows)[2].statement
    swapped = [replace(rows[0], layer=(rows[1].layer[0], rows[0].layer[1])), rows[1]]
    assert "in 1 of 2 pairs" in study.findings(swapped)[0].statement
    balance, run = rows[0].relay
    met = replace(rows[0], relay=(replace(balance, frequency=run.frequency, amplitude=2 * run.amplitude), run))
    assert "off by 0 % in frequency and 100 % in amplitude" in study.findings([met])[1].statement
    larger = replace(rows[0], relay=(balance, replace(run, amplitude=rows[0].cycle.highest)))
    assert "in 0 of 1 pairs" in study.findings([larger])[2].statement
