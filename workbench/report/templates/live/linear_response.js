"use strict";

// The answer G(z) = C (z I - A)^-1 B + D of a linear system at many z. For each input a reflection turns it to the first
// axis and others bring A to Hessenberg's form, once; then, at each z, the equations from the last to the second give all
// states as multiples of the last one, and the first equation its size (Hyman's method: Wilkinson, The Algebraic
// Eigenvalue Problem, 1965, section 7.11), in as many operations as H has numbers.

const AT_A_POLE = 10 * Number.EPSILON; // times the number of states: the share of its terms that is nothing but rounding

// One input of a system: its answers at all outputs.
class InputResponse {
  // A (n, n), b (n), C (m, n), which are overwritten.
  constructor(A, b, C, n, m) {
    const { scale } = balance(A, n, false);
    for (let i = 0; i < n; i++) {
      b[i] /= scale[i];
      for (let k = 0; k < m; k++) C[k * n + i] *= scale[i];
    }
    this.size = n ? turnToAxis(A, b, C, n, m) : 0;
    let count = 1; // of states that the input reaches
    while (count < n && A[count * n + count - 1] !== 0) count += 1;
    count = this.size === 0 ? 0 : count;
    const kept = [...Array(count).keys()];
    Object.assign(this, { n: count, m, H: part(A, n, kept, kept), C: part(C, n, [...Array(m).keys()], kept) });
    for (const name of ["xr", "xi", "dr", "di"]) this[name] = new Float64Array(count);
    for (const name of ["re", "im", "dre", "dim", "terms"]) this[name] = new Float64Array(m);
  }

  // C (z I - A)^-1 b into `re` and `im` (m), and its derivative by z into `dre` and `dim`; false at a pole.
  at(zr, zi, slope) {
    const { n, H, xr, xi, dr, di } = this;
    if (!n) return true; // and all answers are zero
    xr[n - 1] = 1;
    xi[n - 1] = dr[n - 1] = di[n - 1] = 0;
    for (let k = n - 1; k > 0; k--) {
      const h = H[k * n + k - 1], row = k * n;
      let a = zr * xr[k] - zi * xi[k], b = zr * xi[k] + zi * xr[k];
      for (let j = k; j < n; j++) {
        a -= H[row + j] * xr[j];
        b -= H[row + j] * xi[j];
      }
      xr[k - 1] = a / h;
      xi[k - 1] = b / h;
      if (!slope) continue;
      a = xr[k] + zr * dr[k] - zi * di[k];
      b = xi[k] + zr * di[k] + zi * dr[k];
      for (let j = k; j < n; j++) {
        a -= H[row + j] * dr[j];
        b -= H[row + j] * di[j];
      }
      dr[k - 1] = a / h;
      di[k - 1] = b / h;
    }
    return this.read(zr, zi, slope);
  }

  // The first equation, and what the outputs see.
  read(zr, zi, slope) {
    const { n, m, H, C, size, xr, xi, dr, di, re, im, dre, dim } = this;
    let fr = zr * xr[0] - zi * xi[0], fi = zr * xi[0] + zi * xr[0], terms = Math.hypot(zr, zi) * Math.hypot(xr[0], xi[0]);
    for (let j = 0; j < n; j++) {
      fr -= H[j] * xr[j];
      fi -= H[j] * xi[j];
      terms += Math.abs(H[j]) * (Math.abs(xr[j]) + Math.abs(xi[j]));
    }
    const square = fr * fr + fi * fi;
    if (!(Math.sqrt(square) > AT_A_POLE * n * terms)) return false;
    let gr = xr[0] + zr * dr[0] - zi * di[0], gi = xi[0] + zr * di[0] + zi * dr[0];
    if (slope) {
      for (let j = 0; j < n; j++) {
        gr -= H[j] * dr[j];
        gi -= H[j] * di[j];
      }
    }
    for (let i = 0; i < m; i++) {
      let a = 0, b = 0, c = 0, d = 0, sum = 0;
      for (let j = 0; j < n; j++) {
        const weight = C[i * n + j];
        a += weight * xr[j];
        b += weight * xi[j];
        sum += Math.abs(weight) * (Math.abs(xr[j]) + Math.abs(xi[j]));
        if (!slope) continue;
        c += weight * dr[j];
        d += weight * di[j];
      }
      re[i] = size * (a * fr + b * fi) / square;
      im[i] = size * (b * fr - a * fi) / square;
      this.terms[i] = Math.abs(size) * sum / Math.sqrt(square);
      if (!slope) continue;
      const r = size * c - (re[i] * gr - im[i] * gi), q = size * d - (re[i] * gi + im[i] * gr);
      dre[i] = (r * fr + q * fi) / square;
      dim[i] = (q * fr - r * fi) / square;
    }
    return true;
  }
}

