"use strict";

// Linear programs of a few variables, by Seidel's method (1991, Discrete and Computational Geometry 6, 423-434): planes are added
// one by one, and where the optimum so far lies behind one, the new optimum lies on it, which is a program of one variable less.

const ON_PLANE = 1e-12; // of the size of a plane's numbers

// The z of `low` <= z <= `high` at which c z is largest with a z >= b for all planes {a, b}; null where there is none.
function linearOptimum(c, planes, low, high) {
  if (c.length === 1) return optimumOnLine(c[0], planes, low[0], high[0]);
  let z = c.map((one, i) => (one > 0 ? high[i] : low[i]));
  for (let i = 0; i < planes.length; i++) {
    const { a, b } = planes[i];
    let value = -b, size = Math.abs(b);
    for (let k = 0; k < a.length; k++) {
      value += a[k] * z[k];
      size += Math.abs(a[k] * z[k]);
    }
    if (value >= -ON_PLANE * size) continue;
    z = optimumOnPlane(c, planes, i, low, high);
    if (!z) return null;
  }
  return z;
}

function optimumOnLine(c, planes, low, high) {
  for (const { a: [a], b } of planes) {
    if (a > 0) low = Math.max(low, b / a);
    else if (a < 0) high = Math.min(high, b / a);
    else if (b > 0) return null;
  }
  if (!(low <= high + ON_PLANE * Math.abs(high))) return null;
  return [c > 0 ? high : low];
}

// The optimum on plane i, for the planes before it.
function optimumOnPlane(c, planes, i, low, high) {
  const { a, b } = planes[i], j = a.reduce((best, one, k) => (Math.abs(one) > Math.abs(a[best]) ? k : best), 0);
  if (a[j] === 0) return null;
  const others = [...a.keys()].filter((k) => k !== j), without = (v) => others.map((k) => v[k]);
  const onto = (v, w) => ({ a: others.map((k) => v[k] - (v[j] * a[k]) / a[j]), b: w - (v[j] * b) / a[j] }); // of v z >= w
  const axis = a.map((_, k) => Number(k === j)), reduced = [onto(axis, low[j]), onto(axis.map((one) => -one), -high[j])];
  for (let k = 0; k < i; k++) reduced.push(onto(planes[k].a, planes[k].b));
  const found = linearOptimum(onto(c, 0).a, reduced, without(low), without(high));
  if (!found) return null;
  const z = new Array(a.length);
  others.forEach((k, l) => (z[k] = found[l]));
  z[j] = (b - others.reduce((sum, k) => sum + a[k] * z[k], 0)) / a[j];
  return z;
}
