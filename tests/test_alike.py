"""Loops that are much alike run in one march, and each of them gives the bits that it gives alone."""

import sys
from dataclasses import dataclass, replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.core import Entry, Layout, Ode, rk4
from workbench.metrics import iae, measure, measure_alike, overshoot, rmse, settling_time, total_variation
from workbench.metrics.accumulators import maker
from workbench.plants import ArmInstruments
from workbench.simulate import alike, arithmetic, simulate, simulate_alike, simulate_both
from workbench.simulate.kernel import merging
from workbench.simulate.kernel.plan import pass_of

pytest.importorskip("llvmlite")  # there is no wheel of it for some platforms, where each loop runs alone

sys.path.insert(0, str(Path(__file__).parent.parent / "studies"))
import paper_laws
from paper_printed import CHANGES, PLANTS

from workbench.controllers.aosmc_rgs import SHAPES

METRICS = (rmse(), total_variation(1e-3))
SPAN = {"until": 0.5, "every": 0.05}


def pair(equation, h=1e-4, metrics=METRICS):
    make = maker(equation, metrics)
    return make("rk4", h), make("rk4", h / 2)


def assert_same_bits(together, apart):
    for ours, alone in zip(together, apart, strict=True):
        for a, b in zip(ours, alone, strict=True):
            np.testing.assert_array_equal(a.x, b.x)
            np.testing.assert_array_equal(a.t, b.t)
            np.testing.assert_array_equal(a.diverged_at, b.diverged_at)
            assert a.diverged_in == b.diverged_in


def merges(pairs):
    """What steps are merged to, if they are alike."""
    halves = [half for _, half in pairs]
    rates = [half.rule.rate.numel() for half in halves]
    most, others = max(rates), max(half.states.size - n for half, n in zip(halves, rates, strict=True))
    graphs = [merging.widened(pass_of(half), n, most, others) for half, n in zip(halves, rates, strict=True)]
    return merging.merged(graphs, max(half.parameters.size for half in halves))


def run_alike(pairs, until, **asked):
    return simulate_alike(pairs, until=[until] * len(pairs), **asked)


READINGS = [paper_laws.proposed_as_printed("FS", shape, arm).ode() for arm in PLANTS.values() for shape in SHAPES]
VARIANTS = [paper_laws.with_change("FS", change).ode() for change in CHANGES]
ABLATIONS = [loop.ode() for loop in paper_laws.proposed_repaired("FS").ablations().values()]


@pytest.fixture
def none_alone(monkeypatch):
    """Lets no loop run alone within `simulate_alike`."""

    def alone(*pair, **span):
        raise AssertionError("this loop ran alone")

    monkeypatch.setattr(alike, "simulate_both", alone)


@pytest.mark.usefixtures("none_alone")
@pytest.mark.parametrize("odes", [READINGS, READINGS[:3], VARIANTS, ABLATIONS], ids=["8", "3", "changes", "ablations"])
def test_variants_of_a_law_keep_their_bits_in_company(odes):
    pairs = [pair(ode) for ode in odes]
    assert_same_bits(run_alike(pairs, **SPAN), [simulate_both(*each, **SPAN) for each in pairs])


def test_the_readings_of_the_printed_law_are_alike():
    one = merges([pair(ode) for ode in READINGS])
    assert one is not None
    # eight graphs of nearly 400 nodes
    assert len(one.graph.nodes) < 600


def test_a_loop_that_diverges_leaves_its_company_alone_and_is_marked_as_it_is_alone():
    span = {"until": 3.0, "every": 0.05}
    pairs = [pair(READINGS[i]) for i in (0, 1, 4)]
    apart = [simulate_both(*each, **span) for each in pairs]
    assert [bool(fine.diverged[0]) for _, fine in apart] == [True, False, True]
    assert_same_bits(run_alike(pairs, **span), apart)


