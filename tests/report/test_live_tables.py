"""The tables of a live page, run by Node and by Chromium: the bits of metrics, the text of numbers, the cells."""

from __future__ import annotations

import base64
from dataclasses import replace

import numpy as np
import pytest

from tests.support.browsers import NODE
from tests.support.metric_programs import HORIZON, ODD, STEP, bits, catalogue, pair, some_runs
from tests.support.node import answered
from tests.support.table_script import SCRIPT
from workbench.engine import simulate
from workbench.engine.arithmetic import advance_states
from workbench.engine.metrics.accumulators import final_values
from workbench.engine.metrics.measured_equation import MeasuredEquation
from workbench.engine.metrics.measurement import error_of
from workbench.engine.metrics.value_program import program_of
from workbench.report.number_text import number_text, number_text_with_error, paddings
from workbench.report.table_text import grid, plain
from workbench.study.document.document import DivergedCell, ReportTable, TableColumn

HEAD = """
const doubles = (text) => new Float64Array(Uint8Array.from(Buffer.from(text, "base64")).buffer);
const packed = (numbers) => Buffer.from(Float64Array.from(numbers).buffer).toString("base64");
"""
METRICS = MeasuredEquation.of(pair(), catalogue(), HORIZON).metrics


def packed(numbers):
    return base64.b64encode(np.ascontiguousarray(numbers, dtype="<f8").tobytes()).decode()


def doubles(text):
    return np.frombuffer(base64.b64decode(text), dtype="<f8")


@pytest.fixture(scope="session")
def node():
    """Run lines of JavaScript behind those of the tables, with `given` from Python; their `answer` comes back."""
    if NODE is None:
        pytest.skip("this machine has no Node")
    return lambda lines, given: answered(f"{SCRIPT}\n{HEAD}\n{lines}\nreturn answer;", given)


def ends_of(runs):
    x = runs.x[:, -1]
    return x, advance_states(runs.job, x, round(HORIZON / runs.step.h), 1)


def test_a_program_has_the_same_bits_in_javascript_and_python(node):
    runs = some_runs(METRICS)
    programs = [program_of(runs.step, metric, HORIZON) for metric in METRICS]
    rng = np.random.default_rng(21)
    odd = rng.choice([*ODD, *rng.normal(size=30)], (2, 1000, runs.step.states.size))
    x, z = (np.vstack([end, rows]) for end, rows in zip(ends_of(runs), odd, strict=True))
    given = {"x": packed(x), "z": packed(z), "nx": x.shape[1], "programs": [program.plain() for program in programs]}
    answer = node(
        """
        const x = doubles(given.x), z = doubles(given.z), answer = given.programs.map((program) => {
          const found = [];
          for (let at = 0; at < x.length; at += given.nx) found.push(...evaluateProgram(program, x, at, z, at));
          return packed(found);
        });
        """,
        given,
    )
    for program, found in zip(programs, answer, strict=True):
        wanted = program.evaluate(x, z)
        np.testing.assert_array_equal(bits(doubles(found)), bits(wanted.ravel()))


def test_scores_of_a_loop_have_the_values_and_errors_of_a_measurement(node):
    whole = some_runs(METRICS)
    half_step, start = replace(whole.step, h=STEP / 2), whole.x[:, 0]
    half = simulate(half_step, whole.p, start, until=HORIZON, every=STEP, arithmetic="portable")
    programs = [program_of(whole.step, metric, HORIZON) for metric in METRICS]
    metrics = [
        {"program": program.plain(), "labels": list(metric.labels), "time": metric.is_time}
        for metric, program in zip(METRICS, programs, strict=True)
    ]
    ends = [ends_of(runs) for runs in (whole, half)]
    lost = [[bool(gone) for gone in runs.has_diverged] for runs in (whole, half)]
    given = {
        "loop": {"metrics": metrics, "whole": {"h": STEP}},
        "runs": [
            [None if gone else {"x": packed(x), "z": packed(z)} for gone, x, z in zip(those, xs, zs, strict=True)]
            for those, (xs, zs) in zip(lost, ends, strict=True)
        ],
    }
    answer = node(
        """
        const ends = (run) => run && { x: doubles(run.x), z: doubles(run.z) };
        const [whole, half] = given.runs.map((runs) => runs.map(ends));
        const pairs = whole.map((run, i) => scoresOf(given.loop, run, half[i]));
        const alone = whole.map((run) => scoresOf(given.loop, run));
        const answer = [packed(pairs.flat(3)), packed(alone.flat(2).map(([value]) => value)),
          alone.flat(2).every(([, error]) => error === null)];
        """,
        given,
    )
    values, halved = (np.hstack(list(final_values(runs, METRICS).values())) for runs in (whole, half))
    least = [STEP if metric.is_time else 0.0 for metric in METRICS for _ in metric.labels]
    errors = error_of(values, halved, least)
    errors = np.where(np.isnan(errors) & ~np.isnan(values), np.inf, errors)
    wanted = np.stack([values, errors], axis=-1)
    np.testing.assert_array_equal(bits(doubles(answer[0])), bits(wanted.ravel()))
    np.testing.assert_array_equal(bits(doubles(answer[1])), bits(values.ravel()))
    assert answer[2]


