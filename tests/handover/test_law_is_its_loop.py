"""A law alone has the bits that it has in its loop, by construction: in every form, whatever law and plant share."""

import importlib.util
import json
import subprocess
import sys
from functools import cache

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support import random_laws
from tests.support.c_runs import COMPILERS, differing
from tests.support.random_laws import in_c, in_numpy, in_python, in_webassembly, wanted
from workbench.blocks.loop import AbstractController, AbstractObserver, AbstractPlant
from workbench.core import block, layout, parameter
from workbench.engine.arithmetic import FUSED
from workbench.handover.fmi import fmu
from workbench.handover.recording import record

FIRST, OTHERS = range(4), range(4, 13)  # that stay finite; more by `python -m tests.support.random_laws`
UNITS = FIRST[::2]  # of those that become an FMU, whose equations are the same text in C
recorded = cache(random_laws.recorded)

IMPORTER = """
import json, os, sys
import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
for folder in sys.argv[1:]:
    told = json.load(open(f"{folder}/names.json"))
    description = fmpy.read_model_description(f"{folder}/law.fmu")
    places = {variable.name: variable.valueReference for variable in description.modelVariables}
    unit = FMU2Slave(guid=description.guid, unzipDirectory=fmpy.extract(f"{folder}/law.fmu", f"{folder}/unpacked"),
                     instanceName="law", modelIdentifier=description.coSimulation.modelIdentifier)
    unit.instantiate()
    unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    inputs, outputs = ([places[name] for name in told[port]] for port in ("input", "output"))
    rows = np.load(f"{folder}/inputs.npy")
    answers = np.empty((len(rows), len(outputs)))
    for k, row in enumerate(rows.tolist()):
        unit.setReal(inputs, row)
        unit.doStep(currentCommunicationPoint=k * told["period"], communicationStepSize=told["period"])
        answers[k] = unit.getReal(outputs)
    np.save(f"{folder}/answers.npy", answers)
    unit.terminate()
"""


@pytest.mark.parametrize("numbers", [FIRST, pytest.param(OTHERS, marks=pytest.mark.release)])
def test_random_laws_have_the_bits_of_their_loops_in_c_python_webassembly_and_numpy(numbers, tmp_path):
    ran, wrong = 0, {}
    for number in numbers:
        made = recorded(number)
        if made is None:
            continue
        rows, law = made[1], made[1].law
        folder = tmp_path / str(number)
        forms = {"Python": in_python(law, rows), "WebAssembly": in_webassembly(law, rows)}
        forms |= {"NumPy": in_numpy(law, rows, False), **({"C": in_c(law, rows, folder)} if COMPILERS else {})}
        counts = {name: differing(theirs, wanted(rows)) for name, theirs in forms.items()}
        ran += 1
        if any(counts.values()):
            wrong[number] = counts
    assert ran >= len(numbers) - 1
    assert not wrong


@pytest.mark.skipif(
    importlib.util.find_spec("fmpy") is None or not COMPILERS, reason="this environment has no FMPy, or no compiler"
)
def test_random_laws_have_the_bits_of_their_loops_as_fmus(tmp_path):
    commands = {}
    for number in UNITS:
        _, rows = recorded(number)
        folder = tmp_path / str(number)
        folder.mkdir()
        unit = fmu(rows.law, "2.0", "law", compiler=COMPILERS[0])
        unit.write(folder / "law.fmu")
        names = {role: [v.name for v in unit.variables if v.role == role] for role in ("input", "output")}
        (folder / "names.json").write_text(json.dumps({"period": rows.law.period, **names}), encoding="utf-8")
        np.save(folder / "inputs.npy", np.concatenate([rows.y, rows.r], axis=1))
        commands[folder] = rows.u
    assert len(commands) == len(UNITS)
    subprocess.run([sys.executable, "-c", IMPORTER, *map(str, commands)], check=True, timeout=120)
    assert [differing(np.load(folder / "answers.npy"), u) for folder, u in commands.items()] == [0] * len(commands)


def test_random_laws_contract_the_same_products_alone_and_in_their_loops():
    """Where a product is rounded together with its sum too, which depends on what else uses the product."""
    for number in FIRST:
        sampled, rows = recorded(number)
        law, n, step = rows.law, 20, sampled.step(2)
        run = wb.simulate(_with_what_is_handed(step, sampled), until=n * law.period, seed=1, arithmetic=FUSED)
        x, states = run.x[0], run.step.states

        def of(names, x=x, states=states):
            return np.concatenate([x[:, states.slice(name)] for name in names] + [x[:, :0]], axis=1)

        class Rows:
            periods = n
            y, r = (
                of(f"y.{name}" for name in law.readings.names)[1:],
                of(f"r.{name}" for name in law.references.names)[1:],
            )
            memory = staticmethod(lambda first, last, z=of(law.memory.names): z[first : last + 1])

        ours = np.concatenate([of(law.memory.names), of(f"hold.{name}" for name in law.commands.names)], axis=1)[1:]
        assert differing(in_numpy(law, Rows, True), ours) == 0, number


