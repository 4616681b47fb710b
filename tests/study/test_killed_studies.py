"""A study of every kind of run and work that is killed goes on to the bits of a run that nobody disturbed."""

import pytest

from tests.support import kills


@pytest.mark.heavy
def test_a_killed_study_resumes_to_the_same_bits_and_computes_nothing_twice(tmp_path):
    tally = kills.survive(tmp_path, 5, seed=2030)  # two hundred: `python tests/support/kills.py 200`
    assert not tally.faults, str(tally)
    assert tally.kills == 5
