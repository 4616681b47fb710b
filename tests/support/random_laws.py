"""Random laws and plants: every operation, literal gains, degrees, tables, and formulas that both have.

`python -m tests.support.random_laws FIRST LAST` runs the loops of these numbers, and
says which law differs from its loop.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import casadi as ca
import numpy as np

import workbench as wb
from tests.support.c_runs import compiled, differing
from tests.support.random_formulas import GAINS, Draw, table
from tests.support.wasm_runs import Kernel
from workbench.blocks.loop import AbstractController, AbstractObserver, AbstractPlant
from workbench.blocks.loop.environment import AbstractReference
from workbench.core import block, layout, parameter
from workbench.engine.kernel import webassembly
from workbench.engine.kernel.plan import Evaluation, KernelPlan, graph_of
from workbench.engine.machines.numpy_spelling import Arrays
from workbench.handover.c99.c_files import c_code
from workbench.handover.programs.python_law import python_law
from workbench.handover.recording import record

INVERSES = (  # what an instrument does to a signal, and how a law undoes it
    (lambda x: x * (180 / np.pi), lambda y: y * (np.pi / 180)),
    (lambda x: x * (np.pi / 180), lambda y: y * (180 / np.pi)),
    (lambda x: 3.3 * x, lambda y: -4.7 * y),
    (lambda x: ca.exp(ca.tanh(x)), lambda y: ca.log(y)),
    (lambda x: 1 / (2 + ca.sin(x)), lambda y: 1 / y),
    (lambda x: ca.sqrt(1 + x * x), lambda y: y * y - 1),
    (lambda x: x / 10, lambda y: 10 * y),
    (lambda x: -x, lambda y: -y),
    (lambda x: x + 0.1, lambda y: y - 0.1),
    (lambda x: ca.floor(x * 100) / 100, lambda y: ca.floor(y / 0.01 + 0.5) * 0.01),
    (lambda x: x, lambda y: y),
)


@dataclass(frozen=True)
class Drawn:
    """What the blocks of a loop share: random numbers, and how an instrument changes a signal and a law undoes it."""

    draw: Draw
    rng: np.random.Generator
    do: tuple[Callable[[ca.SX], ca.SX], ...]
    undo: tuple[Callable[[ca.SX], ca.SX], ...]
    shared: int  # a formula that law and plant have in common
    discrete: bool
    observed: bool
    zero: bool
    kp: float
    ki: float
    period: float

    @staticmethod
    def of(seed):
        draw = Draw(seed)
        rng = draw(0)
        chosen = [INVERSES[i] for i in rng.integers(len(INVERSES), size=2)]
        do, undo = zip(*chosen, strict=True)
        shared = int(rng.integers(3))
        discrete, observed, zero = rng.random() < 0.15, rng.random() < 0.4, rng.random() < 0.25
        kp, ki = (float(number) for number in rng.choice(GAINS, 2))
        return Drawn(
            *(draw, rng, do, undo, shared, discrete, observed, zero, kp, ki),
            period=float(rng.choice([0.01, 0.02, 0.1, 1 / 30])),
        )

    def gain(self, *others):
        """The next of the gains, or of these numbers."""
        return float(self.rng.choice(others or GAINS))


def _plant(of):
    def moves(self, t, x, u):
        common = of.draw.formula(of.shared, [x.a, x.b, ca.SX(self.m)])
        rate = {"a": x.b - x.a + 0.1 * common, "b": self.m * ca.sin(u.v) - x.b - ca.tanh(table(x.a)) + 0.3 * ca.cos(t)}
        return (
            {name: 0.9 * x[name] + 0.1 * ca.tanh(part) for name, part in rate.items()}
            if of.discrete
            else {name: ca.tanh(part) - 0.5 * x[name] for name, part in rate.items()}
        )

    body = {
        "__annotations__": {"m": float},
        "m": parameter(of.gain(1.0, 1.7), unit="1"),
        "states": layout(a=("1", 0.3), b=("1", -0.2)),
        "inputs": layout(v="V"),
        "outputs": layout(y="1", w="1"),
        "measure": lambda self, t, x: {"y": of.do[0](x.a), "w": of.do[1](x.b) if of.shared else of.do[1](x.b) * self.m},
        **({"update": moves, "period": of.period} if of.discrete else {"rate": moves}),
    }
    return block(type("RandomPlant", (AbstractPlant,), body))


def _observer(of):
    def estimate(self, t, z, y):
        a, b = of.undo[0](y.y), of.undo[1](y.w)
        return {"y": a + 0.5 * (z.h - a), "w": b + of.draw.formula(3, [b, z.g, ca.SX(self.l)], 2)}

    def corrected(self, t, z, y, est, u):
        model = {"h": est.w - z.h, "g": self.m * ca.sin(u.v) - z.g + self.l * (y.w - z.g)}
        return {name: ca.tanh(part) for name, part in model.items()}

    watcher = {
        "__annotations__": {"l": float, "m": float},
        "l": parameter(of.gain(), unit="1"),
        "m": parameter(1.7, unit="1"),
        "memory": layout(h="1", g="1"),
        "inputs": layout(v="V"),
        "reads": layout(y="1", w="1"),
        "gives": layout(y="1", w="1"),
        "estimate": estimate,
        "rate": corrected,
    }
    return block(type("RandomObserver", (AbstractObserver,), watcher))


def _law(of):
    def command(self, t, z, est, ref):
        a, b = (est.y, est.w) if of.observed else (of.undo[0](est.y), of.undo[1](est.w))
        common = of.draw.formula(of.shared, [a, b, ca.SX(self.k)])
        atoms = [a, b, est.y, est.w, ref.y, z.i, ca.SX(self.k), t]
        e = ref.y - of.kp * est.y
        return {"v": self.k * e + of.ki * (z.i - b) + common + of.draw.formula(4, atoms, 4)}

    def adapted(self, t, z, est, ref):
        atoms = [est.y, ref.y, z.i, z.j, ca.SX(self.k)]
        return {"i": ca.tanh(of.draw.formula(5, atoms)) - z.i, "j": ref.y - est.w - z.j}

    def signals(self, z, est, ref):
        return {"s": of.draw.formula(4, [est.y, est.w, ref.y, z.i, z.j, ca.SX(self.k)])}

    own = {
        "__annotations__": {"k": float},
        "k": parameter(of.gain(), unit="V"),
        "memory": layout(i="1", j="1"),
        "reads": layout(y="1", w="1"),
        "follows": layout(y="1"),
        "drives": layout(v="V"),
        "command": command,
        "rate": adapted,
        "signals": signals,
        "period": 2 * of.period if of.rng.random() < 0.2 else None,
    }
    return block(type("RandomLaw", (AbstractController,), own))


def _reference(of):
    def wanted(self, t):
        return {"y": 0.0 if of.zero else of.draw.formula(6, [t, ca.SX(self.k)], 2)}

    says = {
        "__annotations__": {"k": float},
        "k": parameter(of.gain(), unit="1"),
        "gives": layout(y="1"),
        "at": wanted,
    }
    return block(type("RandomReference", (AbstractReference,), says))


def random_loop(seed):
    """A loop of blocks with random equations, and how a computer closes it."""
    of = Drawn.of(seed)
    Plant, Observer, Law, Reference = (make(of) for make in (_plant, _observer, _law, _reference))
    plant = Plant()
    loop = wb.ClosedLoop(plant, *([Observer()] if of.observed else []), controller=Law(), reference=Reference())
    noisy, coarse, limited = of.rng.random(3) < 0.4
    instruments = wb.Instruments.of(
        plant,
        noise={"y": 1e-3} if noisy else {},
        quantum={"w": 0.01} if coarse else {},
        limit={"v": (-2.0, 3.0)} if limited else {},
    )
    return loop.digital(of.period, instruments, delay=int(of.rng.integers(3)))


PERIODS = 50


def in_python(law, rows):
    """Commands and memory of the law as a module of Python."""
    space = {"__name__": "law"}
    exec(compile(python_law(law, "law"), "law", "exec"), space)
    machine, made = space["Law"](), []
    for y, r in zip(rows.y, rows.r, strict=True):
        commands = machine.step(by_name(law.readings, y), by_name(law.references, r))
        made.append(np.concatenate([flat(law.memory, machine.memory), flat(law.commands, commands)]))
    return np.array(made)


def by_name(port, row):
    """The numbers of a port as a module of Python takes them."""
    parts = {entry.name: row[port.slice(entry.name)] for entry in port.entries}
    return {e.name: parts[e.name].tolist() if e.shape else float(parts[e.name][0]) for e in port.entries}


def flat(port, values):
    """The numbers of a port side by side."""
    return np.concatenate([np.zeros(0), *(np.atleast_1d(values[name]) for name in port.names)])


def in_webassembly(law, rows):
    """Commands and memory of the law as a module of WebAssembly, as a browser runs it."""
    plan = KernelPlan.of_step(law.step, ())
    march = {
        "constants": list(plan.constants(law.period)),
        "parameters": list(plan.parameters),
        "lanes": len(plan.lanes),
        "table": len(plan.table),
        "states": law.step.states.size,
        "stride": 1,
    }
    kernel, made = Kernel(webassembly.compile_plan(plan), march, 1), []
    x = np.concatenate([law.memory.default, np.zeros(law.commands.size)])
    for k, row in enumerate(np.concatenate([rows.y, rows.r], axis=1)):
        x = kernel.run(np.concatenate([law.parameters.default, row]), x, 1, begin=k)[0]
        made.append(x)
    return np.array(made)


def in_c(law, rows, folder):
    """Commands and memory of the law in C."""
    u, z, flags = compiled(c_code(law, "law"), folder, options=("-O1",))(rows.y, rows.r)
    assert not flags.any()
    return np.concatenate([z, u], axis=1)


def in_numpy(law, rows, fused):
    """Commands and memory of the law's graph, each instant from the memory that was recorded before it."""
    graph, n = graph_of(law.step), rows.periods
    x = np.concatenate([rows.memory(0, n)[:-1], np.zeros((n, law.commands.size))], axis=1)
    p = np.concatenate([np.tile(law.parameters.default, (n, 1)), rows.y, rows.r], axis=1)
    numbers = graph.numbers(law.period)

    def load(place):
        node = graph.nodes[place]
        if place in numbers:
            return np.float64(numbers[place])
        return np.arange(n, dtype=float) if node.op == "k" else {"x": x, "p": p}[node.op][:, node.entry]

    evaluation = Evaluation(graph, Arrays(fused), load)
    with np.errstate(all="ignore"):
        evaluation.make(range(len(graph.nodes)))
        return np.stack([np.broadcast_to(evaluation.value(place), n) for place in graph.results], axis=1)


