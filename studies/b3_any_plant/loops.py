"""The two loops of each plant of b3: in continuous time, in a computer, cut at the inputs, and over parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import workbench as wb
from studies.b3_any_plant.settings import HARD, SETTINGS, Setting

LAWS = LQG, PID = ("LQG", "PID")
LQR = "LQR"  # of all states: no loop here has that, and its margins are what an observer may cost
PLACED = "placed"  # of the tanks at P+ alone: a gain and an observer with poles that were chosen
REGULATOR, OBSERVER = (-0.05, -0.06, -0.07, -0.08), (-0.06, -0.08, -0.9, -1.2)  # 1/s, poles of `PLACED`
COMPUTER = "in a computer"  # in the names of runs
DIGITAL = "with a digital controller"  # the same in the words of the page
SEED, BASE, STATE_COUNT = 11, 256, 1200
SUBSTEPS, COARSE = 8, 4  # of a period, of a case and of a sweep
HALF_STEP_EVERY = 64  # one run of a sweep in so many is run again at half of the step
BAND = 0.05  # of what the start is off


def loop(setting: Setting, law: str, *, computer: bool = False) -> wb.ClosedLoop:
    """The loop of a plant and a law, which holds the outputs at the operating point."""
    plant, point = setting.plant, setting.point
    holds = {
        name: wb.Constant(name, plant.outputs[name].unit, [value]) for name, value in setting.operating_outputs.items()
    }
    if law == PID:
        second = setting.pid.law(setting)
        if computer and isinstance(second, wb.PID):  # against windup; the others have no integral, or are never limited
            second = replace(second, low=setting.limit[0], high=setting.limit[1])
        reference = wb.CombinedReference(tuple(hold for name, hold in holds.items() if name in second.follows))
        return wb.ClosedLoop(plant, controller=second, reference=reference)
    K, L = placed_gains(setting) if law == PLACED else (setting.design.regulator.K, setting.design.estimator.K)
    rest = {name: float(np.squeeze(part)) for name, part in setting.open.states.unpack(point.x).items()}
    believed: Any = plant
    model = replace(believed, **rest | setting.start)  # what is not read is believed to rest where it shall
    observer = wb.LinearObserver(model, L, x_0=point.x, u_0=point.u)
    regulator = wb.StateFeedback.of(plant, K, point.x, point.u, follow=plant.outputs.names)
    return wb.ClosedLoop(plant, observer, regulator, wb.CombinedReference(tuple(holds.values())))


def placed_gains(setting: Setting, factor: float = 1.0) -> tuple[wb.Array, wb.Array]:
    """The gains of regulator and observer whose poles are `factor` times those of `PLACED`."""
    model = setting.model
    x, u, y = (
        wb.Layout((wb.core.Entry(name, np.zeros(size)),))
        for name, size in zip("xuy", (*model.C.T.shape, model.ninputs), strict=True)
    )
    transposed = wb.core.LinearSystem(x, u, y, model.A.T, model.C.T, model.B.T)
    dual = wb.linearize(wb.open_loop(wb.LinearPlant(transposed)), 0.0, np.zeros(len(model.A)))
    return wb.place(model, factor * np.array(REGULATOR)).K, wb.place(dual, factor * np.array(OBSERVER)).K.T


def cut(setting: Setting, law: str) -> Any:
    """The loop gain at the inputs of the plant about the operating point, a `StateSpace` of python-control."""
    plant, point, model = setting.plant, setting.point, setting.model
    if law == LQR:
        n = len(model.A)
        seen = wb.LinearPlant(
            wb.core.LinearSystem(plant.states, plant.inputs, plant.states, model.A, model.B, np.eye(n))
        )
        closed = wb.ClosedLoop(seen, controller=wb.StateFeedback.of(seen, setting.design.regulator.K))
        return wb.linear.broken_loop(closed.cut(), 0.0, np.zeros(n))
    closed = loop(setting, law)
    ode = closed.cut(f"{setting.name}, {law}")
    if isinstance(closed.controller, wb.Cascade):  # of PD: their integrals stand still, which is no pole of the loop
        ode = wb.linear.freeze(ode, ("controller.outer.integral", "controller.inner.integral"))
    whole, rest = closed.ode(), setting.open.states.unpack(point.x)
    wanted = {f"plant.{name}": part for name, part in rest.items()}
    at_rest = whole.states.unpack(wb.linear.operating_point(whole, wanted).x)  # with the memory of observer and law
    x = np.concatenate([np.ravel(at_rest[name]) for name in ode.states.names])
    return wb.linear.broken_loop(ode, 0.0, x)


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
    delay = min(channel.delay for channel in wb.linear.loop_margins(opened))
    return Margins(wb.linear.disk_margin(opened).alpha, delay, float(-wb.linear.sensitivity(opened).poles().real.max()))


def all_margins(results: wb.Results) -> dict[tuple[str, str], Margins]:
    """The margins of each plant under each law."""
    return dict(zip(ITEMS, results.work("margins"), strict=True))


def recovery(item: tuple[str, float]) -> float:
    """The disk margin of LQG on a plant, its filter made for a push at the inputs that is some times as large."""
    name, factor = item
    setting = next(one for one in SETTINGS if one.name == name)
    return wb.linear.disk_margin(cut(replace(setting, push=factor * setting.push), LQG)).alpha


PUSHES = (10.0, 100.0, 1000.0)
PUSHED_CASES = tuple((setting.name, factor) for setting in SETTINGS for factor in PUSHES)


def run(setting: Setting, law: str, *, computer: bool, substeps: int = SUBSTEPS) -> wb.Run:
    """One run from off the operating point."""
    closed = loop(setting, law, computer=computer)
    h = setting.period / substeps
    every = setting.period * max(round(setting.until / setting.period / STATE_COUNT), 1)
    metrics = (wb.rmse(setting.main), wb.settling_time(setting.main, BAND), wb.total_variation(setting.period))
    if not computer:
        return wb.Run(closed, metrics, setting.until, every, h)
    limit = dict.fromkeys(setting.plant.inputs.names, setting.limit)
    instruments = wb.Instruments.of(setting.plant, noise=setting.noise, limit=limit)
    inside = wb.DigitalLoop(closed, setting.period, instruments, delay=True)
    return wb.Run(inside, metrics, setting.until, every, h, seed=SEED)


def cases() -> tuple[wb.Case, ...]:
    """Each plant with either law, in continuous time and in a computer; the placed design beside them at P+."""
    return tuple(
        wb.Case(setting.name, f"{law} {COMPUTER}" if computer else law, run(setting, law, computer=computer), style)
        for setting in SETTINGS
        for computer in (False, True)
        for style, law in enumerate(laws_of(setting))
    )


def laws_of(setting: Setting) -> tuple[str, ...]:
    """The laws that run on a plant."""
    return (*LAWS, PLACED) if setting.name == HARD else LAWS


def sweep_name(setting: Setting, law: str) -> str:
    """The name of the sweep of a plant and a law."""
    signs = str.maketrans({" ": "_", "-": "_", "\N{MINUS SIGN}": "m", "+": "p"})
    return f"{setting.name}_{law}".lower().translate(signs)


def sweeps() -> tuple[wb.Sweep, ...]:
    """Each plant with either law in continuous time, over the parameters of the plant alone, at the same points."""
    made = []
    for setting in SETTINGS:
        for law in LAWS:
            ends = replace(run(setting, law, computer=False, substeps=COARSE), every=None)
            moved, least = factors(setting), wb.study.least_base(len(setting.spread))
            made.append(
                wb.Sweep(
                    sweep_name(setting, law),
                    ends,
                    moved,
                    design(setting),
                    half_step_every=HALF_STEP_EVERY,
                    least_samples=least,
                )
            )
    return tuple(made)


def factors(setting: Setting) -> tuple[wb.Factor, ...]:
    """The parameters of the plant that are varied, as shares of their own values; both laws keep what they believe."""
    return tuple(
        wb.Factor(name, (f"plant.{name}",), wb.Uniform(low, high), share=True)
        for name, (low, high) in setting.spread.items()
    )


def design(setting: Setting) -> wb.SobolDesign:
    """The same points for both laws."""
    return wb.SobolDesign(len(setting.spread), BASE, seed=SEED)


def errors(results: wb.Results, setting: Setting, law: str) -> wb.Array:
    """The RMSE of each run of the sweep of a plant and a law."""
    return np.asarray(results.sample(sweep_name(setting, law)).score(f"RMSE of {setting.main}").value)


def indices(setting: Setting, results: wb.Results) -> wb.uncertainty.SobolIndices:
    """Sobol indices of the RMSE, an output a law."""
    sample = results.sample(sweep_name(setting, LQG))
    outputs = np.stack([errors(results, setting, law) for law in LAWS], axis=1)
    design = sample.design_of(wb.SobolDesign)
    return wb.sobol(design, outputs, LAWS, factors=sample.factors, control_variate=True)
