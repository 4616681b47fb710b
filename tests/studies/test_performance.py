"""The study of speed: its measurements and its table; no time is asserted."""

import subprocess
import sys
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from tests.house import rules
from tests.house.sources import imports, sources
from tests.support.browsers import needs_chromium

pytest.importorskip("llvmlite", reason="the study of speed is that of the compiled march")

import workbench as wb
from studies.paper.workload import rows_of, run
from studies.performance import fit_rate, frequency_rate, live_page, measurements, pid_rate, study, synthesis_rate
from studies.performance.arithmetic import CHAINS, UNROLL_COUNT, flops, peak_sum
from studies.performance.figures import speed_figure
from studies.performance.measurements import Effort, Row
from studies.performance.peers import IN_MATRICES, PEERS, Peer, casadi_cvodes
from studies.performance.scipy_fit import ScipyEnd, run_arm
from workbench.core import Entry, Layout, Ode, rk4
from workbench.study import Results
from workbench.study.document.document import Figure, Panel, Series, Strong
from workbench.study.writeup import document

TINY = Effort(
    horizon=0.01,
    repetitions=1,
    processes=1,
    seconds=1e-9,
    runs=8,
    batch=8,
    samples=4,
    sizes=(8,),
    fallback=8,
    many=8,
    links=(2, 3),
)


def test_cvodes_comes_nearer_to_the_fine_reference_as_its_tolerance_shrinks():
    p, horizon = rows_of(3), 0.2
    wanted = run(p, horizon, 1e-5)
    errors = [measurements.error(casadi_cvodes(horizon, tolerance)(p), wanted) for tolerance in (1e-3, 1e-5, 1e-8)]
    assert errors[0] > 10 * errors[1] > 100 * errors[2]


def test_the_peak_kernel_adds_one_in_every_chain():
    rounds = 1000
    np.testing.assert_array_equal(peak_sum(rounds), rounds * UNROLL_COUNT * CHAINS)


def decays(n):
    """So many numbers that decay, each at its own rate."""
    states, parameters = (Layout((Entry(name, np.ones(n)),)) for name in ("x", "rate"))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    return rk4(Ode.of("decays", states, parameters, (t, x, p), {"x": -p * ca.sin(x)}, {"e": x}), 0.1)


def test_twice_the_equations_are_twice_the_operations():
    assert 4 * 10 < flops(decays(1), (0,)) < 4 * 60  # four sines by polynomials, and what is around them
    assert flops(decays(6), range(6)) == 6 * flops(decays(1), (0,))


def test_the_coarsest_setting_within_the_error_is_found_from_above():
    found = measurements.coarsest(lambda h: h**2, 1e-4, 1e-5, 1.0)
    assert found <= 1e-2 * (1 + 1e-9) < found * 10 ** (1 / measurements.STEPS_A_DECADE) * (1 + 2e-9)
    with pytest.raises(ValueError, match="has a larger error at every setting down to 0.1"):
        measurements.coarsest(lambda h: h, 1e-3, 0.1, 1.0)


def test_a_run_that_is_lost_counts_as_infinitely_wrong():
    assert measurements.error(np.array([[np.nan, 1.0]]), np.ones((1, 2))) == np.inf


def here(probe, *numbers, cache):
    """What `in_a_process` gives, without the process: the cache is that of the tests."""
    return {"wall": 1.0, **probe(*numbers)}


@pytest.mark.heavy
def test_the_table_has_a_row_for_each_bar(monkeypatch):
    first_result = measurements.first_result(TINY)  # by a process of its own, as one is enough to see
    monkeypatch.setattr(measurements, "in_a_process", here)
    monkeypatch.setattr(measurements, "first_result", lambda effort: first_result)
    there = Peer("one that is there", "numpy", 1e9, 2, lambda horizon: lambda p: run(p, horizon))
    absent = Peer("one that is not", "no_such_package", 7.0, 2, lambda horizon: pytest.fail("it is not there"))
    first, second, *rest = measurements.table_rows(TINY, (there, absent))
    assert len(rest) == len(measurements.EQUAL) + 8
    assert (first.is_reached, first.runs_per_s > 0, first.error < 1) == (False, True, True)
    assert (second.is_reached, second.value, second.note[:13]) == (None, None, "not installed")
    assert {row.name for row in rest if row.is_reached is None} <= {"two threads over one"}  # which needs two


def test_compile_time_is_fitted_over_the_size(monkeypatch):
    monkeypatch.setattr(measurements, "compilation", lambda effort: tuple((n, 10.0 * n, n**2 / 9) for n in (2, 4, 8)))
    assert measurements.growth(TINY).value == pytest.approx(2.0)


