"""A plant with disturbances: signals in time, or coloured noise, added to its inputs and outputs."""

import casadi as ca

from workbench.blocks.loop.coloured_noise import AbstractNoise
from workbench.blocks.loop.contracts import AbstractPlant, Inputs, Parts, is_recursion
from workbench.blocks.loop.environment import AbstractReference
from workbench.blocks.loop.noise_states import NoiseStates, noise_of
from workbench.blocks.plants.equipped_plant import AbstractPlantWrapper
from workbench.core import Entry, Layout, Signals, block
from workbench.core.block import Number, States
from workbench.core.port import misfits

TRUTH = "d_"  # of a disturbance on x is 'd_x'


@block
class DisturbedPlant(AbstractPlantWrapper):
    """A plant with disturbances that are added to its inputs, behind the command, and to its outputs:

        x' = f(t, x, u + d_u(t)),      y = h(t, x) + d_y(t).

    A disturbance is a truth of the plant, a signal that no instrument measures: `d_v` is the disturbance on the input
    v. Noise that is added to the readings of a computer, and not to the outputs, belongs to `Instruments`.

    Parameters
    ----------
    by
        The disturbance: signals in time, such as `Step` or `CombinedReference`, or a noise, such as `GaussMarkov`. Each
        signal is named as the input or output to which it is added; its derivatives are not used. A noise moves at the
        instants of a computer by its exact transition and is held between two instants, so its loop must be made by
        `digital`.

    Raises
    ------
    LookupError
        If the signal of a noise is neither an input nor an output of the plant.
    ValueError
        If a signal does not fit the plant by name, size and unit; or the plant is disturbed there already.

    Examples
    --------
    >>> motor = wb.DisturbedPlant(wb.DCMotor(), by=wb.Step("v", "V", 1.0, time=2.0))
    >>> motor.inputs.names, motor.truths.names
    (('v',), ('d_v',))
    """

    plant: AbstractPlant
    by: AbstractReference | AbstractNoise

    def __post_init__(self) -> None:
        ports = self.plant.inputs + self.plant.outputs
        if isinstance(self.by, AbstractNoise):
            object.__setattr__(self, "by", noise_of("by", self.by, ports, "inputs and outputs"))
        for clause in misfits(self._disturbed_signals, ports):
            held = clause.format(gives=f"`{type(self.plant).__name__}` has")
            raise ValueError(f"`DisturbedPlant(by=...)` adds {held if held.endswith('?') else f'{held}.'}")
        for name in (*self._disturbed_signals.with_prefix(TRUTH).names, *self._noise.layout.names):
            if name in self.plant.outputs + self.plant.truths or name in self.plant.states:
                raise ValueError(
                    f"`DisturbedPlant(by=...)` must leave the name '{name}' to `{type(self.plant).__name__}`, which "
                    "has it already: where that is a disturbance too, add the two up in one signal."
                )

    @property
    def period(self) -> float | None:  # type: ignore[override]
        """The period of a plant in discrete time in s, else None."""
        return self.plant.period

    @property
    def recursion(self) -> bool:
        """True if the plant is in discrete time."""
        return is_recursion(self.plant)

    @property
    def states(self) -> Layout:
        return self.plant.states + self._noise.layout

    @property
    def noises(self) -> int:
        return self.plant.noises + self._noise.layout.size

    @property
    def truths(self) -> Layout:
        return self.plant.truths + self._disturbed_signals.with_prefix(TRUTH)

    def noise_states(self, k: Number, x: States, w: ca.SX, period: float) -> Parts:
        inner = self.plant.noises
        moved = self.plant.noise_states(k, self._own(x), w[:inner], period)
        return {**moved, **self._noise.after(k, x, w[inner:], period)}

    def update_sampled_states(self, t: Number, x: States, u: Inputs) -> Parts:
        return self.plant.update_sampled_states(t, self._own(x), self._disturbed_inputs(t, x, u))

    def measure(self, t: Number, x: States) -> Signals:
        d, y = self._at(t, x), Signals(self.plant.measure(t, self._own(x)))
        truths = {f"{TRUTH}{name}": part for name, part in d.items()}
        return y | {name: y[name] + part for name, part in d.items() if name in self.outputs} | truths

    def applied_inputs(self, t: Number, x: States, u: Inputs) -> Signals:
        return self.plant.applied_inputs(t, self._own(x), self._disturbed_inputs(t, x, u))

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        still = {entry.name: 0 * x[entry.name] for entry in self._noise.layout.entries}
        return {**self.plant.rate(t, self._own(x), self._disturbed_inputs(t, x, u)), **still}

    def update(self, t: Number, x: States, u: Inputs) -> Parts:
        """The states at the next instant, for a plant in discrete time."""
        kept = {entry.name: x[entry.name] for entry in self._noise.layout.entries}
        return {**self.plant.update(t, self._own(x), self._disturbed_inputs(t, x, u)), **kept}

    @property
    def _noise(self) -> NoiseStates:
        return NoiseStates((self.by,) if isinstance(self.by, AbstractNoise) else ())

    @property
    def _disturbed_signals(self) -> Layout:
        if isinstance(self.by, AbstractNoise):
            return self._noise.signals
        return Layout(
            tuple(Entry(e.name, e.default, e.unit) for e in self.by.gives.entries if e.name in self.by.primary)
        )

    def _own(self, x: States) -> Signals:
        return Signals(x).only(self.plant.states)

    def _at(self, t: Number, x: States) -> Signals:
        if isinstance(self.by, AbstractNoise):
            return self._noise.signal_noise(x)
        return Signals(self.by.at(t)).only(self._disturbed_signals)

    def _disturbed_inputs(self, t: Number, x: States, u: Inputs) -> Signals:
        return u | {name: u[name] + part for name, part in self._at(t, x).items() if name in self.inputs}
