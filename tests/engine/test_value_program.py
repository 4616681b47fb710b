"""The program of a metric's value finds the same bits as the metric, and what it cannot hold is refused by name."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
import pytest
import scipy.special

from tests.support.equations import decay
from tests.support.metric_programs import HORIZON, ODD, RUNS, STEP, bits, catalogue, pair, some_runs
from workbench.core import Entry, Layout
from workbench.engine import simulate
from workbench.engine.arithmetic import advance_states
from workbench.engine.metrics import AbstractMetric, peak_error, step_with_metrics
from workbench.engine.metrics.accumulators import final_values
from workbench.engine.metrics.contract import Integral
from workbench.engine.metrics.measured_equation import MeasuredEquation, accumulators_in, values
from workbench.engine.metrics.value_program import program_of

MEASURED = MeasuredEquation.of(pair(), catalogue(), HORIZON)
METRICS = MEASURED.metrics
RUNS_OF_ALL = some_runs(METRICS)
STEP_OF_ALL = RUNS_OF_ALL.step


@pytest.mark.parametrize("metric", METRICS, ids=lambda metric: metric.name)
def test_a_program_has_the_bits_of_the_metric_in_runs_that_settle_never_settle_and_diverge(metric):
    runs = RUNS_OF_ALL
    assert 20 < runs.has_diverged.sum() < RUNS - 20
    x = runs.x[:, -1]
    z = advance_states(runs.job, x, round(HORIZON / STEP), 1)
    wanted, found = final_values(runs, METRICS)[metric.name], program_of(STEP_OF_ALL, metric, runs.t[-1]).evaluate(x, z)
    assert found.shape == wanted.shape == (RUNS, 2)
    np.testing.assert_array_equal(bits(found), bits(wanted))


def test_the_runs_have_times_that_are_infinite_and_finite_ones():
    found = final_values(RUNS_OF_ALL, METRICS)["settling time"]
    assert np.isinf(found).sum() > 20
    assert np.isfinite(found).sum() > 20


@pytest.mark.parametrize("metric", METRICS, ids=lambda metric: metric.name)
def test_a_program_has_the_bits_of_the_metric_for_odd_accumulators(metric):
    rng = np.random.default_rng(19)
    states = rng.choice([*ODD, *rng.normal(size=20), *rng.normal(size=5) * 1e12], (2000, STEP_OF_ALL.states.size))
    held = accumulators_in(STEP_OF_ALL, METRICS)
    rows = np.hstack([states[:, STEP_OF_ALL.states.slice(name)] for name in held.names])
    with np.errstate(all="ignore"):
        wanted = values(METRICS, held, rows, HORIZON)[metric.name]
    found = program_of(STEP_OF_ALL, metric, HORIZON).evaluate(states, states)
    # the sign of the larger of 0 and -0 is NumPy's own on each machine; in a run such a time is never -0
    signed = bits(found) == bits(wanted)
    assert (signed | ((found == 0) & (wanted == 0))).all()
    if metric.name != "settling time":
        assert signed.all()


def test_integrals_are_read_at_the_horizon_and_memories_one_step_later():
    step, runs = STEP_OF_ALL, RUNS_OF_ALL
    area, largest = (program_of(step, metric, HORIZON) for metric in METRICS[2:12:6])
    labels = [step.states.labels[place] for _, place in (*area.inputs, *largest.inputs)]
    assert [name for name, _ in (*area.inputs, *largest.inputs)] == ["x", "x", "z", "z"]
    assert labels == ["integral of IAE[0]", "integral of IAE[1]", "peak error.peak[0]", "peak error.peak[1]"]
    later = advance_states(runs.job, runs.x[:, -1], round(HORIZON / STEP), 1)
    rows = MEASURED.accumulators.unpack(MEASURED.totals(runs))
    np.testing.assert_array_equal(rows["peak error.peak"], later[:, step.states.slice("peak error.peak")])


def test_only_what_the_value_needs_is_in_the_program():
    settling = next(metric for metric in METRICS if metric.name == "settling time")
    program = program_of(STEP_OF_ALL, settling, HORIZON)
    labels = {STEP_OF_ALL.states.labels[place].partition("[")[0] for _, place in program.inputs}
    assert labels == {f"settling time.{name}" for name in ("since", "outside", "longest")}
    assert len(set(program.nodes)) == len(program.nodes)


@pytest.mark.parametrize("metric", METRICS, ids=lambda metric: metric.name)
def test_a_program_is_plain_json_with_operands_before_their_use(metric):
    program = program_of(STEP_OF_ALL, metric, HORIZON)
    plain = json.loads(json.dumps(program.plain(), allow_nan=False))
    assert plain["inputs"] == [list(place) for place in program.inputs]
    for i, (operation, *operands) in enumerate(plain["nodes"], start=len(plain["inputs"])):
        if operation == "const":
            assert float(operands[0]) == program.nodes[i - len(plain["inputs"])][1]
        else:
            assert all(operand < i for operand in operands)
    assert len(plain["results"]) == len(metric.labels)


def of(finish):
    """The integral of e, turned by a function of the user's own."""
    return Integral("own", "m", "", lambda t, y: y["e"], finish)


def program_of_own(finish):
    step = step_with_metrics(decay(), [of(finish)], 0.1)
    return program_of(step, of(finish), 1.0), step.states.size


