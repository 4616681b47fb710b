"""The bench that a block is tested on: a plant, a law and a reference with any ports, whose signals stay bounded."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import casadi as ca
import numpy as np

from workbench.blocks.loop import (
    AbstractController,
    AbstractPlant,
    AbstractReference,
    ClosedLoop,
    Follows,
    Inputs,
    NoReference,
)
from workbench.blocks.loop.contracts import Parts, Reads
from workbench.core import Layout, Signals, block, initial, layout, parameter
from workbench.core.block import Number, Scalar, States
from workbench.testing.failure_sentences import name_of_block, no_refusal


@block
class BenchPlant(AbstractPlant):
    """x_i' = sin(t + i) - x_i + tanh(sum of all inputs) / 2, with a state for each number that a law reads."""

    inputs_of_plant: Layout
    outputs_of_plant: Layout

    @property
    def states(self) -> Layout:
        entries = (replace(e, default=np.where(e.default != 0, e.default, 0.1)) for e in self.outputs_of_plant.entries)
        return Layout(tuple(entries))

    @property
    def inputs(self) -> Layout:
        return self.inputs_of_plant

    @property
    def outputs(self) -> Layout:
        return self.outputs_of_plant

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        push = ca.tanh(sum((ca.sum1(ca.vec(u[name])) for name in self.inputs_of_plant.names), ca.SX(0))) / 2
        return {name: _waves(t, self.outputs_of_plant, name) - x[name] + push for name in self.outputs_of_plant.names}


@block
class BenchReference(AbstractReference):
    """1/2 + sin(t + i) / 3 for each number that a law follows."""

    signals: Layout

    @property
    def gives(self) -> Layout:
        return self.signals

    def at(self, t: Number) -> Signals:
        return Signals({name: 0.5 + _waves(t, self.signals, name) / 3 for name in self.signals.names})


@block
class BenchLaw(AbstractController):
    """Each input of a plant at its usual number, with a sine of a tenth of it, or of 0.1, beside it."""

    inputs: Layout

    @property
    def reads(self) -> Layout:
        return Layout()

    @property
    def drives(self) -> Layout:
        return self.inputs

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        def of(name: str) -> ca.SX:
            usual = self.inputs[name].default
            return ca.SX(usual) + ca.SX(0.1 * np.maximum(np.abs(usual), 1.0)) * _waves(3 * t, self.inputs, name)

        return Signals({name: of(name) for name in self.inputs.names})


@block
class EveryOperation(AbstractController):
    """A law with each operation of a graph, among them quotients by zero and functions at their edges."""

    gain: Scalar = parameter(default=2.0, unit="V s/rad")
    state: Scalar = initial(default=0.3, unit="rad/s")
    reads = follows = layout(omega="rad/s")
    drives = layout(v="V")

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        e, w = 40 * (ref.omega - est.omega), est.omega
        wild = ca.fmod(e, 0.7) + ca.atan2(e, w) + ca.tanh(e) + ca.exp(-e * e) + ca.log(1 + e * e)
        wild += ca.sqrt(ca.fabs(e)) + ca.sin(w) * ca.cos(e) + ca.atan(e) + z["state"]
        steps = ca.sign(e) + ca.floor(3 * e) + ca.if_else(ca.logic_and(e > 0.1, w < 0.9), e, -w) + (w == 0)
        edges = ca.if_else(w == 0, 0, ca.fmin(1 / w, 5)) + ca.fmax(ca.logic_not(e > w), ca.logic_or(e > 1, w > 0.5))
        return Signals(v=self.gain * (wild + steps + edges) + ca.sin(t))

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        return {"state": ca.tanh(est.omega) - z["state"]}


def _waves(t: ca.SX, port: Layout, name: str) -> ca.SX:
    """sin(t + i) for the numbers of a signal, which are counted through its port."""
    entry, first = port[name], port.slice(name).start
    rows, columns = (entry.shape + (1, 1))[:2]
    waves: ca.SX = ca.reshape(ca.vertcat(*(ca.sin(t + first + i) for i in range(entry.size))), rows, columns)
    return waves


@lru_cache(maxsize=2)  # of a law that several tests are given
def bench_loop(law: AbstractController) -> ClosedLoop:
    """A loop for a law of which no plant is known: what it reads, follows and drives are signals of the bench."""
    remedy = "correct its ports, or return the loop that it is for in `loop`"
    with no_refusal(name_of_block(law), "have ports that a loop can connect", remedy):
        reference = BenchReference(law.follows) if law.follows.size else NoReference()
        return ClosedLoop(BenchPlant(law.drives, law.reads), controller=law, reference=reference)
