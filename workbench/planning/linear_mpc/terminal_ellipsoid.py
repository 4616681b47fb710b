r"""The terminal ellipsoid, and where the exact law is feasible forever and stable.

In E = {x'P x <= level} the LQR law keeps every limit, so that E is invariant and P its cost: with

    level = min over rows (bound / |P^-1/2 h|)^2,   h = F - E K.

A cone has offset - |centre| in the place of the bound, and |L P^-1/2| + slope |P^-1/2 h_a| of its rows L and h_a.

**Theorem** (Limon, Alamo, Salas and Camacho 2006, theorem 3, IEEE TAC 51; Rawlings, Mayne and Diehl 2017, section 2.6).
Let the limits hold 0 inside, Q be positive definite, P - (A - B K)'P (A - B K) >= Q + K'R K, and

    V_N(x) <= N d + level,     d = least value of x'Q x outside E = level / (largest eigenvalue of Q^-1 P).

Then the plan of the exact law from x ends in E, the problem stays feasible, and V_N falls by x'Q x + u'R u or more a
period: 0 is asymptotically stable in the set of such x. The reason: a plan that never enters E costs N d and more,
and P of its end more than level; one that enters E can stay there at the cost of P.
The law with a fixed number of sweeps is not the exact law: the theorem says nothing of it, and `sampled_loss` samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from workbench.core.claim import Claim
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, finite
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError
from workbench.planning.linear_mpc.array_doors import finite_vector
from workbench.planning.linear_mpc.cone_limits import StageCone
from workbench.planning.linear_mpc.linear_problem import LinearMpc, regulator

SHRUNK = 1 - 1e-9  # of the level, for rounding
LARGEST_EXACT = 12  # states: exact rational factors of larger matrices take seconds
SOURCE = "Limon, Alamo, Salas and Camacho (2006), On the stability of constrained MPC without terminal constraint"


@dataclass(frozen=True, eq=False)
@show
class TerminalSet:
    """The ellipsoid x'P x <= level in which the LQR law keeps all limits, and the cost below which a start is safe.

    Parameters
    ----------
    P, K
        (nx, nx) and (nu, nx), the cost and the gain of the LQR law.
    level
        The level of the ellipsoid; infinite if there are no limits.
    safe_cost
        N d + level: the exact law is feasible forever and stable from every x with V_N(x) below it; `level` if Q is
        singular.
    limit
        The name of the row that bounds the ellipsoid.
    decrease_is_proved
        True if P - (A - B K)'P (A - B K) is positive definite in exact rational arithmetic, so that E is invariant
        under the LQR law of the matrices as given.
    claims
        The claims with their hypotheses.
    """

    P: Array
    K: Array
    level: float
    safe_cost: float
    limit: str
    decrease_is_proved: bool
    claims: tuple[Claim, ...]

    def holds_state(self, x: Numbers) -> bool:
        """True if x (nx,) lies in the ellipsoid."""
        x = finite_vector("TerminalSet.holds_state(x=...)", x, len(self.P), "states")
        return bool(x @ self.P @ x <= self.level)

    def is_safe(self, cost: float) -> bool:
        """True if the exact law is feasible forever from a state of this optimal cost."""
        return bool(finite("TerminalSet.is_safe(cost=...)", cost) <= self.safe_cost)


@check_arguments
def terminal_set(problem: LinearMpc) -> TerminalSet:
    """The terminal ellipsoid of a problem, with its claims and their hypotheses checked.

    Raises
    ------
    DesignError
        If a limit does not hold 0 inside, or P is not the cost of the LQR law.

    Examples
    --------
    >>> from workbench.planning.linear_mpc import MpcLimits, mpc_problem, terminal_set
    >>> limits = MpcLimits(inputs=(-1.0, 1.0))
    >>> problem = mpc_problem([[1.0, 0.1], [0.0, 1.0]], [[0.0], [0.1]], np.eye(2), [[0.1]], 20, limits)
    >>> ends = terminal_set(problem)
    >>> ends.limit, ends.decrease_is_proved, ends.is_safe(2 * ends.level)
    ('u[0]', True, True)
    """
    K, P = regulator(problem.A, problem.B, problem.Q, problem.R) if problem.K is None else (problem.K, problem.P)
    if np.abs(P - problem.P).max() > 1e-6 * np.abs(P).max():
        raise DesignError(
            "`terminal_set(problem)` needs P to be the cost of the LQR law, which keeps the limits in the ellipsoid; "
            "this problem has another P. Leave P out of `mpc_problem`."
        )
    level, limit = _level(problem, K, P)
    values = np.linalg.eigvalsh(problem.Q)
    d = 0.0
    if values[0] > 1e-12 * values[-1]:
        roots = np.linalg.cholesky(problem.Q)
        half = np.linalg.solve(roots, P)
        d = level / float(np.linalg.eigvalsh(np.linalg.solve(roots, half.T)).max())
    is_proved = _falls(problem.A - problem.B @ K, P)
    safe = level + problem.horizon * d * SHRUNK
    return TerminalSet(P, K, level, safe, limit, is_proved, _claims(level, limit, d))


def _level(problem: LinearMpc, K: Array, P: Array) -> tuple[float, str]:
    """The level of the ellipsoid, and the row that it touches."""
    values, rows = np.linalg.eigvalsh(P), problem.rows
    if not values[0] > 1e-12 * values[-1]:
        raise DesignError(
            "`terminal_set(problem)` needs a cost that every state adds to, so that x'P x <= level is an ellipsoid; "
            f"the eigenvalues of P run from {values[0]:.3g} to {values[-1]:.3g}. Weigh every state, and leave out "
            "limits on rates, whose state is the last input."
        )
    reach = rows.F - rows.E @ K
    sizes = np.sqrt(np.einsum("ij,ji->i", reach, np.linalg.solve(P, reach.T)))
    best, limit = np.inf, "none"
    for name, size, low, high in zip(rows.names, sizes, rows.low, rows.high, strict=True):
        bound = min(high, -low)
        if not bound > 0:
            raise DesignError(
                f"`terminal_set(problem)`: the limits of '{name}' must hold 0 inside, as the law rests there; they are "
                f"{low:g} and {high:g}. Move the rest, or widen them."
            )
        if size > 0 and (bound / size) ** 2 < best:
            best, limit = (bound / size) ** 2, name
    for cone in rows.cones:
        size, margin = _cone_reach(cone, reach, P)
        if size > 0 and (margin / size) ** 2 < best:
            best, limit = (margin / size) ** 2, cone.name
    return best * SHRUNK, limit


def _cone_reach(cone: StageCone, reach: Array, P: Array) -> tuple[float, float]:
    """A bound of |l| - slope a over x'P x <= 1 for rows reach (nc, nx), and the margin of the cone at 0."""
    margin = cone.offset - float(np.linalg.norm(cone.centre))
    if not margin > 0:
        raise DesignError(
            f"`terminal_set(problem)`: the {cone.name} must hold 0 inside, as the law rests there; 0 is {-margin:g} "
            "outside. Move the rest, or widen the cone."
        )
    half = np.linalg.solve(np.linalg.cholesky(P), reach.T)
    along = 0.0 if cone.axial is None else float(np.linalg.norm(half[:, cone.axial]))
    return float(np.linalg.norm(half[:, list(cone.lateral)], 2)) + cone.slope * along, margin


