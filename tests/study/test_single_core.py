"""One core for what is measured."""

import os

import pytest

import workbench as wb


def cores_in_a_block_that_fails(seen):
    with wb.study.one_core():
        seen.append(os.sched_getaffinity(0))
        raise RuntimeError


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="the system cannot hold a process to a core")
def test_a_process_has_one_core_within_the_block_and_all_of_them_after_it_also_after_an_error():
    before, seen = os.sched_getaffinity(0), []
    with pytest.raises(RuntimeError):
        cores_in_a_block_that_fails(seen)
    assert seen == [{min(before)}]
    assert os.sched_getaffinity(0) == before
