"use strict";

// Eigenvalues of a real matrix: it is balanced, brought to Hessenberg's form, and there by shifted QR steps to
// eigenvalues. After Parlett and Reinsch (1969), and Martin, Peters and Wilkinson (1970), in the Handbook for Automatic
// Computation.

// Balance A (n, n) in place by powers of two, and take apart what is triangular already: eigenvalues of the rows outside
// of low..high stand on the diagonal. `scale` (n) has the factors D of D^-1 A D.
function balance(A, n, permutes = true) {
  const scale = new Float64Array(n).fill(1), order = Array.from({ length: n }, (_, i) => i);
  let low = 0, high = n - 1;
  const exchange = (i, j) => {
    if (i === j) return;
    swapRows(A, n, i, j);
    for (let k = 0; k < n; k++) {
      const a = A[k * n + i];
      A[k * n + i] = A[k * n + j];
      A[k * n + j] = a;
    }
    [order[i], order[j]] = [order[j], order[i]];
  };
  const alone = (i, alongRow) => { // whether all others of its row, or column, within the block are zero
    for (let j = low; j <= high; j++) if (j !== i && A[alongRow ? i * n + j : j * n + i] !== 0) return false;
    return true;
  };
  for (let again = permutes; again && high > low;) {
    again = false;
    for (let i = high; i >= low && !again; i--) {
      if (alone(i, true)) {
        exchange(i, high--);
        again = true;
      }
    }
    for (let i = low; i <= high && !again; i++) {
      if (alone(i, false)) {
        exchange(i, low++);
        again = true;
      }
    }
  }
  for (let again = true; again;) {
    again = false;
    for (let i = low; i <= high; i++) again = balanceRow(A, n, i, low, high, scale) || again;
  }
  return { low, high, scale, order };
}

// Scale a row and its column so that their sizes are alike; false if they are.
function balanceRow(A, n, i, low, high, scale) {
  let column = 0, row = 0, factor = 1;
  for (let j = low; j <= high; j++) {
    if (j === i) continue;
    column += Math.abs(A[j * n + i]);
    row += Math.abs(A[i * n + j]);
  }
  if (!(column > 0 && row > 0)) return false;
  const sum = column + row;
  for (; column < row / 2; column *= 4) factor *= 2;
  for (; column >= row * 2; column /= 4) factor /= 2;
  if (!((column + row) / factor < 0.95 * sum)) return false;
  scale[i] *= factor;
  for (let j = 0; j < n; j++) A[i * n + j] /= factor;
  for (let j = 0; j < n; j++) A[j * n + i] *= factor;
  return true;
}

// Bring A (n, n) to Hessenberg's form in place, between low and high, by Householder's reflections; B (n, m) and C (m, n)
// of the same system follow.
function toHessenberg(A, n, low = 0, high = n - 1, B = null, C = null, m = 0) {
  const v = new Float64Array(n);
  for (let k = low; k < high - 1; k++) {
    let size = 0;
    for (let i = k + 1; i <= high; i++) size = Math.max(size, Math.abs(A[i * n + k]));
    if (!(size > 0)) continue;
    let norm = 0;
    for (let i = k + 1; i <= high; i++) norm += (v[i] = A[i * n + k] / size) ** 2;
    norm = Math.sqrt(norm);
    if (v[k + 1] < 0) norm = -norm;
    v[k + 1] += norm;
    const weight = 1 / (norm * v[k + 1]);
    reflectRows(A, n, k, n, v, weight, k + 1, high);
    reflectColumns(A, n, 0, n, v, weight, k + 1, high);
    if (B) reflectRows(B, m, 0, m, v, weight, k + 1, high);
    if (C) reflectColumns(C, n, 0, m, v, weight, k + 1, high);
    for (let i = k + 2; i <= high; i++) A[i * n + k] = 0;
  }
}

// (I - weight v v') M, for its columns from `first` on.
function reflectRows(M, width, first, end, v, weight, low, high) {
  for (let j = first; j < end; j++) {
    let sum = 0;
    for (let i = low; i <= high; i++) sum += v[i] * M[i * width + j];
    sum *= weight;
    for (let i = low; i <= high; i++) M[i * width + j] -= sum * v[i];
  }
}

// M (I - weight v v'), for its rows from `first` on.
function reflectColumns(M, width, first, end, v, weight, low, high) {
  for (let i = first; i < end; i++) {
    let sum = 0;
    for (let j = low; j <= high; j++) sum += v[j] * M[i * width + j];
    sum *= weight;
    for (let j = low; j <= high; j++) M[i * width + j] -= sum * v[j];
  }
}

// The eigenvalues of A (n, n), which is overwritten, as {re, im}; null if they do not converge or A is not finite.
function eigenvalues(A, n) {
  if (!allFinite(A, 0, n * n)) return null;
  const re = new Float64Array(n), im = new Float64Array(n), { low, high } = balance(A, n);
  for (let i = 0; i < n; i++) if (i < low || i > high) re[i] = A[i * n + i];
  toHessenberg(A, n, low, high);
  return qrSteps(A, n, low, high, re, im) ? { re, im } : null;
}

