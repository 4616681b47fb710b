"""Logs are read from files with their names, units and times, or refused in one sentence."""

import gzip
import re
import sys

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

import workbench as wb
from tests.support.robot_logs import EPOCH, write_json_mcap, write_mcap, write_ulog
from workbench.identification.datasets import csv_reader, log_columns

ROWS = [(0.0, 1.0, 0.5), (0.1, 2.0, 0.25), (0.2, 3.0, 0.125)]
CELLS = [[str(number) for number in row] for row in ROWS]
HEADS = {
    "t [s],v [V],omega [rad/s]": ",",
    "t:s, v:V, omega:rad/s": ",",
    "time [s]\t v [V]\tomega [rad/s]": "\t",
    "# a comment\n\nt [s]; v [V]; omega [rad/s]": ";",
    '"t [s]","v [V]","omega [rad/s]"': ",",
    "t (s),v (V),omega (rad/s)": ",",
    "t [sec],v [V],omega [rad/s]": ",",
    "t,v,omega\n[s],[V],[rad/s]": ",",
    "sep=;\nt;v;omega\ns;V;rad/s": ";",
}


def text_of(head="t [s],v [V],omega [rad/s]", rows=CELLS, separator=","):
    return "\n".join([head, *(separator.join(row) for row in rows), ""])


@pytest.fixture
def file(tmp_path):
    """The function that writes a text to a file and gives its path."""

    def write(text, name="log.csv"):
        path = tmp_path / name
        data = text.encode()
        path.write_bytes(gzip.compress(data) if name.endswith(".gz") else data)
        return path

    return write


@pytest.mark.parametrize("head", HEADS)
@pytest.mark.parametrize("name", ["log.csv", "log.csv.gz"])
def test_a_csv_file_gives_its_names_units_and_numbers(file, head, name):
    log = wb.Dataset.from_csv(file(text_of(head, separator=HEADS[head]), name))
    assert [(entry.name, entry.unit) for entry in log.signals.entries] == [("v", "V"), ("omega", "rad/s")]
    assert np.array_equal(np.column_stack([log.experiments[0].t, log["v"], log["omega"]]), ROWS)
    assert (log.names, log.source, log.notes) == (("log",), f"'{name}'", ())


def test_a_frame_of_a_log_is_read_back_bit_by_bit(tmp_path):
    rng = np.random.default_rng(1)
    log = wb.Dataset.of(
        np.cumsum(rng.random(500)), {"q": rng.standard_normal((500, 3)), "v": rng.random(500)}, {"q": "rad"}
    )
    log.to_frame().to_csv(tmp_path / "log.csv")
    log.to_frame().to_parquet(tmp_path / "log.parquet")
    for again in (
        wb.Dataset.from_csv(tmp_path / "log.csv"),
        wb.Dataset.from_parquet(tmp_path / "log.parquet"),
        wb.Dataset.from_frame(log.to_frame()),
    ):
        assert [(e.name, e.shape, e.unit) for e in again.signals.entries] == [("q", (3,), "rad"), ("v", (), "?")]
        assert np.array_equal(again.experiments[0].t, log.experiments[0].t)
        assert np.array_equal(again.experiments[0].values, log.experiments[0].values)
    assert np.array_equal(wb.Dataset.from_csv(tmp_path / "log.csv", ["q"])["q[1]"], log["q"][:, 1])


@pytest.mark.parametrize(("unit", "factor"), [("ms", 1e3), ("us", 1e6), ("min", 1 / 60), ("h", 1 / 3600), ("s", 1)])
def test_times_in_another_unit_are_converted_to_seconds_and_noted(file, unit, factor):
    rows = [[repr(t * factor), *rest] for t, *rest in [("0.0", "1", "2")] for t in (0.0, 0.1, 0.2)]
    said = wb.Dataset.from_csv(file(text_of(f"t [{unit}],v [V],w [V]", rows)))
    told = wb.Dataset.from_csv(file(text_of("stamp,v [V],w [V]", rows)), time="stamp", units={"stamp": unit})
    for log in (said, told):
        assert log.experiments[0].t == pytest.approx([0.0, 0.1, 0.2], rel=1e-15, abs=0)  # one rounding
        assert bool(log.notes) == (unit != "s")
    assert "no unit" in wb.Dataset.from_csv(file(text_of("t,v,w")), units={"v": "V"}).notes[0]


