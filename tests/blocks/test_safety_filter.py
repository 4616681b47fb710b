"""The safety filter: it changes no safe command, keeps all limits of its model, and takes the nearest plan."""

from functools import cache

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.c_runs import EACH_COMPILER, compiled, differing, needs_compiler, recorded
from workbench.design.matrices import DesignError
from workbench.handover.c99.c_files import c_code

LIMITS = {"a": (-2.0, 2.0), "p": (-1.5, 1.0), "v": (-1.2, 1.2)}
NOMINAL, BETWEEN, UNPROVED = 0, 1, 2


@wb.block
class Axis(wb.Plant):
    """A mass on a line."""

    p: float = wb.initial(default=0.0, unit="m")
    v: float = wb.initial(default=0.0, unit="m/s")
    inputs, outputs = wb.layout(a="m/s^2"), wb.layout(place="m")

    def rate(self, t, x, u):
        return {"p": x["v"], "v": u["a"]}

    def measure(self, t, x):
        return {"place": x["p"]}


@cache
def design(sweeps=6, **options):
    model = wb.linearize(wb.open_loop(Axis()), t=0.0, x=np.zeros(2), at_rest=True)
    options = {"limits": LIMITS} | {name: dict(value) for name, value in options.items()}
    return wb.predictive_design(model, 0.1, np.diag([4.0, 1.0]), [[0.5]], 12, sweeps=sweeps, **options)


def nominal(gain=8.0):
    return wb.StateFeedback.of(Axis(), [[gain, 4.0]], follow=("p",))


def run_of(law, plant=None, step=2.0, until=8.0, signal="p"):
    plant = plant or Axis()
    reference = wb.Step(signal, {"p": "m", "a": "m/s^2"}[signal], step)
    loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law, reference=reference)
    return wb.simulate(loop.digital(0.1).step(1), until=until)


def signals(run):
    return tuple(np.asarray(run[name])[0].ravel() for name in ("p", "v", "a"))


def choices(run):
    return run.x[0, :, run.step.states.slice("controller.choice")].ravel()[1:]


def test_a_safe_command_passes_bit_for_bit():
    filtered = run_of(wb.SafetyFilter.of(Axis(), design(), nominal(2.0)), step=0.2)
    alone = run_of(nominal(2.0).run_every(0.1), step=0.2)
    for one, other in zip(signals(filtered), signals(alone), strict=True):
        np.testing.assert_array_equal(one, other)
    assert set(choices(filtered)) == {NOMINAL}


@pytest.mark.heavy
@pytest.mark.parametrize("sweeps", [1, 6, 30])
@pytest.mark.parametrize(("gain", "step"), [(8.0, 2.0), (30.0, -3.0), (-5.0, 0.5)], ids=["far", "rough", "unstable"])
def test_no_limit_is_passed_whatever_the_law_does_and_however_many_sweeps_are_made(sweeps, gain, step):
    law = wb.SafetyFilter.of(Axis(), design(sweeps), nominal(gain))
    run = run_of(law, step=step)
    for values, (low, high) in zip(signals(run), (LIMITS["p"], LIMITS["v"], LIMITS["a"]), strict=True):
        assert values.min() >= low - 1e-12  # of 80 roundings of the march
        assert values.max() <= high + 1e-12
    assert np.isin(choices(run), (BETWEEN,)).sum() > 5
    alone = run_of(nominal(gain).run_every(0.1), step=step, until=2.0)
    assert np.abs(alone["a"]).max() > 2.0  # the law alone passes a limit


def test_a_filtered_law_comes_near_to_the_limit_that_its_reference_lies_beyond():
    p, _, _ = signals(run_of(wb.SafetyFilter.of(Axis(), design(3), nominal()), until=15.0))
    assert 0.99 < p[-1] <= 1.0 + 1e-12


def test_a_command_of_a_human_is_a_reference_of_the_inputs():
    law = wb.SafetyFilter.of(Axis(), design())
    assert law.follows.names == ("a",)
    p, _, a = signals(run_of(law, step=0.5, signal="a", until=6.0))
    assert (a[:3] == 0.5).all()
    assert p.max() <= 1.0 + 1e-12


