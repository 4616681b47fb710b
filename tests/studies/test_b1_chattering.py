"""The study of chattering: one line of its table, and its findings where nothing oscillates."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from studies.b1_chattering import findings, loops, study
from workbench.study.case_runs import run
from workbench.study.document.document import MissingCell


@cache
def study_row(lag, period):
    """The row of a lag and a period, from its own runs."""
    cases = tuple(loops.case(lag, period, switch) for switch in loops.SWITCHES)
    results = run(replace(study.study, cases=cases))
    runs = map(loops.record_oscillation, results.outcomes)
    return loops.Row.of((lag, period), loops.predict((lag, period)), *runs)


def test_a_layer_that_is_too_thin_chatters_as_foreseen():
    found = study_row(1e-2, 5e-3)
    foreseen, seen = found.layer
    assert foreseen.least_phi > loops.PHI
    (oscillation,) = foreseen.oscillations
    # a third harmonic of 3 %, and a half period that is no whole number of instants
    np.testing.assert_allclose(
        [oscillation.frequency, oscillation.amplitude], [seen.frequency, seen.amplitude], rtol=0.05
    )
    _, relay = found.relay
    assert found.cycle.samples == 4
    assert found.cycle.amplitude * (1 - 1e-3) < relay.amplitude < found.cycle.highest


@pytest.mark.heavy
def test_a_layer_that_is_wide_enough_rests_as_foreseen():
    found = study_row(2e-3, 2e-3)
    assert found.layer[0].oscillations == ()
    assert study.layer_table([found]).rows[0][-4:] == (MissingCell("rest"),) * 4


def test_what_is_found_of_chattering_follows_its_rows():
    rows = [study_row(2e-3, 2e-3), study_row(1e-2, 5e-3)]
    assert [r.layer_agrees for r in rows] == [True, True]
    every = [rows, *([rows] * len(loops.STARTS))]
    layer, _, cycle = findings.findings(every)
    assert ("In all 2 pairs" in layer.statement, layer.answer, layer.kind) == (True, "all", "found")
    assert "In all 2 of these" in cycle.statement
    swapped = [replace(rows[0], layer=(rows[1].layer[0], rows[0].layer[1])), rows[1]]
    layer, *_ = findings.findings([swapped, *([rows] * len(loops.STARTS))])
    assert (layer.answer, layer.kind) == ("1 of 2", "depends")
    balance, run = rows[0].relay
    met = replace(rows[0], relay=(replace(balance, frequency=run.frequency, amplitude=2 * run.amplitude), run))
    np.testing.assert_allclose(findings.errors_of([met]), [[0], [100]], atol=1e-9)
    larger = replace(rows[0], relay=(balance, replace(run, amplitude=rows[0].cycle.highest)))
    assert findings.agreement_count([larger]) == "0 of 1"


def test_another_start_brings_the_relay_to_another_half_period():
    lag, period = 2e-3, 2e-3
    runs = loops.other_starts((lag, period))
    halves = np.array([np.pi / (period * relay.frequency) for relay, _ in runs])
    # half a period is a whole number of periods of the computer, here to the scatter of some 1e-5
    np.testing.assert_allclose(halves, halves.round(), rtol=1e-3)
    first = np.pi / (period * study_row(lag, period).relay[1].frequency)
    assert {*halves.round()} - {round(first)}
    assert all(layer.amplitude < loops.QUIET for _, layer in runs)
