"""Choices in the loops of a law in C: one branch for one condition, tables of its numbers, and the same bits."""

import ctypes
import re
import subprocess
from functools import cache

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.c_runs import COMPILERS, EACH_COMPILER, compiled, differing, needs_compiler, recorded, warned
from tests.support.cases import heavy_but
from workbench.handover.c99.c_files import c_code

PASSES, CARRIED, PERIODS = 5, 4, 60


@wb.block
class Choosing(wb.Controller):
    """A law whose loop carries a few numbers, of which choices drawn by a seed keep some as they are."""

    seed: int
    gain: float = wb.parameter(default=0.7, unit="1")
    rows: np.ndarray = wb.parameter(default=np.linspace(-1.0, 1.0, 2 * PASSES), shape=("n",), unit="1")
    z: np.ndarray = wb.initial(default=np.linspace(-0.5, 0.5, PASSES), unit="1", shape=("N",))

    reads = wb.layout(omega="rad/s")
    follows = wb.layout()
    drives = wb.layout(v="V")

    def body(self, c, row, old):
        """The next carried values and a row: groups of choices by two conditions, with what only they need."""
        rng = np.random.default_rng(self.seed)
        values = [c[i] for i in range(CARRIED)] + [row[0], row[1], old]

        def formula():
            a, b, d = (values[i] for i in rng.integers(len(values), size=3))
            x, y = rng.uniform(-0.9, 0.9, 2)
            return ca.sin(x * a) * self.gain + ca.fmax(y * b, ca.fabs(d)) * 0.3

        conditions = [values[rng.integers(len(values))] > 0.0, row[0] != 0.0]
        ends = []
        for i in range(CARRIED):
            condition, other = conditions[rng.integers(2)], rng.integers(3)
            ends.append(ca.if_else(condition, formula(), (c[i], ca.SX(0.0), formula())[other]))
        return ca.vertcat(*ends), ca.if_else(conditions[0], formula(), ends[0])

    def passed(self, z, est):
        start = ca.vertcat(est.omega, 0.1, -0.2, ca.SX(0.0))
        return wb.bounded_loop(PASSES, self.body, start, ca.reshape(ca.SX(self.rows), 2, PASSES), z.z.T)

    def command(self, t, z, est, ref):
        end, _ = self.passed(z, est)
        return {"v": ca.sum1(end)}

    def update(self, t, z, est, ref):
        _, made = self.passed(z, est)
        return {"z": ca.vec(made)}


@cache
def choosing(seed):
    """The loop in a computer, and its law."""
    motor = wb.DCMotor()
    loop = wb.ClosedLoop(motor, controller=Choosing(seed=seed)).digital(0.05)
    return loop, loop.law()


def branches(source):
    """The lines of the branches that stand in loops."""
    return [line for line in source.splitlines() if re.match(r" {8,}if \(", line)]


@needs_compiler
@pytest.mark.parametrize("compiler", EACH_COMPILER)
@pytest.mark.parametrize("seed", heavy_but(range(12), 0, 1, 2, 3))
def test_branches_have_the_bits_of_the_simulation(seed, compiler, tmp_path):
    loop, law = choosing(seed)
    y, r, u, z = recorded(loop, law, PERIODS, substeps=1)
    made, memory, flags = compiled(c_code(law, "law"), tmp_path, compiler)(y, r)
    assert not flags.any()
    assert differing(made, u) == differing(memory, z) == 0


@needs_compiler
def test_branches_compile_without_a_warning(tmp_path):
    for seed in range(4):
        c_code(choosing(seed)[1], f"law_{seed}").write(tmp_path)
    c_code(predictive()[1], "predictive").write(tmp_path)
    warned(COMPILERS[0], tmp_path, "predictive.c", *(f"law_{seed}.c" for seed in range(4)))


def test_some_of_the_drawn_laws_have_branches():
    assert sum(bool(branches(c_code(choosing(seed)[1], "law").source)) for seed in range(12)) >= 6


@cache
def predictive(horizon=20):
    """A predictive law of a cart, whose limit acts in some periods, and its loop."""
    plant = wb.CartPole(phi=0.2)
    cart = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    weights = np.diag([10.0, 1.0, 10.0, 1.0]), [[0.1]]
    design = wb.predictive_design(cart, 0.02, *weights, horizon, limits={"F": (-3.0, 3.0)})
    law = wb.ModelPredictive.of(plant, design)
    loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law).digital(0.02)
    return loop, loop.law(truths=("xd", "phid"))


def test_what_acts_nowhere_is_left_out_of_a_predictive_law():
    source = c_code(predictive()[1], "law").source
    sums = re.search(r"const bool (w_\d+) = w_\d+ != 0\.0;\n +if \(\1\) \{\n(.*?)\n +\}\n", source, re.DOTALL)
    assert " else " not in sums[2]  # a stage at which no row acts leaves the sums as they are
    assert "A call makes at most " in source
    assert len(branches(source)) == 5  # back, forth, sums, the small system, and the plan of the next period


