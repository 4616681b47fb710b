"""Of a heavy test with many cases `make test-all` runs every fourth, and another quarter for each test."""

from types import SimpleNamespace

from tests.conftest import EVERY, cases_of_a_release

MANY = 7


def items(test, cases):
    """What pytest collected of one test."""
    return [SimpleNamespace(nodeid=f"{test}[{case}]") for case in range(cases)]


def left(test, cases=MANY):
    """The cases of a test that are run."""
    found = items(test, cases)
    return {item.nodeid for item in found} - {item.nodeid for item in cases_of_a_release(found)}


def test_each_test_keeps_a_case():
    for cases in range(1, EVERY):
        assert {len(left(f"tests/a.py::test_{number}", cases)) for number in range(12)} == {1}
    assert cases_of_a_release([SimpleNamespace(nodeid="tests/a.py::test_without_cases")]) == []


def test_each_test_keeps_every_fourth_case():
    tests = [f"tests/a.py::Kit::test_{number}" for number in range(24)]
    assert {len(left(test, EVERY)) for test in tests} == {1}
    assert {len(left(test)) for test in tests} == {MANY // EVERY, MANY // EVERY + 1}
    all_items = [item for test in tests for item in items(test, MANY)]
    of_all = {item.nodeid for item in cases_of_a_release(all_items)}
    assert of_all == {item.nodeid for item in all_items} - {case for test in tests for case in left(test)}


def test_each_case_of_a_family_is_run_by_some_test():
    run = {case.partition("[")[2] for number in range(24) for case in left(f"tests/a.py::Kit::test_{number}")}
    assert len(run) == MANY
