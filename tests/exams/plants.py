"""The exam of plants that a user brings as plain functions: at rest, linear, with a gain, and in a computer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from workbench.blocks.loop import AbstractController, ClosedLoop, open_loop
from workbench.blocks.plants import OdePlant
from workbench.core import Layout, Ode, SampledSystem, Signals, block, layout, parameter
from workbench.core.block import Matrix, Vector
from workbench.core.validation.refusals import Array
from workbench.design.linear import linearize, operating_point
from workbench.design.riccati import lqr
from workbench.engine import simulate
from workbench.engine.reference import reference_run

from .graders import Grader, Loaded

AGREED = 1e-9  # by how much samples may change where the substeps are doubled, relative to the largest of each state
ROUNDING = 1e-15  # by how much a state that rests may change, relative to the largest of all
MOST_SUBSTEPS = 128


@block
class Regulator(AbstractController):
    """u = u_0 - K (x - x_0), from all states of a plant."""

    states: Layout
    inputs: Layout
    K: Matrix = parameter(unit="", shape=("m", "nx"))
    x_0: Vector = parameter(unit="", shape=("nx",))
    u_0: Vector = parameter(unit="", shape=("m",))

    @property
    def reads(self) -> Layout:
        """All states."""
        return self.states

    @property
    def drives(self) -> Layout:
        """All inputs."""
        return self.inputs

    def command(self, t: Any, z: Any, est: Any, ref: Any) -> Signals:
        """The gain's command."""
        u = self.u_0 - self.K @ (self.states.flatten(est) - self.x_0)
        return Signals(self.inputs.view(u))


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """What the grader asks of one case."""
    u = np.array(case["u"], dtype=float)
    ode = open_loop(OdePlant.of(case["f"], case["states"], case["inputs"], case["outputs"], x0=case["x"], u0=u))
    x = _rest(ode, u) if case.get("balance") else ode.states.default
    linear = linearize(ode, 0.0, x, u=u)
    K = lqr(linear, np.diag(np.array(case["Q"], dtype=float)), np.diag(np.array(case["R"], dtype=float))).K
    plant = OdePlant.of(case["f"], case["states"], case["inputs"], x0=case["x0"])  # whose states are all read
    loop = ClosedLoop(plant, controller=Regulator(plant.states, plant.inputs, K, x, u))
    samples = _samples(loop.digital(case["period"]), max(case["kept"]), plant.states.names)
    return {"x": x, "A": linear.A, "B": linear.B, "K": K, "samples": samples[np.array(case["kept"])]}


def _rest(ode: Ode, u: Array) -> Array:
    """The rest point at these inputs that Newton's method reaches from the defaults."""
    held = dict(zip(ode.inputs, u, strict=True))
    return operating_point(ode, held).x


def _samples(loop: SampledSystem, last: int, names: tuple[str, ...]) -> Array:
    """The states (last + 1, nx) at the instants, with as many substeps as they need to agree."""
    before, substeps = np.full((last + 1, len(names)), np.inf), 4
    while substeps <= MOST_SUBSTEPS:
        run = simulate(loop.step(substeps), until=last * loop.period, arithmetic="casadi")  # compiles nothing
        now = np.column_stack([run[f"plant.{name}"][0] for name in names])
        if (np.abs(now - before) <= AGREED * np.abs(now).max(axis=0) + ROUNDING * np.abs(now).max()).all():
            return now
        before, substeps = now, 2 * substeps
    return _stiff_samples(loop, last, names)


def _stiff_samples(loop: SampledSystem, last: int, names: tuple[str, ...]) -> Array:
    """The same by the reference mode over each period, implicit where that pays: for a plant too stiff for substeps."""
    jump = ca.Function("jump", [loop.k, loop.flow.x, loop.flow.p], [loop.jump])
    flow, since = loop.flow, layout(since="s")
    clock = since.symbols()
    late = {"parameters": flow.parameters + since, "p": ca.vertcat(flow.p, clock)}
    flow = replace(flow, rate=ca.substitute(flow.rate, flow.t, flow.t + clock), **late)
    p, at = loop.parameters.default, [loop.states.default]
    for k in range(last):
        held = np.array(jump(k, at[-1], p)).ravel()
        asked = {"times": [loop.period], "method": "implicit", "rtol": 1e-9, "atol": 1e-11 * (1 + abs(held))}
        at.append(reference_run(flow, np.append(p, k * loop.period), held, **asked).x[-1])
    states = loop.states.unpack(np.array(at))
    return np.column_stack([states[f"plant.{name}"] for name in names])


def plants(exam: Loaded) -> tuple[bool, str]:
    """All cases beside the grader: those that are shown, and those that are held back where they are there."""
    folder = Path(str(exam.module.__file__)).parent
    lines: list[str] = []
    for name in ("visible", "held"):
        if (folder / f"{name}.json").exists():
            lines += exam.module.grade(solve, *exam.module.load(str(folder), name))[0]
    good = [line for line in lines if line.endswith(": passed")]
    missed = "; ".join(line for line in lines if line not in good)
    return bool(lines) and not missed, f"{len(good)} of {len(lines)} passed" + (f"; {missed}" if missed else "")


def asked(grader: Grader) -> bool:
    """Whether a grader asks for plants: it loads cases, and grades what is made of each."""
    return {"grade", "load"} <= grader.functions