def test_columns_are_chosen_and_renamed_and_get_units_and_a_period(file):
    head, rows = '"uEst","yEst","Ts",', [["1", "2", "4", ""], ["3", "", "", ""]]
    log = wb.Dataset.from_csv(
        file(text_of(head, rows)),
        ["uEst", "y"],
        names={"uEst": "u", "yEst": "y"},
        units={"u": "V", "yEst": "V"},
        time=4.0,
    )
    assert repr(log) == "<Dataset of u [V], y [V]: 1 experiment, 2 samples, 4 s>"
    assert np.array_equal(log["y"], [2.0, np.nan], equal_nan=True)
    assert "1 of 4 cells are empty" in log.notes[1]


def test_every_nth_line_is_read_across_the_chunks(file, monkeypatch):
    monkeypatch.setattr(csv_reader, "ROWS", 7)
    rows = [[str(i), str(i * i), "0"] for i in range(100)]
    path = file(text_of(rows=rows))
    assert np.array_equal(wb.Dataset.from_csv(path, every=3).experiments[0].t, np.arange(0, 100, 3))
    rows[50][1] = ""  # and cell by cell, where a line is odd
    rows[51][2] = ""
    log = wb.Dataset.from_csv(file(text_of(rows=rows)), every=3)
    assert np.array_equal(log.experiments[0].t, np.arange(0, 100, 3))
    assert np.isnan(log["omega"][17])


BAD_CELLS = {
    "n/a": "line 3 of 'log.csv' has 'n/a' for 'v [V]'",
    "inf": "line 3 of 'log.csv' has 'inf' for 'v [V]'",
    "1_0": "line 3 of 'log.csv' has '1_0' for 'v [V]'",
    "2.0,7": "line 3 of 'log.csv' has 4",
}


@pytest.mark.parametrize("cell", BAD_CELLS)
def test_a_bad_cell_is_refused_by_line_and_column(file, cell):
    path = file(text_of(rows=[CELLS[0], [CELLS[1][0], cell, CELLS[1][2]], CELLS[2]]))
    with pytest.raises(ValueError, match=r"from_csv") as refusal:
        wb.Dataset.from_csv(path)
    assert BAD_CELLS[cell] in str(refusal.value)


def test_a_short_line_is_refused_and_a_lost_sample_can_have_a_word(file):
    with pytest.raises(ValueError, match=r"a cell for each of its 3 columns in each line; line 3 of 'log.csv' has 2"):
        wb.Dataset.from_csv(file(text_of(rows=[CELLS[0], CELLS[1][:2], CELLS[2]])))
    log = wb.Dataset.from_csv(file(text_of(rows=[CELLS[0], [CELLS[1][0], "n/a", "nan"]])), absent=["n/a"])
    assert np.isnan([log["v"][1], log["omega"][1]]).all()


OTHERS = {
    "": (ValueError, "is empty"),
    "1,2\n3,4\n": (ValueError, "begins with numbers"),
    "a,b\n1,2\n": (ValueError, "one column of time called 't' or 'time'"),
    "t,time,b\n1,2,3\n": (ValueError, "one column of time"),
    "t,b,b\n1,2,3\n": (ValueError, "2 columns 'b'"),
    "t [kg],b\n1,2\n": (ValueError, "times in one of s, ms"),
    't,b\n1,"2\n': (ValueError, "is none at line"),
}


@pytest.mark.parametrize("text", OTHERS)
def test_a_file_that_is_no_log_is_refused_in_one_sentence(file, text):
    kind, words = OTHERS[text]
    with pytest.raises(kind) as refusal:
        wb.Dataset.from_csv(file(text))
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_files_that_are_not_there_or_not_whole_are_refused(file, tmp_path):
    with pytest.raises(LookupError, match="There is no file 'none.csv'"):
        wb.Dataset.from_csv(tmp_path / "none.csv")
    broken = tmp_path / "broken.csv.gz"
    broken.write_bytes(gzip.compress(text_of().encode())[:-9])
    with pytest.raises(LookupError, match="cannot be read"):
        wb.Dataset.from_csv(broken)
    (tmp_path / "latin.csv").write_bytes(b"t,v\n1,2\n2,\xe9\n")
    with pytest.raises(ValueError, match="UTF-8"):
        wb.Dataset.from_csv(tmp_path / "latin.csv")
    with pytest.raises(LookupError, match="Did you mean 'omega'"):
        wb.Dataset.from_csv(file(text_of()), ["omeg"])
    with pytest.raises(ValueError, match=r"'v \[V\]' is in \[V\], and `units` says 'A'"):
        wb.Dataset.from_csv(file(text_of()), units={"v": "A"})


