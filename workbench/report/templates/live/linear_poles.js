"use strict";

// Poles of linear systems, whether they decay, and the frequencies near which they may hide something.

const SUSPECT = 1e-6; // of the size of a matrix: a pole that decays more slowly may be one that rounding has moved
const DEAD = 1e-9; // a pole z of this size decays within a period
const LIGHT = 0.2; // the damping below which a pole has frequencies of its own
const AROUND = Float64Array.from({ length: 15 }, (_, i) => Math.sinh(-4 + 8 * i / 14)); // times its distance from the axis

// The poles of A (n, n), the slowest first, as {re, im}; null where there are none to trust.
function polesOf(A, n, period) {
  const found = eigenvalues(A.slice(), n);
  if (!found) return null;
  const growth = Float64Array.from(found.re, (re, i) => (period ? Math.hypot(re, found.im[i]) : re));
  const order = [...growth.keys()].sort((i, j) => {
    const apart = Math.round(growth[j] * 1e9) - Math.round(growth[i] * 1e9);
    return apart || found.im[j] - found.im[i];
  });
  return { re: Float64Array.from(order, (i) => found.re[i]), im: Float64Array.from(order, (i) => found.im[i]) };
}

// True if every pole of A decays by more than rounding may have moved it.
function allDecay(A, n, poles, period) {
  let size = null;
  for (let i = 0; i < n; i++) {
    const decay = period ? 1 - Math.hypot(poles.re[i], poles.im[i]) : -poles.re[i];
    if (!(decay > 0)) return false;
    size ??= largestSingularValue(A, n);
    if (decay > SUSPECT * size) continue;
    const doubt = n * Number.EPSILON * size * conditionOf(A, n, poles.re[i], poles.im[i], size);
    if (!(decay > doubt)) return false;
  }
  return true;
}

// How much more than a change of A (n, n) an eigenvalue may change, |y| |x| / |y' x| by its left and right vectors.
function conditionOf(A, n, re, im, size) {
  const transposed = part(A, n, [...Array(n).keys()], [...Array(n).keys()]);
  for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) transposed[j * n + i] = A[i * n + j];
  const x = eigenvector(A, n, re, im, size), y = eigenvector(transposed, n, re, im, size);
  let sr = 0, si = 0; // without conjugates, as y is that of the transposed matrix
  for (let i = 0; i < n; i++) {
    sr += x[i] * y[i] - x[n + i] * y[n + i];
    si += x[i] * y[n + i] + x[n + i] * y[i];
  }
  return Math.min(1 / Math.hypot(sr, si), 1 / Number.EPSILON);
}

// The eigenvector of length one, real parts and then imaginary parts, by inverse iteration on [[A - re, im], [-im, A - re]].
function eigenvector(A, n, re, im, size) {
  const N = 2 * n, near = size * Number.EPSILON * 4;
  let v = new Float64Array(N).map((_, i) => 1 + 0.1 * Math.sin(i + 1));
  for (let round = 0; round < 3; round++) {
    const M = new Float64Array(N * N);
    for (let i = 0; i < n; i++) {
      for (let j = 0; j < n; j++) M[i * N + j] = M[(n + i) * N + n + j] = A[i * n + j] - (i === j ? re + near : 0);
      M[i * N + n + i] = im;
      M[(n + i) * N + i] = -im;
    }
    v = solveInPlace(M, v, N, 1) || v;
    const length = Math.hypot(...v);
    v = v.map((value) => value / length);
  }
  return v;
}

// The natural frequencies [rad/s] of poles or zeros, and those at which the lightly damped ones of them stand out, unless
// they have less than some least damping.
function rootFrequencies({ re, im }, period, least = 0) {
  const sizes = [], around = [];
  for (let i = 0; i < re.length; i++) {
    let a = re[i], b = Math.abs(im[i]);
    if (period) {
      const modulus = Math.hypot(a, b);
      if (!(modulus > DEAD)) continue;
      [a, b] = [Math.log(modulus) / period, Math.abs(Math.atan2(b, a)) / period];
    }
    const size = Math.hypot(a, b);
    sizes.push(size);
    if (b > 0 && Math.abs(a) < LIGHT * size && Math.abs(a) >= least * size) for (const turn of AROUND) around.push(b + turn * Math.abs(a));
  }
  return { sizes, around };
}

// The zeros of a system of one channel, roughly: where they are is a hint, and no figure.
function zerosOf({ A, B, C, D, n }) {
  let row = C.slice(), gain = D[0];
  const length = (v) => Math.hypot(...v);
  for (let degree = 0; degree <= n; degree++) {
    const scale = degree ? length(row) * length(B) : 0;
    const next = degree ? product(row, A, 1, n, n) : row;
    if (degree) gain = row.reduce((sum, value, i) => sum + value * B[i], 0);
    if (degree ? Math.abs(gain) > 1e-10 * scale : Math.abs(gain) > 1e-12) {
      const closed = A.slice();
      for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) closed[i * n + j] -= B[i] * next[j] / gain;
      return eigenvalues(closed, n) || { re: [], im: [] };
    }
    row = next;
  }
  return { re: [], im: [] };
}