def test_a_metric_without_a_program_has_no_score(node):
    given = {"loop": {"metrics": [{"program": None, "labels": ["a"], "time": False}], "whole": {"h": 1.0}}}
    assert node("const answer = [scoresOf(given.loop, null), scoresOf(given.loop, null, null)];", given) == [[None]] * 2


@pytest.mark.parametrize("value", ODD)
@pytest.mark.parametrize("least", [0.0, 0.01])
def test_an_error_is_twice_the_change_to_the_bit(node, value, least):
    given = {"value": packed([value]), "half": packed(ODD), "least": least}
    lines = """
        const [value] = doubles(given.value);
        const answer = packed(doubles(given.half).map((half) => errorOfValue(value, half, given.least)));
    """
    with np.errstate(over="ignore"):
        wanted = error_of(np.full((len(ODD), 1), value), np.reshape(ODD, (-1, 1)), [least])[:, 0]
    wanted = np.where(np.isnan(wanted) & ~np.isnan(value), np.inf, wanted)
    np.testing.assert_array_equal(bits(doubles(node(lines, given))), bits(wanted))


def odd_values(rng, count):
    """Values of all sizes, with many halves that a rounding must decide, and round ones."""
    sizes = np.concatenate([10.0 ** rng.uniform(-12, 12, count), 10.0 ** rng.uniform(-300, 300, count // 10)])
    halves = rng.integers(-4000, 4000, count) / rng.choice([2, 4, 8, 16, 64, 256], count)
    short = np.round(rng.normal(size=count), 3) * 10.0 ** rng.integers(-5, 9, count)
    return np.concatenate([sizes * rng.choice([-1, 1], len(sizes)), halves, short, [0.0, -0.0, 1e5, 99999.5, 1e-3]])


def as_dict(number):
    return {"sign": number.sign, "whole": number.whole, "tail": number.tail, "power": number.power}


def test_a_measured_number_has_the_text_of_the_printed_page(node):
    rng = np.random.default_rng(22)
    values = odd_values(rng, 4000)
    errors = np.abs(rng.permutation(values)) * rng.choice([0, 1e-9, 1e-3, 0.1, 1], len(values))
    near = np.abs(values) * 10.0 ** rng.uniform(-7, 1, len(values))
    pairs = [*zip(values, errors, strict=True), *zip(values, near, strict=True)]
    lines = """
        const values = doubles(given.values), errors = doubles(given.errors);
        const answer = Array.from(values, (value, i) => measuredText(value, errors[i]));
    """
    answer = node(lines, {"values": packed([v for v, _ in pairs]), "errors": packed([e for _, e in pairs])})
    for (value, error), found in zip(pairs, answer, strict=True):
        assert found == as_dict(number_text_with_error(value, error)), (value, error)


@pytest.mark.parametrize("digits", [1, 3, 4])
def test_a_number_without_an_error_has_the_text_of_the_printed_page(node, digits):
    values = odd_values(np.random.default_rng(23), 4000)
    lines = "const answer = Array.from(doubles(given.values), (value) => printedText(value, given.digits));"
    answer = node(lines, {"values": packed(values), "digits": digits})
    for value, found in zip(values, answer, strict=True):
        assert found == as_dict(number_text(float(value), digits)), value


def test_the_time_of_a_divergence_has_the_words_of_the_printed_page(node):
    times = [*np.abs(odd_values(np.random.default_rng(24), 300)), 3.21, 3.125, 0.0125, 50.0, 100.16]
    table = ReportTable("t", "c", (TableColumn("a"),), tuple((DivergedCell(float(at)),) for at in times))
    wanted = [plain(row[0].content) for row in grid(table)]
    lines = "const answer = Array.from(doubles(given.times), (at) => scoreText(NaN, null, at));"
    assert node(lines, {"times": packed(times)}) == wanted
    assert "diverged at 3.21 s" in wanted


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (np.inf, 0.0, "never"),
        (np.inf, None, "never"),
        (-np.inf, 0.0, "no value"),
        (np.nan, np.nan, "no error estimate"),
        (np.nan, None, "no value"),
        (-np.inf, None, "no value"),
        (1.0, np.nan, "no error estimate"),
        (1.0, np.inf, "no error estimate"),
    ],
)
def test_a_score_that_is_no_number_says_so_in_words(node, value, error, text):
    given = {"value": packed([value]), "error": None if error is None else packed([error])}
    lines = "const answer = scoreText(doubles(given.value)[0], given.error && doubles(given.error)[0], null);"
    assert node(lines, given) == text


def test_numbers_are_padded_to_their_column_as_on_the_printed_page(node):
    rng = np.random.default_rng(25)
    values = odd_values(rng, 200)
    columns = [
        [number_text_with_error(v, abs(v) * 10.0 ** rng.uniform(-6, 0)) for v in rng.choice(values, 6)]
        for _ in range(100)
    ]
    lines = """
        const answer = given.map((numbers) => numbers.map((number) => new NumberFrame(numbers).padding(number)));
    """
    answer = node(lines, [[as_dict(number) for number in column] for column in columns])
    for column, found in zip(columns, answer, strict=True):
        wanted = [{"before": p.before, "behind": p.behind, "power": p.power} for p in paddings(column)]
        assert found == wanted
