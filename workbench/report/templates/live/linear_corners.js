"use strict";

// Corners: where a law or a plant switches at the very state of a loop, as |s| does at s = 0, a derivative is that of no
// piece. The Jacobians are then taken a little off the state, to many sides, and hold if they are alike on all of them.

const REACH = 4e-12; // how far off, relative to the state
const SIDES = 12; // pairs of opposite sides
const ALIKE = 1e-12; // of the largest entries of row and column: rounding
const JUMP = 1e-9; // the least difference of two motions, relative to their size, that counts as a jump

// Whether the loop has one linear model at x, though it is on a corner there; the model is left evaluated beside x.
function isStraightAt(model, x) {
  const { n, m } = model, shapes = [["A", n], ["B", m], ["C", n], ["D", m]], beside = new Float64Array(n);
  let first = null;
  for (let side = 0; side < 2 * SIDES; side++) {
    const sign = side % 2 ? -1 : 1, k = side >> 1;
    for (let i = 0; i < n; i++) beside[i] = x[i] + sign * REACH * (1 + Math.abs(x[i])) * Math.cos((i + 1) * (k + 0.5));
    model.evaluate(beside);
    const here = {};
    for (const name of ["change", "closed", "A", "B", "C", "D"]) here[name] = model[name].slice();
    first ||= here;
    if (shapes.some(([name, width]) => isApart(first[name], here[name], width))) return false;
    if (here.change.some((moved, i) => Math.abs(moved - first.change[i]) > jumpOf(here, i, x, n))) return false;
  }
  return true;
}

function isApart(M, N, width) {
  const rows = new Float64Array(M.length / width), columns = new Float64Array(width);
  for (const matrix of [M, N]) {
    matrix.forEach((value, k) => {
      const i = Math.floor(k / width), j = k % width, size = Math.abs(value);
      rows[i] = Math.max(rows[i], size);
      columns[j] = Math.max(columns[j], size);
    });
  }
  return M.some((value, k) => !(Math.abs(value - N[k]) <= ALIKE * (rows[Math.floor(k / width)] + columns[k % width])));
}

// What a smooth motion may change by between two sides, by the slopes of the closed loop, and a share of its size.
function jumpOf({ change, closed }, i, x, n) {
  let slopes = 1;
  for (let j = 0; j < n; j++) slopes += Math.abs(closed[i * n + j]) * (1 + Math.abs(x[j]));
  return 8 * REACH * slopes + JUMP * (1 + Math.abs(change[i]));
}