def test_one_law_with_other_numbers_is_alike_however_many_numbers_differ():
    loop = paper_laws.proposed_repaired("FS")
    loops = [replace(loop, controller=replace(loop.controller, phi=phi)) for phi in (0.05, 0.1, 0.2)]
    pairs = [pair(one.ode()) for one in loops]
    # the numbers are parameters: there is nothing to select
    one = merges(pairs)
    assert one is not None
    assert one.columns == ()
    assert_same_bits(run_alike(pairs, **SPAN), [simulate_both(*each, **SPAN) for each in pairs])


@pytest.mark.usefixtures("none_alone")
def test_the_noise_of_a_run_is_its_own_in_company():
    pairs = []
    for ode in READINGS[:2]:
        step = rk4(ode, 1e-4)
        walk = Layout((Entry("walk", np.zeros(2)),))
        rule = replace(step.rule, w=ca.SX.sym("w", 2))
        symbols = walk.symbols()
        noisy = replace(step, rule=rule).extended(walk, symbols, symbols + rule.w * ca.sin(rule.x[0]))
        pairs.append((noisy, replace(noisy, h=5e-5)))
    together = run_alike(pairs, **SPAN)
    assert (np.ptp(together[0][1].x[0, :, -2:], axis=0) > 0).all()
    assert_same_bits(together, [simulate_both(*each, **SPAN) for each in pairs])


def test_loops_beneath_a_computer_whose_step_and_half_are_two_rules_run_alone():
    noisy = ArmInstruments(2, noise_q=1e-4)
    pairs = [pair(paper_laws.with_change("FS", change).digital(1e-3, noisy), 5e-4) for change in list(CHANGES)[:2]]
    span = {"until": 0.1, "every": 0.05}
    assert_same_bits(run_alike(pairs, **span), [simulate_both(*each, **span) for each in pairs])


def test_loops_that_are_not_alike_run_one_after_the_other():
    pairs = [pair(paper_laws.rival("FS", law).ode()) for law in ("PID", "Fuzzy-ASMC")]
    assert merges(pairs) is None
    seen = []
    assert_same_bits(run_alike(pairs, **SPAN, progress=seen.append), [simulate_both(*each, **SPAN) for each in pairs])
    assert seen == sorted(seen)
    assert seen[-1] == pytest.approx(1.0)


def test_where_nothing_can_be_compiled_each_loop_runs_alone(monkeypatch):
    def missing(name):
        raise ImportError("no wheel")

    pairs = [pair(ode) for ode in READINGS[:2]]
    monkeypatch.setattr(arithmetic, "native", missing)
    span = {"until": 0.01, "every": 0.01}
    assert_same_bits(run_alike(pairs, **span), [simulate_both(*each, **span) for each in pairs])


def test_every_step_kept_a_single_loop_and_none_are_no_reason_to_refuse():
    pairs = [pair(ode) for ode in READINGS[:2]]
    span = {"until": 0.05, "every": 1e-4}
    assert_same_bits(run_alike(pairs, **span), [simulate_both(*each, **span) for each in pairs])
    assert_same_bits(run_alike(pairs[:1], **SPAN), [simulate_both(*pairs[0], **SPAN)])
    assert run_alike([], **SPAN) == []


def test_measures_of_loops_that_are_alike_are_those_of_each():
    # one law in two scenarios and less a slip, each with metrics and a horizon of its own
    odes = [VARIANTS[0], paper_laws.proposed_repaired("SS").ode(), *VARIANTS[1:]]
    metrics = [METRICS, (*METRICS, overshoot(), settling_time(band=0.05), iae()), *[METRICS[:1]] * (len(odes) - 2)]
    until = [0.6, 0.5, 0.6, 0.3, 0.5, 0.5, 0.5]
    ask = {"h": 1e-4, "every": 0.05, "tolerance": 1e-3}
    together = measure_alike(odes, metrics, until=until, **ask)
    for ode, own, end, found in zip(odes, metrics, until, together, strict=True):
        alone = measure(ode, own, until=end, **ask)
        assert found.limits == alone.limits
        assert str(found.check) == str(alone.check)
        for name, score in alone.scores.items():
            np.testing.assert_array_equal(found.scores[name].value, score.value)
            np.testing.assert_array_equal(found.scores[name].error, score.error)


