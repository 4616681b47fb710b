"""The kinds `clean`, `noisy` and `models` of the exam of identification, as the workbench answers them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from workbench.blocks.loop import open_loop
from workbench.blocks.plants import OdePlant
from workbench.core import Ode, layout
from workbench.core.validation.refusals import Array
from workbench.identification.datasets import Dataset, check_data
from workbench.identification.estimation import fit, identifiability

IDLE = "idle:1"  # the input of a plant that has none


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """The estimates of a log with or without noise; or what an experiment cannot tell."""
    return identify(case) if case["kind"] == "models" else estimate(case, log_of(case))


def estimate(case: dict[str, Any], log: Dataset) -> dict[str, Any]:
    """The estimates with standard errors and intervals, by the names of the case."""
    noise = None if case["sigma"] is None else dict(zip(case["outputs"], map(float, case["sigma"]), strict=True))
    initial = initial_names(case)
    found = fit(
        ode_of(case),
        log,
        free_names(case),
        noise=noise,
        hold="hold" if case["hold"] == "zero" else "linear",
        hold_out=0.0,
        answers=answers_to(case, log),
    )
    names = {f"{state}(0)": name for state, name in initial.items()}

    def by_name(values: Mapping[str, Any]) -> dict[str, Any]:
        return {names.get(name, name): value for name, value in values.items()}

    return {
        "parameters": by_name(found.values),
        "standard_errors": by_name(found.standard_errors),
        "intervals": by_name(found.intervals()),
        "warnings": found.warnings,
    }


def answers_to(case: dict[str, Any], log: Dataset) -> dict[str, str]:
    """The answers to the questions of the check of a log, which a case gives as it is to be fitted."""
    inputs = [port.partition(":")[0] for port in case["inputs"] or (IDLE,)]
    check = check_data(log, inputs=inputs, outputs=list(case["outputs"]), parameters=list(case["parameters"]))
    return {one.name: "the exam gives this log to be fitted" for one in check.findings if one.severity == "question"}


def identify(case: dict[str, Any]) -> dict[str, Any]:
    """The dimension of the null space and the parameters that take part in it."""
    initial = initial_names(case)
    outputs = [f"y{i}" for i in range(_output_count(case))]
    answer = identifiability(ode_of(case), log_of(case), free_names(case), outputs)
    names = {f"{state}(0)": name for state, name in initial.items()}
    return {"dimension": answer.dimension, "names": [names.get(name, name) for name in answer.ambiguous_names]}


def free_names(case: dict[str, Any]) -> list[str]:
    """The unknown numbers of a case: its parameters, and the initial states that are parameters."""
    initial = initial_names(case)
    return [*(name for name in case["parameters"] if name not in initial.values()), *(f"{name}(0)" for name in initial)]


def initial_names(case: dict[str, Any]) -> dict[str, str]:
    """The states whose initial values are parameters, with the names of these."""
    pairs = zip(case["states"], case["x0"], strict=True)
    return {state.partition(":")[0]: name for state, name in pairs if isinstance(name, str)}


@cache
def _ode_of(f: Any, g: Any, parameters: Any, states: Any, inputs: Any, outputs: Any, x0: Any) -> Ode:
    return _made(
        {"f": f, "parameters": dict(parameters), "states": states, "inputs": inputs, "outputs": outputs, "x0": x0}
        | ({"g": g} if g else {})
    )


def ode_of(case: dict[str, Any]) -> Ode:
    """The plant of a case at the starts of its parameters, or at their nominal values, made once for all its logs."""
    parts = (tuple(case.get(name, ())) for name in ("states", "inputs", "outputs", "x0"))
    return _ode_of(case["f"], case.get("g"), tuple(case["parameters"].items()), *parts)


def _made(case: dict[str, Any]) -> Ode:
    starts = {name: value[0] if isinstance(value, tuple) else value for name, value in case["parameters"].items()}
    units = {name: value[1] if isinstance(value, tuple) else "" for name, value in case["parameters"].items()}
    x0 = np.array([starts[value] if isinstance(value, str) else float(value) for value in case["x0"]])
    own = layout(**{name: (units[name], value) for name, value in starts.items()})
    inputs = case["inputs"] or (IDLE,)
    if "g" in case:

        def h(t: Any, x: Any, p: Any, m: Any) -> Any:
            return case["g"](x, p, m)

        outputs = [f"y{i}" for i in range(_output_count(case))]
        return open_loop(OdePlant.of(case["f"], case["states"], inputs, outputs, h=h, p=own, x0=x0))
    return open_loop(OdePlant.of(case["f"], case["states"], inputs, case["outputs"], p=own, x0=x0))


def log_of(case: dict[str, Any]) -> Dataset:
    """The inputs of a case at its instants, and its outputs where it has any."""
    t, knots, u = (np.asarray(case[name], dtype=float) for name in ("t", "tu", "u"))
    signals: dict[str, Array] = {}
    units: dict[str, str] = {}
    for i, port in enumerate(case["inputs"]):
        name, _, units[name] = port.partition(":")
        if case["hold"] == "zero":
            rows = np.searchsorted(knots, t + 1e-9 * (t[1] - t[0]), side="right") - 1
            signals[name] = u[np.maximum(rows, 0), i]
        else:
            signals[name] = np.interp(t, knots, u[:, i])
    if not signals:
        signals[IDLE.partition(":")[0]] = np.zeros_like(t)
    if "y" in case:
        signals |= {name: np.asarray(case["y"])[:, i] for i, name in enumerate(case["outputs"])}
    units |= {port.partition(":")[0]: port.partition(":")[2] for port in case["states"]}
    return Dataset.of(t, signals, {name: units.get(name) or "1" for name in signals})


def _output_count(case: dict[str, Any]) -> int:
    numbers = {name: float(value) for name, value in case["parameters"].items()}
    return len(case["g"](np.ones(len(case["states"])), SimpleNamespace(**numbers), np))
