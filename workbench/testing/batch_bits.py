"""The bits of a run alone, in batches of each order and size, in each arithmetic and engine."""

from __future__ import annotations

import numpy as np

from workbench.core import Ode, SampledSystem, StepMap, rk4
from workbench.core.validation.refusals import Array
from workbench.engine import simulate
from workbench.engine.arithmetic import CASADI, FUSED, PORTABLE, is_compiled
from workbench.testing.failure_sentences import fail, no_refusal
from workbench.testing.form_checks import differing_bits

RUNS, STEPS, FEW = 5, 20, 3  # FEW steps where NumPy takes a millisecond each
SPREAD = 0.05
SPELL = "write it with operations that the graph has"
OUT_OF_ITSELF = (
    "let its methods be expressions of their arguments alone, without `random`, a file, or a number that they keep"
)


def demand_same_bits(name: str, equation: Ode | SampledSystem, h: float, exportable: bool) -> None:
    """Fail where a bit of a run depends on its company, its place, the engine, or on what else varies.

    What is not exportable runs in the arithmetic of CasADi alone.
    """
    step = equation.step(1) if isinstance(equation, SampledSystem) else rk4(equation, h)
    starts = _starts(step)
    for arithmetic in (FUSED, PORTABLE) if exportable else (CASADI,):
        with no_refusal(name, f"run in the arithmetic '{arithmetic}'", SPELL):
            whole = simulate(step, None, starts, until=STEPS * step.h, arithmetic=arithmetic).x
            _demand_numbers(name, whole)
            alone = [simulate(step, None, row, until=STEPS * step.h, arithmetic=arithmetic).x for row in starts[:2]]
            backwards = simulate(step, None, starts[::-1], until=STEPS * step.h, arithmetic=arithmetic).x[::-1]
        _demand_equal(name, whole[:2], np.concatenate(alone), f"alone, in the arithmetic '{arithmetic}'")
        _demand_equal(name, whole, backwards, f"in the opposite order, in the arithmetic '{arithmetic}'")
        if is_compiled(step, arithmetic):
            slow = simulate(step, None, starts, until=FEW * step.h, arithmetic=arithmetic, engine="numpy").x
            _demand_equal(name, whole[:, : FEW + 1], slow, f"in NumPy, in the arithmetic '{arithmetic}'")
    _demand_same_bits_where_numbers_vary(name, step, starts, exportable)


def _demand_same_bits_where_numbers_vary(name: str, step: StepMap, starts: Array, exportable: bool) -> None:
    """Alone, all numbers are the same in each run, and what is made of them once has the same bits as made for each."""
    if not step.parameters.size:
        return
    rows = np.tile(step.parameters.default, (RUNS, 1))
    rows *= 1 + 1e-3 * np.arange(RUNS)[:, np.newaxis]
    try:
        step.parameters.check(rows)
    except ValueError:  # a bound is met: the numbers as they are, in rows
        rows = np.tile(step.parameters.default, (RUNS, 1))
    engine = "numpy" if exportable else "casadi"
    whole = simulate(step, rows, starts, until=FEW * step.h, engine=engine).x
    alone = simulate(step, rows[-1], starts[-1], until=FEW * step.h, engine=engine).x
    _demand_equal(name, whole[-1:], alone, "alone, where its numbers vary from run to run")


def _starts(step: StepMap) -> Array:
    """The initial state, and others near it."""
    usual = step.states.default
    rng = np.random.default_rng(1)
    moved = usual + SPREAD * np.maximum(np.abs(usual), 0.1) * rng.uniform(-1, 1, (RUNS, usual.size))
    moved[0] = usual
    for entry in step.states.entries:
        if entry.bounds.symmetric:  # a matrix of which any one number alone has no meaning
            moved[:, step.states.slice(entry.name)] = usual[step.states.slice(entry.name)]
    low, high = (np.concatenate([np.full(e.size, e.bounds.ends[i]) for e in step.states.entries]) for i in (0, 1))
    return np.asarray(np.clip(moved, low, high))


def _demand_numbers(name: str, x: Array) -> None:
    if not np.isfinite(x[:, -1]).any(axis=0).all():
        fail(name, "run", "a state of the loop that it is tested in is not finite", "return a loop that runs in `loop`")


def _demand_equal(name: str, whole: Array, other: Array, where: str) -> None:
    differ = differing_bits(whole, other)
    if differ.any():
        came = f"{int(differ.sum())} numbers of its runs differ {where}"
        fail(name, "give the same bits in any batch", came, OUT_OF_ITSELF)
