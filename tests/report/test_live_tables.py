"""The tables of a live page, run by Node and by Chromium: the bits of metrics, the text of numbers, the cells."""

from __future__ import annotations

import base64
import json
import subprocess
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

from tests.support.browsers import CHROMIUM, NODE
from tests.support.metric_programs import HORIZON, ODD, STEP, bits, catalogue, pair, some_runs
from workbench.engine import simulate
from workbench.engine.arithmetic import continued
from workbench.engine.metrics.accumulators import final_values
from workbench.engine.metrics.measured_equation import MeasuredEquation
from workbench.engine.metrics.measurement import error_of
from workbench.engine.metrics.value_program import program_of
from workbench.report.number_text import Printed, measured, paddings, printed
from workbench.report.table_text import grid, plain
from workbench.study.document.document import Column, Diverged, Table

LIVE = files("workbench.report") / "templates" / "live"
SCRIPT = (LIVE / "tables.js").read_text("utf-8")
HEAD = """
const given = JSON.parse(require("fs").readFileSync(0, "utf8"));
const doubles = (text) => new Float64Array(Uint8Array.from(Buffer.from(text, "base64")).buffer);
const packed = (numbers) => Buffer.from(Float64Array.from(numbers).buffer).toString("base64");
"""

METRICS = MeasuredEquation.of(pair(), catalogue(), HORIZON).metrics


def packed(numbers):
    return base64.b64encode(np.ascontiguousarray(numbers, dtype="<f8").tobytes()).decode()


def doubles(text):
    return np.frombuffer(base64.b64decode(text), dtype="<f8")


