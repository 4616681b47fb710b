"""Words for the sentences of a report."""

import pytest

import workbench as wb


@pytest.mark.parametrize(
    ("names", "words"),
    [([], "none"), (["PID"], "PID"), (["PID", "SMC"], "PID and SMC"), (["PID", "SMC", "RISE"], "PID, SMC and RISE")],
)
def test_names_stand_in_a_row_with_and_before_the_last(names, words):
    assert wb.document.join_names(iter(names)) == words


def test_without_names_the_word_of_the_caller_stands():
    assert wb.document.join_names([], empty="no law") == "no law"


@pytest.mark.parametrize(
    ("share", "decimals", "words"),
    [(0.0123, None, "1.2 %"), (0.0999, None, "10 %"), (0.1, None, "10 %"), (1.234, None, "123 %"), (0.5, 1, "50.0 %")],
)
def test_a_percentage_has_two_digits_below_ten_and_is_whole_above(share, decimals, words):
    assert wb.document.percent(share, decimals) == words


def test_a_span_of_values_that_read_alike_is_one_number():
    assert wb.document.span([1.001, 1.002], "{:.2g}".format) == "1"
    assert wb.document.span([3.0, 1.0, 2.0], "{:.2g}".format) == "1 to 3"
    assert wb.document.span([], "{:.2g}".format) == ""


@pytest.mark.parametrize(
    ("write", "what"),
    [(lambda: "1", "raised TypeError"), (lambda value: value, "gave 1.0"), (lambda value: 1 / 0, "raised ZeroDiv")],
)
def test_a_span_names_a_function_that_does_not_write_a_number(write, what):
    with pytest.raises(ValueError, match=rf"`span\(write=...\)\(1\)` must return the number as text; it {what}"):
        wb.document.span([1.0, 2.0], write)
