"""An arm from a fit, for a7 and a8: `FIT=arm.json make reports`, or `FIT=arm.json` before `python -m workbench run`.

The file is one that `fit.parameters.save` wrote, with paths of a two-link `wb.Manipulator`, such as `arm.links[0].mass`
or `friction.viscous[1]`; `plant.` may stand before them. The simulated arm and its frictions are then drawn with the
covariance of the fit, and the models of laws and observers have its estimates. Without FIT nothing changes, and what a
ledger holds is found again: each function stays the one that it was.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar, cast

import numpy as np

import workbench as wb
from studies.paper.laws import ARM
from studies.paper.scenarios import HELD_OUT

PLANT, MODEL = "plant.", "arm."
NO_FRICTION = wb.arms.Friction((0.0, 0.0), (0.0, 0.0), speed=0.05)  # in rad/s, as of the frictions of a8
OF_LINKS = ("com", "offset", "inertia")  # numbers that a point mass has not

F = TypeVar("F", bound=Callable[..., Any])
L = TypeVar("L", wb.ClosedLoop, wb.DigitalLoop)
B = TypeVar("B")


def read_fit(path: str) -> wb.FittedParameters | None:
    """The parameters in a file, with paths as those of a plant has; None without a path."""
    if not path:
        return None
    read = wb.FittedParameters.from_file(path)
    names = tuple(name.removeprefix(PLANT) for name in read.names)
    known = wb.open_loop(wb.Manipulator(arm_for(names), (0.0, 0.0), friction=NO_FRICTION)).parameters.labels
    strange = [name for name in names if name not in known or not name.startswith((f"{MODEL}links[", "friction."))]
    if strange:
        raise ValueError(
            "FIT must be a file with masses, lengths, centres, inertias and frictions of a two-link arm, such as "
            f"'arm.links[0].mass' and 'friction.viscous[1]'; '{path}' has '{strange[0]}': write the others alone, by "
            "`fit.parameters.select(names).save(path)`."
        )
    return replace(read, names=names)


def arm_for(names: tuple[str, ...]) -> wb.arms.mechanics.PlanarArm:
    """The arm of the paper with links that have all numbers of some names."""
    if not any(name.rpartition(".")[2] in OF_LINKS for name in names):
        return ARM
    links = tuple(wb.arms.mechanics.Link(link.mass, link.length, link.length) for link in ARM.links)
    return wb.arms.mechanics.PlanarArm(links, ARM.gravity)


# when the module is loaded, so that an answer of a study belongs to the fit that it was computed from
FIT = read_fit(os.environ.get("FIT", ""))


def with_fit_in_case(case: wb.Case) -> wb.Case:
    """A case whose loop has the estimates; the case itself without a fit."""
    loop = case.run.loop
    if FIT is None or not isinstance(loop, wb.ClosedLoop):
        return case
    return replace(case, run=replace(case.run, loop=with_fit(loop)))


def fitted_model(fit: wb.FittedParameters) -> wb.arms.mechanics.PlanarArm:
    """The arm that a designer believes in: the estimates."""
    arm = arm_for(fit.names)
    return fit.apply(arm, path=MODEL) if any(name.startswith(MODEL) for name in fit.names) else arm


def with_fit(loop: L) -> L:
    """A loop whose arm, frictions and models have the estimates; the loop itself without a fit.

    Masses and frictions that a scenario makes larger or smaller than usual keep their ratio to the usual ones.
    """
    if FIT is None:
        return loop
    closed = loop if isinstance(loop, wb.ClosedLoop) else loop.loop
    parts = {name: with_model(getattr(closed, name), fitted_model(FIT)) for name in ("controller", "observer")}
    made = replace(closed, plant=fitted_plant(FIT, closed.plant), **parts)
    return made if isinstance(loop, wb.ClosedLoop) else replace(loop, loop=made)


def with_model(block: B, model: wb.arms.mechanics.PlanarArm) -> B:
    """A block in which each arm is the model."""
    if isinstance(block, wb.arms.mechanics.PlanarArm):
        return model  # type: ignore[return-value]
    if isinstance(block, tuple):
        return tuple(with_model(part, model) for part in block)  # type: ignore[return-value]
    if not is_dataclass(block) or isinstance(block, type):
        return block
    parts = {field.name: (getattr(block, field.name)) for field in fields(block) if field.init}
    made = {name: with_model(part, model) for name, part in parts.items() if is_dataclass(part)}
    return replace(block, **made) if made else block


def fitted_plant(fit: wb.FittedParameters, plant: wb.Plant) -> wb.Manipulator:
    """The plant with the estimates, in the ratio that its own numbers have to the usual ones."""
    if not isinstance(plant, wb.Manipulator) or not isinstance(plant.arm, wb.arms.mechanics.PlanarArm):
        raise TypeError("A fit of an arm is for loops with a `Manipulator` of two links.")
    shares = np.array([own.mass / usual.mass for own, usual in zip(plant.arm.links, ARM.links, strict=True)])
    arm = fitted_model(fit)
    links = tuple(replace(link, mass=link.mass * share) for link, share in zip(arm.links, shares, strict=True))
    made = replace(plant, arm=replace(arm, links=links))
    names = [name for name in fit.names if name.startswith("friction.")]
    if not names:
        return made
    friction = plant.friction or NO_FRICTION
    values = {name: fit.values[name] * friction_share(friction, name) for name in names}
    return fit.select(names).apply(replace(made, friction=friction), values=values)


def friction_share(friction: wb.arms.Friction, name: str) -> float:
    """The ratio of the friction of a scenario to the usual one of a8; 1 for a friction that is not there."""
    kind = name.split(".")[1].partition("[")[0]
    if kind == "speed":
        return 1.0
    own, usual = np.array(getattr(friction, kind)), np.array(getattr(HELD_OUT[0], kind))
    return float(own[0] / usual[0]) or 1.0


def fitted_factors(every: tuple[wb.Factor, ...], loop: wb.ClosedLoop | wb.DigitalLoop) -> tuple[wb.Factor, ...]:
    """The factors of a loop that has the estimates, with the directions of the fit in place of its numbers' ranges."""
    assert FIT is not None
    closed = loop if isinstance(loop, wb.ClosedLoop) else loop.loop
    ode = closed.ode()
    own = {f"{PLANT}{name}": name for name in FIT.names}
    made: list[wb.Factor] = []
    for factor in every:
        labels = [label for path in factor.paths for label in labels_of(ode, path)]
        rest = tuple(label for label in labels if label not in own)
        if rest:
            made.append(factor if len(rest) == len(labels) else replace(factor, paths=rest))
    return (*made, *scaled_fit(ode, own).factors(path=PLANT))


def labels_of(ode: wb.Ode, path: str) -> list[str]:
    """The single numbers of a path, of a parameter or of a state."""
    of = ode.parameters if path in ode.parameters or path in ode.parameters.labels else ode.states
    return [of.labels[i] for i in of.indices(path)]


def scaled_fit(ode: wb.Ode, own: dict[str, str]) -> wb.FittedParameters:
    """The parameters of the fit in the ratio that the numbers of a plant have to the estimates."""
    assert FIT is not None
    at = np.array([float(ode.parameters.default[ode.parameters.labels.index(path)]) for path in own])
    scale = np.where(FIT.centre == 0, 1.0, at / np.where(FIT.centre == 0, 1.0, FIT.centre))
    ends = (np.where(np.abs(end) < 1e300, end * scale, end) for end in (FIT.low, FIT.high))
    low, high = ends
    return replace(FIT, centre=at, covariance=FIT.covariance * np.outer(scale, scale), low=low, high=high)


def unless_fitted(other: Callable[..., Any]) -> Callable[[F], F]:
    """A decorator: the function itself without a fit, and another one with it."""

    def choose(own: F) -> F:
        return own if FIT is None else cast("F", other)

    return choose
