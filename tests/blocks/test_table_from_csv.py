"""A table from a CSV file: names, units, times and windows, and refusals with line and column."""

import gzip
import hashlib
import re
from pathlib import Path

import casadi as ca
import numpy as np
import pandas as pd
import pytest

import workbench as wb

LOGS = Path(__file__).parents[3] / "shared" / "data"
needs_logs = pytest.mark.skipif(not LOGS.is_dir(), reason="needs the measured logs beside the repository")
LOG = "t [s], omega [rad/s], v [V], note\n0, 1, 5, up\n\n# a remark\n0.5, 2, 6,\n1, 4, 7, down\n2, 3, 7.5, \n"


def written(tmp_path, text, name="log.csv"):
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    return file


def values(table, times):
    t = ca.SX.sym("t")
    x = ca.densify(ca.SX(table.at(t)[table.signal]))
    return np.array(ca.Function("x", [t], [x])(np.asarray(times)[None])).T


def test_a_file_says_the_names_the_units_and_the_times(tmp_path):
    table = wb.Table.from_csv(written(tmp_path, LOG), "omega")
    assert (table.signal, table.unit, table.ends) == ("omega", "rad/s", 2.0)
    np.testing.assert_array_equal(values(table, [0.0, 0.25, 0.75, 2.0]).ravel(), [1, 1.5, 3, 3])
    held = wb.Table.from_csv(written(tmp_path, LOG), "omega", interpolation="hold")
    np.testing.assert_array_equal(values(held, [0.0, 0.4999, 0.5, 1.9]).ravel(), [1, 1, 2, 4])


def test_a_unit_may_stand_behind_a_colon(tmp_path):
    table = wb.Table.from_csv(written(tmp_path, "t:s, omega:rad/s, ns::x, share:\n0,1,2,3\n1,3,5,4\n"), "omega")
    assert (table.unit, table.ends) == ("rad/s", 1.0)
    assert wb.Table.from_csv(tmp_path / "log.csv", "share").unit == "1"
    assert wb.Table.from_csv(tmp_path / "log.csv", "ns::x", "m").unit == "m"


def test_a_signal_of_several_numbers_has_a_column_for_each(tmp_path):
    file = written(tmp_path, "t [s],q[0] [rad],q[1] [m],other\n0,1,2,x\n1,3,5,y\n")
    table = wb.Table.from_csv(file, "q")
    assert (table.unit, table.dof) == ("rad, m", 2)
    np.testing.assert_array_equal(values(table, [0.5]), [[2, 3.5]])
    swapped = wb.Table.from_csv(file, "q", columns=("q[1]", "q[0]"))
    assert swapped.unit == "m, rad"


def test_the_table_is_the_one_that_pandas_reads(tmp_path):
    rng = np.random.default_rng(1)
    frame = pd.DataFrame(
        rng.standard_normal((50, 3)),
        columns=["x [m]", "y [m]", "z"],
        index=pd.Index(np.cumsum(rng.uniform(0.1, 1, 50)), name="time [s]"),
    )
    file = tmp_path / "log.csv.gz"
    frame.to_csv(file)
    begin = float(frame.index[10])
    table = wb.Table.from_csv(file, "p", columns=("x", "y"), begin=begin)
    np.testing.assert_array_equal(table.values, frame.to_numpy()[10:, :2])
    np.testing.assert_array_equal(table.times, frame.index[10:] - begin)


def test_a_run_that_was_written_as_a_table_drives_another_one(tmp_path):
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    runs = wb.simulate(wb.rk4(loop.ode(), 1e-3), until=1.0, every=0.01)
    runs.to_frame().to_csv(tmp_path / "run.csv")
    table = wb.Table.from_csv(tmp_path / "run.csv", "omega")
    np.testing.assert_array_equal(table.values, runs["omega"][0])
    again = wb.simulate(wb.ClosedLoop(motor, controller=law, reference=table), until=1.0)
    assert np.abs(again["e_omega"]).max() < 1.0
    with pytest.raises(ValueError, match="1 s"):
        wb.simulate(wb.ClosedLoop(motor, controller=law, reference=table), until=1.5)


def test_the_corners_of_the_interpolation_are_known_before_a_run(tmp_path):
    plant = wb.DisturbedPlant(wb.DCMotor(), by=wb.Table.from_csv(written(tmp_path, LOG), "v"))
    switches = wb.open_loop(plant).switches
    assert switches.has_instants
    assert not switches.unknown_operations
    instants = switches.until(np.zeros((1, switches.p.numel())), 2.0)[0]
    np.testing.assert_allclose(instants, [0.5, 1.0], rtol=2.0**-49)  # the clock is enlarged by 2^-50 of a time


