"""A study of every kind of run and work that is killed goes on to the bits of a run that nobody disturbed."""

import pytest

from tests.support import kills


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """A run that nobody disturbs."""
    return kills.undisturbed(tmp_path_factory.mktemp("kills") / "undisturbed")


@pytest.mark.parametrize(("count", "seed"), [(2, 30), pytest.param(5, 2030, marks=pytest.mark.heavy)])
def test_a_killed_study_resumes_to_the_same_bits_and_computes_nothing_twice(undisturbed, tmp_path, count, seed):
    tally = kills.survive(tmp_path, count, seed, undisturbed)  # two hundred: `python tests/support/kills.py 200`
    assert not tally.faults, str(tally)
    assert tally.kills == count