@pytest.mark.heavy
def test_the_plan_is_that_of_a_peer_within_the_narrower_limits():
    one = design(100)
    problem, law = one.problem, wb.SafetyFilter.of(Axis(), one, nominal(), margin=0.02)
    K, S = problem.K, problem.R + problem.B.T @ problem.P @ problem.B
    rows, closed = problem.rows.F - problem.rows.E @ K, problem.A - problem.B @ K
    planned = 0
    for x in ([0.3, 0.9], [-0.8, -0.9], [0.6, 0.6]):
        wanted = float(8.0 * (2.0 - x[0]) - 4.0 * x[1])
        run = run_of(law, Axis(p=x[0], v=x[1]), until=0.1)
        d, e, lines = ca.SX.sym("d", 12), ca.DM(x), []
        for k in range(12):
            lines.append(rows @ e + problem.rows.E @ d[k])
            e = closed @ e + problem.B @ d[k]
        gap = d - ca.vertcat(wanted + float(K[0] @ x), ca.DM.zeros(11))
        solver = ca.qpsol("peer", "daqp", {"x": d, "f": float(S[0, 0]) * ca.sumsqr(gap), "g": ca.vertcat(*lines)})
        narrow = np.r_[1.0, 0.98, 0.98]
        answer = solver(lbg=np.tile(problem.rows.low * narrow, 12), ubg=np.tile(problem.rows.high * narrow, 12))
        first = float(answer["x"][0]) - float(K[0] @ x)
        if choices(run)[0] == BETWEEN:
            planned += 1
            assert np.asarray(run["a"])[0, 0, 0] == pytest.approx(first, abs=1e-2)  # of a span of 4, after 100 sweeps
    assert planned >= 2


def test_the_memory_of_the_filtered_law_goes_on():
    law = wb.PID(wb.layout(p="m"), Axis().inputs, Kp=2.0, Ki=0.2, Kd=2.0, N=5.0)
    filtered, alone = (run_of(one, step=0.1) for one in (wb.SafetyFilter.of(Axis(), design(), law), law.run_every(0.1)))
    np.testing.assert_array_equal(signals(filtered)[0], signals(alone)[0])


def test_the_claim_has_its_hypotheses():
    (claim,) = design().filter_claims
    assert claim.name == "safe forever"
    assert [one.name for one in claim.hypotheses] == ["terminal set", "invariance", "model"]
    assert "exact rational arithmetic" in claim.hypotheses[1].statement


def test_unfit_parts_are_refused_in_one_sentence():
    with pytest.raises(ValueError, match="must be the result of `predictive_design`"):
        wb.SafetyFilter.of(Axis(), np.eye(2))
    other = wb.StateFeedback.of(wb.CartPole(), [[1.0, 1.0, 1.0, 1.0]])
    with pytest.raises(ValueError, match="a law that drives a; got"):
        wb.SafetyFilter.of(Axis(), design(), other)
    with pytest.raises(ValueError, match=r"a law without a period, or of 0.1 s; got 0.2"):
        wb.SafetyFilter.of(Axis(), design(), nominal().run_every(0.2))
    with pytest.raises(ValueError, match=r"margin=...\)` must be a finite number"):
        wb.SafetyFilter.of(Axis(), design(), margin=1.0)
    with pytest.raises(DesignError, match="leave out limits on rates"):
        wb.SafetyFilter.of(Axis(), design(rate_limits=(("a", (-1.0, 1.0)),)))


@needs_compiler
@pytest.mark.parametrize("compiler", EACH_COMPILER)
def test_c_has_the_bits_of_the_simulation(compiler, tmp_path):
    law = wb.SafetyFilter.of(Axis(), design(3), nominal())
    loop = wb.ClosedLoop(Axis(), observer=wb.FullState.of(Axis()), controller=law, reference=wb.Step("p", "m", 2.0))
    sampled = loop.digital(0.1)
    extracted = sampled.law(truths=("p", "v"))
    y, r, u, z = recorded(sampled, extracted, 80, substeps=1)
    made, memory, flags = compiled(c_code(extracted, "safe"), tmp_path, compiler)(y, r)
    assert not flags.any()
    assert differing(made, u) == differing(memory, z) == 0
