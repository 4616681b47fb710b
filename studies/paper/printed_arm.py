"""The arm of the AOSMC-RGS paper exactly as it prints it: equations (2), (3) and (4).

Its parameters bear the names of the derived arm's: `links[0].mass`, `links[0].length`, ..., `gravity`.
"""

from __future__ import annotations

import casadi as ca

import workbench as wb


def _matrix(rows: list[list[wb.core.Scalar]]) -> ca.SX:
    return ca.SX(ca.blockcat(rows))


@wb.block
class PrintedArm(wb.arms.AbstractArm):
    r"""Two point masses on massless links, angles from the downward vertical:

        M = [ m1 l1^2 + m2 (l1^2 + l2^2 + 2 l1 l2 cos q2)    m2 (l2^2 + l1 l2 cos q2) ]
            [ m2 (l2^2 + l1 l2 cos q2)                       m2 l2^2                  ]   (2)

        C = [ -m2 l1 l2 sin q2 q2'    C12 ]
            [  m2 l1 l2 sin q2 q1'    0   ]                                               (3)

        G = [ (m1 + m2) g l1 sin q1 + m2 g l2 sin(q1 + q2) ]
            [ m2 g l2 sin(q1 + q2)                         ]                              (4)

    where (3) prints for C12 the entry (1,2) of (2), which has no velocity in it.
    """

    links: tuple[wb.arms.mechanics.PointMass, ...] = (
        wb.arms.mechanics.PointMass(1.0, 1.0),
        wb.arms.mechanics.PointMass(1.0, 1.0),
    )
    gravity: wb.core.Scalar = wb.parameter(default=9.81, unit="m/s^2", low=0, symbol="g")
    coriolis: str = wb.option(
        {
            "printed": "C12 = m2 (l2^2 + l1 l2 cos q2), as equation (3) has it",
            "repaired": "C12 = -m2 l1 l2 sin q2 (q1' + q2'), the smallest repair of equation (3)",
        },
        default="printed",
    )

    def __post_init__(self) -> None:
        if len(self.links) != 2:
            raise ValueError(f"`PrintedArm(links=...)` has two links, as equations (2) to (4); got {len(self.links)}.")

    @property
    def dof(self) -> int:
        return 2

    def mass_matrix(self, q: ca.SX) -> ca.SX:
        m1, m2, l1, l2 = self._letters
        M12 = m2 * (l2**2 + l1 * l2 * ca.cos(q[1]))
        return _matrix([[m1 * l1**2 + m2 * (l1**2 + l2**2 + 2 * l1 * l2 * ca.cos(q[1])), M12], [M12, m2 * l2**2]])

    def coriolis_matrix(self, q: ca.SX, qd: ca.SX) -> ca.SX:
        _, m2, l1, l2 = self._letters
        if self.coriolis == "printed":
            C12 = m2 * (l2**2 + l1 * l2 * ca.cos(q[1]))
        else:
            C12 = -m2 * l1 * l2 * ca.sin(q[1]) * (qd[0] + qd[1])
        return _matrix([[-m2 * l1 * l2 * ca.sin(q[1]) * qd[1], C12], [m2 * l1 * l2 * ca.sin(q[1]) * qd[0], 0]])

    def gravity_vector(self, q: ca.SX) -> ca.SX:
        m1, m2, l1, l2 = self._letters
        g = self.gravity
        G2 = m2 * g * l2 * ca.sin(q[0] + q[1])
        return _matrix([[(m1 + m2) * g * l1 * ca.sin(q[0]) + G2], [G2]])

    @property
    def _letters(self) -> tuple[wb.core.Scalar, wb.core.Scalar, wb.core.Scalar, wb.core.Scalar]:
        first, second = self.links
        return first.mass, second.mass, first.length, second.length
