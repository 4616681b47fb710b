"""Information: what each law of a comparison is given, and which laws are given the same."""

from __future__ import annotations

from collections.abc import Mapping
from string import ascii_uppercase
from typing import Any

from workbench.core import Roles, grouped
from workbench.study.document.phrases import Cell, Column, Phrase, Table
from workbench.validation.doors import door
from workbench.validation.words import described, refusal, whole

HEADS = ("law", "class", "observer", "state", "model", "D", "memory")
NOTE = (
    "Read from the equations of each loop: what its command depends on. State: positions and velocities, or the two "
    "one by one, are read where a reading acts at its own instant, filtered where it acts by the observer's memory "
    "alone, and estimated where the observer makes them from other readings. Model: the matrices M, C and G of the "
    "believed arm that act, in the law / in the observer. D: the disturbance. Memory: the numbers that are remembered, "
    "in the law / in the observer. Laws of one class are given the same, and only they are compared as laws."
)


OF_PLANTS = "Model f: the equations of the believed plant, in the observer."


@door
def information_table(
    name: str, caption: Phrase, loops: Mapping[str, Any], tuned: Mapping[str, int] | None = None
) -> Table:
    """A row a law: how it comes by positions and velocities, its model, its estimate of the disturbance, its states.

    Parameters
    ----------
    loops
        By law its loop, or its `Roles`.
    tuned
        By law how many of its numbers are tuned.

    Raises
    ------
    ValueError
        If there is no law, a loop cannot say its roles, or `tuned` has other laws.
    """
    if not loops:
        raise ValueError("`information_table(loops)` must map each law to its loop, at least one; got none.")
    if tuned is not None and set(tuned) != set(loops):
        raise ValueError(
            f"`information_table(tuned=...)` must have a number for each of {described(list(loops))}; got "
            f"{described(list(tuned))}."
        )
    roles = {law: _roles_of(law, loop) for law, loop in loops.items()}
    classes = {law: _letter(k) for k, laws in enumerate(grouped(roles)) for law in laws}
    rows = [(law, classes[law], *_cells(held)) for law, held in roles.items()]
    notes = (NOTE, OF_PLANTS) if any("f" in held for one in roles.values() for held in one.models.values()) else (NOTE,)
    if tuned is None:
        return Table(name, caption, tuple(map(Column, HEADS)), tuple(rows), notes)
    counts = [whole(f"information_table(tuned={{'{law}': ...}})", tuned[law], 0) for law in loops]
    heads = (*map(Column, HEADS), Column("tuned"))
    return Table(name, caption, heads, tuple((*row, n) for row, n in zip(rows, counts, strict=True)), notes)


def _roles_of(law: str, given: Any) -> Roles:
    """The roles of a loop, or of what has it as its `loop`."""
    held = given if isinstance(given, Roles) else getattr(getattr(given, "loop", given), "roles", None)
    if not isinstance(held, Roles):
        raise refusal(f"information_table(loops={{'{law}': ...}})", "a `ClosedLoop` or the `Roles` of one", given)
    return held


def _letter(k: int) -> str:
    return ascii_uppercase[k] if k < len(ascii_uppercase) else str(k + 1)


def _cells(held: Roles) -> tuple[Cell, ...]:
    observed = bool(held.observer_states or held.observer)
    pairs = ((_model(held, "controller"), _model(held, "observer")), (held.law_states, held.observer_states))
    model, states = (f"{law} / {observer}" if observed else f"{law}" for law, observer in pairs)
    return (
        held.observer or None,
        _state(held),
        None if model == "–" else model,
        "oracle" if held.truths else "estimated" if held.unread else None,
        states,
    )


def _state(held: Roles) -> str:
    """How the outputs of the plant come, in one word where they come alike."""
    ways = [" and ".join(ways) or "unused" for ways in held.readings.values()]
    return ways[0] if len(set(ways)) == 1 else ", ".join(ways)


def _model(held: Roles, socket: str) -> str:
    """Which matrices of the arm, or equations of another plant, act in a law or an observer."""
    models = [matrices for path, matrices in held.models.items() if path.startswith(socket)]
    acting = "".join(matrix for matrix in "MCGf" if any(matrix in matrices for matrices in models))
    return acting or ("unused" if models else "–")