def _falls(loop: Array, P: Array) -> bool:
    """True if P - loop'P loop is positive definite, by exact rational factors."""
    n = len(P)
    if n > LARGEST_EXACT:
        return False
    F = [[Fraction(float(v)) for v in row] for row in loop]
    X = [[Fraction(float(v)) for v in row] for row in (P + P.T) / 2]
    half = [[sum((X[i][k] * F[k][j] for k in range(n)), Fraction(0)) for j in range(n)] for i in range(n)]
    G = [[X[i][j] - sum((F[k][i] * half[k][j] for k in range(n)), Fraction(0)) for j in range(n)] for i in range(n)]
    for j in range(n):  # Gauss without pivoting: all pivots are positive exactly for a positive definite matrix
        if G[j][j] <= 0:
            return False
        for i in range(j + 1, n):
            share = G[i][j] / G[j][j]
            G[i] = [a - share * b for a, b in zip(G[i], G[j], strict=True)]
    return True


def _claims(level: float, limit: str, d: float) -> tuple[Claim, ...]:
    inside = Claim("limits hold 0", "Every limit has 0 strictly inside.", SOURCE)
    falls = Claim("the cost falls", "P - (A - B K)'P (A - B K) is positive definite.", SOURCE)
    weight = Claim("weight of every state", "Q is positive definite.", SOURCE)
    invariant = Claim(
        "terminal set",
        f"Under u = -K x no limit is passed from a state with x'P x <= {level:.6g}, which {limit} bounds.",
        SOURCE,
        (inside, falls),
    )
    if not d > 0:
        return (invariant,)
    stable = Claim(
        "feasible forever",
        f"The exact law is feasible forever and stable from every state whose optimal cost is at most N {d:.6g} + "
        f"{level:.6g}.",
        SOURCE,
        (inside, falls, weight),
    )
    return invariant, stable
