"""The two loops of each plant of b3: in continuous time, in a computer, cut at the inputs, and over parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from studies.b3_any_plant.settings import HARD, SETTINGS, Setting
from workbench.blocks.laws import PID2, Cascade, Regulator
from workbench.blocks.loop import ClosedLoop, DigitalLoop, Instruments, LinearPlant, open_loop
from workbench.blocks.observers import LinearObserver
from workbench.blocks.signals import Hold, Together
from workbench.core import Entry, Layout, LinearSystem
from workbench.core.validation.refusals import Array
from workbench.design.linear import (
    broken_loop,
    disk_margin,
    freeze,
    linearize,
    loop_margins,
    operating_point,
    place,
    sensitivity,
)
from workbench.engine.metrics import rmse, settling_time, total_variation
from workbench.study import Case, Factor, Results, Run, SobolDesign, Sweep, Uniform, least_base, sobol
from workbench.study.uncertainty import SobolIndices

LAWS = LQG, PID = ("LQG", "PID")
LQR = "LQR"  # of all states: no loop here has that, and its margins are what an observer may cost
PLACED = "placed"  # of the tanks at P+ alone: a gain and an observer with poles that were chosen
REGULATOR, OBSERVER = (-0.05, -0.06, -0.07, -0.08), (-0.06, -0.08, -0.9, -1.2)  # 1/s, poles of `PLACED`
COMPUTER = "in a computer"
SEED, BASE, KEPT = 11, 256, 1200
SUBSTEPS, COARSE = 8, 4  # of a period, of a case and of a sweep
HALVED = 64  # one run of a sweep in so many is run again at half of the step
BAND = 0.05  # of what the start is off


def loop(setting: Setting, law: str, *, computer: bool = False) -> ClosedLoop:
    """The loop of a plant and a law, which holds the outputs at the operating point."""
    plant, point = setting.plant, setting.point
    holds = {name: Hold([value], name, plant.outputs[name].unit) for name, value in setting.wanted.items()}
    if law == PID:
        second = setting.pid.law(setting)
        if computer and isinstance(second, PID2):  # against windup; the others have no integral, or are never limited
            second = replace(second, low=setting.limit[0], high=setting.limit[1])
        reference = Together(tuple(hold for name, hold in holds.items() if name in second.follows))
        return ClosedLoop(plant, controller=second, reference=reference)
    K, L = placed(setting) if law == PLACED else (setting.design.regulator.K, setting.design.estimator.K)
    rest = {name: float(np.squeeze(part)) for name, part in setting.open.states.unpack(point.x).items()}
    believed: Any = plant
    model = replace(believed, **rest | setting.start)  # what is not read is believed to rest where it shall
    observer = LinearObserver(model, L, x_0=point.x, u_0=point.u)
    regulator = Regulator.of(plant, K, point.x, point.u, follow=plant.outputs.names)
    return ClosedLoop(plant, observer, regulator, Together(tuple(holds.values())))


def placed(setting: Setting, factor: float = 1.0) -> tuple[Array, Array]:
    """The gains of regulator and observer whose poles are `factor` times those of `PLACED`."""
    model = setting.model
    x, u, y = (
        Layout((Entry(name, np.zeros(size)),))
        for name, size in zip("xuy", (*model.C.T.shape, model.ninputs), strict=True)
    )
    transposed = LinearSystem(x, u, y, model.A.T, model.C.T, model.B.T)
    dual = linearize(open_loop(LinearPlant(transposed)), 0.0, np.zeros(len(model.A)))
    return place(model, factor * np.array(REGULATOR)).K, place(dual, factor * np.array(OBSERVER)).K.T


def cut(setting: Setting, law: str) -> Any:
    """The loop gain at the inputs of the plant about the operating point, a `StateSpace` of python-control."""
    plant, point, model = setting.plant, setting.point, setting.model
    if law == LQR:
        n = len(model.A)
        seen = LinearPlant(LinearSystem(plant.states, plant.inputs, plant.states, model.A, model.B, np.eye(n)))
        closed = ClosedLoop(seen, controller=Regulator.of(seen, setting.design.regulator.K))
        return broken_loop(closed.broken(), 0.0, np.zeros(n))
    closed = loop(setting, law)
    ode = closed.broken(f"{setting.name}, {law}")
    if isinstance(closed.controller, Cascade):  # of PD: their integrals stand still, which is no pole of the loop
        ode = freeze(ode, ("controller.outer.integral", "controller.inner.integral"))
    whole, rest = closed.ode(), setting.open.states.unpack(point.x)
    wanted = {f"plant.{name}": part for name, part in rest.items()}
    at_rest = whole.states.unpack(operating_point(whole, wanted).x)  # with the memory of observer and law
    x = np.concatenate([np.ravel(at_rest[name]) for name in ode.states.names])
    return broken_loop(ode, 0.0, x)


@dataclass(frozen=True)
class Margins:
    """The linear loop at rest: the disk margin of all inputs at once, the least delay margin of an input by itself in
    s, and the decay of its slowest mode in 1/s.
    """

    disk: float
    delay: float
    decay: float


ITEMS = tuple((setting.name, law) for setting in SETTINGS for law in (LQR, LQG, PID))


def margins(item: tuple[str, str]) -> Margins:
    """The margins of a plant under a law, by their names."""
    name, law = item
    opened = cut(next(setting for setting in SETTINGS if setting.name == name), law)
    delay = min(channel.delay for channel in loop_margins(opened))
    return Margins(disk_margin(opened).alpha, delay, float(-sensitivity(opened).poles().real.max()))


def all_margins(results: Results) -> dict[tuple[str, str], Margins]:
    """The margins of each plant under each law."""
    return dict(zip(ITEMS, results.work("margins"), strict=True))


def recovery(item: tuple[str, float]) -> float:
    """The disk margin of LQG on a plant, its filter made for a push at the inputs that is some times as large."""
    name, factor = item
    setting = next(one for one in SETTINGS if one.name == name)
    return disk_margin(cut(replace(setting, push=factor * setting.push), LQG)).alpha


PUSHES = (10.0, 100.0, 1000.0)
PUSHED = tuple((setting.name, factor) for setting in SETTINGS for factor in PUSHES)


def run(setting: Setting, law: str, *, computer: bool, substeps: int = SUBSTEPS) -> Run:
    """One run from off the operating point."""
    closed = loop(setting, law, computer=computer)
    h = setting.period / substeps
    every = setting.period * max(round(setting.until / setting.period / KEPT), 1)
    metrics = (rmse(setting.main), settling_time(setting.main, BAND), total_variation(setting.period))
    if not computer:
        return Run(closed, metrics, setting.until, every, h)
    limit = dict.fromkeys(setting.plant.inputs.names, setting.limit)
    instruments = Instruments.of(setting.plant, noise=setting.noise, limit=limit)
    inside = DigitalLoop(closed, setting.period, instruments, delay=True)
    return Run(inside, metrics, setting.until, every, h, seed=SEED)


def cases() -> tuple[Case, ...]:
    """Each plant with either law, in continuous time and in a computer; the placed design beside them at P+."""
    return tuple(
        Case(setting.name, f"{law} {COMPUTER}" if computer else law, run(setting, law, computer=computer), style)
        for setting in SETTINGS
        for computer in (False, True)
        for style, law in enumerate(laws_of(setting))
    )


def laws_of(setting: Setting) -> tuple[str, ...]:
    """The laws that run on a plant."""
    return (*LAWS, PLACED) if setting.name == HARD else LAWS


def called(setting: Setting, law: str) -> str:
    """The name of the sweep of a plant and a law."""
    signs = str.maketrans({" ": "_", "-": "_", "\N{MINUS SIGN}": "m", "+": "p"})
    return f"{setting.name}_{law}".lower().translate(signs)


def sweeps() -> tuple[Sweep, ...]:
    """Each plant with either law in continuous time, over the parameters of the plant alone, at the same points."""
    made = []
    for setting in SETTINGS:
        for law in LAWS:
            ends = replace(run(setting, law, computer=False, substeps=COARSE), every=None)
            moved, least = factors(setting), least_base(len(setting.spread))
            made.append(Sweep(called(setting, law), ends, moved, design(setting), halved=HALVED, least=least))
    return tuple(made)


def factors(setting: Setting) -> tuple[Factor, ...]:
    """The parameters of the plant that are varied, as shares of their own values; both laws keep what they believe."""
    return tuple(
        Factor(name, (f"plant.{name}",), Uniform(low, high), share=True) for name, (low, high) in setting.spread.items()
    )


def design(setting: Setting) -> SobolDesign:
    """The same points for both laws."""
    return SobolDesign(len(setting.spread), BASE, seed=SEED)


def errors(results: Results, setting: Setting, law: str) -> Array:
    """The RMSE of each run of the sweep of a plant and a law."""
    return np.asarray(results.sample(called(setting, law)).score(f"RMSE of {setting.main}").value)


def indices(setting: Setting, results: Results) -> SobolIndices:
    """Sobol indices of the RMSE, an output a law."""
    sample = results.sample(called(setting, LQG))
    outputs = np.stack([errors(results, setting, law) for law in LAWS], axis=1)
    found: SobolIndices = sobol(sample.design, outputs, LAWS, factors=sample.factors, control=True)
    return found
