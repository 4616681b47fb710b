"""Files and functions of tests keep the budgets of the package."""

from tests.house import rules_of_code, sources

# Files of tests that are still to be split by idea; the list may only become shorter.
STILL_LONG = {
    *(f"tests/arms/{name}.py" for name in ["test_integrators", "test_observer_gains", "test_sheet"]),
    *(
        f"tests/blocks/{name}.py"
        for name in (
            "test_coloured_noise",
            "test_equipped",
            "test_kalman_filters",
            "test_loop_refusals",
            "test_ports",
        )
    ),
    *(f"tests/core/{name}.py" for name in ["test_normal_form"]),
    *(f"tests/design/{name}.py" for name in ["test_specifications"]),
    *(f"tests/engine/{name}.py" for name in ["test_reference"]),
    *(f"tests/handover/{name}.py" for name in ["test_fmi", "test_law_forms", "test_single_precision"]),
    *(
        f"tests/study/{name}.py"
        for name in (
            "test_evidence",
            "test_sensitivity",
            "test_store",
            "test_sweep",
            "test_sweeping",
            "test_tuning",
        )
    ),
}


def test_no_file_or_function_of_tests_is_longer_than_its_budget():
    tests = sources.sources("tests")
    long = {breach.partition(":")[0] for breach in rules_of_code.long_files(tests)}
    assert long == STILL_LONG
    assert rules_of_code.long_functions(tests) == []
