"""A study of every kind of run and work that is killed goes on to the bits of a run that nobody disturbed."""

import kills
import pytest


def test_a_killed_study_resumes_to_the_same_bits_and_computes_nothing_twice(tmp_path):
    tally = kills.survive(tmp_path, 3, seed=30)
    assert not tally.faults, str(tally)


@pytest.mark.heavy
def test_twelve_kills_at_random_moments_change_no_bit(tmp_path):
    tally = kills.survive(tmp_path, 12, seed=2030)  # two hundred: `python tests/kills.py 200`
    assert not tally.faults, str(tally)
    assert tally.kills == 12
