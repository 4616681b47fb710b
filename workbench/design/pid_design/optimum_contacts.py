"""The optimum in full accuracy: Newton's method on the conditions of one contact, or of two.

At a contact the loop touches its limit at a frequency: f = 0 and df/domega = 0. The largest ki has one contact with
df/dk = 0 too, or two contacts that hold k from both sides.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.pid_design.derivative_action import DerivativeAction
from workbench.design.pid_design.gain_plane import GainPlane

STEPS = 30
SETTLED = 1e-13
ROUNDING = 1e-10  # the slack that a solution may lack between its contacts
CLOSE = 0.06  # the slack up to which a frequency may be a contact
MOST = 5  # contacts
ENOUGH = 0.9  # of the bound of a search: the first solution above it is taken
TOUCH = 1e-7  # the slack of a contact

Terms = tuple[float, Array, Array]


@dataclass(frozen=True)
class Contact:
    """A frequency at which S (kind 0) or T (kind 1) may touch its limit."""

    kind: int
    omega: float


@dataclass(frozen=True, eq=False)
class ContactEquations:
    """f = |law + g|^2 - rho^2 |base|^2 over |g|^2, with base g for S and the law for T, and its derivatives."""

    plane: GainPlane
    derivative: DerivativeAction

    def terms(self, kind: int, k: float, ki: float, omega: float) -> Terms:
        """The value, gradient (3,) and Hessian (3, 3) of f."""
        g, g1, g2 = self.plane.process.inverse_slopes(omega)
        d, d1, d2 = self.derivative.slopes(omega)
        law = (k - 1j * ki / omega + d, 1.0, -1j / omega, 1j * ki / omega**2 + d1, 1j / omega**2)
        law_2 = -2j * ki / omega**3 + d2
        if kind == 1 and self.plane.Mt == 1:
            return _without_loss(law, law_2, (g, g1, g2))
        top = _square(law[0] + g, law[1], law[2], law[3] + g1, law[4], law_2 + g2)
        base = _square(g, 0, 0, g1, 0, g2) if kind == 0 else _square(*law, law_2)
        limit = self.plane.Ms if kind == 0 else self.plane.Mt
        size, share = abs(g) ** 2, 1 / limit**2
        return (
            (top[0] - share * base[0]) / size,
            (top[1] - share * base[1]) / size,
            (top[2] - share * base[2]) / size,
        )

    def least_slack(self, kind: int, k: float, ki: float, omega: float) -> tuple[float, float]:
        """The frequency near `omega` at which f is least, and f there."""
        for _ in range(0 if self._at_rest(omega) else STEPS):
            _, gradient, hessian = self.terms(kind, k, ki, omega)
            if not hessian[2, 2] > 0:
                break
            step = float(np.clip(-gradient[2] / hessian[2, 2], -0.05 * omega, 0.05 * omega))
            omega += step
            if abs(step) <= SETTLED * omega:
                break
        return omega, self.terms(kind, k, ki, omega)[0]

    def _at_rest(self, omega: float) -> bool:
        """True for the frequency that stands for zero, where every slope by the frequency is zero."""
        return omega <= 2 * float(self.plane.omega[0])

    def solve(
        self, contacts: tuple[Contact, ...], k: float, ki: float, hold: bool = False
    ) -> tuple[float, float] | None:
        """The gains at which contacts hold ki from above; None if Newton's method finds none.

        They are one contact, with df/dk = 0 or, if `hold`, with k as it is; or two.
        """
        z = np.array([k, ki, *(c.omega for c in contacts)])
        scale = np.array([abs(k) + ki / contacts[0].omega, ki, *(c.omega for c in contacts)])
        for _ in range(STEPS):
            residuals, rows = [], []
            for i, contact in enumerate(contacts):
                value, gradient, hessian = self.terms(contact.kind, z[0], z[1], z[2 + i])
                still = (0.0, np.array([0, 0, 1.0]))
                equations = [(value, gradient), still if self._at_rest(z[2 + i]) else (gradient[2], hessian[2])]
                if len(contacts) == 1:
                    equations.append((0.0, np.array([1.0, 0, 0])) if hold else (gradient[0], hessian[0]))
                for residual, slope in equations:
                    row = np.zeros(len(z))
                    row[:2], row[2 + i] = slope[:2], slope[2]
                    size = float(np.abs(row * scale).max()) or 1.0
                    residuals.append(residual / size)
                    rows.append(row * scale / size)
            try:
                step = np.linalg.solve(np.array(rows), -np.array(residuals))
            except np.linalg.LinAlgError:
                return None
            longest = float(np.abs(step).max())
            z = z + scale * step * min(1.0, 0.2 / longest if longest else 1.0)
            if not (np.isfinite(z).all() and z[1] > 0 and (z[2:] > 0).all()):
                return None
            if longest < SETTLED:
                break
        return (float(z[0]), float(z[1])) if longest < 1e-9 else None


def _square(value: complex, by_k: complex, by_ki: complex, by_omega: complex, mixed: complex, twice: complex) -> Terms:
    """|value|^2 with gradient and Hessian by k, ki, omega; the value is linear in k and ki."""
    slopes = np.array([by_k, by_ki, by_omega])
    gradient = 2 * (np.conj(value) * slopes).real
    hessian = 2 * (np.conj(slopes)[:, np.newaxis] * slopes).real
    cross = 2 * (np.conj(value) * mixed).real
    hessian[1, 2] += cross
    hessian[2, 1] += cross
    hessian[2, 2] += 2 * (np.conj(value) * twice).real
    return abs(value) ** 2, gradient, hessian


def _without_loss(law: tuple[complex, ...], law_2: complex, inverse: tuple[complex, complex, complex]) -> Terms:
    """f of T for Mt = 1, which is 1 + 2 Re(conj(law) g) / |g|^2 and stays finite at rest."""
    (value, by_k, by_ki, by_omega, mixed), (g, g1, g2) = np.conj(law), inverse
    size, base = abs(g) ** 2, _square(g, 0, 0, g1, 0, g2)
    slopes = np.array([by_k * g, by_ki * g, by_omega * g + value * g1]).real
    twice = np.zeros((3, 3))
    twice[2, 0] = twice[0, 2] = (by_k * g1).real
    twice[2, 1] = twice[1, 2] = (mixed * g + by_ki * g1).real
    twice[2, 2] = (np.conj(law_2) * g + 2 * by_omega * g1 + value * g2).real
    parts = 2 * (value * g).real, 2 * slopes, 2 * twice
    return (base[0] + parts[0]) / size, (base[1] + parts[1]) / size, (base[2] + parts[2]) / size


def polish(
    equations: ContactEquations, k: float, ki: float, interval: tuple[float, float]
) -> tuple[float, float] | None:
    """The optimum near gains that a search has found; None if no contact or pair of contacts gives one."""
    best: tuple[float, float] | None = None
    pool = _near_contacts(equations.plane, k, ki)[:2]
    tried: set[tuple[Contact, ...]] = set()
    for _ in range(MOST):
        added: list[Contact] = []
        for contacts in (c for size in (1, 2) for c in combinations(pool, size) if c not in tried):
            tried.add(contacts)
            for gains in _solutions(equations, contacts, k, ki, interval):
                slack, contact = worst_contact(equations, *gains)
                if slack < -ROUNDING:
                    if contact is not None and not any(_same(contact, other) for other in (*pool, *added)):
                        added.append(contact)
                elif is_stable(equations.plane, *gains) and (best is None or gains[1] > best[1]):
                    best = gains
                    if best[1] > ENOUGH * ki:
                        return best
        pool = [*pool, *added][:MOST]
        if not added:
            break
    return best or _backed_off(equations, k, ki)


def _backed_off(equations: ContactEquations, k: float, ki: float) -> tuple[float, float] | None:
    """The first ki below the one of a search that meets the limits and stabilises, in steps; None for none."""
    for share in np.geomspace(1e-6, 0.3, 20).tolist():
        lower = ki * (1 - share)
        if 0 <= worst_contact(equations, k, lower)[0] < np.inf and is_stable(equations.plane, k, lower):
            return k, lower
    return None


def _solutions(
    equations: ContactEquations, contacts: tuple[Contact, ...], k: float, ki: float, interval: tuple[float, float]
) -> Iterator[tuple[float, float]]:
    """The gains of some contacts, with k inside its interval or, for one contact, at an end that is near."""
    low, high = interval
    gains = equations.solve(contacts, k, ki)
    if gains is not None and 0.2 * ki < gains[1] < 2 * ki and low <= gains[0] <= high:
        yield gains
    for end in interval if len(contacts) == 1 else ():
        if abs(k - end) < 0.3 * abs(end):
            gains = equations.solve(contacts, end, ki, hold=True)
            if gains is not None and 0.2 * ki < gains[1] < 2 * ki:
                yield gains


def worst_contact(equations: ContactEquations, k: float, ki: float) -> tuple[float, Contact | None]:
    """The least slack of the loop at any frequency, as f, and where; infinite if no frequency is near its limit."""
    worst, place = np.inf, None
    for contact in _near_contacts(equations.plane, k, ki):
        omega, value = equations.least_slack(contact.kind, k, ki, contact.omega)
        if value < worst:
            worst, place = value, Contact(contact.kind, omega)
    return worst, place


def contacts_of(equations: ContactEquations, k: float, ki: float, touch: float = TOUCH) -> tuple[Contact, ...]:
    """The contacts at gains that are an optimum."""
    found: list[Contact] = []
    for contact in _near_contacts(equations.plane, k, ki):
        omega, value = equations.least_slack(contact.kind, k, ki, contact.omega)
        if abs(value) < touch and not any(_same(Contact(contact.kind, omega), other) for other in found):
            found.append(Contact(contact.kind, omega))
    return tuple(found)


def is_stable(plane: GainPlane, k: float, ki: float) -> bool:
    """True if the gains stabilise."""
    (intervals,) = plane.stable_intervals(np.array([k]))
    return any(low < ki < high for low, high in intervals)


def _near_contacts(plane: GainPlane, k: float, ki: float) -> list[Contact]:
    """The frequencies at which S or T is near its limit, the nearest first."""
    slack = plane.slack(k, ki)
    padded = np.pad(slack, ((0, 0), (1, 1)), constant_values=np.inf)
    least = (slack <= padded[:, :-2]) & (slack <= padded[:, 2:]) & (slack < CLOSE)
    kinds, places = np.nonzero(least)
    order = np.argsort(slack[kinds, places])[:MOST]
    return [Contact(int(kinds[i]), float(plane.omega[places[i]])) for i in order]


def _same(one: Contact, other: Contact) -> bool:
    return one.kind == other.kind and abs(one.omega - other.omega) < 1e-3 * one.omega