def test_a_file_of_too_many_numbers_is_refused_with_its_figure(file, monkeypatch):
    monkeypatch.setattr(log_columns, "MOST_NUMBERS", 600)
    monkeypatch.setattr(csv_reader, "ROWS", 50)
    path = file(text_of(rows=[[str(i), "1", "2"] for i in range(1000)]))
    with pytest.raises(ValueError, match=r"3 columns of [\d.e+]+ rows: the file has 0 MB; choose columns"):
        wb.Dataset.from_csv(path)
    assert len(wb.Dataset.from_csv(path, every=10).experiments[0]) == 100
    packed = file(text_of(rows=[[str(i), "1", "2"] for i in range(1000)]), "log.csv.gz")  # whose size says nothing
    with pytest.raises(ValueError, match="choose columns by `signals`"):
        wb.Dataset.from_csv(packed)


def test_a_frame_may_have_dates_and_words():
    t = pd.date_range("2026-01-01", periods=3, freq="250ms", name="when")
    frame = pd.DataFrame({"v [V]": [1, 2, 3], "mode": ["a", "b", "c"]}, index=t)
    log = wb.Dataset.from_frame(frame, time="when")
    assert np.array_equal(log.experiments[0].t, [0.0, 0.25, 0.5])
    assert "2026-01-01" in log.notes[0]
    assert "mode" in log.notes[1]
    with pytest.raises(ValueError, match="'mode' of the table"):
        wb.Dataset.from_frame(frame, ["mode"], time="when")


def test_a_mat_file_gives_vectors_matrices_and_fields_of_structures(tmp_path):
    t = np.linspace(0, 1, 11)
    columns = {"t": t, "u": np.sin(t).reshape(-1, 1), "q": np.column_stack([t, -t, t**2])}
    savemat(tmp_path / "log.mat", {**columns, "gain": 3.5, "data": {"w": t**3}, "other": np.ones(4)})
    log = wb.Dataset.from_mat(tmp_path / "log.mat", units={"u": "V", "q": "rad"})
    assert [(e.name, e.shape) for e in log.signals.entries] == [("u", ()), ("q", (3,)), ("data.w", ())]
    assert np.array_equal(log["q"], columns["q"])
    assert any("gain = 3.5" in note for note in log.notes)
    assert any("other" in note for note in log.notes)
    (tmp_path / "new.mat").write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64" + bytes(600))
    with pytest.raises(ValueError, match=r"version 7\.3, which is HDF5: save it by `save\(name, '-v7'\)`"):
        wb.Dataset.from_mat(tmp_path / "new.mat")
    (tmp_path / "none.mat").write_bytes(b"no MAT file")
    with pytest.raises(ValueError, match="must be a MAT file; 'none.mat' is none"):
        wb.Dataset.from_mat(tmp_path / "none.mat")


def test_an_mcap_file_gives_its_numbers_by_path_at_the_union_of_its_times(tmp_path):
    path = write_mcap(
        tmp_path / "bag.mcap", [(10 * i, (i, -i)) for i in range(5)], [(10 * i + 5, 0.5 * i) for i in range(4)]
    )
    log = wb.Dataset.from_mcap(path, ["/encoders.position", "tau"], names={"/effort.data": "tau"}, units={"tau": "N m"})
    assert np.array_equal(log.experiments[0].t, 0.005 * np.arange(9))
    assert np.array_equal(log["/encoders.position[1]"][::2], [0, -1, -2, -3, -4])
    assert np.isnan(log["/encoders.position"][1::2]).all()
    assert np.array_equal(log["tau"][1::2], [0, 0.5, 1, 1.5])
    even = log.resample(0.01, hold=["tau"])
    assert np.array_equal(even["/encoders.position"][:, 0], np.arange(5))
    assert "2 clocks were united" in log.notes[-1]
    stamped = wb.Dataset.from_mcap(tmp_path, ["/encoders.position[0]"], time="header.stamp")  # the folder of rosbag2
    assert np.array_equal(stamped["/encoders.position"].ravel(), np.arange(5))
    assert f"{EPOCH - 1}.998000000 s" in stamped.notes[0]
    with pytest.raises(ValueError, match="messages of '/effort', std_msgs/msg/Float64, have none"):
        wb.Dataset.from_mcap(path, time="header.stamp")
    with pytest.raises(LookupError, match="its topics are /encoders, /effort"):
        wb.Dataset.from_mcap(path, ["/wheels.position"])


