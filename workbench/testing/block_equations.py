"""The equations of a block by itself: a column of values in a column of symbols, both with names and units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np

from workbench.blocks.loop.contracts import AbstractController, AbstractObserver, AbstractPlant, is_recursion
from workbench.blocks.loop.wiring import call_block
from workbench.core import Entry, Layout, Signals, lift
from workbench.core.fingerprints import fingerprint_of
from workbench.core.units import per_second
from workbench.core.validation.refusals import Array

Member = AbstractPlant | AbstractObserver | AbstractController
Values = dict[str, ca.SX]
Given = dict[str, Signals]  # the states of a block, and what comes through its ports
PARAMETERS = "parameters."  # before the path of a number of the block, among its arguments


@dataclass(frozen=True, eq=False)
class BlockEquations:
    """values = F(symbols) of a block, whose `arguments` and `results` have names, units and usual numbers."""

    block: Member
    arguments: Layout
    results: Layout
    symbols: ca.SX
    values: ca.SX

    @cached_property
    def F(self) -> ca.Function:
        """The equations as a CasADi function of a column."""
        return ca.Function("workbench_block", [self.symbols], [ca.densify(self.values)])

    @property
    def fingerprint(self) -> str:
        """The digest of all operations."""
        return fingerprint_of(b"", self.F)

    def at(self, numbers: Array) -> Array:
        """The values (m,) at numbers (n,)."""
        return np.asarray(self.F(numbers), dtype=float).ravel()

    def random_arguments(self, rng: np.random.Generator) -> Array:
        """Numbers (n,) near the usual ones: within 10 % of a number, within 0.3 of a zero; parameters as they are."""
        usual = self.arguments.default
        moved = usual * (1 + 0.1 * rng.uniform(-1, 1, usual.size)) + (usual == 0) * rng.uniform(-0.3, 0.3, usual.size)
        for entry in self.arguments.entries:
            if entry.name.startswith(PARAMETERS):
                place = self.arguments.slice(entry.name)
                moved[place] = usual[place]
        return np.asarray(moved)


def equations_of_block(block: Member) -> BlockEquations:
    """The equations of a plant, an observer or a law, with its numbers as symbols."""
    lifted = lift(block)
    twin, own = with_period_of(block, lifted.block), block.states if isinstance(block, AbstractPlant) else block.memory
    free = Layout((Entry("t", np.array(1.0), "s"),)) + own.with_prefix("states.")
    for port, layout in _ports_of(block).items():
        free = free + layout.with_prefix(f"{port}.")
    symbols = free.symbols()
    parts = free.view(symbols)
    t, given = parts["t"], {port: _below(port, parts) for port in ("states", *_ports_of(block))}
    if isinstance(twin, AbstractPlant):
        results, values = _of_plant(twin, block, own, t, given)
    elif isinstance(twin, AbstractObserver):
        results, values = _of_observer(twin, block, own, t, given)
    else:
        results, values = _of_law(twin, block, own, t, given)
    arguments = free + lifted.layout.with_prefix(PARAMETERS)
    return BlockEquations(block, arguments, results, ca.vertcat(symbols, lifted.symbols), results.flatten(values))


def with_period_of(block: Member, twin: Member) -> Member:
    """The twin of a block at the period of `run_every`, which is none of its fields."""
    if isinstance(twin, AbstractController) and block.period is not None and twin.period is None:
        return twin.run_every(block.period)
    return twin


@lru_cache(maxsize=2)
def same_equations(block: Member) -> BlockEquations:
    """The same, made once for several tests of one block."""
    return equations_of_block(block)


def _ports_of(block: Member) -> dict[str, Layout]:
    """The ports through which a block is given something."""
    if isinstance(block, AbstractPlant):
        return {"inputs": block.inputs}
    if isinstance(block, AbstractObserver):
        return {"reads": block.reads, "inputs": block.inputs}
    return {"reads": block.reads, "follows": block.follows}


def _of_plant(twin: AbstractPlant, block: Member, own: Layout, t: ca.SX, given: Given) -> tuple[Layout, Values]:
    x = given["states"]
    seen = twin.outputs + twin.truths
    moved = call_block(twin, _method(block), own, t, x, given["inputs"])
    results = seen.with_prefix("outputs.") + _moves(block, own)
    return results, _above("outputs", call_block(twin, "measure", seen, t, x)) | _above(_method(block), moved)


def _of_observer(twin: AbstractObserver, block: Member, own: Layout, t: ca.SX, given: Given) -> tuple[Layout, Values]:
    z, y = given["states"], given["reads"]
    estimates = call_block(twin, "estimate", twin.gives, t, z, y)
    moved = call_block(twin, _method(block), own, t, z, y, estimates, given["inputs"])
    results = twin.gives.with_prefix("gives.") + _moves(block, own)
    return results, _above("gives", estimates) | _above(_method(block), moved)


def _of_law(twin: AbstractController, block: Member, own: Layout, t: ca.SX, given: Given) -> tuple[Layout, Values]:
    arguments = t, given["states"], given["reads"], given["follows"]
    commands = call_block(twin, "command", twin.drives, *arguments)
    moved = call_block(twin, _method(block), own, *arguments)
    results = twin.drives.with_prefix("drives.") + _moves(block, own)
    return results, _above("drives", commands) | _above(_method(block), moved)


def _method(block: Member) -> str:
    """The method that moves the states of a block."""
    return "update" if is_recursion(block) else "rate"


def _moves(block: Member, own: Layout) -> Layout:
    """The rate of each state, or its next value, by name and unit."""
    rate = not is_recursion(block)
    entries = (Entry(e.name, e.default, per_second(e.unit) if rate else e.unit) for e in own.entries)
    return Layout(tuple(entries)).with_prefix(f"{_method(block)}.")


def _below(port: str, parts: Mapping[str, ca.SX]) -> Signals:
    return Signals({name.removeprefix(f"{port}."): p for name, p in parts.items() if name.startswith(f"{port}.")})


def _above(port: str, parts: Mapping[str, ca.SX]) -> Values:
    return {f"{port}.{name}": part for name, part in parts.items()}
