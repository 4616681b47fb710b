"""CSV logs in the shapes that recorders, spreadsheets and other countries give them."""

import re
import tracemalloc

import numpy as np
import pandas as pd
import pytest

import workbench as wb
from workbench.identification.datasets import csv_reader

ROWS = [(0.0, 1.0, 0.5), (0.1, 2.0, 0.25), (0.2, 3.0, 0.125)]
CELLS = [[str(number) for number in row] for row in ROWS]


def text_of(head="t [s],v [V],omega [rad/s]", rows=CELLS, separator=","):
    return "\n".join([head, *(separator.join(row) for row in rows), ""])


@pytest.fixture
def file(tmp_path):
    """The function that writes a text to a file and gives its path."""

    def write(text):
        path = tmp_path / "log.csv"
        path.write_text(text)
        return path

    return write


@pytest.mark.parametrize("separator", [";", "\t"])
def test_decimal_commas_are_read_between_semicolons_and_tabs(file, separator):
    """Behind whole numbers, and also where a cell is odd, so that pandas gives up."""
    rows = [["0", "1", "0"], *([cell.replace(".", ",") for cell in row] for row in CELLS[1:])]
    head = separator.join(["t [s]", "v [V]", "omega [rad/s]"])
    for last in ([], [["# a remark"]]):
        log = wb.Dataset.from_csv(file(text_of(head, [*rows, *last], separator)))
        assert np.array_equal(log["omega"][:3], [0.0, 0.25, 0.125])
        assert np.array_equal(log.experiments[0].t[:3], [0.0, 0.1, 0.2])
    with pytest.raises(ValueError, match="line 5 of 'log.csv' has '1.5,0' for 'v"):
        wb.Dataset.from_csv(file(text_of(head, [*rows, ["0,3", "1.5,0", "1"]], separator)))


def test_the_memory_of_a_long_file_is_that_of_the_lines_that_are_kept(file, monkeypatch):
    monkeypatch.setattr(csv_reader, "ROWS", 2**12)
    lines = 100_000
    path = file(text_of("t,a,b,c,d", [[str(i), "1.5", "2.5", "3.5", "4.5"] for i in range(lines)]))
    wb.Dataset.from_csv(path, every=50_000)  # so that what pandas loads once is loaded
    tracemalloc.start()
    try:
        log = wb.Dataset.from_csv(path, every=500)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert np.array_equal(log.experiments[0].t, np.arange(0, lines, 500))
    assert peak < 2e6  # bytes; all lines have 4e6, and a chunk 1.6e5


def test_a_bracket_of_no_unit_is_a_part_of_the_name(file):
    log = wb.Dataset.from_csv(file(text_of("t (s),speed (raw),n (1/min)")))
    assert [(entry.name, entry.unit) for entry in log.signals.entries] == [("speed (raw)", "?"), ("n", "1/min")]


def test_dates_of_a_csv_file_are_read_by_the_road_that_the_refusal_names(file):
    path = file(text_of(rows=[[f"2024-05-01T12:00:00.{i}00+02:00", *row[1:]] for i, row in enumerate(CELLS)]))
    with pytest.raises(ValueError, match=re.escape("parse_dates=['t [s]']")):
        wb.Dataset.from_csv(path)
    log = wb.Dataset.from_frame(pd.read_csv(path, parse_dates=["t [s]"]))
    assert log.experiments[0].t == pytest.approx([row[0] for row in ROWS], abs=1e-12)


def test_a_temperature_beside_the_time_is_no_time(file):
    log = wb.Dataset.from_csv(file(text_of("T [K],t [s],omega [rad/s]")))
    assert np.array_equal(log.experiments[0].t, [row[1] for row in ROWS])
    assert np.array_equal(log["T"], [row[0] for row in ROWS])
    table = wb.Table.from_csv(file(text_of("T [K],t [s],omega [rad/s]")), "omega", begin=1.0)
    assert np.array_equal(table.times, [0.0, 1.0, 2.0])