// Francis' double steps on a matrix of Hessenberg's form; the eigenvalues come from the end.
function qrSteps(H, n, low, high, re, im) {
  let norm = 0, shift = 0, end = high, tries = 0;
  for (let i = low; i <= high; i++) for (let j = Math.max(i - 1, low); j <= high; j++) norm += Math.abs(H[i * n + j]);
  while (end >= low) {
    const start = splitAt(H, n, low, end, norm), last = end * n + end;
    if (start === end) {
      re[end] = H[last] + shift;
      im[end--] = 0;
      tries = 0;
    } else if (start === end - 1) {
      pairAt(H, n, end, shift, re, im);
      end -= 2;
      tries = 0;
    } else {
      if (tries === 60) return false;
      let x = H[last], y = H[last - n - 1], w = H[last - 1] * H[last - n];
      if (tries % 10 === 0 && tries > 0) { // an exceptional shift
        shift += x;
        for (let i = low; i <= end; i++) H[i * n + i] -= x;
        const s = Math.abs(H[last - 1]) + Math.abs(H[last - n - 2]);
        x = y = 0.75 * s;
        w = -0.4375 * s * s;
      }
      tries += 1;
      doubleStep(H, n, start, end, x, y, w);
    }
  }
  return true;
}

// The first row of the block that ends at `end`: above it stands a number that is nothing but rounding.
function splitAt(H, n, low, end, norm) {
  let l = end;
  for (; l > low; l--) {
    const s = Math.abs(H[(l - 1) * n + l - 1]) + Math.abs(H[l * n + l]) || norm;
    if (Math.abs(H[l * n + l - 1]) < Number.EPSILON * s / 2) {
      H[l * n + l - 1] = 0;
      break;
    }
  }
  return l;
}

// The two eigenvalues of the block of two rows that ends at `end`.
function pairAt(H, n, end, shift, re, im) {
  const x = H[end * n + end], y = H[(end - 1) * n + end - 1], w = H[end * n + end - 1] * H[(end - 1) * n + end];
  const p = (y - x) / 2, q = p * p + w, root = Math.sqrt(Math.abs(q));
  if (q >= 0) {
    const z = p + (p >= 0 ? root : -root);
    re[end - 1] = x + shift + z;
    re[end] = z === 0 ? re[end - 1] : x + shift - w / z;
    im[end - 1] = im[end] = 0;
  } else {
    re[end - 1] = re[end] = x + shift + p;
    im[end - 1] = root;
    im[end] = -root;
  }
}

function doubleStep(H, n, l, end, x, y, w) {
  let m = end - 2, p = 0, q = 0, r = 0;
  for (; m >= l; m--) { // two small numbers below the diagonal allow a later start
    const z = H[m * n + m], a = x - z, b = y - z;
    p = (a * b - w) / H[(m + 1) * n + m] + H[m * n + m + 1];
    q = H[(m + 1) * n + m + 1] - z - a - b;
    r = H[(m + 2) * n + m + 1];
    const s = Math.abs(p) + Math.abs(q) + Math.abs(r);
    p /= s;
    q /= s;
    r /= s;
    if (m === l) break;
    const near = Math.abs(H[(m - 1) * n + m - 1]) + Math.abs(z) + Math.abs(H[(m + 1) * n + m + 1]);
    if (Math.abs(H[m * n + m - 1]) * (Math.abs(q) + Math.abs(r)) < Number.EPSILON / 2 * Math.abs(p) * near) break;
  }
  for (let i = m + 2; i <= end; i++) {
    H[i * n + i - 2] = 0;
    if (i > m + 2) H[i * n + i - 3] = 0;
  }
  for (let k = m; k < end; k++) {
    const isLast = k === end - 1;
    let size = 1;
    if (k !== m) {
      p = H[k * n + k - 1];
      q = H[(k + 1) * n + k - 1];
      r = isLast ? 0 : H[(k + 2) * n + k - 1];
      size = Math.abs(p) + Math.abs(q) + Math.abs(r);
      if (size === 0) continue;
      p /= size;
      q /= size;
      r /= size;
    }
    const s = (p < 0 ? -1 : 1) * Math.sqrt(p * p + q * q + r * r);
    if (k !== m) H[k * n + k - 1] = -s * size;
    else if (l !== m) H[k * n + k - 1] = -H[k * n + k - 1];
    p += s;
    const a = p / s, b = q / s, c = r / s, f = q / p, g = r / p;
    for (let j = k; j <= end; j++) {
      const sum = H[k * n + j] + f * H[(k + 1) * n + j] + (isLast ? 0 : g * H[(k + 2) * n + j]);
      H[k * n + j] -= sum * a;
      H[(k + 1) * n + j] -= sum * b;
      if (!isLast) H[(k + 2) * n + j] -= sum * c;
    }
    for (let i = l; i <= Math.min(end, k + 3); i++) {
      const sum = a * H[i * n + k] + b * H[i * n + k + 1] + (isLast ? 0 : c * H[i * n + k + 2]);
      H[i * n + k] -= sum;
      H[i * n + k + 1] -= sum * f;
      if (!isLast) H[i * n + k + 2] -= sum * g;
    }
  }
}
