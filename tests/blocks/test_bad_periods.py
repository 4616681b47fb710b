"""Fallbacks of both predictive laws: lost readings, too few sweeps, a plan that runs out, and bad arguments."""

from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.c_runs import compiled, differing, needs_compiler, recorded
from tests.support.law_forms import run_here
from workbench.handover.c99.c_files import c_code
from workbench.handover.programs.python_law import python_law

PERIOD, N, SAFE = 0.1, 8, 0.25
WEIGHTS = np.diag([1.0, 0.1]), [[1.0]]
FORMS = ("warm", "safe_command", "last_good", "cold")
LAWS = ("linear", "nonlinear")
FEW = {"linear": (1, 0.03), "nonlinear": (1, 0.05)}  # sweeps, and a bound of the residual


@wb.block
class Cart(wb.Plant):
    """A cart with a drag that grows, whose speed is not measured for some time."""

    x: float = wb.initial(default=0.0, unit="m")
    v: float = wb.initial(default=0.0, unit="m/s")
    lost_at: float = wb.parameter(default=1e9, unit="s")
    lost_for: float = wb.parameter(default=0.0, unit="s")
    drag: float = wb.parameter(default=0.2, unit="N s^3/m^3")

    inputs = wb.layout(F="N")
    outputs = wb.layout(x="m", v="m/s")

    def measure(self, t, x):
        lost = ca.logic_and(t >= self.lost_at - 1e-6, t < self.lost_at + self.lost_for - 1e-6)
        return {"x": x.x, "v": ca.if_else(lost, np.nan, x.v)}

    def rate(self, t, x, u):
        return {"x": x.v, "v": u.F - 0.3 * x.v - self.drag * x.v**3}


def law_of(kind, sweeps=6, fallback="warm", safe=True, **options):
    plant = Cart()
    rest = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(2), at_rest=True)
    how = {"limits": {"F": (-1.0, 1.0)}, "sweeps": sweeps}
    options |= {"follow": ("x",), "fallback": fallback} | ({"safe_command": {"F": SAFE}} if safe else {})
    if kind == "linear":
        return wb.ModelPredictive.of(plant, wb.predictive_design(rest, PERIOD, *WEIGHTS, N, **how), **options)
    return wb.NonlinearPredictive.of(plant, wb.nonlinear_predictive_design(rest, PERIOD, *WEIGHTS, N, **how), **options)


def computer_of(law, lost_at=1e9, lost_for=0, **start):
    plant = Cart(lost_at=lost_at * PERIOD if lost_for else 1e9, lost_for=lost_for * PERIOD, **start)
    step = wb.Step("x", "m", -1.0, time=0.5)
    return wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law, reference=step).digital(PERIOD)


def run_of(law, until=8.0, **how):
    return wb.simulate(computer_of(law, **({"x": 1.0} | how)).step(1), until=until)


def few_sweeps(kind, **options):
    """A law that has not converged in some periods, and the bound that its residual passes then."""
    sweeps, bound = FEW[kind]
    return law_of(kind, sweeps=sweeps, residual_bound=bound, **options)


def memory_of(run, name):
    return run.x[0, :, run.step.states.slice(f"controller.{name}")].squeeze()


def expected_inputs(run, kind, good, first):
    """The forces (K,) of a law with `last_good`, from the plans that it records, its good periods, and its own."""
    plans, queue, forces = run["predicted_F"][0], [], []
    for k in range(len(good)):
        if good[k]:
            forces.append(first[k])
            queue = list(plans[k][1:N] if kind == "linear" else plans[k + 1][: N - 1])
        else:
            forces.append(queue.pop(0) if queue else SAFE)
    return np.array(forces)


@pytest.mark.parametrize("kind", LAWS)
@pytest.mark.parametrize("lost_for", [1, 3, N + 3])
def test_the_next_inputs_of_the_last_good_plan_are_sent_and_then_the_safe_command(kind, lost_for):
    run = run_of(law_of(kind, fallback="last_good"), lost_at=4, lost_for=lost_for)
    forces = run["F"][0].ravel()[:-1]
    good = np.ones(len(forces), dtype=bool)
    good[4 : 4 + lost_for] = False
    np.testing.assert_allclose(forces, expected_inputs(run, kind, good, forces), rtol=0, atol=1e-15)  # a rounding
    assert np.abs(np.diff(forces[3:6])).max() > 0.01  # the plan moves
    if lost_for > N:
        np.testing.assert_array_equal(forces[4 + N - 1 : 4 + lost_for], SAFE)
    np.testing.assert_array_equal(memory_of(run, "bad_periods")[5 : 5 + lost_for], 1 + np.arange(lost_for))
    assert not run.has_diverged.any()
    assert np.abs(run.x[0, -1, :2] - [-1.0, 0.0]).max() < 0.05
    assert "'controller.bad_periods' of 'loop' passes its bound of 0 at" in "".join(run.warnings)


@pytest.mark.heavy
@pytest.mark.parametrize("kind", LAWS)
def test_a_lost_reading_costs_less_with_the_last_good_plan_than_with_the_safe_command(kind):
    costs = []
    for fallback in ("last_good", "safe_command"):
        run = run_of(law_of(kind, fallback=fallback), lost_at=2, lost_for=5)
        x, F = run.x[0, :, :2] - np.pad(run["x_ref"][0], ((0, 0), (0, 1))), run["F"][0].ravel()
        costs.append(float((x**2 @ np.diag(WEIGHTS[0])).sum() + 1.0 * (F**2).sum()))
    assert costs[0] < 0.9 * costs[1]


