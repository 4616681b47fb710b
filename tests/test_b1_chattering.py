"""The study of chattering: one line of its table, and what it says where nothing oscillates."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "studies"))

import b1_chattering as study


def test_a_layer_that_is_too_thin_chatters_as_foreseen():
    found = study.row(1e-2, 5e-3)
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
    found = study.row(2e-3, 2e-3)
    assert found.layer[0].oscillations == ()
    assert study.cells(found)[-2:] == ("rest", "rest")
