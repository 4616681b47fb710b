"""Test vectors: what a law got and sent in its loop, under names, as files that hold a law on another machine to it."""

import csv
import subprocess

import numpy as np
import pytest

import workbench as wb
from tests.support.c_runs import COMPILERS, WARNINGS, differing, needs_compiler
from tests.support.cases import heavy_but
from tests.support.digital_laws import arm_law, kalman_law, motor_law
from tests.support.random_laws import in_c, in_python, wanted
from workbench.handover.recording import single

LAWS = {"motor": motor_law, "cart": kalman_law, "arm": arm_law}


def rows_of(name, periods=300):
    return wb.record(LAWS[name](), periods=periods, seed=1)


def files(folder, rows, **options):
    """The law, its vectors, and the program that checks it, compiled without a warning."""
    wb.export(rows.law, "c", folder, name="law", **options)
    rows.write(folder, "c", "law")
    command = [COMPILERS[0], *WARNINGS, "law_check.c", "law.c", "-o", "check"]
    subprocess.run(command, cwd=folder, check=True, timeout=60)
    return subprocess.run([folder / "check"], capture_output=True, text=True, check=False)


def test_a_recording_has_its_signals_under_the_names_of_the_ports():
    rows = rows_of("arm", 20)
    assert rows.signals.names == ("y.q", "y.qd", "r.q", "r.qd", "r.qdd", "u.tau")
    assert rows["y.q"].shape == (20, 2)
    assert differing(rows["u.tau"], rows.u) == 0
    np.testing.assert_allclose(rows.t[[0, -1]], [0, 19e-3], rtol=1e-15)  # a product is rounded once
    with pytest.raises(LookupError, match=r"no 'y.v' among .* signals of this recording"):
        rows["y.v"]


def test_a_law_that_is_handed_what_was_recorded_sends_what_was_recorded():
    """A signal of a run is computed again from its states, and accuses a law that is right."""
    sampled = motor_law()
    rows = wb.record(sampled, until=1.0)
    assert differing(in_python(rows.law, rows), wanted(rows)) == 0
    runs = wb.simulate(sampled.step(), until=1.0, arithmetic="portable")
    np.testing.assert_allclose(runs["v"][0, :-1, 0], rows["u.v"], rtol=1e-9, atol=1e-9)  # rounding alone, else the same


@pytest.mark.parametrize("name", LAWS)
def test_the_numbers_of_the_table_are_those_of_the_recording_to_the_last_bit(name, tmp_path):
    rows = rows_of(name)
    (path,) = rows.write(tmp_path, "csv", "law")
    assert path.name == "law_vectors.csv"
    with path.open(newline="") as file:
        head, *lines = csv.reader(line for line in file if not line.startswith("#"))
    assert tuple(head) == ("k", *rows.signals.labels)
    read = np.array([[float(cell) for cell in line[1:]] for line in lines])
    assert differing(read, np.concatenate([rows.y, rows.r, rows.u], axis=1)) == 0


@needs_compiler
@pytest.mark.parametrize("name", heavy_but(LAWS, "motor"))
def test_the_program_of_c_finds_no_difference_in_the_exported_law(name, tmp_path):
    done = files(tmp_path, rows_of(name))
    assert (done.returncode, done.stdout) == (0, "0 of 300 periods differ\n")


@needs_compiler
def test_the_program_of_c_finds_a_last_digit(tmp_path):
    rows = rows_of("motor")
    rows.u[200, 0] = np.nextafter(rows.u[200, 0], np.inf)
    done = files(tmp_path, rows)
    assert done.returncode == 1
    assert "the first difference is in period 200, with the flags 0" in done.stdout
    assert "1 of 300 periods differ" in done.stdout


@needs_compiler
def test_vectors_in_single_precision_are_those_of_the_law_in_single_precision(tmp_path):
    rows = single(rows_of("motor", 100))
    done = files(tmp_path, rows, precision="single")
    assert (done.returncode, done.stdout) == (0, "0 of 100 periods differ\n")
    rows.write(tmp_path, "csv", "law")
    last = (tmp_path / "law_vectors.csv").read_text().splitlines()[-1].split(",")
    assert [np.float32(cell) for cell in last[1:]] == [rows.y[-1, 0], rows.r[-1, 0], rows.u[-1, 0]]


@needs_compiler
def test_a_late_computer_is_recorded_as_it_was_handed_its_readings(tmp_path):
    sampled = motor_law().with_timing_faults()
    p = sampled.parameters.pack({"computer.jitter": 0.2 * sampled.period})[0]
    rows = wb.record(sampled, periods=200, p=p, seed=3)
    assert differing(in_c(rows.law, rows, tmp_path), wanted(rows)) == 0


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, r"or the time in s; got none"),
        ({"periods": 10, "until": 1.0}, r"or the time in s; got both"),
        ({"until": 0.0105}, r"`record\(until=...\)` must be a multiple of the period"),
        ({"until": -1.0}, r"`record\(until=...\)`"),
        ({"periods": 0}, r"`record\(periods=...\)`"),
    ],
)
def test_a_length_that_is_none_is_refused(given, said):
    with pytest.raises(ValueError, match=said):
        wb.record(motor_law(), **given)


def test_an_unknown_form_and_an_odd_name_are_refused(tmp_path):
    rows = rows_of("motor", 3)
    with pytest.raises(LookupError, match="forms of test vectors"):
        rows.write(tmp_path, "xlsx")
    with pytest.raises(ValueError, match="identifier of C"):
        rows.write(tmp_path, "c", "7 laws")
    assert not list(tmp_path.iterdir())
