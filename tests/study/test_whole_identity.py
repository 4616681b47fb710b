"""The names of loops, chunks and cases change with all on which a run depends, and with nothing else."""

import shutil
import subprocess
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.sweeps import Decay, sweep
from workbench.core import Layout, Ode, layout, rk4
from workbench.core.fingerprints import fingerprint_of
from workbench.core.layout import Entry
from workbench.engine import simulate
from workbench.engine.metrics import ise, rmse, total_variation
from workbench.engine.reference import reference_run
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.run_and_sweep import Run
from workbench.study.study import Case, Outcome
from workbench.study.uncertainty import MonteCarlo

X = ca.SX.sym("x", 2)


def table(values=(0.0, 0.5, 1.0), grid=(0.0, 1.0, 4.0), kind="linear", **options):
    return ca.interpolant("friction", kind, [list(grid)], list(values), options)


def slide(friction, name="slide", start=1.0):
    """x' = push - friction(x)."""
    states, parameters = Layout((Entry("x", np.array(start)),)), Layout((Entry("push", np.zeros(())),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    return Ode(name, states, parameters, layout(e=""), t, x, p, p - friction(x), x)


class Slide:
    def __init__(self, friction):
        self.friction = friction

    def ode(self, name="loop"):
        return replace(slide(self.friction, name), parameters=Layout((Entry("push", np.zeros(())),)))


def never_inlined(of):
    v = ca.SX.sym("v")
    return ca.Function("apart", [v], [of(v)], {"never_inline": True})


def matrix_graph(of):
    v = ca.MX.sym("v")
    return ca.Function("graph", [v], [of(v)], {"never_inline": True})


def branches(of):
    v = ca.MX.sym("v")
    one, two = ca.Function("one", [v], [of(v)]), ca.Function("two", [v], [2 * v])
    chosen = ca.Function.if_else("chosen", one, two)
    return lambda x: chosen(x > 0, x)


def its_slope(of):
    v = ca.SX.sym("v")
    slope = ca.Function("slope", [v], [ca.jacobian(of(v), v)])
    return lambda x: slope(x) + of(x)


def mapped(of):
    v = ca.MX.sym("v")
    twice = ca.Function("one", [v], [of(v)]).map(2, "thread", 2)
    return lambda x: ca.sum2(twice(ca.horzcat(x, 2 * x)))


def a_root(of):
    z, p = ca.SX.sym("z"), ca.SX.sym("p")
    root = ca.rootfinder("root", "newton", {"x": z, "p": p, "g": z**3 + z - of(p)})
    return lambda x: root(x, x)


WAYS = {
    "as it stands": lambda of: of,
    "never inlined": never_inlined,
    "in a graph of matrices": matrix_graph,
    "two deep": lambda of: never_inlined(matrix_graph(never_inlined(of))),
    "in a branch": branches,
    "by its slope, as a Kalman filter does": its_slope,
    "at two places side by side": mapped,
    "in an equation for a root": a_root,
}
TABLES = [
    table(),
    table((0.0, 5.0, 10.0)),
    table((0.0, 0.5, np.nextafter(1.0, 2.0))),
    table(grid=(0.0, 2.0, 4.0)),
    table(kind="bspline", grid=(0.0, 1.0, 2.0, 3.0, 4.0), values=(0.0, 0.3, 0.5, 0.8, 1.0)),
    table(kind="bspline", grid=(0.0, 1.0, 2.0, 3.0, 4.0), values=(0.0, 0.3, 0.5, 0.8, 1.1)),
    table(kind="bspline", grid=(0.0, 1.0, 2.0, 3.0, 4.0), values=(0.0, 0.3, 0.5, 0.8, 1.0), algorithm="smooth_linear"),
    table(lookup_mode=["exact"], grid=(0.0, 2.0, 4.0)),
]


@pytest.mark.parametrize("way", WAYS)
def test_every_edit_of_a_table_changes_the_fingerprint_however_it_is_called(way):
    prints = [slide(WAYS[way](friction)).fingerprint for friction in TABLES]
    assert len(set(prints)) == len(TABLES)
    assert prints[0] == slide(WAYS[way](table())).fingerprint
    assert prints[0] == slide(WAYS[way](table()), name="another", start=2.0).fingerprint  # names and defaults are free


@pytest.mark.parametrize("kind", ["linear", "bspline"])
def test_a_fingerprint_stays_when_derivatives_were_asked_for(kind):
    values, grid = np.arange(6.0) ** 2, np.arange(6.0)
    ode = slide(its_slope(table(values, grid, kind)))
    first = ode.fingerprint
    _ = ode.A, ca.hessian(ode.rate, ode.x), slide(its_slope(its_slope(table(values, grid, kind))))
    assert replace(ode).fingerprint == first == slide(its_slope(table(values, grid, kind))).fingerprint


def test_a_fingerprint_tells_which_table_is_called_where():
    one, other = table(), table((0.0, 5.0, 10.0))
    first = ca.Function("f", [X], [one(X[0]) + 2 * other(X[1])])
    second = ca.Function("f", [X], [other(X[0]) + 2 * one(X[1])])
    assert fingerprint_of(b"", first) != fingerprint_of(b"", second)


def test_a_fingerprint_tells_where_the_entries_of_a_sparse_rate_stand():
    first, second = ca.SX(2, 1), ca.SX(2, 1)
    first[0], second[1] = X[0], X[0]
    states, t = layout(a="", b=""), ca.SX.sym("t")

    def of(rate):
        return Ode("two", states, Layout(), Layout(), t, X, ca.SX(0, 1), rate, ca.SX(0, 1))

    assert of(first).fingerprint != of(second).fingerprint


class Hidden(ca.Callback):
    def __init__(self):
        ca.Callback.__init__(self)
        self.construct("hidden", {})

    def eval(self, arguments):
        return [2 * arguments[0]]


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """A function of a compiled library."""
    gcc, folder, v = shutil.which("gcc"), tmp_path_factory.mktemp("library"), ca.SX.sym("v")
    if gcc is None:
        pytest.skip("there is no compiler")
    source = ca.CodeGenerator("compiled")
    source.add(ca.Function("compiled", [v], [2 * v]))
    source.generate(f"{folder}/")
    subprocess.run([gcc, "-shared", "-fPIC", "-o", "compiled.so", "compiled.c"], cwd=folder, check=True)
    return ca.external("compiled", str(folder / "compiled.so"))


@pytest.mark.parametrize("way", [way for way in WAYS if not way.startswith("by its slope") and "root" not in way])
def test_a_function_that_cannot_be_seen_is_refused_by_name_however_deep_it_is_called(compiled, way):
    for hidden in (Hidden(), compiled):
        with pytest.raises(ValueError, match=f"equations call '{hidden.name()}', whose operations CasADi cannot show"):
            _ = slide(WAYS[way](hidden)).fingerprint


def test_two_sweeps_that_differ_in_a_table_alone_share_no_chunk():
    def name(friction):
        factor = {"factors": sweep().factors[1:], "design": MonteCarlo(1, 50, seed=3)}
        return compile_sweep(sweep(loop=Slide(friction), **factor)).name(0, 8)

    assert name(table()) == name(table())
    assert name(table()) != name(table((0.0, 5.0, 10.0)))


def test_each_number_on_which_a_run_depends_is_in_the_name_of_its_chunk():
    class Other(Decay):
        def ode(self, name="loop"):
            ode = Decay.ode(self, name)
            entries = tuple(replace(e, default=e.default + 0.5) for e in ode.parameters.entries)
            return replace(ode, parameters=Layout(entries))

    edits = {
        "nothing": {},
        "a default": {"loop": Other()},
        "a metric": {"metrics": (ise(),)},
        "the order of metrics": {"metrics": tuple(reversed(sweep().run.metrics))},
        "the sample of a metric": {"metrics": (total_variation(0.02, "e"),)},
        "another sample of it": {"metrics": (total_variation(0.04, "e"),)},
        "the step": {"h": 0.02},
        "the horizon": {"until": 4.0},
        "the times": {"every": 1.0},
        "the seed": {"seed": 7},
        "the draws": {"design": MonteCarlo(2, 50, seed=4)},
        "the share run again": {"half_step_every": 25},
    }
    names = {edit: compile_sweep(sweep(**changes)).name(0, 8) for edit, changes in edits.items()}
    assert len(set(names.values())) == len(edits)
    assert compile_sweep(sweep(name="other")).name(0, 8).split("/")[2] == names["nothing"].split("/")[2]


def test_each_part_of_a_loop_is_in_its_fingerprint_and_no_default_number_is():
    motor = wb.DCMotor()

    def loop(plant=motor, reference=None, **law):
        held = {"Kp": 100.0, "Ki": 200.0} | law
        controller = wb.PID(plant.outputs, plant.inputs, **held)
        return wb.ClosedLoop(plant, controller=controller, reference=reference or wb.Step("omega", "rad/s", 1.0))

    free = {loop().ode().fingerprint, loop(Kp=50.0).ode().fingerprint}
    free.add(loop(plant=replace(motor, R=2.0)).ode().fingerprint)
    free.add(loop(reference=wb.Step("omega", "rad/s", 2.0)).ode().fingerprint)
    assert len(free) == 1
    digital = loop().digital(0.01)
    others = [
        loop(reference=wb.Ramp("omega", "rad/s", 1.0)).ode(),
        wb.open_loop(motor),
        digital,
        loop().digital(0.02),
        loop().digital(0.01, delay=True),
        digital.with_timing_faults(),
    ]
    prints = [one.fingerprint for one in others]
    assert len({*prints, *free}) == len(others) + 1
    assert digital.law().fingerprint != loop(Kp=50.0).digital(0.01).law().fingerprint  # a law's holds its numbers
    assert digital.law().fingerprint == loop().digital(0.01).law().fingerprint


def test_the_digest_of_a_case_with_noise_holds_its_seed():
    noise, at = ca.SX.sym("w"), ca.SX.sym("k")
    flow = slide(lambda x: x)

    def digest(seed, noisy=True):
        jump = flow.x + noise if noisy else flow.x
        loop = wb.SampledSystem(flow, 0.1, at, noise if noisy else ca.SX(0, 1), jump)
        case = Case("s", "l", Run(loop, (rmse("e"),), h=0.05, until=1.0, seed=seed))
        return Outcome(case, loop, wb.measure(loop, case.run.metrics, until=1.0, h=0.1, seed=seed)).digest

    assert digest(1) == digest(1)
    assert digest(1) != digest(2)
    assert digest(1, noisy=False) == digest(2, noisy=False)


def test_a_function_of_several_results_runs_and_has_no_surfaces_to_be_found():
    v = ca.MX.sym("v", 2)
    apart = ca.Function("apart", [v], [2 * v[0], -3 * v[1]], {"never_inline": True})
    states, t = Layout((Entry("x", np.ones(2)),)), ca.SX.sym("t")
    ode = Ode("two", states, Layout(), Layout(), t, X, ca.SX(0, 1), ca.vertcat(*apart(X)), ca.SX(0, 1))
    end = simulate(rk4(ode, 0.01), until=1.0).x[0, -1]
    np.testing.assert_allclose(end, np.exp([2.0, -3.0]), rtol=1e-6)  # the error of RK4: (3 h)^4 / 120 a second
    with pytest.raises(ValueError, match="'two' switches by 'a function that it calls, such as a table'"):
        reference_run(ode, times=[0.0, 1.0])
