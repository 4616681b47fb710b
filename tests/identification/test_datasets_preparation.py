"""Samples are prepared without loss: each step says in a note what it did, and refuses what it cannot do."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import lfilter

import workbench as wb
from workbench.core.recorded_step import recorded_step
from workbench.identification.datasets import Experiment


def log_of(t, **signals):
    return wb.Dataset.of(np.asarray(t), {name: np.asarray(values, dtype=float) for name, values in signals.items()})


def test_resampling_meets_lines_and_holds_and_leaves_gaps():
    rng = np.random.default_rng(2)
    t = np.sort(np.append(rng.uniform(0, 10, 400), [0.0, 10.0]))
    t = t[(t < 4) | (t > 5)]
    log = log_of(t, u=np.floor(t), y=3 * t - 1)
    even = log.resample(0.05, hold=["u"], gap=0.5)
    grid = even.experiments[0].t
    assert np.array_equal(grid, t[0] + 0.05 * np.arange(201))
    first, last = t[t < 4].max(), t[t > 5].min()
    is_gap = (grid > first) & (grid < last)
    assert np.array_equal(np.isnan(even["y"]), is_gap)
    assert np.array_equal(np.isnan(even["u"]), is_gap)
    assert even["y"][~is_gap] == pytest.approx(3 * grid[~is_gap] - 1, rel=0, abs=1e-13)  # rounding of a line
    held = np.array([log["u"][t <= one].max() for one in grid[~is_gap]])
    assert np.array_equal(even["u"][~is_gap], held)
    assert f"{2 * int(is_gap.sum())} numbers in gaps or outside" in even.notes[-1]
    assert not np.isnan(log.resample(0.05, gap=np.inf)["y"]).any()


def test_resampling_passes_over_marked_and_missing_samples():
    t = np.arange(0, 1.01, 0.1)
    y = 2 * t
    y[[3, 7]] = np.nan, 99.0
    even = log_of(t, y=y).mark_limits("y", high=50.0).resample(0.05)
    assert even["y"] == pytest.approx(2 * even.experiments[0].t, rel=0, abs=1e-15)
    assert "1 marked samples were passed over" in even.notes[-1]


def test_a_filter_without_phase_keeps_slow_sines_where_they_are_and_halves_its_cutoff():
    t = np.arange(0, 40, 0.01)
    log = log_of(t, slow=np.sin(2 * np.pi * 0.1 * t), edge=np.sin(2 * np.pi * 2 * t), other=t).filter(
        2.0, ["slow", "edge"]
    )
    inside = slice(1000, 3000)
    # the gain at 0.1 Hz is 1/(1 + (tan(0.1 pi h)/tan(2 pi h))^8), 1 to 1e-10; the ends reach not so far
    assert log["slow"][inside] == pytest.approx(np.sin(2 * np.pi * 0.1 * t)[inside], rel=0, abs=1e-6)
    assert log["edge"][inside] == pytest.approx(np.sin(2 * np.pi * 2 * t)[inside] / 2, rel=0, abs=1e-6)
    assert np.array_equal(log["other"], t)
    assert log.notes == ("Filtered at 2 Hz, order 4 forward and backward: slow, edge.",)


def test_a_derivative_of_a_cubic_is_exact_and_has_its_unit():
    t = np.arange(0, 2, 0.01)
    log = wb.Dataset.of(t, {"q": np.column_stack([t**3, t**2])}, {"q": "rad"}).differentiate("q", "qd", window=0.1)
    # rounding of 1 in q over a step of 0.01
    assert log["qd"] == pytest.approx(np.column_stack([3 * t**2, 2 * t]), rel=0, abs=1e-11)
    assert log.signals["qd"].unit == "rad/s"
    twice = log.differentiate("q[0]", "a", window=0.1, order=2)
    assert twice["a"] == pytest.approx(6 * t, rel=0, abs=1e-9)
    assert twice.signals["a"].unit == "rad/s^2"


def test_filters_refuse_uneven_missing_and_marked_samples():
    t = np.arange(0, 1, 0.01)
    uneven = log_of(np.where(t > 0.5, t + 0.003, t), y=t)
    with pytest.raises(
        ValueError, match=r"samples at even times; 'log' has periods from 0\.01 to 0\.013 s: write `log"
    ):
        uneven.filter(5.0)
    with pytest.raises(ValueError, match="at even times"):
        uneven.differentiate("y", "v", window=0.1)
    lost = log_of(t, y=np.where(t == t[5], np.nan, t))
    with pytest.raises(ValueError, match="'y' of 'log' has 1 that are NaN or marked"):
        lost.filter(5.0)
    with pytest.raises(ValueError, match="has 50 that are NaN or marked"):
        log_of(t, y=t).mark_limits("y", high=t[50]).filter(5.0)
    with pytest.raises(ValueError, match="below half of the rate, 50 Hz"):
        log_of(t, y=t).filter(50.0)
    with pytest.raises(ValueError, match="0.02 s are 3 samples"):
        log_of(t, y=t).differentiate("y", "v", window=0.02)


def test_outliers_are_marked_and_keep_their_values():
    rng = np.random.default_rng(3)
    t = np.arange(0, 20, 0.01)
    clean = np.sin(t) + 0.01 * rng.standard_normal(t.size)
    places = [100, 700, 701, 1500]
    y = clean.copy()
    y[places] += [0.5, -0.4, 0.3, 2.0]
    log = log_of(t, y=y, still=np.zeros(t.size)).mark_outliers(threshold=6.0)
    assert np.array_equal(log["y"], y)
    marks = log.experiments[0].marks
    assert np.flatnonzero(marks[:, 0]).tolist() == places
    assert not marks[:, 1].any()
    assert log.notes == ("Marked as outliers, 6 deviations off the median of 11 samples: 4 of y.",)
    assert not log.experiments[0].is_weighed[places, 0].any()


def test_one_quantum_is_no_outlier():
    y = np.zeros(200)
    y[[50, 120]] = 1.0, 8.0  # the smallest step is a quantum, and an encoder at rest jumps by one
    assert np.flatnonzero(log_of(np.arange(200.0), y=y).mark_outliers().experiments[0].marks).tolist() == [120]


@pytest.mark.parametrize(("keep", "kept"), [("first", 1.0), ("last", 3.0), ("mean", 2.0)])
def test_rows_of_one_time_become_one(keep, kept):
    log = log_of([0.0, 0.1, 0.1, 0.2], y=[0.0, 1.0, 3.0, 4.0]).merge_repeated(keep)
    assert np.array_equal(log.experiments[0].t, [0.0, 0.1, 0.2])
    assert np.array_equal(log["y"], [0.0, kept, 4.0])
    assert log.notes == (f"1 rows had the time of the row before them; the {keep} of each was used.",)


def test_logs_of_two_clocks_are_joined_and_signals_selected_and_converted():
    one = wb.Dataset.of(np.array([0.0, 0.2, 0.4]), {"u": np.array([1.0, 2.0, 3.0])}, {"u": "V"})
    two = wb.Dataset.of(np.array([0.1, 0.2]), {"h": np.array([5.0, 6.0])}, {"h": "cm"})
    log = one.join(two)
    assert np.array_equal(log["u"], [1, np.nan, 2, 3], equal_nan=True)
    assert np.array_equal(log["h"], [np.nan, 5, 6, np.nan], equal_nan=True)
    assert log.select(["h"]).signals.names == ("h",)
    metres = log.convert({"h": "m"})
    assert metres["h"][1] == 0.05
    assert metres.signals["h"].unit == "m"
    assert metres.notes[-1] == "Converted were h from cm to m."
    turned = wb.Dataset.of(np.arange(2.0), {"q": np.array([0.0, 180.0])}, {"q": "deg"}).convert({"q": "rad"})
    assert turned["q"][1] == pytest.approx(np.pi, rel=1e-15)
    with pytest.raises(ValueError, match=r"a unit of the same kind; 'u' is in \[V\], and got 'm'"):
        log.convert({"u": "m"})
    with pytest.raises(ValueError, match="distinct names"):
        one.join(one)


def delayed(hold, lag, seed):
    """A log of u and y with a delay of 11.4 periods of 0.02 s, which is marched in twentieths of a period."""
    rng = np.random.default_rng(seed)
    u = np.repeat(rng.choice([-1.0, 1.0], 80), 10)
    parts = 20 * np.arange(u.size)
    inner = np.arange(20 * u.size) - 228
    line = np.interp(inner, parts, u)
    held = u[np.clip(inner // 20, 0, None)]
    driven = held[:-1] if hold == "hold" else (line[:-1] + line[1:]) / 2  # over each twentieth
    a, y = np.exp(-0.001 / lag) if lag else 0.0, line if hold == "linear" else held
    if lag:
        y = np.append(0.0, lfilter([1 - a], [1, -a], driven))
    return log_of(0.02 * np.arange(u.size), u=u, y=0.4 + 2 * y[::20] + 0.05 * rng.standard_normal(u.size))


@pytest.mark.parametrize("hold", ["hold", "linear"])
@pytest.mark.parametrize("lag", [0.0, 0.15])
def test_a_delay_lies_within_its_interval(hold, lag):
    h, delay = 0.02, 0.228
    estimate = delayed(hold, lag, 5).estimate_delay("u", "y", longest=0.6, hold=hold)
    assert estimate.low <= delay <= estimate.high
    # without a lag a held input tells the delay to one period, and no better
    assert estimate.high - estimate.low < (1.01 * h if hold == "hold" and not lag else 0.5 * h)
    assert estimate.gain == pytest.approx(2, abs=0.05)  # noise of 0.05 in 800 samples, a hundredfold
    assert estimate.explained_share > 0.99


def test_a_measured_input_drives_a_loop_along_its_instants():
    rng = np.random.default_rng(6)
    t = np.cumsum(rng.uniform(0.005, 0.015, 200))
    v = rng.choice([-6.0, 6.0], 200)
    record = log_of(t, v=v).experiments[0].record(["v"])
    assert np.array_equal(record.begins, record.ends)
    assert np.array_equal(record.begins[:, 0], v[:-1])
    ode = wb.open_loop(wb.DCMotor())
    runs = wb.simulate(recorded_step(ode, record), until=199.0)  # whose time is the number of the instant
    A, B = (np.array(matrix(0.0, np.zeros(2), ode.parameters.default)) for matrix in (ode.A, ode.B))
    x = np.zeros((200, 2))
    for k, dt in enumerate(np.diff(t)):
        x[k + 1] = (expm(dt * np.block([[A, B], [np.zeros((1, 3))]])) @ [*x[k], v[k]])[:2]
    # one step of Runge and Kutta leaves (h lambda)^5/120, with h = 0.015 s and lambda = 10/s, of a state of 10
    assert runs.x[0] == pytest.approx(x, rel=0, abs=1e-4)
    line = log_of(t, v=v, w=v).experiments[0].record(["v", "w"], hold={"v": "linear"})
    assert np.array_equal(line.ends, np.column_stack([v[1:], v[:-1]]))


def test_a_hole_in_an_input_is_refused_by_name_time_and_row():
    t = np.arange(5) * 0.1
    with pytest.raises(ValueError, match=r"'v' of 'log' has nan at 0\.3 s, in row 3"):
        log_of(t, v=np.where(np.arange(5) == 3, np.nan, t)).experiments[0].record(["v"])
    with pytest.raises(ValueError, match=r"row 2 has 0\.1 s after 0\.1 s"):
        log_of([0.0, 0.1, 0.1], v=np.zeros(3)).experiments[0].record(["v"])
    with pytest.raises(LookupError, match="Did you mean 'v'"):
        log_of(t, v=t, w=t).experiments[0].record(["vv"])


def test_an_experiment_knows_the_evenness_of_its_times():
    t = np.array([float(f"{0.01 * i:.4f}") for i in range(100)])  # as a text of four places holds them
    assert log_of(t, y=t).experiments[0].is_uniform
    assert not log_of(np.append(t, 1.01), y=np.append(t, 1.0)).experiments[0].is_uniform
    empty = log_of([], y=[]).experiments[0]
    assert isinstance(empty, Experiment)
    assert not empty.is_uniform
    assert np.isnan(empty.period)