def _with_what_is_handed(step, sampled):
    from workbench.core import Entry, Layout

    extra = Layout(tuple(Entry(name, np.zeros(part.numel())) for name, part in sampled.computer_inputs.items()))
    return step.with_memory(extra, ca.SX.sym("handed", extra.size), ca.vertcat(*sampled.computer_inputs.values()))


def test_random_laws_with_their_references_built_in_have_the_bits_of_their_loops():
    for number in FIRST:
        sampled, _ = recorded(number)
        rows = record(sampled, sampled.law(reference="built in"), 50, seed=1)
        assert differing(in_numpy(rows.law, rows, False), wanted(rows)) == 0, number


# The pairs that were found to differ: what an instrument does to an angle, and how the law goes on with it.
PAIRS = {
    "a literal gain": (lambda th: 3.3 * th, lambda y: 4.7 * y),
    "degrees": (lambda th: th * (180 / np.pi), lambda y: y * (np.pi / 180)),
    "exp and log": (lambda th: ca.exp(th), lambda y: ca.log(y)),
    "a reciprocal": (lambda th: 1 / (3 + th), lambda y: 1 / y),
    "a table": (lambda th: ca.pw_lin(th, ca.DM([-1, 0, 1]), ca.DM([-0.7, 0, 0.9])), lambda y: y / 0.7),
    "a sum of angles": (lambda th: ca.sin(th + 0.3), lambda y: ca.cos(y - 0.3) + ca.sin(y) + ca.cos(y)),
}


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("wanted_angle", [0.0, 0.4])
def test_a_command_has_the_bits_of_its_loop_whatever_the_instrument_does_to_the_reading(pair, wanted_angle):
    do, undo = PAIRS[pair]

    @block
    class Pendulum(AbstractPlant):
        """An angle as an instrument shows it."""

        states, inputs, outputs = layout(th=("rad", 0.5), om="rad/s"), layout(u="N m"), layout(y="1")

        def rate(self, t, x, u):
            return {"th": x.om, "om": -9.81 * ca.sin(x.th) - x.om + u.u}

        def measure(self, t, x):
            return {"y": do(x.th)}

    @block
    class Shown(AbstractObserver):
        """The reading undone."""

        reads, gives = layout(y="1"), layout(q="rad")

        def estimate(self, t, z, y):
            return {"q": undo(y.y)}

    @block
    class Law(AbstractController):
        """A literal gain."""

        reads, follows, drives = layout(q="rad"), layout(q="rad"), layout(u="N m")

        def command(self, t, z, est, ref):
            return {"u": ref.q - 4.7 * est.q}

    reference = wb.Step("q", "rad", wanted_angle)
    loop = wb.ClosedLoop(Pendulum(), Shown(), Law(), reference).digital(0.01)
    rows = record(loop, loop.law(), 2000)
    assert differing(in_numpy(rows.law, rows, False), wanted(rows)) == 0


def test_a_product_that_plant_and_law_have_in_common_is_contracted_in_both():
    """Shared with the plant it would have two uses, and be rounded by itself in the loop alone."""
    loop = wb.ClosedLoop(Sharing(), controller=SharingLaw()).digital(0.1)
    graph = _law_part(loop.step(1))
    assert graph == _law_part(loop.law().step)
    assert any(node.op in ("fma", "fms", "fnma") for node in graph)


@block
class Sharing(AbstractPlant):
    """Its reading and its rate hold a product that the law makes too."""

    states, inputs, outputs = layout(x=("m", 0.3)), layout(u="N"), layout(x="m")

    def rate(self, t, x, u):
        return {"x": x.x * ca.sin(t) - x.x + 0.1 * u.u * ca.cos(t)}

    def measure(self, t, x):
        return {"x": x.x * ca.sin(t)}


@block
class SharingLaw(AbstractController):
    """A law with the time in it."""

    k: float = parameter(2.0, unit="N/m")
    reads, drives = layout(x="m"), layout(u="N")

    def command(self, t, z, est, ref):
        return {"u": self.k - est.x * ca.sin(t)}

    def signals(self, z, est, ref):
        return {"s": est.x * est.x + 1}


def _law_part(step):
    from workbench.engine.kernel.casadi_to_graph import read
    from workbench.engine.kernel.graph_rewriting import expand_angle_sums, fuse_products

    return [node._replace(entry=0) for node in fuse_products(expand_angle_sums(read(step).earlier[-1])).nodes]
