"""Refusals of a nonlinear predictive law: unfit models and previews."""

from __future__ import annotations

import numpy as np

from workbench.blocks.laws.plant_stages import signals_of
from workbench.blocks.loop.contracts import AbstractPlant, is_recursion
from workbench.blocks.loop.environment import AbstractReference
from workbench.core.validation.refusals import known_name


def refuse_unfit_plan(
    call: str,
    model: AbstractPlant,
    follow: tuple[str, ...],
    row_names: tuple[str, ...],
    preview: AbstractReference | None,
) -> None:
    """Refuse an unfit model, names that it has not, and an unfit preview."""
    refuse_unfit_model(call, model)
    for name in follow:
        known_name(name, model.states.names, "states of the model")
    for name in row_names:
        known_name(name, signals_of(model).labels, "states and outputs of the model")
    if preview is not None:
        refuse_unfit_preview(call, model, preview, follow)


def refuse_unfit_model(call: str, model: AbstractPlant) -> None:
    """Refuse a model in discrete time, and one with states that move at the instants of a computer alone."""
    if is_recursion(model):
        raise ValueError(
            f"`{call}(model=...)` must be a plant in continuous time, whose rate the law integrates; "
            f"`{type(model).__name__}` has an update."
        )
    if model.sampled_states.size or model.noises:
        raise ValueError(
            f"`{call}(model=...)` must move by its rate alone; `{type(model).__name__}` has noise, or states that "
            "change at the instants of a computer. Take the plant without them as the model."
        )


def refuse_unfit_preview(call: str, model: AbstractPlant, preview: AbstractReference, follow: tuple[str, ...]) -> None:
    """Refuse a previewed reference with other signals than the model's, with an end, or beside `follow`."""
    if follow:
        raise ValueError(f"`{call}(follow=..., preview=...)` must be one of them alone, as each is the reference.")
    port = model.states + model.inputs
    for name in preview.primary:
        known_name(name, port.names, "states and inputs of the model")
    for entry in (entry for entry in preview.gives.entries if entry.name in port):
        own = port[entry.name]
        if (entry.size, entry.unit) != (own.size, own.unit):
            raise ValueError(
                f"`{call}(preview=...)` must give '{entry.name}' with the size and unit of the model, {own.size} in "
                f"'{own.unit}'; it has {entry.size} in '{entry.unit}'."
            )
    if not np.isinf(preview.ends):
        raise ValueError(
            f"`{call}(preview=...)` must go on behind its end, as the law plans beyond it; it ends at {preview.ends:g} "
            "s. Hold its last state with `PlannedReference(motion, rest_inputs=...)`."
        )
