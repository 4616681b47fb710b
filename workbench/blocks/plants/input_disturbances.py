"""A plant with a constant, unknown disturbance on each input, as the model of an observer and of a law."""

from workbench.blocks.loop.contracts import AbstractPlant, Inputs, Parts, is_recursion
from workbench.blocks.plants.equipped_plant import AbstractPlantWrapper
from workbench.core import Entry, Layout, Signals, block
from workbench.core.block import Number, States

PREFIX = "d_"  # of the disturbance of an input


@block
class InputDisturbances(AbstractPlantWrapper):
    """The model x' = f(t, x, u + d), d' = 0 of a plant: an observer of it estimates the disturbances d with the states.

    The disturbance of the input v is the state `d_v`, in the unit of v. A `NonlinearPredictive` law of this model sends
    inputs u = s - d where it would send s, so that a constant disturbance of an input leaves no offset.

    Parameters
    ----------
    plant
        The plant, in continuous time.

    Raises
    ------
    ValueError
        If the plant is in discrete time, or has a state or an output with the name of a disturbance.

    References
    ----------
    Pannocchia and Rawlings (2003), Disturbance models for offset-free model-predictive control, AIChE Journal 49.

    Examples
    --------
    >>> wb.InputDisturbances(wb.DCMotor()).states.names
    ('omega', 'i', 'd_v')
    """

    plant: AbstractPlant

    def __post_init__(self) -> None:
        kind = type(self.plant).__name__
        if is_recursion(self.plant):
            raise ValueError(
                f"`InputDisturbances(plant=...)` must be in continuous time, as a disturbance has a rate; `{kind}` has "
                "an update. Write a plant with a rate."
            )
        for name in self.input_disturbances.names:
            if name in self.plant.outputs + self.plant.truths or name in self.plant.states:
                raise ValueError(
                    f"`InputDisturbances(plant=...)` must leave the name '{name}' free for a disturbance; `{kind}` has "
                    "it. Rename it there."
                )

    @property
    def input_disturbances(self) -> Layout:
        """The disturbances of the inputs, in their order."""
        return Layout(tuple(Entry(f"{PREFIX}{e.name}", 0.0 * e.default, e.unit) for e in self.plant.inputs.entries))

    @property
    def states(self) -> Layout:
        return self.plant.states + self.input_disturbances

    @property
    def truths(self) -> Layout:
        return self.plant.truths

    def measure(self, t: Number, x: States) -> Signals:
        return self.plant.measure(t, Signals(x).only(self.plant.states))

    def applied_inputs(self, t: Number, x: States, u: Inputs) -> Signals:
        return self.plant.applied_inputs(t, Signals(x).only(self.plant.states), self._sum(x, u))

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        still = {name: 0 * x[name] for name in self.input_disturbances.names}
        return {**self.plant.rate(t, Signals(x).only(self.plant.states), self._sum(x, u)), **still}

    def _sum(self, x: States, u: Inputs) -> Signals:
        return Signals({name: u[name] + x[f"{PREFIX}{name}"] for name in self.inputs.names})
