"use strict";

// Small real matrices, each a Float64Array row by row, for the linear answers of a loop.

// C (n, k) = A (n, m) B (m, k), or C + A B.
function multiplyInto(C, A, B, n, m, k, adds = false) {
  if (!adds) C.fill(0, 0, n * k);
  for (let i = 0; i < n; i++) {
    for (let l = 0; l < m; l++) {
      const a = A[i * m + l];
      if (a === 0) continue;
      for (let j = 0; j < k; j++) C[i * k + j] += a * B[l * k + j];
    }
  }
}

function product(A, B, n, m, k) {
  const C = new Float64Array(n * k);
  multiplyInto(C, A, B, n, m, k);
  return C;
}

function identity(n) {
  const I = new Float64Array(n * n);
  for (let i = 0; i < n; i++) I[i * n + i] = 1;
  return I;
}

// Some rows and columns of A, which has `width` columns.
function part(A, width, rows, columns) {
  const B = new Float64Array(rows.length * columns.length);
  rows.forEach((i, k) => columns.forEach((j, l) => (B[k * columns.length + l] = A[i * width + j])));
  return B;
}

// X (n, k) of A X = B, by Gauss with row pivots; null where A is singular. A and B are overwritten.
function solveInPlace(A, B, n, k) {
  for (let c = 0; c < n; c++) {
    let best = c;
    for (let i = c + 1; i < n; i++) if (Math.abs(A[i * n + c]) > Math.abs(A[best * n + c])) best = i;
    if (!(Math.abs(A[best * n + c]) > 0)) return null;
    if (best !== c) {
      swapRows(A, n, best, c);
      swapRows(B, k, best, c);
    }
    for (let i = c + 1; i < n; i++) {
      const factor = A[i * n + c] / A[c * n + c];
      if (factor === 0) continue;
      for (let j = c; j < n; j++) A[i * n + j] -= factor * A[c * n + j];
      for (let j = 0; j < k; j++) B[i * k + j] -= factor * B[c * k + j];
    }
  }
  for (let i = n - 1; i >= 0; i--) {
    for (let j = 0; j < k; j++) {
      let sum = B[i * k + j];
      for (let l = i + 1; l < n; l++) sum -= A[i * n + l] * B[l * k + j];
      B[i * k + j] = sum / A[i * n + i];
    }
  }
  return B;
}

function swapRows(A, width, i, k) {
  for (let j = 0; j < width; j++) {
    const a = A[i * width + j];
    A[i * width + j] = A[k * width + j];
    A[k * width + j] = a;
  }
}

// The singular values s of A (rows, n), with U s in the place of A and V (n, n), by the one-sided method of Jacobi.
function singularValues(A, rows, n) {
  const V = identity(n), s = new Float64Array(n);
  for (let sweep = 0, turned = true; turned && sweep < 40; sweep++) {
    turned = false;
    for (let p = 0; p < n - 1; p++) {
      for (let q = p + 1; q < n; q++) turned = rotate(A, V, rows, n, p, q) || turned;
    }
  }
  for (let j = 0; j < n; j++) {
    let sum = 0;
    for (let i = 0; i < rows; i++) sum += A[i * n + j] ** 2;
    s[j] = Math.sqrt(sum);
  }
  return { s, V };
}

// Turn two columns until they are orthogonal; false if they are so already.
function rotate(A, V, rows, n, p, q) {
  let a = 0, b = 0, c = 0;
  for (let i = 0; i < rows; i++) {
    const x = A[i * n + p], y = A[i * n + q];
    a += x * x;
    b += y * y;
    c += x * y;
  }
  if (!(Math.abs(c) > 1e-16 * Math.sqrt(a * b))) return false;
  const zeta = (b - a) / (2 * c);
  const t = (zeta < 0 ? -1 : 1) / (Math.abs(zeta) + Math.hypot(1, zeta)), cos = 1 / Math.hypot(1, t), sin = cos * t;
  turnColumns(A, rows, n, p, q, cos, sin);
  turnColumns(V, n, n, p, q, cos, sin);
  return true;
}

function turnColumns(M, rows, n, p, q, cos, sin) {
  for (let i = 0; i < rows; i++) {
    const x = M[i * n + p], y = M[i * n + q];
    M[i * n + p] = cos * x - sin * y;
    M[i * n + q] = sin * x + cos * y;
  }
}

// The shortest x (n) with the least |A x - b|, A (rows, n); singular values below `least` of the largest count as zero.
function leastSquares(A, b, rows, n, least) {
  const U = A.slice(), { s, V } = singularValues(U, rows, n), x = new Float64Array(n);
  const cut = least * s.reduce((most, value) => Math.max(most, value), 0);
  for (let j = 0; j < n; j++) {
    if (!(s[j] > cut)) continue;
    let along = 0;
    for (let i = 0; i < rows; i++) along += U[i * n + j] * b[i];
    for (let i = 0; i < n; i++) x[i] += V[i * n + j] * (along / s[j] ** 2);
  }
  return x;
}

// The largest singular value of A (n, n).
function largestSingularValue(A, n) {
  return singularValues(A.slice(), n, n).s.reduce((most, value) => Math.max(most, value), 0);
}