@pytest.fixture(scope="session")
def node(tmp_path_factory):
    """Run lines of JavaScript behind those of the tables, with `given` from Python; their `answer` comes back."""
    if NODE is None:
        pytest.skip("this machine has no Node")

    def run(lines, given):
        file = tmp_path_factory.mktemp("node") / "lines.js"
        file.write_text(f"{SCRIPT}\n{HEAD}\n{lines}\nprocess.stdout.write(JSON.stringify(answer));\n", "utf-8")
        done = subprocess.run(
            [NODE, str(file)], input=json.dumps(given, allow_nan=False), capture_output=True, text=True, timeout=120
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


def ends_of(runs):
    x = runs.x[:, -1]
    return x, continued(runs.job, x, round(HORIZON / runs.step.h), 1)


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
    lost = [[bool(gone) for gone in runs.diverged] for runs in (whole, half)]
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
        assert found == as_dict(measured(value, error)), (value, error)


@pytest.mark.parametrize("digits", [1, 3, 4])
def test_a_number_without_an_error_has_the_text_of_the_printed_page(node, digits):
    values = odd_values(np.random.default_rng(23), 4000)
    lines = "const answer = Array.from(doubles(given.values), (value) => printedText(value, given.digits));"
    answer = node(lines, {"values": packed(values), "digits": digits})
    for value, found in zip(values, answer, strict=True):
        assert found == as_dict(printed(float(value), digits)), value


def test_the_time_of_a_divergence_has_the_words_of_the_printed_page(node):
    times = [*np.abs(odd_values(np.random.default_rng(24), 300)), 3.21, 3.125, 0.0125, 50.0, 100.16]
    table = Table("t", "c", (Column("a"),), tuple((Diverged(float(at)),) for at in times))
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
    columns = [[measured(v, abs(v) * 10.0 ** rng.uniform(-6, 0)) for v in rng.choice(values, 6)] for _ in range(100)]
    lines = """
        const answer = given.map((numbers) => numbers.map((number) => new NumberFrame(numbers).padding(number)));
    """
    answer = node(lines, [[as_dict(number) for number in column] for column in columns])
    for column, found in zip(columns, answer, strict=True):
        wanted = [{"before": p.before, "behind": p.behind, "power": p.power} for p in paddings(column)]
        assert found == wanted


PAGE = """<!DOCTYPE html><html><head><meta charset="utf-8"><style>%s</style></head><body><table><tbody>
<tr><th>law</th><td class="ALIGN" data-cell="0">
<span class="number"><span class="pad" data-pad="1"></span>1.234(5)</span></td>
<td class="ALIGN" data-cell="1"><span class="number">0.12(1)</span></td><td>7</td></tr>
<tr><th>law</th><td class="ALIGN" data-cell="2">
<span class="number">11.2(1)<span class="pad" data-pad="00"></span></span></td>
<td class="ALIGN" data-cell="3"><span class="number">3(1)<span class="pad" data-pad=".00"></span></span></td>
<td data-cell="99">8</td></tr>
</tbody></table><pre id="seen"></pre><script>%s
const data = {
  cells: [0, 1, 2, 3].map((i) => {
    return { table: "t", column: 1 + i %% 2, loop: i >> 1, metric: i %% 2, number: 0, scale: 1 };
  }),
  loops: [
    { label: "a", scores: [[[1.234, 0.005]], [[0.12, 0.01]]] },
    { label: "b", scores: [[[11.2, 0.1]], [[NaN, NaN]]] },
  ],
};
const cells = () => [...document.querySelectorAll("td")];
const before = cells().map((cell) => cell.innerHTML);
const tables = openTables(document, data), seen = [];
const texts = () => cells().map((cell) => {
  const live = cell.querySelector(".live-number");
  return live ? [live.className, live.getAttribute("aria-live"), live.textContent] : cell.textContent.trim();
});
const widths = () => cells().map((cell) => cell.getBoundingClientRect().width);
const ends = (element) => {
  const range = document.createRange();
  range.selectNodeContents(element);
  const { left, right } = range.getBoundingClientRect();
  return [left, right];
};
const pairs = () => cells().filter((cell) => cell.querySelector(".live-number:not(.words)"))
  .map((cell) => [ends(cell.querySelector(".number")), ends(cell.querySelector(".live-number"))]);
const look = () => seen.push({ texts: texts(), widths: widths(), pairs: pairs() });
look();
tables.show(0, [[[1.3512, null]], [[0.5, null]]]); look();
tables.show(0, [[[1.3512, 0.0014]], [[0.5, 0.1]]]); look();
tables.show(1, [[[NaN, null]], null], 3.208); look();
tables.show(1, [[[2e-7, 1e-9]], null]); look();
tables.show(0, [[[-1.5, 0.1]], [[0.5, 0.1]]]); look();
tables.show(0, [[[1.3, 0.1]], [[0.5, 0.1]]]); look();
tables.show(0, null); look();
tables.clear(); look();
seen.push({ same: cells().every((cell, i) => cell.innerHTML === before[i]) });
document.getElementById("seen").textContent = JSON.stringify(seen);
</script></body></html>"""


@pytest.fixture(scope="session", params=["center", "right"])
def seen(tmp_path_factory, request):
    """The cells of a small page after each call, and the widths of their columns, in Chromium."""
    if CHROMIUM is None:
        pytest.skip("this machine has no Chromium")
    folder = tmp_path_factory.mktemp("chromium")
    style = (LIVE.parent / "style.css").read_text("utf-8") + (LIVE / "tables.css").read_text("utf-8")
    (folder / "page.html").write_text(PAGE.replace("ALIGN", request.param) % (style, SCRIPT), "utf-8")
    flags = ["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", f"--user-data-dir={folder / 'profile'}"]
    call = [CHROMIUM, *flags, "--dump-dom", (folder / "page.html").as_uri()]
    page = subprocess.run(call, capture_output=True, text=True, timeout=120).stdout
    return json.loads(page.partition('<pre id="seen">')[2].partition("</pre>")[0])


def test_a_coarse_number_has_three_digits_and_is_marked(seen):
    assert seen[1]["texts"] == [
        ["live-number coarse", "off", "1.35"],
        ["live-number coarse", "off", "0.500"],
        *("7", "11.2(1)", "3(1)", "8"),
    ]


def test_a_fine_number_has_its_error_in_brackets(seen):
    assert seen[2]["texts"][:2] == [["live-number", "off", "1.3512(14)"], ["live-number", "off", "0.50(10)"]]


def test_a_run_that_diverged_says_when_in_each_of_its_cells(seen):
    words = ["live-number words", "off", "diverged at 3.21 s"]
    assert seen[3]["texts"][3:] == [words, words, "8"]


def test_a_metric_without_a_program_stays_as_printed(seen):
    assert seen[4]["texts"][3:] == [["live-number", "off", "2.000(10)\u2009×\u200910−7"], "3(1)", "8"]


def test_what_is_cleared_is_as_printed(seen):
    assert seen[7]["texts"][:3] == ["1.234(5)", "0.12(1)", "7"]
    assert seen[8] == seen[0]
    assert seen[9]["same"]


def test_a_column_keeps_its_width_from_the_coarse_number_to_the_fine_one_and_beside_words(seen):
    for look in seen[2:4]:
        assert look["widths"] == pytest.approx(seen[1]["widths"], abs=0.1)
    # a power of ten and a sign have widened the column, which then stays
    assert seen[6]["widths"] == pytest.approx(seen[5]["widths"], abs=0.1)


def test_a_live_number_stands_in_the_frame_of_the_printed_one_so_that_their_points_are_aligned(seen):
    pairs = [pair for look in seen[:9] for pair in look["pairs"]]
    assert len(pairs) == 16
    for number, live in pairs:
        assert live == pytest.approx(number, abs=1.0)  # px


def test_the_printed_numbers_of_these_tests_are_printed_as_the_page_does():
    assert measured(1.3512, 0.0014) == Printed("", "1", ".3512(14)")
    assert measured(2e-7, 1e-9) == Printed("", "2", ".000(10)", "−7")
