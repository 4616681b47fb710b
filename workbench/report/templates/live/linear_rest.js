"use strict";

// The state at which a loop rests, by the method of Gauss and Newton, as `find_rest` of the workbench seeks it.

const AT_REST = 1e-8; // a rate counts as zero below this share of the terms that could have made it
const WAY = [4, 12, 24, 48, 96]; // implicit steps in time, after which Newton's method tries again
const REST_ROUNDS = 100, SMALL_STEP = 1e-7, LEAST_STEP = 1e-14; // evaluations; relative steps taken whole, and rounding

// The states at rest x, and `reason`, a sentence if there are none. The model stays evaluated at x.
function findRest(model) {
  const { linear, n } = model, must = linear.must, x = queueFilled(model);
  model.evaluate(x);
  if (!linear.rests) return { x, reason: "" };
  let shares = sharesOf(model, x);
  const free = movingStates(model);
  if (free.length && !(most(shares, must) <= AT_REST) && allFinite(model.change, 0, n)) {
    const start = x.slice();
    shares = descend(model, x, free, shares);
    if (!(most(shares, must) <= AT_REST)) shares = descendOnTheWay(model, x, start, free) || shares;
    model.evaluate(x);
  }
  return { x, reason: unrest(model, shares) };
}

// The first states, in a computer with its queue filled by what its law commands.
function queueFilled(model) {
  const { linear, jump, p, start } = model, x = start.slice();
  for (let round = 0; round < linear.follows.length; round++) {
    p[p.length - 1] = model.instant;
    jump.at(p, x);
    for (const i of linear.follows) x[i] = jump.heights[i];
  }
  return allFinite(x, 0, x.length) ? x : start.slice();
}

// The states that must rest and that something moves.
function movingStates(model) {
  return model.linear.must.filter((i) => model.change[i] !== 0 || stateMoves(model, i));
}

// Whether anything moves a state.
function stateMoves({ closed, n, isSampled }, i) {
  for (let j = 0; j < n; j++) if (closed[i * n + j] !== (isSampled && i === j ? 1 : 0)) return true;
  return false;
}

// The motion of each state as a share of what could have moved it; infinite where that is no number.
function sharesOf({ closed, change, n, isSampled }, x) {
  const reads = new Uint8Array(n);
  for (let i = 0; i < n * n; i++) if (closed[i] !== 0) reads[i % n] = 1;
  return Float64Array.from(change, (moved, i) => {
    let share = Math.abs(moved);
    if (isSampled) share = reads[i] ? share / (1 + Math.abs(x[i])) : 0;
    else {
      let terms = 1;
      for (let j = 0; j < n; j++) terms += Math.abs(closed[i * n + j]) * (1 + Math.abs(x[j]));
      share /= terms;
    }
    return Number.isNaN(share) ? Infinity : share;
  });
}

function most(shares, places) {
  return places.reduce((worst, i) => Math.max(worst, shares[i]), 0);
}

// Newton's steps on x in place, halved while the next one would be longer; the shares at the end.
function descend(model, x, free, shares) {
  const { n } = model, ahead = new Float64Array(n);
  let step = towardsRest(model, free), size = sizeOf(step, x, free), factor = 1;
  for (let round = 0; round < REST_ROUNDS && size > LEAST_STEP && Number.isFinite(size); round++) {
    ahead.set(x);
    free.forEach((i, k) => (ahead[i] += factor * step[k]));
    model.evaluate(ahead);
    const next = towardsRest(model, free), left = sizeOf(next, ahead, free);
    const stalls = left >= size / 2 && size < SMALL_STEP;
    if (left < size || (size < SMALL_STEP && Number.isFinite(left))) {
      x.set(ahead);
      step = next;
      size = left;
      factor = 1;
      shares = sharesOf(model, x);
    } else factor /= 2;
    if (stalls || factor <= 1e-9) break;
  }
  return shares;
}

// Newton's steps from states to which the loop moves, by implicit steps in time; x in place if there is a rest.
function descendOnTheWay(model, x, start, free) {
  const { n, closed, isSampled, linear } = model, { must } = linear, at = start.slice();
  model.evaluate(at);
  let rate = 1, size = norm(sharesOf(model, at), must);
  if (!isSampled) for (let i = 0; i < n; i++) rate = Math.max(i ? rate : 0, rowSum(closed, n, i));
  for (let count = 1; count <= WAY[WAY.length - 1]; count++) {
    const step = towardsRest(model, free, rate);
    free.forEach((i, k) => (at[i] += step[k]));
    model.evaluate(at);
    const left = norm(sharesOf(model, at), must);
    if (!(Number.isFinite(left) && left > 0 && size > 0)) return null;
    rate *= Math.min(Math.max(left / size, 0.5), 5);
    size = left;
    if (!WAY.includes(count)) continue;
    const ahead = at.slice(), shares = descend(model, ahead, movingStates(model), sharesOf(model, ahead));
    if (most(shares, must) <= AT_REST) {
      x.set(ahead);
      return shares;
    }
    model.evaluate(at);
  }
  return null;
}

function norm(shares, places) {
  return Math.sqrt(places.reduce((sum, i) => sum + shares[i] * shares[i], 0));
}

function rowSum(M, n, i) {
  let sum = 0;
  for (let j = 0; j < n; j++) sum += Math.abs(M[i * n + j]);
  return sum;
}

// The least change of the free states that stops those that must rest, to first order; NaN where there is none.
// With a rate it is an implicit step in time.
function towardsRest({ closed, change, linear, n, isSampled }, free, rate = 0) {
  const { must } = linear, J = part(closed, n, must, free), size = { steepest: 0 };
  const less = rate + (isSampled ? 1 : 0);
  if (less) must.forEach((i, k) => free.forEach((j, l) => (J[k * free.length + l] -= i === j ? less : 0)));
  for (const value of J) size.steepest = Math.max(size.steepest, Math.abs(value));
  const scale = size.steepest > 0 ? size.steepest : 1, right = Float64Array.from(must, (i) => -change[i] / scale);
  if (!Number.isFinite(scale) || !allFinite(right, 0, right.length) || !allFinite(J, 0, J.length)) {
    return new Float64Array(free.length).fill(NaN);
  }
  return leastSquares(J.map((value) => value / scale), right, must.length, free.length, 1e-12);
}

function sizeOf(step, x, free) {
  let size = 0;
  free.forEach((i, k) => {
    const share = Math.abs(step[k]) / (1 + Math.abs(x[i]));
    size = Number.isNaN(share) ? NaN : Math.max(size, share);
  });
  return size;
}

// The sentence that says what moves, or would in time; empty at rest.
function unrest(model, shares) {
  const { linear } = model, { must, labels, t } = linear, { share, state } = model.driven(must);
  if (state >= 0 && !(share <= AT_REST)) {
    return `The loop has no rest here: at t = ${t} s '${labels[state]}' is driven by a signal that moves in time.`;
  }
  const worst = must.reduce((best, i) => (best < 0 || shares[i] > shares[best] ? i : best), -1);
  if (worst < 0 || shares[worst] <= AT_REST) return "";
  return `Newton's method found no state at which the loop rests: '${labels[worst]}' still moves at t = ${t} s.`;
}