def test_a_parameter_and_the_number_of_its_place_are_two_things():
    # what differs is a parameter, 0 or 1, and which way is taken, told by the numbers 0 and 1
    states, parameters = Layout((Entry("x", np.array([0.3])),)), Layout((Entry("p", np.array([0.7, 1.9])),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    rates = (p[0] * x - ca.exp(x), p[1] * x - ca.tanh(x))
    odes = [Ode.of(f"{i}", states, parameters, (t, x, p), {"x": rate}, {"e": x}) for i, rate in enumerate(rates)]
    pairs = [pair(ode, 0.01, ()) for ode in odes]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(merging, "WORTH", 1e9)
        assert len(merges(pairs).columns) == 2
        together = run_alike(pairs, until=1.0, every=0.1)
    assert_same_bits(together, [simulate_both(*each, until=1.0, every=0.1) for each in pairs])


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"until": [0.5]}, "a horizon for each of the 2 equations; got 1"),
        ({"tolerance": -1.0}, r"`measure_alike\(tolerance=...\)` must be a positive"),
        ({"until": [0.5, float("nan")]}, "must be a positive, finite number of seconds"),
    ],
)
def test_what_does_not_fit_the_equations_is_refused(change, why):
    ask = {"until": [0.5, 0.5], "h": 1e-4} | change
    with pytest.raises(ValueError, match=why):
        measure_alike(READINGS[:2], [METRICS] * 2, **ask)


@dataclass(frozen=True)
class Grower:
    """Random expressions that share what they can."""

    x: ca.SX
    p: ca.SX
    t: ca.SX

    def grow(self, genes):
        held = [*ca.vertsplit(self.x), *ca.vertsplit(self.p), ca.sin(self.t), ca.SX(0.5), ca.SX(2.0)]
        for op, a, b in genes:
            u, v = held[a % len(held)], held[b % len(held)]
            held.append(
                (
                    u + v,
                    u - v,
                    u * v,
                    ca.tanh(u) * v,
                    ca.fmin(u, v),
                    u / (1 + v * v),
                    ca.cos(u + v),
                    ca.if_else(u < v, u, v),
                )[op]
            )
        return held


GENES = st.tuples(st.integers(0, 7), st.integers(0, 40), st.integers(0, 40))


@settings(max_examples=25, deadline=None)
@given(
    common=st.lists(GENES, min_size=1, max_size=8),
    own=st.lists(st.lists(GENES, max_size=5), min_size=2, max_size=4),
    arithmetic=st.sampled_from(["fused", "portable"]),
)
def test_whatever_graphs_are_merged_each_run_keeps_the_bits_of_its_own_in_every_kernel(common, own, arithmetic):
    odes = []
    for i, genes in enumerate(own):
        states, parameters = (
            Layout((Entry("x", np.array([0.3, -0.2])),)),
            Layout((Entry("p", np.array([0.7, 1.1 + i])),)),
        )
        t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
        held = Grower(x, p, t).grow([*common, *genes])
        rates = {"x": ca.vertcat(held[-1] - x[0], held[-2] * 0.1 - x[1])}
        odes.append(Ode.of(f"random {i}", states, parameters, (t, x, p), rates, {"e": x}))
    pairs = [pair(ode, 0.01, (iae(),)) for ode in odes]
    span = {"until": 0.2, "every": 0.1, "arithmetic": arithmetic}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(merging, "WORTH", 1e9)  # alike or not
        assert merges(pairs) is not None
        together = run_alike(pairs, **span)
    assert_same_bits(together, [simulate_both(*each, **span) for each in pairs])
    by_numpy = [tuple(simulate(step, engine="numpy", **span) for step in each) for each in pairs]
    assert_same_bits(together, by_numpy)