def test_a_window_and_every_nth_line_of_a_long_log(tmp_path):
    t = np.arange(5001) * 2e-3
    file = tmp_path / "long.csv"
    np.savetxt(file, np.column_stack([t, np.sin(t)]), delimiter=",", header="time,u", comments="", fmt="%.17g")
    with pytest.raises(ValueError, match="at most 2000 rows"):
        wb.Table.from_csv(file, "u", "V")
    table = wb.Table.from_csv(file, "u", "V", begin=1.001, end=5.0, every=10)
    np.testing.assert_allclose(table.times, np.append(np.arange(1.0, 5.0, 0.02), 5.0) - 1.001, rtol=0, atol=1e-12)
    np.testing.assert_allclose(table.values.ravel(), np.sin(table.times + 1.001), rtol=0, atol=1e-12)


def test_a_file_without_times_has_a_period(tmp_path):
    file = written(tmp_path, '"uEst","yEst","Ts",\n3.0,5.0,4,\n2.0,4.0,,\n1.0,3.0,,\n')
    table = wb.Table.from_csv(file, "w", "V", columns=("uEst",), time=4.0)
    np.testing.assert_array_equal(table.times, [0, 4, 8])


def refused(path, **how):
    return wb.Table.from_csv(path, **{"signal": "omega", **how})


@pytest.mark.parametrize(
    ("text", "how", "kind", "says"),
    [
        ("t [s],omega [rad/s]\n0,1\n1,abc\n", {}, ValueError, r"line 3 of '.*log.csv' has 'abc' for 'omega'"),
        ("t [s],omega [rad/s]\n0,1\n\n1,\n", {}, ValueError, "line 4 of .* has nothing for 'omega'"),
        ("t [s],omega [rad/s]\n0,1\n1,nan\n", {}, ValueError, "line 3 of .* has 'nan' for 'omega'"),
        ("t [s],omega [rad/s]\n0,1\n1,1_0\n", {}, ValueError, "has '1_0' for 'omega'"),
        ("t [s],omega [rad/s]\n0,1\n__import__('os'),2\n", {}, ValueError, "line 3 of .* has .* for 't'"),
        ("t [s],omega [rad/s]\n0,1\n1,2,3\n", {}, ValueError, "each of its 2 columns in each line; line 3 of .* has 3"),
        (
            "t [s],omega [rad/s]\n0,1\n1,2\n1,3\n",
            {},
            ValueError,
            "line 4 of .* has 1 s after 1 s: say which of the two is meant by `repeated`",
        ),
        ("t [s],omega [rad/s]\n0,1\n1,2\n0.5,3\n", {}, ValueError, "line 4 of .* has 0.5 s after 1 s.$"),
        ("t [s],omega [rad/s]\n5,1\n6,2\n", {}, ValueError, "has 5 to 6 s, and a run would start at 0 s"),
        ("t [ms],omega [rad/s]\n0,1\n6,2\n", {}, ValueError, r"times in s; 't' of .* is in \[ms\]"),
        ("t [s],omega [rpm]\n0,1\n6,2\n", {"unit": "rad/s"}, ValueError, r"is in \[rpm\], and got 'rad/s'"),
        ("t [s],omega\n0,1\n6,2\n", {}, ValueError, "must say the unit of 'omega'"),
        ("t [s],omega [rad/s]\n0,1\n6,2\n", {"unit": "V, V"}, ValueError, "one unit, or one a column, 1"),
        ("x [m],omega [rad/s]\n0,1\n6,2\n", {}, ValueError, "a column of time called 't' or 'time'"),
        ("t [s],omga [rad/s]\n0,1\n6,2\n", {}, LookupError, "no 'omega' among the 2 columns .* mean 'omga'"),
        ("t [s],omega [rad/s],omega [V]\n0,1,1\n6,2,2\n", {}, ValueError, "has 2 of them"),
        ("0,1\n6,2\n", {}, ValueError, "begins with numbers"),
        ("", {}, ValueError, "is empty"),
        ("t [s],omega [rad/s]\n", {}, ValueError, "has none below its first"),
        ("t [s],omega [rad/s]\n0,1\n6,2\n", {"time": 0.0}, ValueError, r"`Table.from_csv\(time=...\)`"),
        ("t [s],omega [rad/s]\n0,1\n6,2\n", {"end": 0.0}, ValueError, "must lie behind `begin`"),
        (
            "t [s],omega [rad/s]\n0,1\n6,2\n",
            {"interpolation": "next"},
            ValueError,
            "is one of 'linear', 'cubic', 'hold'",
        ),
        ('t [s],omega [rad/s]\n0,"1\n', {}, ValueError, "none at line 2: unexpected end"),
    ],
)
def test_what_a_file_cannot_say_is_refused_by_its_line_and_column(tmp_path, text, how, kind, says):
    with pytest.raises(kind, match=says):
        refused(written(tmp_path, text), **how)