def recorded(seed):
    """The law of a random loop and its recording, or None where a number of the run is not finite."""
    sampled = random_loop(seed)
    try:
        return sampled, record(sampled, sampled.law(), PERIODS, substeps=2, seed=1)
    except ValueError as error:
        if "stays finite" in str(error):
            return None
        raise


def wanted(rows):
    """Commands and memory as they are in the loop."""
    return np.concatenate([rows.memory(0, rows.periods)[1:], rows.u], axis=1)


def main(first, last):
    """Say which of these laws differs from its loop, in which form."""
    counts = dict.fromkeys(("ran", "not finite", "numbers", "differing"), 0)
    for seed in range(first, last):
        made = recorded(seed)
        if made is None:
            counts["not finite"] += 1
            continue
        (_, rows), ours = made, wanted(made[1])
        with TemporaryDirectory() as folder:
            forms = {
                "C": in_c(rows.law, rows, Path(folder)),
                "Python": in_python(rows.law, rows),
                "WebAssembly": in_webassembly(rows.law, rows),
                "NumPy": in_numpy(rows.law, rows, False),
            }
        counts["ran"] += 1
        for name, theirs in forms.items():
            counts["numbers"] += ours.size
            if count := differing(theirs, ours):
                counts["differing"] += count
                sys.stdout.write(f"{seed}: {count} numbers differ in {name}\n")
        if seed % 100 == 99:
            sys.stdout.write(f"{seed + 1}: {counts}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
