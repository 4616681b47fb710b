"""An exhaustive search for the PID gains with the largest ki under limits of |S| and |T|, in NumPy alone.

It shares no code with the workbench and starts from no answer: a box of k, ki and kd in units of the ultimate gain and
frequency is sampled, and boxes about the best cells are sampled again, ever smaller. Stability is the argument of
1 + L.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

CELLS, ROUNDS, SHRINK = 12, 16, 0.72  # boxes that are kept, and how often and how much they shrink
CHUNK = 4000
FINE = 5.0  # times as many frequencies in the end
UNIT = np.linspace(-1, 1, 9)


@dataclass
class Loop:
    """A stable or integrating process num/den exp(-s delay) at frequencies, with a filter N and two limits."""

    num: list[float]
    den: list[float]
    delay: float
    N: float
    Ms: float
    Mt: float
    fineness: float = 1.0

    def __post_init__(self):
        self.ultimate = self._ultimate()
        self.omega = self._frequencies()
        s = 1j * self.omega
        self.G = self.at(self.omega)
        self.parts = np.stack([np.ones_like(s), 1 / s, s / (1 + s / self.N)]) * self.G
        self.integrators = 1 + int(self.den[-1] == 0)

    def at(self, omega):
        s = 1j * omega
        return np.polyval(self.num, s) / np.polyval(self.den, s) * np.exp(-s * self.delay)

    def _ultimate(self):
        """The first frequency at which the phase is -180 degrees, and 1/|G| there."""
        omega = np.geomspace(1e-4, 1e5, 200_000)
        G = self.at(omega)
        first = np.nonzero((G.real < 0) & (np.diff(np.sign(G.imag), append=0) > 0))[0][0]
        return omega[first], 1 / abs(G[first])

    def _frequencies(self):
        """So dense that the logarithms of omega and G change little, far beyond the ultimate frequency."""
        top = max(60 * self.ultimate[0], 3 * self.N)
        if self.delay:
            top = min(top, max(80 / self.delay, 6 * self.ultimate[0]))
        dense = np.geomspace(1e-3 * min(self.ultimate[0], 0.05 * self.N), top, 60_000)
        G = self.at(dense)
        change = np.abs(np.diff(np.log(np.abs(G)))) + np.abs(np.diff(np.unwrap(np.angle(G)))) + np.diff(np.log(dense))
        total = np.concatenate([[0], np.cumsum(change)]) / (0.13 / self.fineness)
        return np.interp(np.linspace(0, total[-1], int(total[-1]) + 2), total, dense)

    def good(self, k, ki, kd):
        """Which gains meet the limits and stabilise."""
        found = np.zeros(len(k), bool)
        for i in range(0, len(k), CHUNK):
            gains = np.stack([k[i : i + CHUNK], ki[i : i + CHUNK], kd[i : i + CHUNK]], axis=1)
            left = np.arange(len(gains))
            for some in (slice(7, None, 16), slice(3, None, 4), slice(None)):
                L = gains[left] @ self.parts[:, some]
                distance = np.abs(1 + L)
                fine = (self.Ms * distance >= 1).all(1) & (np.abs(L) <= self.Mt * distance).all(1)
                left, L = left[fine], L[fine]
                if not left.size:
                    break
            else:
                turn = np.unwrap(np.angle(1 + L), axis=1)
                left = left[np.abs(turn[:, -1] - turn[:, 0] - self.integrators * np.pi / 2) < np.pi / 2]
                found[i + left] = True
        return found


def exhaustive(loop: Loop):
    """The gains (k, ki, kd) with the largest ki > 0 that were found; None for none."""
    omega, gain = loop.ultimate
    k = gain * np.concatenate([-np.geomspace(1, 0.03, 6), [0], np.geomspace(0.02, 20, 34)])
    kd = gain / omega * np.concatenate([[0], np.geomspace(0.01, 20, 26)])
    ki = gain * omega * np.geomspace(1e-4, 20, 50)
    grid = [axis.ravel() for axis in np.meshgrid(k, kd, ki, indexing="ij")]
    K, D, I = grid
    good = loop.good(K, I, D).reshape(len(k), len(kd), len(ki))
    highest = np.where(good.any(axis=2), good.shape[2] - 1 - good[:, :, ::-1].argmax(axis=2), -1)
    order = np.argsort(-highest, axis=None)[: 3 * CELLS]
    rows, columns = np.unravel_index(order[highest.ravel()[order] >= 0], highest.shape)
    if not rows.size:
        return None
    wide_k, wide_d = np.gradient(k), np.gradient(kd)
    best = []
    for i, j in zip(rows, columns, strict=True):
        best.append((k[i], ki[highest[i, j]], kd[j], 1.5 * wide_k[i], 0.5, 1.5 * wide_d[j]))
    for n in range(ROUNDS):
        best = sorted(_refined(loop, best), key=lambda b: -b[1])[: max(CELLS - n // 2, 4)]
    fine = replace(loop, fineness=FINE)
    best = [
        (k, 0.9 * ki, kd, max(0.05 * abs(k), 4 * dk), 0.13, 0.05 * kd + 4 * dd) for k, ki, kd, dk, _, dd in best[:4]
    ]
    best = [box for box in (_best_in(fine, box) for box in best) if box]
    for _ in range(ROUNDS):
        best = _refined(fine, best)
    return max(best, key=lambda b: b[1])[:3] if best else None


def _refined(loop, boxes):
    """Each box about the best of its own samples, smaller unless that lies at its edge."""
    found = []
    for box in boxes:
        better = _best_in(loop, box)
        if better is None or better[1] <= box[1]:
            better = (*box[:3], *(SHRINK * width for width in box[3:]))
        found.append(better)
    return found


def _best_in(loop, box):
    """The best sample of a box, as a box; None if none is good."""
    k, ki, kd, dk, di, dd = box
    U, V, W = (axis.ravel() for axis in np.meshgrid(UNIT, np.linspace(0, 1, 10), UNIT, indexing="ij"))
    K, I, D = k + dk * U, ki * (1 + di * V), kd + dd * W
    keep = D >= 0
    K, I, D, U, V, W = (x[keep] for x in (K, I, D, U, V, W))
    good = np.nonzero(loop.good(K, I, D))[0]
    if not good.size:
        return None
    top = good[I[good] == I[good].max()]
    at = top[len(top) // 2]
    share = 1.0 if max(abs(U[at]), V[at], abs(W[at])) == 1 else SHRINK
    return K[at], I[at], D[at], share * dk, share * di, share * dd
