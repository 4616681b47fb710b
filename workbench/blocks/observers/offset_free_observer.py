"""The observer of a predictive law without offset: the state, and a constant disturbance."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.blocks.laws.predictive_ports import DISTURBANCE, all_finite, disturbance_port, refuse_other_signals
from workbench.blocks.loop.contracts import AbstractObserver, AbstractPlant, Inputs, Parts, Reads
from workbench.blocks.observers.observer_model import stack_signals
from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Matrix, Number, Vector
from workbench.core.units import ANY
from workbench.core.validation.refusals import refusal, seconds


@block
class OffsetFreeObserver(AbstractObserver):
    """The steady Kalman filter of a linear model and of a constant disturbance d, once in a period:

        at t_k        (e, d)+ = (e, d) + L (y - y_0 - C e - Cd d)
        to t_(k+1)    e = A e + B v + Bd d,      d = d

    with e = x - x_0 and v = u - u_0. Behind the states of the plant in e stands the input before, if a delay has a part
    of a period. The estimate of d takes up a constant disturbance, a wrong gain, and what a linear model lacks at
    another rest. A period with a reading that is not finite corrects nothing.

    `OffsetFreeObserver.of` makes the observer of a design, for the law `ModelPredictive.of` the same design.

    Parameters
    ----------
    states, commands, outputs
        Layouts of the plant's states, of its inputs, and of the outputs that are read.
    A, B, Bd
        The model of a period, (nx, nx), (nx, nu) and (nx, nd).
    C, Cd
        The map to the outputs, (ny, nx) and (ny, nd).
    L
        Gain (nx + nd, ny).
    x0, u0, y0
        The rest of the model.
    period
        Period of the computer in s.

    References
    ----------
    Pannocchia and Rawlings (2003), Disturbance models for offset-free model-predictive control, AIChE Journal 49.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> linear = wb.linearize(wb.open_loop(motor), t=0.0, x=np.zeros(2), at_rest=True)
    >>> options = {"limits": {"v": (-12.0, 12.0)}, "offset_free": ("omega",)}
    >>> design = wb.predictive_design(linear, 0.05, np.diag([10.0, 0.1]), [[0.1]], 20, **options)
    >>> observer = wb.OffsetFreeObserver.of(motor, design)
    >>> observer.reads.names, observer.gives.names
    (('omega',), ('omega', 'i', 'd'))
    """

    states: Layout
    commands: Layout
    outputs: Layout
    A: Matrix = parameter(unit=ANY, shape=("nx", "nx"))
    B: Matrix = parameter(unit=ANY, shape=("nx", "nu"))
    Bd: Matrix = parameter(unit=ANY, shape=("nx", "nd"), symbol="B_d")
    C: Matrix = parameter(unit=ANY, shape=("ny", "nx"))
    Cd: Matrix = parameter(unit=ANY, shape=("ny", "nd"), symbol="C_d")
    L: Matrix = parameter(unit=ANY, shape=("na", "ny"))
    x0: Vector = parameter(unit=ANY, shape=("n",), symbol="x_0")
    u0: Vector = parameter(unit=ANY, shape=("nu",), symbol="u_0")
    y0: Vector = parameter(unit=ANY, shape=("ny",), symbol="y_0")
    period: float

    def __post_init__(self) -> None:
        if DISTURBANCE in self.states:
            raise ValueError(
                "`OffsetFreeObserver(states=...)` must have no state named 'd', which is the name of its estimate of a "
                "disturbance. Rename the state of the plant."
            )
        seconds("OffsetFreeObserver(period=...)", self.period)

    @staticmethod
    def of(plant: AbstractPlant, design: object) -> OffsetFreeObserver:
        """The observer of a design with `offset_free` for a plant, once in its period. It begins at the rest.

        Raises
        ------
        ValueError
            If `design` is no such result, or is for other states or inputs.
        """
        own = getattr(design, "observer_arguments", None)
        if not isinstance(own, dict) or not own:
            raise refusal(
                "OffsetFreeObserver.of(design=...)", "the result of `predictive_design(..., offset_free=...)`", design
            )
        own = dict(own)
        names, outputs = own.pop("names"), own.pop("output_names")
        refuse_other_signals("OffsetFreeObserver.of(plant, design)", plant, names)
        port = Layout(tuple(plant.outputs[name] for name in outputs))
        return OffsetFreeObserver(plant.states, plant.inputs, port, **own)

    @property
    def reads(self) -> Layout:
        return self.outputs

    @property
    def inputs(self) -> Layout:
        return self.commands

    @property
    def gives(self) -> Layout:
        return self.states + disturbance_port(self.Bd.shape[1])

    @property
    def memory(self) -> Layout:
        nx, nd = self.Bd.shape
        return Layout((Entry("e_hat", np.zeros(nx), ANY), Entry("d_hat", np.zeros(nd), ANY)))

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        e, d = self._correct(z, y)
        x = self.states.view(e[: self.states.size] + self.x0)
        return Signals({**x, DISTURBANCE: d})

    def update(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The estimate before the readings of the next instant."""
        e, d = self._correct(z, y)
        v = stack_signals(u, self.commands) - self.u0
        return {"e_hat": self.A @ e + self.B @ v + self.Bd @ d, "d_hat": d}

    def _correct(self, z: Parts, y: Reads) -> tuple[ca.SX, ca.SX]:
        both = ca.vertcat(z["e_hat"], z["d_hat"])
        gap = stack_signals(y, self.outputs) - self.y0
        known = all_finite(gap)
        gap = ca.if_else(known, gap, ca.SX.zeros(gap.numel())) - self.C @ z["e_hat"] - self.Cd @ z["d_hat"]
        both = both + ca.if_else(known, self.L @ gap, ca.SX.zeros(both.numel()))
        return both[: self.A.shape[0]], both[self.A.shape[0] :]