def test_the_report_tells_of_every_row():
    rows = [
        Row("slow peer", 10.0, 4.5, runs_per_s=3.0, error=1e-3),
        Row("absent peer", 14.0, note="not installed"),
        Row("memory", 1.0, 0.25, "GB", at_most=True, note="in 3 s"),
    ]
    assert study.bars(rows).rows == (
        ("slow peer", "3", "4.5 x", "≥ 10 x", "1.0e-03", Strong("MISSED")),
        ("absent peer", None, None, "≥ 14 x", None, "not measured"),
        ("memory", None, "0.25 GB", "≤ 1 GB", None, "reached"),
    )
    peers, bars = study.findings(rows)
    assert (peers.answer, [one.answer for one in peers.variations]) == (
        "the engine is faster",
        ["the engine is faster"],
    )
    assert (bars.answer, bars.kind) == (
        "1 of 2",
        "depends",
    )  # neither is near its figure, and on another machine 17 are reached
    assert "1 of 2 measured targets" in bars.statement
    assert "slow peer (4.5 x, target ≥ 10 x)" in bars.statement
    assert (
        "and 1 of 2 targets are reached. An earlier version reached 17 of 19 on a processor with AVX-512."
        in study.answer(rows)
    )
    assert "no peer was measured, and 1 of 1 targets are reached." in study.answer(rows[2:])
    (panel,) = speed_figure(rows).panels
    assert "slow peer" in [series.label for series in panel.series]
    assert "absent peer" not in [series.label for series in panel.series]


def test_a_bar_near_its_figure_leaves_the_count_open():
    rows = [Row("near", 10.0, 9.0), Row("far", 10.0, 40.0), Row("memory", 1.0, 0.9, "GB", at_most=True)]
    finding = study.bars_finding(rows)
    assert (finding.answer, finding.kind) == ("2 of 3", "open")
    assert {one.words: one.answer for one in finding.variations} == {
        "the page of 25 November 2026, on an AMD EPYC with AVX-512": "17 of 19",
        "near on the other side of its target": "3 of 3",
        "memory on the other side of its target": "1 of 3",
    }
    assert "2 numbers lie within 20 % of the target: near; memory." in finding.evidence[-1]


def test_peers_that_could_be_faster_in_scalars_are_compared_so_too():
    rows = [
        Row(name, 10.0, ratio, runs_per_s=3.0, error=1e-3) for name, ratio in zip(IN_MATRICES, (9e3, 2.0), strict=True)
    ]
    (finding,) = study.peer_findings(rows)
    assert [one.words for one in finding.reversals] == [f"{IN_MATRICES[1]}, if three times as fast in scalars"]
    assert set(IN_MATRICES) <= {peer.name for peer in PEERS}


def test_two_threads_are_not_measured_beside_other_processes(monkeypatch):
    for name, answer in (("getloadavg", (4.0, 4.0, 4.0)), ("sched_getaffinity", {0, 1}), ("sched_setaffinity", None)):
        monkeypatch.setattr(measurements.os, name, lambda *_, answer=answer: answer, raising=False)
    row = measurements.threads(TINY)
    assert (row.is_reached, row.note) == (None, "not measured: 3.0 other processes were running")


def test_the_page_of_speed_opens_with_its_bars_and_says_that_it_is_of_one_machine(monkeypatch):
    rows = (Row("slow peer", 10.0, 4.5, runs_per_s=3.0, error=1e-3), Row("memory", 1.0, 0.25, "GB", at_most=True))
    monkeypatch.setattr(study, "rows", lambda: rows)
    for name in ("precision", "flat", "compile"):
        empty = Figure(name, "", (Panel("rate", (Series("", np.arange(2.0), np.arange(2.0)),)),))
        monkeypatch.setattr(study, f"{name}_figure", lambda *arguments, empty=empty: empty)
    page = document(study.study, Results(), "")
    assert [one.name for one in page.findings] == ["faster_than_peers", "bars_reached"]
    assert str(page.answer).startswith("In one run on one machine, ")
    assert len(str(page.answer).split()) <= 40


@pytest.mark.heavy
def test_a_peer_is_imported_by_its_own_file_alone_and_only_when_it_runs():
    assert rules.open_side_doors({"studies/performance/peers.py": "import control"}) == []
    assert rules.open_side_doors({"studies/performance/study.py": "import control"})
    others = {path: text for path, text in sources("studies/performance").items() if not path.endswith("/peers.py")}
    tops = {module.partition(".")[0] for path, text in others.items() for _, module, _ in imports(path, text)}
    assert len(others) > 5
    assert not tops & {"jax", "numba"}
    code = "import sys, studies.performance.peers; sys.exit(bool({'jax', 'numba', 'control'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_pilot_chooses_steps_with_the_error_asked_for_in_the_runs_of_a_call(monkeypatch):
    effort = replace(TINY, horizon=0.1, batch=12, samples=6)
    runner, _ = measurements.by_pilot(1e-4, effort)
    found = runner(rows_of(effort.batch))
    assert found.shape == (12, 2)
    assert measurements.error(found, measurements.reference(effort)) <= 1e-4
    monkeypatch.setattr(measurements, "OURS", (1e-2, 1e-1))  # a search that finds nothing tries all there is
    with pytest.raises(ValueError, match="has a larger error at every setting down to"):
        measurements.by_pilot(1e-15, effort)


