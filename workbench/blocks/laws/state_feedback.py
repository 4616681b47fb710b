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
    """Linear feedback of the state about an operating point of any plant:

        u = u0 - K (x - x0).

    The columns of K are in the order of `states`; those that `follow` have their wanted value from the reference, in
    the place of that in x0. With the design of `lqr` or `place` for the plant linearised at (x0, u0) the loop has the
    poles of that design near x0.

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
        """The law for a plant that is held at the point of a design; it needs an estimate of each state.

        Parameters
        ----------
        K
            The answer of `lqr` or `place` for the linearised plant, or its K, which carry their point; or any other
            matrix (nu, nx), which is about x0 and u0, or about zero if the plant rests there.
        x0, u0
            (nx,) and (nu,), in the place of those of the design.

        Raises
        ------
        ValueError
            If a matrix without a point comes without x0 and u0 and the plant does not rest at zero, the design is for
            other states or inputs or for a point that is not at rest, or a number is not of its shape.
        LookupError
            If a state to follow is none of the plant.
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