FINISHES = {
    "the square": lambda i, T: i**2,
    "the root": lambda i, T: i**0.5,
    "np.square": lambda i, T: np.square(i) + 1,
    "an array made by asarray": lambda i, T: 2 * np.asarray(np.sqrt(i)) - T,
    "constants of NumPy": lambda i, T: np.float64(T) - i / np.array([[3]]) + np.int64(2),
    "indices": lambda i, T: i[:, [0, 0]] - i[:, :1],
    "shapes": lambda i, T: np.reshape(i, (len(i), -1)) + np.ravel(i).reshape(i.shape),
    "joined numbers": lambda i, T: np.hstack([i, -i, 0 * i + np.ones((len(i), 1))]),
    "signs": lambda i, T: np.where(i < 0, -np.abs(i), np.minimum(i, 0.25)),
    "truths": lambda i, T: np.where((i > 0.1) & ~(i >= 0.2) | np.isnan(i) | np.isinf(i), np.floor(10 * i), i != 0),
    "finite numbers": lambda i, T: np.where(np.logical_not(np.isfinite(i)), 0.0, +i),
    "a truth times a number": lambda i, T: (i <= 0.5) * i + (i == 1.0) * np.fabs(i),
}


@pytest.mark.parametrize("finish", FINISHES.values(), ids=FINISHES)
def test_a_metric_of_ones_own_has_a_program_too(finish):
    program, size = program_of_own(finish)
    rng = np.random.default_rng(20)
    states = rng.choice([*ODD, *rng.normal(size=30)], (500, size))
    place = step_with_metrics(decay(), [of(finish)], 0.1).states.slice("integral of own")
    with np.errstate(all="ignore"):
        wanted = finish(states[:, place], 1.0)
    np.testing.assert_array_equal(bits(program.evaluate(states, states)), bits(np.asarray(wanted, dtype=float)))


@pytest.mark.parametrize("a", [0.0, -0.0])
def test_the_larger_of_two_zeros_is_plus_zero_and_the_smaller_one_minus_zero(a):
    program, size = program_of_own(lambda i, T: np.hstack([np.maximum(i, -a), np.minimum(-a, i)]))
    state = np.full((1, size), a)
    assert np.signbit(program.evaluate(state, state)).tolist() == [[False, True]]


REFUSED = {
    "`np.exp`": lambda i, T: np.exp(-i),
    "`np.log`": lambda i, T: np.log(i),
    "`np.power`": lambda i, T: np.power(i, 2),
    "a power of 3": lambda i, T: i**3,
    "a power of a changing number": lambda i, T: i**i,
    "`np.erf`": lambda i, T: scipy.special.erf(i),
    "`np.add.reduce`": lambda i, T: np.add.reduce(i, axis=1),
    "`np.sum`": lambda i, T: np.sum(i, axis=1, keepdims=True),
    "`np.cumsum`": lambda i, T: np.cumsum(i, axis=1),
    "`np.add` with `out`": lambda i, T: np.add(i, 1.0, out=np.ones((1, 1))),
    "`np.where` of a number that is not a comparison": lambda i, T: np.where(i, 1.0, 2.0),
    "`np.add` of truths": lambda i, T: (i > 0) + (i < 0),
    "`np.logical_and`": lambda i, T: np.where(np.logical_and(i, i > 0), 1.0, 2.0),
    "a branch on a number of the run": lambda i, T: i if i[0, 0] > 0 else -i,
    "a number of the run as a `float`": lambda i, T: np.array([[float(i[0, 0])]]),
    "numbers of kind complex128": lambda i, T: i * 1j,
    "an answer of shape (1,)": lambda i, T: i[0],
    "an answer of shape (1, 0)": lambda i, T: i[:, :0],
    "an operation that raised TypeError": lambda i, T: i.__setitem__(0, 1.0) or i,
    "an operation that raised ZeroDivisionError: float division by zero": lambda i, T: i * (1.0 / 0.0),
}


def test_an_array_of_doubles_made_of_a_run_is_refused_by_name():
    with pytest.raises(ValueError, match="it needs a number of the run as a `float`"):
        program_of_own(lambda i, T: np.asarray(i, dtype=float))


@pytest.mark.parametrize(("operation", "finish"), REFUSED.items(), ids=REFUSED)
def test_an_operation_that_no_program_has_is_refused_by_metric_and_name(operation, finish):
    with pytest.raises(ValueError, match="The value of the metric 'own' cannot be written as a program") as refusal:
        program_of_own(finish)
    assert f"it needs {operation.partition(' raised TypeError')[0]}" in str(refusal.value)


@dataclass(frozen=True)
class Last(AbstractMetric):
    """The last value of an output, with a memory that is a matrix."""

    watches = ("e",)

    def memory(self, size):
        return Layout((Entry("seen", np.zeros((2, 3))),))

    def update(self, k, h, z, y):
        return {"seen": z["seen"] + ca.DM([[1, 2, 3], [4, 5, 6]]) * y["e"]}

    def value(self, integral, z, horizon):
        return z["seen"][:, 1, :] / horizon


def test_a_memory_that_is_a_matrix_is_read_in_its_shape():
    metric = Last("last", "", "")
    runs = simulate(step_with_metrics(decay(), [metric], 0.1), until=1.0, every=1.0, arithmetic="portable")
    later = advance_states(runs.job, runs.x[:, -1], 10, 1)
    found = program_of(runs.step, metric, 1.0).evaluate(runs.x[:, -1], later)
    np.testing.assert_array_equal(found, final_values(runs, [metric])["last"])
    assert found[0, 2] == pytest.approx(1.5 * found[0, 0])


def test_a_metric_that_the_step_does_not_accumulate_is_refused():
    with pytest.raises(ValueError, match=r"metric 'peak error' cannot be written.*KeyError: 'peak'"):
        program_of(step_with_metrics(decay(), [], 0.1), peak_error(), 1.0)


def test_a_horizon_that_is_no_time_is_refused():
    with pytest.raises(ValueError, match=r"`program_of\(horizon=...\)` must be a positive, finite number of seconds"):
        program_of(STEP_OF_ALL, replace(METRICS[0]), np.nan)