def test_an_mcap_file_may_hold_json_and_damage_is_refused(tmp_path):
    path = write_json_mcap(
        tmp_path / "json.mcap", [f'{{"a": {{"b": [{i}, 1]}}, "on": true, "word": "x"}}' for i in range(3)]
    )
    log = wb.Dataset.from_mcap(path)
    assert log.signals.labels == ("/state.a.b[0]", "/state.a.b[1]", "/state.on")
    assert np.array_equal(log.experiments[0].values, [[0, 1, 1], [1, 1, 1], [2, 1, 1]])
    (tmp_path / "cut.mcap").write_bytes(path.read_bytes()[:60])
    with pytest.raises(ValueError, match=r"a whole MCAP file; 'cut\.mcap' is none"):
        wb.Dataset.from_mcap(tmp_path / "cut.mcap")
    (tmp_path / "old.db3").touch()
    with pytest.raises(ValueError, match="convert it by `ros2 bag convert`"):
        wb.Dataset.from_mcap(tmp_path / "old.db3")


def test_a_ulog_file_gives_fields_of_topics_and_instances(tmp_path):
    attitudes = [(1000 + 4000 * i, (1.0, 0.25 * i, 0.0, 0.0)) for i in range(4)]
    gyros = [(1000 + 4000 * i, instance, i + 0.5 * instance) for i in range(4) for instance in (0, 1)]
    path = write_ulog(tmp_path / "flight.ulg", attitudes, gyros, dropout_ms=20)
    log = wb.Dataset.from_ulog(path, units={"gyro.x": "rad/s"})
    assert np.array_equal(log.experiments[0].t, 0.004 * np.arange(4))
    assert np.array_equal(log["attitude.q"][:, 1], [0, 0.25, 0.5, 0.75])
    assert np.array_equal(log["gyro#1.x"] - log["gyro.x"], np.full(4, 0.5))
    assert any("lost samples 1 times, for 0.02 s" in note for note in log.notes)
    one = wb.Dataset.from_ulog(path, ["rate"], names={"gyro.x": "rate"})
    assert np.array_equal(one["rate"], np.arange(4))
    (tmp_path / "none.ulg").write_bytes(b"no log at all, and long enough for a header")
    with pytest.raises(ValueError, match=r"must be a ULog file; 'none\.ulg' is none"):
        wb.Dataset.from_ulog(tmp_path / "none.ulg")


def test_simulated_runs_are_experiments_with_their_states_and_outputs():
    ode = wb.open_loop(wb.DCMotor())
    runs = wb.simulate(wb.rk4(ode, 1e-2), ode.parameters.pack({"v": np.array([1.0, 2.0])}), until=0.1)
    log = wb.Dataset.from_runs(runs, ["omega", "i"])
    assert log.names == ("run 0", "run 1")
    assert np.array_equal(log.experiment("run 1")["omega"], runs["omega"].reshape(2, -1)[1])
    assert [entry.unit for entry in log.signals.entries] == ["rad/s", "A"]


MISSING = {
    "mcap.reader": ("from_mcap", "[logs]"),
    "pyulog": ("from_ulog", "[logs]"),
    "pyarrow": ("from_parquet", "[data]"),
}


@pytest.mark.parametrize("library", MISSING)
def test_a_reader_without_its_library_says_what_to_install(file, monkeypatch, library):
    method, extra = MISSING[library]
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(LookupError, match=f"not installed: pip install control-workbench{re.escape(extra)}"):
        getattr(wb.Dataset, method)(file("", "log.bin"))
