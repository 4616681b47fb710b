"use strict";

// The disk margin of all channels of a loop at once: 1 / mu of (S - T) / 2 over complex changes of each channel by itself.
// Of two channels mu is exact; of more it is bounded from above by the best diagonal scaling that is found at each
// frequency, so that the margin is a safe one.

const WORTH_OF_DISK = 0.8; // of the largest number of the grid
const SCALINGS = 6, DESCENTS = 24; // rounds, each of all channels

// mu of (S - T) / 2 = (I + L)^-1 - I / 2 at a frequency, with L = -G (m, m); infinite where the feedback has no solution.
class BalancedGain {
  constructor(response) {
    const { m } = response;
    Object.assign(this, { response, m, E: new Float64Array(4 * m * m), X: new Float64Array(4 * m * m) });
  }

  // Roughly, from above, or as well as it is known.
  at(omega, isRough = false) {
    const { response } = this;
    if (!response.at(omega)) return 0.5; // as L is infinite
    return this.of(response.re, response.im, isRough);
  }

  // By real matrices of twice the size, [[a, -b], [b, a]] for a + j b.
  of(re, im, isRough = false) {
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
    return m === 2 ? this.pair() : this.scaled(isRough);
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

  // Of more: rows and columns are made alike in size, channel by channel, as Osborne does; then the singular vectors of the
  // largest gain say which way each channel is to be scaled, until both have the same size in each channel.
  scaled(isRough) {
    const { X, m } = this, N = 2 * m;
    for (let round = 0; round < SCALINGS; round++) {
      for (let i = 0; i < m; i++) {
        let row = 0, column = 0;
        for (let j = 0; j < m; j++) {
          if (j === i) continue;
          row += this.size(i, j) ** 2;
          column += this.size(j, i) ** 2;
        }
        if (row > 0 && column > 0) this.scale(i, (column / row) ** 0.25);
      }
    }
    if (isRough) return largestSingularValue(X, N);
    let least = Infinity, power = 0.5;
    for (let round = 0; round < DESCENTS; round++) {
      const U = X.slice(), { s, V } = singularValues(U, N, N), top = s.indexOf(s.reduce((a, b) => Math.max(a, b), 0));
      if (!(s[top] < least)) power /= 2;
      least = Math.min(least, s[top]);
      for (let i = 0; i < m; i++) {
        const u = Math.hypot(U[i * N + top], U[(m + i) * N + top]) / s[top], v = Math.hypot(V[i * N + top], V[(m + i) * N + top]);
        if (u > 0 && v > 0) this.scale(i, (v / u) ** power);
      }
    }
    return least;
  }

  // Multiply the row of a channel by a factor, and divide its column by it.
  scale(i, factor) {
    const { X, m } = this, N = 2 * m;
    for (const k of [i, m + i]) {
      for (let j = 0; j < N; j++) X[k * N + j] *= factor;
      for (let j = 0; j < N; j++) X[j * N + k] /= factor;
    }
  }
}

// The disk margin of a loop of several channels, at frequencies on which nothing is overlooked. What is roughly known is
// looked at again only where it may be the largest.
function diskMarginOf(response, omega, D) {
  const gain = new BalancedGain(response), { m, period } = response, rough = omega.map((w) => gain.at(w, true));
  const top = period ? Math.PI / period : Infinity, none = new Float64Array(m * m);
  let best = { omega: 0, value: gain.at(0) };
  const offer = (w, value) => {
    if (value > best.value) best = { omega: w, value };
  };
  offer(top, period ? gain.at(top) : gain.of(D, none));
  for (const k of [...rough.keys()].sort((i, j) => rough[j] - rough[i])) {
    if (rough[k] < best.value) break;
    offer(omega[k], gain.at(omega[k]));
  }
  rough.forEach((value, k) => {
    if (k === 0 || k === omega.length - 1 || value < WORTH_OF_DISK * best.value) return;
    if (!(value >= rough[k - 1] && value > rough[k + 1])) return;
    const at = peakBetween((w) => gain.at(w), omega[k - 1], omega[k + 1], m > 2 ? 1e-6 : 1e-9);
    offer(at, gain.at(at));
  });
  return { alpha: 1 / best.value, omega: Number.isFinite(best.omega) ? best.omega : null };
}
