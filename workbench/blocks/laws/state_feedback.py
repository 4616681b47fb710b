from __future__ import annotations

import casadi as ca

from workbench.blocks.loop.contracts import AbstractController, AbstractPlant, Follows, Parts, Reads
from workbench.blocks.loop.plant_equilibrium import point_for
from workbench.core import Layout, Signals, block, parameter
from workbench.core.block import Matrix, Number, Vector
from workbench.core.units import ANY
from workbench.core.validation.refusals import known_name, matrix


@block
class StateFeedback(AbstractController):
    """Linear state feedback about an operating point (x0, u0) of a plant:

        u = u0 - K (x - x0).

    `StateFeedback.of` makes the law from a plant and the design of `lqr` or `place`. Near x0, the loop then has the
    poles of the design for the plant linearised at (x0, u0).

    Parameters
    ----------
    states
        Layout of the states x, in the order of the columns of K.
    inputs
        Layout of the inputs u, in the order of the rows of K.
    K
        Gain. Each entry is in the unit of its input over that of its state.
    x0
        State at the operating point, in the units of `states`.
    u0
        Input at the operating point, in the units of `inputs`.
    follow
        Names of the states that follow a reference: their reference replaces the value in x0.

    References
    ----------
    Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods, chapters 2 and 3.

    Examples
    --------
    >>> plant = wb.CartPole(phi=0.1)
    >>> linear = wb.linearize(wb.open_loop(plant), 0.0, np.zeros(4))
    >>> law = wb.StateFeedback.of(plant, wb.lqr(linear, Q=np.eye(4), R=[[1.0]]), follow=("x",))
    >>> law.reads.names, law.follows.names, law.drives.names
    (('x', 'xd', 'phi', 'phid'), ('x',), ('F',))
    """

    states: Layout
    inputs: Layout
    K: Matrix = parameter(unit=ANY, shape=("nu", "nx"))
    x0: Vector = parameter(unit=ANY, shape=("nx",), symbol="x_0")
    u0: Vector = parameter(unit=ANY, shape=("nu",), symbol="u_0")
    follow: tuple[str, ...] = ()
    hint_on_follows = "`StateFeedback.of(..., follow=({names},))`"

    def __post_init__(self) -> None:
        matrix("StateFeedback(K=...)", self.K, self.inputs.size, self.states.size)
        for name in self.follow:
            known_name(name, self.states.names, "states that the law reads")

    @staticmethod
    def of(
        plant: AbstractPlant, K: object, x0: object = None, u0: object = None, follow: tuple[str, ...] = ()
    ) -> StateFeedback:
        """The law that regulates a plant to the operating point of a design. It reads an estimate of each state.

        Parameters
        ----------
        plant
            The plant.
        K
            The result of `lqr` or `place` for the linearised plant, or its gain K, an array that also has the operating
            point. Or any other matrix (nu, nx), with x0 and u0; they may be left out if the plant has an
            equilibrium at zero.
        x0, u0
            State (nx,) and input (nu,) of an operating point that replaces that of the design.
        follow
            Names of the states that follow a reference.

        Raises
        ------
        ValueError
            If a matrix without a point comes without x0 and u0, and zero is no equilibrium of the plant; the design is
            for other states or inputs, or for a point that is no equilibrium; or an array has the wrong shape.
        LookupError
            If the plant has no state with a name of `follow`.
        """
        gain, x, u = point_for("StateFeedback.of", plant, K, x0, u0)
        checked = matrix("StateFeedback.of(K=...)", gain, plant.inputs.size, plant.states.size)
        return StateFeedback(plant.states, plant.inputs, checked, x, u, follow)

    @property
    def reads(self) -> Layout:
        return self.states

    @property
    def follows(self) -> Layout:
        return Layout(tuple(self.states[name] for name in self.follow))

    @property
    def drives(self) -> Layout:
        return self.inputs

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        wanted = {**self.states.view(ca.SX(self.x0)), **{name: ref[name] for name in self.follow}}
        return Signals(self.inputs.view(self.u0 - self.K @ (self.states.flatten(est) - self.states.flatten(wanted))))