@pytest.mark.parametrize("kind", LAWS)
@pytest.mark.parametrize("fallback", FORMS)
def test_a_period_of_too_few_sweeps_does_what_is_declared(kind, fallback):
    law = few_sweeps(kind, fallback=fallback)
    run = run_of(law)
    residual, forces = memory_of(run, "residual")[1:], run["F"][0].ravel()[:-1]
    good = residual <= FEW[kind][1]
    assert 0 < (~good).sum() < len(good)
    assert (memory_of(run, "bad_periods")[1:] > 0).tolist() == (~good).tolist()
    if fallback == "warm":
        free = run_of(law_of(kind, sweeps=FEW[kind][0], safe=False))
        np.testing.assert_array_equal(forces, free["F"][0].ravel()[:-1])
    if fallback == "safe_command":
        np.testing.assert_array_equal(forces[~good], SAFE)
    if fallback == "last_good":
        assert (good[:-1] & ~good[1:]).any()
        np.testing.assert_allclose(forces, expected_inputs(run, kind, good, forces), rtol=0, atol=1e-15)
    if fallback == "cold":
        e = (run.x[0, :, :2] - np.pad(run["x_ref"][0], ((0, 0), (0, 1))))[:-1]
        np.testing.assert_allclose(forces[~good], np.clip(-e @ np.ravel(law.K), -1, 1)[~good], rtol=0, atol=1e-12)
        plan = memory_of(run, "plan" if kind == "linear" else "plan_u")
        np.testing.assert_array_equal(plan[1:][~good], 0.0)
    assert any("'controller.bad_periods' of 'loop' passes its bound of 0" in text for text in run.warnings)


@pytest.mark.heavy
@pytest.mark.parametrize("kind", LAWS)
@pytest.mark.parametrize("fallback", FORMS)
def test_a_fallback_that_is_not_needed_changes_no_bit(kind, fallback):
    bare, guarded = (run_of(law_of(kind, **how)) for how in ({"safe": False}, {"fallback": fallback}))
    np.testing.assert_array_equal(bare["F"], guarded["F"])
    assert not any("bad_periods" in text for text in guarded.warnings)


@pytest.mark.parametrize("kind", LAWS)
def test_a_bound_alone_flags_a_run_and_changes_no_input(kind):
    bare, flagged = run_of(law_of(kind, sweeps=FEW[kind][0], safe=False)), run_of(few_sweeps(kind, safe=False))
    np.testing.assert_array_equal(bare["F"], flagged["F"])
    assert any("bad_periods" in text for text in flagged.warnings)


@pytest.mark.parametrize("kind", LAWS)
def test_many_runs_fall_back_each_for_itself(kind):
    loop = computer_of(few_sweeps(kind, fallback="last_good"))
    starts = np.linspace(-1.0, 2.0, 7)
    many = wb.simulate(loop.step(1), x0=loop.states.pack({"plant.x": starts}), until=3.0)
    for i, x in enumerate(starts):
        one = wb.simulate(loop.step(1), x0=loop.states.pack({"plant.x": np.array([x])}), until=3.0)
        np.testing.assert_array_equal(many.x[i], one.x[0])
    bad = many.x[:, :, many.step.states.slice("controller.bad_periods")]
    assert len(set((bad > 0).sum(axis=1).ravel().tolist())) > 1


@needs_compiler
@pytest.mark.parametrize("kind", LAWS)
@pytest.mark.parametrize("fallback", ["last_good", "cold"])
def test_c_falls_back_with_the_bits_of_the_simulation(kind, fallback, tmp_path):
    loop = computer_of(few_sweeps(kind, fallback=fallback), x=1.0)
    y, r, u, z = recorded(loop, loop.law(), 40, substeps=1)
    made, memory, flags = compiled(c_code(loop.law(), "planned"), tmp_path)(y, r)
    assert not flags.any()
    assert differing(made, u) == differing(memory, z) == 0
    assert z[:, loop.law().memory.slice("controller.bad_periods")].max() > 0


@pytest.mark.parametrize("kind", LAWS)
@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fallback": "last_good", "safe": False}, r"fallback='last_good'\)` must come with `safe_command`"),
        ({"fallback": "hold"}, "'hold'"),
        ({"residual_bound": 0.0}, "residual_bound"),
        ({"residual_bound": np.nan}, "residual_bound"),
    ],
)
def test_bad_fallbacks_are_refused(kind, options, message):
    with pytest.raises((ValueError, LookupError), match=message):
        law_of(kind, **options)


@needs_compiler
@pytest.mark.parametrize("kind", LAWS)
def test_c_and_python_answer_a_lost_reading_with_the_bits_of_the_simulation(kind, tmp_path):
    loop = computer_of(law_of(kind, fallback="last_good"), lost_at=4, lost_for=N + 3, x=1.0)
    law, run = loop.law(), wb.simulate(loop.step(1), until=3.0, arithmetic="portable")
    y, r, u = (np.ascontiguousarray(part[0, :-1]) for part in (run.x[:, :, :2], run["x_ref"], run["F"]))
    y[4 : 4 + N + 3, 1] = np.nan
    made, memory, flags = compiled(c_code(law, "planned"), tmp_path)(y, r)
    np.testing.assert_array_equal(flags, np.isnan(y[:, 1]))  # BAD_READING
    assert differing(made, u) == 0
    assert differing(memory, np.hstack([run.x[0, 1:, run.step.states.slice(name)] for name in law.memory.names])) == 0
    told = run_here(SimpleNamespace(law=law, readings=y, references=r), python_law(law))
    assert differing(np.array([[commands["F"]] for commands, *_ in told]), u) == 0