def test_all_sweeps_are_left_out_where_lqr_keeps_the_limits():
    source = c_code(predictive()[1], "law").source
    assert re.search(r"for \(int (pass_\d+) = 0; \1 < 3; \+\+\1\) \{\n +if \(w_\d+ != 0\.0\) \{\n", source)


def test_numbers_of_a_table_and_the_memory_are_not_copied():
    loop, law = predictive()
    source = c_code(law, "law").source
    table = re.search(r"static const double (W_table)\[(\d+)\] = \{\n(.*?)\};", source, re.DOTALL)
    assert table[3].count("/* controller.W[") == int(table[2]) == np.size(loop.parameters["controller.W"])
    assert re.search(r"const double \*const row_\d+a = state->controller_plan \+ pass_\d+;", source)
    settable = c_code(law, "law", parameters="settable").source
    assert "_table" not in settable


@needs_compiler
@pytest.mark.parametrize("options", [{}, {"parameters": "settable"}], ids=["built in", "settable"])
def test_tables_have_the_bits_of_the_simulation(options, tmp_path):
    loop, law = predictive()
    y, r, u, z = recorded(loop, law, 100, substeps=1)
    made, memory, _ = compiled(c_code(law, "law", **options), tmp_path)(y, r)
    assert differing(made, u) == differing(memory, z) == 0
    assert np.abs(u).max() == 3.0  # the limit acts


@needs_compiler
def test_static_memory_is_that_of_the_state(tmp_path):
    for precision in ("double", "single"):
        code = c_code(predictive()[1], f"law_{precision}", precision=precision)
        head = " ".join(code.header.partition("*/")[0].replace(" * ", " ").split())
        stated = int(re.search(r"Static memory: ([\d,]+) bytes of state", head)[1].replace(",", ""))
        program = f'#include "{code.name}.h"\nint size(void) {{ return (int)sizeof({code.name}_state); }}\n'
        assert stated == size_in_c(code, program, tmp_path)


def size_in_c(code, program, folder):
    """What a function `size` of a program returns."""
    code.write(folder)
    (folder / f"{code.name}_size.c").write_text(program)
    library = folder / f"{code.name}_size.so"
    subprocess.run(
        ["gcc", "-shared", "-fPIC", "-o", str(library), f"{code.name}_size.c"], cwd=folder, check=True, timeout=60
    )
    return ctypes.CDLL(str(library)).size()


def test_the_counts_of_a_replay_stand_in_the_header(tmp_path):
    loop, law = predictive()
    replay = wb.replay(loop, name="law", periods=5, targets=["gcc-O2", "numpy"], truths=("xd", "phid"))
    header, _ = wb.export(law, "c", tmp_path, name="law", replay=replay)
    counted = [result for result in replay.results if result.figures.instructions]
    text = " ".join(header.read_text().replace(" * ", " ").split())
    assert all(f"Instructions of a period on {result.target}: " in text for result in counted)
    with pytest.raises(ValueError, match=r"must be a replay of the exported law in double precision"):
        wb.export(predictive(21)[1], "c", tmp_path / "other", name="law", replay=replay)


@wb.block
class PushedCart(wb.Plant):
    """The linearised cart under a force that takes its law to a limit now and then, as long as it runs."""

    A: np.ndarray = wb.parameter(shape=("n", "n"), unit="1")
    B: np.ndarray = wb.parameter(shape=("n", "m"), unit="1")
    force: float = wb.parameter(unit="N")
    s: np.ndarray = wb.initial(default=np.zeros(4), unit="1", shape=("n",))

    inputs = wb.layout(F="N")
    outputs = property(lambda self: self.states)

    def rate(self, t, x, u):
        return {"s": self.A @ x.s + self.B @ (u.F + self.force * (ca.sin(2.0 * t) + ca.sin(4.6 * t)))}


def pushed_loop():
    cart = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    plant = PushedCart(A=np.array(cart.A), B=np.array(cart.B), force=0.0)
    point = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(4), at_rest=True)
    weights = np.diag([10.0, 1.0, 10.0, 1.0]), [[0.1]]
    design = wb.predictive_design(point, 0.02, *weights, 20, limits={"F": (-3.0, 3.0)})
    pushed = PushedCart(A=plant.A, B=plant.B, force=1.2)
    law = wb.ModelPredictive.of(pushed, design)
    return wb.ClosedLoop(pushed, observer=wb.FullState.of(pushed), controller=law).digital(0.02)


@pytest.mark.parametrize(
    "periods", [pytest.param(2_000, marks=pytest.mark.heavy), pytest.param(100_000, marks=pytest.mark.release)]
)
def test_a_predictive_law_has_the_same_bits_on_every_target(periods):
    targets = tuple(wb.handover.TARGETS)
    replay = wb.replay(pushed_loop(), name="law", periods=periods, targets=targets, timeout=5000.0)
    assert replay.equal
    assert 0.02 < np.mean(np.abs(replay.recording.u) == 3.0) < 0.5  # the limit acts in some periods
