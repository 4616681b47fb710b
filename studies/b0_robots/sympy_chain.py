"""The planar chain in sympy.physics.mechanics, as one who knows it would write it; run as a script, it measures.

python sympy_chain.py kane 6
python sympy_chain.py lagrange 6
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from time import process_time
from typing import Any, NamedTuple


class Chain(NamedTuple):
    """Rods on hinges, of mass m, length l, centre of mass at c and inertia I each, with gravity g."""

    q: Sequence[Any]
    qd: Sequence[Any]
    bodies: Sequence[Any]
    forces: Sequence[Any]
    rods: Sequence[Sequence[Any]]
    g: Any
    ground: Any


def chain(joints: int, speeds: Sequence[Any] | None) -> Chain:
    """It hangs along -y, each angle measured from the rod before; without `speeds` these are the derivatives of q."""
    from sympy import symbols
    from sympy.physics.mechanics import Point, ReferenceFrame, RigidBody, dynamicsymbols, inertia

    q = list(dynamicsymbols(f"q1:{joints + 1}"))
    qd = [q_i.diff() for q_i in q] if speeds is None else list(speeds)
    rods = [symbols(f"{letter}1:{joints + 1}") for letter in "mlcI"]
    g = symbols("g")
    ground, origin = ReferenceFrame("N"), Point("O")
    origin.set_vel(ground, 0)
    bodies, forces, frame, joint = [], [], ground, origin
    for i, (m, l, c, I) in enumerate(zip(*rods, strict=True)):
        body = frame.orientnew(f"B{i}", "Axis", [q[i], ground.z])
        body.set_ang_vel(frame, qd[i] * ground.z)
        centre, end = joint.locatenew(f"G{i}", -c * body.y), joint.locatenew(f"P{i}", -l * body.y)
        centre.v2pt_theory(joint, ground, body)
        end.v2pt_theory(joint, ground, body)
        rod = RigidBody(f"rod{i}", centre, body, m, (inertia(body, 0, 0, I), centre))
        rod.potential_energy = m * g * centre.pos_from(origin).dot(ground.y)
        bodies.append(rod)
        forces.append((centre, -m * g * ground.y))
        frame, joint = body, end
    return Chain(q, qd, bodies, forces, rods, g, ground)


def kane(joints: int) -> tuple[Any, Any, Chain]:
    """M and the bias C qd + G by Kane's method."""
    from sympy.physics.mechanics import KanesMethod, dynamicsymbols

    made = chain(joints, dynamicsymbols(f"u1:{joints + 1}"))
    rates = [q.diff() - u for q, u in zip(made.q, made.qd, strict=True)]
    method = KanesMethod(made.ground, made.q, made.qd, rates)
    method.kanes_equations(made.bodies, made.forces)
    return method.mass_matrix, -method.forcing, made


def lagrange(joints: int) -> tuple[Any, Any, Chain]:
    """The same by Lagrange's equation of the second kind."""
    from sympy.physics.mechanics import LagrangesMethod, Lagrangian

    made = chain(joints, None)
    method = LagrangesMethod(Lagrangian(made.ground, *made.bodies), made.q, frame=made.ground)
    method.form_lagranges_equations()
    return method.mass_matrix, -method.forcing, made


METHODS: dict[str, Callable[[int], tuple[Any, Any, Chain]]] = {"kane": kane, "lagrange": lagrange}


def coriolis(M: Any, chain: Chain) -> list[list[Any]]:
    """C of the Christoffel symbols, which no method of the package gives; each derivative of M is taken once."""
    n, q, qd = len(chain.q), chain.q, chain.qd
    D = {}
    for i in range(n):
        for j in range(i, n):
            D[i, j] = D[j, i] = [M[i, j].diff(angle) for angle in q]
    return [
        [sum((D[i, j][k] + D[i, k][j] - D[j, k][i]) * qd[k] for k in range(n)) / 2 for j in range(n)] for i in range(n)
    ]


def measure(name: str, joints: int) -> dict[str, Any]:
    """The seconds of a core to M and C qd + G, those to M, C and G, and all of these at the state of `values`."""
    import sympy.physics.mechanics  # noqa: F401  (its import is not counted)

    begin = process_time()
    M, bias, made = METHODS[name](joints)
    middle = process_time()
    C = coriolis(M, made)
    potential = sum(body.potential_energy for body in made.bodies)
    G = [potential.diff(angle) for angle in made.q]
    end = process_time()
    parts = {"M": M.tolist(), "C": C, "G": [G], "bias": [list(bias)]}
    known = numbers(made)
    at = {letter: [[float(x.subs(known)) for x in row] for row in rows] for letter, rows in parts.items()}
    rows = {letter: at[letter][0] for letter in ("G", "bias")}
    return {"bias": middle - begin, "matrices": end - begin, "at": {**at, **rows}}


def values(joints: int) -> tuple[list[float], list[float]]:
    """The state (q, qd) at which answers are compared."""
    return [0.3 + 0.5 * i for i in range(joints)], [1.0 - 0.4 * i for i in range(joints)]


def numbers(chain: Chain) -> dict[Any, float]:
    """The speeds come first: where they are derivatives of q they would vanish with it."""
    q, qd = values(len(chain.q))
    known = dict(zip([*chain.qd, *chain.q], [*qd, *q], strict=True)) | {chain.g: 9.81}
    for letters, value in zip(chain.rods, (1.0, 1.0, 0.5, 1 / 12), strict=True):
        known |= dict.fromkeys(letters, value)
    return known


if __name__ == "__main__":
    sys.stdout.write(json.dumps(measure(sys.argv[1], int(sys.argv[2]))))