def test_without_a_browser_the_live_pages_are_not_measured(monkeypatch):
    monkeypatch.setattr(live_page, "program", lambda: None)
    rows = live_page.live_rows(TINY)
    assert [row.is_reached for row in rows] == [None] * 6
    assert {row.note for row in rows} == {"no Chromium here"}


def test_frequency_answers_are_timed_beside_python_control_and_their_error_is_told():
    rate, error = frequency_rate.frequency_rows(replace(TINY, draws=8, peer_draws=2))
    assert rate.value > 1
    assert "8 samples at 200 frequencies" in rate.note
    assert 0 < error.value < 1e-14
    assert error.at_most


def test_an_optimal_pi_law_is_timed_beside_a_grid_search(monkeypatch):
    two = pid_rate.processes()[:2]
    monkeypatch.setattr(pid_rate, "processes", lambda: two)
    monkeypatch.setattr(pid_rate, "GRID", 40)
    (row,) = pid_rate.pid_rows(TINY)
    assert row.value > 0
    assert "2 processes of the batch" in row.note
    assert "times as long" in row.note
    assert " -" not in row.note  # no gain of the grid is larger than the optimum


def test_a_synthesis_is_timed_beside_that_of_slycot_where_it_is_installed(monkeypatch):
    monkeypatch.setattr(synthesis_rate, "has_slycot", lambda: False)
    (row,) = synthesis_rate.synthesis_rows(TINY)
    assert (row.value, row.note) == (None, "slycot is not installed")
    calls = []
    monkeypatch.setattr(synthesis_rate, "has_slycot", lambda: True)
    monkeypatch.setattr(synthesis_rate, "ORDER", 2)
    monkeypatch.setattr(synthesis_rate, "control_hinfsyn", calls.append)
    (row,) = synthesis_rate.synthesis_rows(TINY)
    assert row.value >= 0
    assert len(calls) == 3 * TINY.repetitions
    assert "3 random plants of order 2" in row.note


def test_a_fit_is_timed_beside_scipy_only_if_both_end_at_the_same_estimates(monkeypatch):
    two_seconds, ends = replace(TINY, horizon=2.0), []
    monkeypatch.setattr(fit_rate, "scipy_estimate", lambda t, u, q, start, *options: ScipyEnd(start, len(q)))
    (row,) = fit_rate.fit_rows(two_seconds)
    assert row.value is None  # SciPy is said to end where it began
    assert row.note.startswith("not measured, as both end apart")

    def same(t, u, q, start, *options):
        errors = (run_arm(start, t, u, 1e-9) - q) / fit_rate.SIGMA
        ends.append(float(np.sqrt(np.mean(errors**2))))
        return ScipyEnd(start, 1)

    monkeypatch.setattr(fit_rate, "SAME", 1e9)
    monkeypatch.setattr(fit_rate, "START", (1.0,) * 10)
    monkeypatch.setattr(fit_rate, "scipy_estimate", same)
    (row,) = fit_rate.fit_rows(two_seconds)
    assert row.value > 0
    assert ends == pytest.approx([1.0, 1.0], abs=0.05)  # 4,002 samples of noise, whose spread is known to 1 %


def test_the_arm_of_the_fit_moves_alike_by_scipy_and_by_the_engine():
    t = np.arange(501) / fit_rate.RATE
    arm = wb.open_loop(fit_rate.FrictionArm())
    truth = arm.parameters.default[: len(fit_rate.START)]
    log = fit_rate.arm_log(t, truth)
    fit = wb.fit(arm, log, ["J1"], hold="linear", hold_out=0.0)
    quiet = run_arm(np.append(fit.theta, truth[1:]), t, fit_rate.torques(t), 1e-10)
    noise = np.column_stack([log["q1"], log["q2"]]) - quiet
    np.testing.assert_allclose(fit.errors[0], -noise, atol=1e-7)  # the step of the fit is chosen to 3 % of its noise


@needs_chromium
@pytest.mark.heavy
def test_a_turned_knob_is_timed_until_its_pictures_are_drawn():
    with live_page.open_bench(live_page.page_of_w(), "phi") as page:
        assert min(live_page.turn_times(page, "phi", 0.01, 0.1, 2)) > 0
        assert min(live_page.kernels(page, TINY)) > 0
        assert page.complaints == []
