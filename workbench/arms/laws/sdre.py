import casadi as ca

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.dynamics import AbstractArm, solve_definite
from workbench.arms.laws.algebraic_riccati import doubling_solution, norm, residual
from workbench.arms.laws.sliding_surface import matrices
from workbench.blocks.loop.contracts import Follows, Parts, Reads
from workbench.core import block, parameter
from workbench.core.block import Matrix, Number, quantities

DOUBLINGS = 9


@block
class Sdre(AbstractArmController):
    """Feedback by a Riccati equation that is solved at each state, with x = [e; ed], e = q - q_ref:

        tau = M qdd_ref + C qd_ref + G - R^-1 B' P x
        A'P + PA - P B R^-1 B' P + blockdiag(Qp, Qd) = 0
        A = [0, I; 0, -M^-1 C],   B = [0; M^-1]

    with M, C, G of `model` at the estimates. With the right model x' = A x + B u exactly, u what is beside the first
    three terms; as A and B move with the state, it is near the optimum close to rest only, and stable in a
    neighbourhood.

    P comes from nine doublings of a Cayley transform. The signal "residual" is what they leave of the equation over the
    size of its terms: where it is not small, as where joints turn fast under light weights, P is not the solution.

    References
    ----------
    Cimen (2008), State-dependent Riccati equation (SDRE) control: a survey, IFAC World Congress.

    Examples
    --------
    >>> from workbench.arms.laws import Sdre
    >>> law = Sdre(wb.paper_arm(), Qp=np.eye(2), Qd=np.eye(2), R=np.eye(2))
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> wb.ClosedLoop(plant, controller=law, reference=wanted).ode().states.size
    4
    """

    model: AbstractArm
    Qp: Matrix = parameter(unit="1/{position}^2", symmetric=True, definite="positive", shape=("n", "n"), symbol="Q_p")
    Qd: Matrix = parameter(unit="s^2/{position}^2", symmetric=True, definite="semi", shape=("n", "n"), symbol="Q_d")
    R: Matrix = parameter(unit="1/({force})^2", symmetric=True, definite="positive", shape=("n", "n"), symbol="R")

    def __post_init__(self) -> None:
        for f, quantity in quantities(self):
            quantity.bounds.refuse_unsymmetric(f"Sdre({f.name}=...)", getattr(self, f.name)[None])

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        M, C, G = matrices(self.model, est)
        x = ca.vertcat(est.q - ref.q, est.qd - ref.qd)
        P = doubling_solution(*self._problem(M, C), DOUBLINGS)
        u = -ca.solve(self.R, solve_definite(M, P[self.dof :, :] @ x))
        return M @ ref.qdd + C @ ref.qd + G + u

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        M, C, _ = matrices(self.model, est)
        A, G, Q, rate = self._problem(M, C)
        return {"residual": residual(A, G, Q, doubling_solution(A, G, Q, rate, DOUBLINGS))}

    def _problem(self, M: ca.SX, C: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """A, G = B R^-1 B' and Q of the Riccati equation at a state, (2n, 2n), and a rate in 1/s amid its poles."""
        n = self.dof
        none, eye = ca.SX.zeros(n, n), ca.SX.eye(n)
        solved = solve_definite(M, ca.horzcat(C, eye))
        N, inverse = -solved[:, :n], solved[:, n:]
        pushed = inverse @ ca.solve(self.R, inverse.T)
        A = ca.blockcat([[none, eye], [none, N]])
        G = ca.blockcat([[none, none], [none, pushed]])
        Q = ca.blockcat([[self.Qp, none], [none, self.Qd]])
        # the fourth root of |G| |Qp| is the geometric mean of a joint's two poles, whatever damps it
        rate = norm(N) + ca.sqrt(ca.sqrt(norm(pushed) * norm(self.Qp)))
        return A, G, Q, rate