def test_what_is_no_file_of_text_is_refused(tmp_path):
    with pytest.raises(LookupError, match="There is no file"):
        refused(tmp_path / "none.csv")
    with pytest.raises(LookupError, match="There is no file"):
        refused(tmp_path)
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ValueError, match="UTF-8; .* at byte 0"):
        refused(tmp_path / "binary.csv")
    (tmp_path / "broken.csv.gz").write_bytes(gzip.compress(LOG.encode())[:-20])
    with pytest.raises(LookupError, match="cannot be read"):
        refused(tmp_path / "broken.csv.gz")


def test_a_file_with_semicolons_and_a_mark_of_its_order_is_read(tmp_path):
    file = tmp_path / "log.csv"
    file.write_text("t [s];omega [rad/s]\r\n0;1\r\n1;2\r\n", encoding="utf-8-sig")
    assert refused(file).ends == 1.0


def test_of_lines_with_one_time_the_first_or_the_last_is_taken_if_so_said(tmp_path):
    file = written(tmp_path, "t [s],omega [rad/s]\n0,1\n0,2\n1,3\n2,4\n2,5\n")
    for repeated, want in (("first", [1, 3, 4]), ("last", [2, 3, 5])):
        table = refused(file, duplicates=repeated)
        np.testing.assert_array_equal(table.values.ravel(), want)
        np.testing.assert_array_equal(table.times, [0, 1, 2])


@needs_logs
def test_a_measured_log_is_read_by_its_columns_though_its_heads_have_spaces_and_its_first_time_comes_twice():
    file = LOGS / "double_pendulum_dfki" / "A0_noise" / "rest_down_dt0.002.csv"
    with pytest.raises(ValueError, match=r"line 3 of .* has 0 s after 0 s"):
        wb.Table.from_csv(file, "q", "rad", columns=("pos1", "pos2"))
    wanted = pd.read_csv(file, skipinitialspace=True).drop_duplicates("time", keep="last")
    table = wb.Table.from_csv(file, "q", "rad", columns=("pos1", "pos2"), duplicates="last")
    np.testing.assert_allclose(table.values, wanted[["pos1", "pos2"]], rtol=1e-15)  # pandas rounds the last digit
    np.testing.assert_allclose(table.times, wanted["time"], rtol=1e-15)


@needs_logs
@pytest.mark.parametrize("file", sorted(LOGS.glob("*_pendulum_dfki/**/*.csv*")), ids=lambda file: file.name)
def test_every_measured_log_is_read_or_its_line_is_named(file):
    text = gzip.decompress(file.read_bytes()) if file.suffix == ".gz" else file.read_bytes()
    frame = pd.read_csv(file, skipinitialspace=True)
    column = text.split(b",", 2)[1].decode().strip()
    try:
        table = wb.Table.from_csv(file, "x", "rad", columns=(column,), every=4, duplicates="last")
    except ValueError as refusal:
        line = int(re.search(r"line (\d+) of", str(refusal))[1])
        times = frame["time"].to_numpy()
        assert times[line - 2] < times[line - 3]
    else:
        assert table.ends == pytest.approx(frame["time"].iloc[-1], rel=1e-15)


@needs_logs
def test_reading_leaves_the_file_as_it_was():
    file = LOGS / "cascaded_tanks" / "dataBenchmark.csv"
    before = hashlib.sha256(file.read_bytes()).hexdigest()
    table = wb.Table.from_csv(file, "u", "V", columns=("uEst",), time=4.0, interpolation="hold")
    assert (len(table.times), table.ends) == (1024, 4092.0)
    assert hashlib.sha256(file.read_bytes()).hexdigest() == before
