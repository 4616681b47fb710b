"use strict";

// The disk margin of all channels of a loop at once: 1 / mu of (S - T) / 2 over complex changes of each channel by itself.
// Of two channels mu is exact; of more it is bounded from above by a diagonal scaling, so that the margin is a safe one.

const WORTH_OF_DISK = 0.8; // of the largest number of the grid
const SCALINGS = 12; // rounds, each of all channels

// mu of (S - T) / 2 = (I + L)^-1 - I / 2 at a frequency, with L = -G (m, m); infinite where the feedback has no solution.
class BalancedGain {
  constructor(response) {
    const { m } = response;
    Object.assign(this, { response, m, E: new Float64Array(4 * m * m), X: new Float64Array(4 * m * m) });
  }

  at(omega) {
    const { response, m } = this;
    if (!response.at(omega)) return 0.5; // as L is infinite
    return this.of(response.re, response.im);
  }

  // By real matrices of twice the size, [[a, -b], [b, a]] for a + j b.
  of(re, im) {
    const { m, E, X } = this, N = 2 * m;
    X.fill(0);
    for (let i = 0; i < m; i++) {
      for (let j = 0; j < m; j++) {
        E[i * N + j] = E[(m + i) * N + m + j] = (i === j ? 1 : 0) - re[i * m + j];
        E[(m + i) * N + j] = -im[i * m + j];
        E[i * N + m + j] = im[i * m + j];
      }
      X[i * N + i] = X[(m + i) * N + m + i] = 1;
    }
    if (!solveInPlace(E, X, N, N)) return Infinity;
    for (let i = 0; i < N; i++) X[i * N + i] -= 0.5;
    return m === 2 ? this.pair() : this.scaled();
  }

  // The modulus of an entry.
  size(i, j) {
    const { X, m } = this;
    return Math.hypot(X[i * 2 * m + j], X[(m + i) * 2 * m + j]);
  }

  // Of two channels: the scaling that makes both numbers beside the diagonal alike leaves the least largest gain.
  pair() {
    const { X } = this, a = this.size(0, 0), d = this.size(1, 1), trace = a * a + d * d + 2 * this.size(0, 1) * this.size(1, 0);
    const times = (i, j, k, l) => [
      X[i * 4 + j] * X[k * 4 + l] - X[(2 + i) * 4 + j] * X[(2 + k) * 4 + l],
      X[i * 4 + j] * X[(2 + k) * 4 + l] + X[(2 + i) * 4 + j] * X[k * 4 + l],
    ];
    const [pr, pi] = times(0, 0, 1, 1), [qr, qi] = times(0, 1, 1, 0), determinant = Math.hypot(pr - qr, pi - qi);
    return Math.sqrt((trace + Math.sqrt(Math.max(0, trace * trace - 4 * determinant * determinant))) / 2);
  }

  // Of more: rows and columns are made alike in size, channel by channel, as Osborne does.
  scaled() {
    const { X, m } = this, N = 2 * m;
    for (let round = 0; round < SCALINGS; round++) {
      for (let i = 0; i < m; i++) {
        let row = 0, column = 0;
        for (let j = 0; j < m; j++) {
          if (j === i) continue;
          row += this.size(i, j) ** 2;
          column += this.size(j, i) ** 2;
        }
        if (!(row > 0 && column > 0)) continue;
        const factor = (column / row) ** 0.25;
        for (let j = 0; j < N; j++) for (const k of [i, m + i]) X[k * N + j] *= factor;
        for (let j = 0; j < N; j++) for (const k of [i, m + i]) X[j * N + k] /= factor;
      }
    }
    return largestSingularValue(X, N);
  }
}

// The disk margin of a loop of several channels, at frequencies on which nothing is overlooked.
function diskMarginOf(response, omega, D) {
  const gain = new BalancedGain(response), { m, period } = response, numbers = omega.map((w) => gain.at(w));
  const top = period ? Math.PI / period : Infinity, none = new Float64Array(m * m);
  let best = { omega: 0, value: gain.at(0) };
  const offer = (w, value) => {
    if (value > best.value) best = { omega: w, value };
  };
  offer(top, period ? gain.at(top) : gain.of(D, none));
  const most = numbers.reduce((a, b) => Math.max(a, b), 0);
  numbers.forEach((value, k) => {
    offer(omega[k], value);
    if (k === 0 || k === omega.length - 1 || value < WORTH_OF_DISK * most) return;
    if (!(value >= numbers[k - 1] && value > numbers[k + 1])) return;
    const at = peakBetween((w) => gain.at(w), omega[k - 1], omega[k + 1]);
    offer(at, gain.at(at));
  });
  return { alpha: 1 / best.value, omega: Number.isFinite(best.omega) ? best.omega : null };
}
