"""Files and functions of tests keep the budgets of the package."""

from tests.house import rules_of_code, sources


def test_no_file_or_function_of_tests_is_longer_than_its_budget():
    tests = sources.sources("tests")
    assert rules_of_code.long_files(tests) == []
    assert rules_of_code.long_functions(tests) == []