// Bring A (n, n) to Hessenberg's form in coordinates in which b is a multiple of the first axis, which is returned.
function turnToAxis(A, b, C, n, m) {
  const v = new Float64Array(n);
  let first = b[0];
  for (let k = 0; k < n - 1; k++) {
    let size = 0, norm = 0;
    const entry = (i) => (k ? A[i * n + k - 1] : b[i]);
    for (let i = k; i < n; i++) size = Math.max(size, Math.abs(entry(i)));
    if (!(size > 0)) return k ? first : 0;
    for (let i = k; i < n; i++) norm += (v[i] = entry(i) / size) ** 2;
    norm = v[k] > 0 ? -Math.sqrt(norm) : Math.sqrt(norm);
    if (k === 0) first = norm * size;
    v[k] -= norm;
    const weight = -1 / (norm * v[k]);
    reflectRows(A, n, k ? k - 1 : 0, n, v, weight, k, n - 1);
    reflectColumns(A, n, 0, n, v, weight, k, n - 1);
    reflectColumns(C, n, 0, m, v, weight, k, n - 1);
    for (let i = k + 1; k && i < n; i++) A[i * n + k - 1] = 0;
  }
  return first;
}

class LinearResponse {
  // A (n, n), B (n, m), C (m, n) and D (m, m); the period in s of a computer, or null.
  constructor({ A, B, C, D, n, m }, period) {
    Object.assign(this, { D, n, m, period });
    const all = [...Array(m).keys()], seen = reached(A, n, false, (i) => all.some((k) => C[k * n + i] !== 0));
    this.inputs = all.map((j) => {
      const moved = reached(A, n, true, (i) => B[i * m + j] !== 0), states = [...Array(n).keys()].filter((i) => moved[i] && seen[i]);
      return new InputResponse(part(A, n, states, states), part(B, m, states, [j]), part(C, n, all, states), states.length, m);
    });
    for (const name of ["re", "im", "dre", "dim", "terms"]) this[name] = new Float64Array(m * m);
  }

  // G at a frequency in rad/s into `re` and `im` (m, m), and its derivative by omega into `dre` and `dim` if asked; false
  // at a pole. `terms` (m, m) are the sizes of what each number is the sum of, which its rounding follows.
  at(omega, slope = false) {
    const { m, period, re, im, dre, dim, terms, D } = this;
    const zr = period ? Math.cos(omega * period) : 0, zi = period ? Math.sin(omega * period) : omega;
    const ar = period ? -zi * period : 0, ai = period ? zr * period : 1; // dz / d omega
    for (let j = 0; j < m; j++) {
      const one = this.inputs[j];
      if (!one.at(zr, zi, slope)) return false;
      for (let i = 0; i < m; i++) {
        const place = i * m + j;
        re[place] = one.re[i] + D[place];
        im[place] = one.im[i];
        terms[place] = one.terms[i] + Math.abs(D[place]);
        if (!slope) continue;
        dre[place] = one.dre[i] * ar - one.dim[i] * ai;
        dim[place] = one.dre[i] * ai + one.dim[i] * ar;
      }
    }
    return true;
  }
}

// Which states others reach along A, or are reached from against it, from those that begin.
function reached(A, n, forwards, begins) {
  const there = new Uint8Array(n);
  for (let i = 0; i < n; i++) there[i] = begins(i) ? 1 : 0;
  for (let again = true; again;) {
    again = false;
    for (let i = 0; i < n; i++) {
      for (let j = 0; j < n; j++) {
        const from = forwards ? j : i, to = forwards ? i : j;
        if (A[i * n + j] === 0 || !there[from] || there[to]) continue;
        there[to] = 1;
        again = true;
      }
    }
  }
  return there;
}

// The system whose inputs `places` are its outputs of the same places; null where that has no solution. Feedback is
// positive: of L, which has the sign of negative feedback, hand over -C and -D.
function closedAt({ A, B, C, D, n, m }, places) {
  const all = Array.from({ length: m }, (_, i) => i), k = places.length, rest = all.filter((i) => !places.includes(i));
  const states = Array.from({ length: n }, (_, i) => i);
  const E = part(D, m, places, places).map((d, i) => (i % (k + 1) === 0 ? 1 : 0) - d);
  const right = new Float64Array(k * (n + rest.length)), Cp = part(C, n, places, states), Dp = part(D, m, places, rest);
  for (let i = 0; i < k; i++) {
    right.set(Cp.subarray(i * n, (i + 1) * n), i * (n + rest.length));
    right.set(Dp.subarray(i * rest.length, (i + 1) * rest.length), i * (n + rest.length) + n);
  }
  if (!solveInPlace(E, right, k, n + rest.length)) return null;
  const width = n + rest.length, ofStates = part(right, width, [...Array(k).keys()], states);
  const ofRest = part(right, width, [...Array(k).keys()], rest.map((_, i) => n + i));
  const Bp = part(B, m, states, places), Drp = part(D, m, rest, places);
  const closed = {
    A: A.slice(), B: part(B, m, states, rest), C: part(C, n, rest, states), D: part(D, m, rest, rest), n, m: rest.length,
  };
  multiplyInto(closed.A, Bp, ofStates, n, k, n, true);
  multiplyInto(closed.B, Bp, ofRest, n, k, rest.length, true);
  multiplyInto(closed.C, Drp, ofStates, rest.length, k, n, true);
  multiplyInto(closed.D, Drp, ofRest, rest.length, k, rest.length, true);
  return closed;
}
