"use strict";

// The numbers of knobs that put a pole where a reader drags it, or as near to it as their ranges let it come.

const PLACED = 1e-8; // of its size: a pole that is so near is there
const FLAT = 1e-3; // of the size of a pair: its least distance from the real axis, where the two are no pair any more
const DESCENT_ROUNDS = 60, LONGEST = 1; // steps towards the nearest place, and the longest of them in sizes of the knobs
const SMALLEST_SHARE = 1e-5, LARGEST_SHARE = 0.02, LONGER = 2.5; // of the range of a knob: steps along a locus
const SECTIONS = 60, SAME_SHARE = 1e-11, HELD_ROUNDS = 8;

// The pole nearest to another one, of those on and above the real axis; where two are as near, the one nearer to a target.
function nearestPole({ re, im }, from, target) {
  let best = null, least = Infinity;
  for (let j = 0; j < re.length; j++) {
    if (im[j] < 0) continue;
    const far = Math.hypot(re[j] - from.re, im[j] - from.im) + 1e-3 * Math.hypot(re[j] - target.re, im[j] - target.im);
    if (far < least) [best, least] = [{ re: re[j], im: im[j] }, far];
  }
  return best;
}

const between = (s, t) => Math.hypot(s.re - t.re, s.im - t.im);

// The reply to a drag of the pole `from` to a target by a choice of knobs: their numbers, where the pole is then, whether that
// is the target, and the knobs that were followed, which are fewer where the choice has no single answer at this pole.
function placedPole(map, { from, target, choice }) {
  const all = map.only(choice.knobs), poles = all.at(all.start), none = { knobs: [], values: [], reached: false, holds: false };
  if (!poles) return { ...none, at: from, blocked: true, isUnique: true };
  const s = nearestPole(poles, from, from), size = sizeOfPole(s, poles, map.period);
  const mine = movedPoles(all).find((one) => between(one, s) <= PLACED * size)?.choices ?? [];
  const isUnique = mine.some(({ knobs, holds }) => knobs.length === choice.knobs.length && holds === choice.holds);
  const followed = isUnique ? [...choice.knobs.keys()] : mine.find(({ knobs }) => knobs.length === 1)?.knobs ?? [];
  if (!followed.length) return { ...none, at: s, blocked: false, isUnique };
  const own = all.only(followed), isPair = followed.length > 1 && s.im > 0, holds = isUnique && choice.holds;
  const wished = isPair ? { re: target.re, im: Math.max(target.im, FLAT * Math.abs(target.re)) } : target;
  const found = holds ? heldPlace(own, poles, s, wished) : isPair ? freePlace(own, poles, s, wished) : placeOnLocus(own, s, wished);
  const reached = between(found.at, wished) <= PLACED * Math.max(sizeOfPole(wished, poles, map.period), size);
  return { ...found, knobs: followed.map((i) => choice.knobs[i]), reached, blocked: own.blocked, isUnique, holds };
}

// The numbers at which the vector f is zero, by Newton's method within the ranges, or the last ones that came nearer.
function solvedNumbers(map, f, start) {
  let values = start, now = f(values);
  for (let round = 0; now && round < NEWTON_ROUNDS; round++) {
    const size = Math.hypot(...now), columns = size > 0 ? map.differences(f, values) : null, step = columns && combined(columns, now)?.x;
    let next = null;
    for (let share = 1; step && !next && share > 1e-4; share /= 2) {
      const tried = map.inside(values.map((one, i) => one - share * step[i] * map.size(i, one))), then = f(tried);
      if (then && Math.hypot(...then) < (1 - 1e-4 * share) * size) next = { tried, then };
    }
    if (!next) break;
    [values, now] = [next.tried, next.then];
  }
  return values;
}

// Two knobs put a pair at the target, wherever the other poles go; else as near to it as they can.
function freePlace(map, poles, s, target) {
  const weights = poles.re.map((_, j) => Math.max(apart(target, poles, j), LEAST_SIZE * sizeOfPole(target, poles, map.period)));
  const f = (values) => {
    const now = map.at(values);
    return now && factorsAt(target, now, weights);
  };
  const values = solvedNumbers(map, f, map.start), at = nearestPole(map.at(values), target, target);
  if (between(at, target) <= PLACED * sizeOfPole(target, poles, map.period)) return { values, at };
  return nearestPlace(map, s, target);
}

// Go down the distance of a pole from the target, by Levenberg's and Marquardt's steps along the ranges of the knobs.
function nearestPlace(map, s, target) {
  let values = map.start, at = s, damping = 1e-3;
  const dot = (u, v) => u.reduce((sum, one, i) => sum + one * v[i], 0), off = (one) => [one.re - target.re, one.im - target.im];
  for (let round = 0; round < DESCENT_ROUNDS && damping < 1e9; round++) {
    const from = at, poleAt = (numbers) => {
      const poles = map.at(numbers);
      return poles && nearestPole(poles, from, target);
    };
    const columns = map.differences((numbers) => {
      const one = poleAt(numbers);
      return one && off(one);
    }, values);
    if (!columns) break;
    const slope = columns.map((column) => dot(column, off(at))), free = [...slope.keys()].filter((i) => {
      const { low, high } = map.knobs[i];
      return slope[i] > 0 ? values[i] > low : values[i] < high;
    });
    if (!free.length) break;
    let next = null;
    for (; !next && damping < 1e9; damping *= 4) {
      const M = new Float64Array(free.length ** 2), lengths = free.map((i) => dot(columns[i], columns[i]));
      free.forEach((i, a) => free.forEach((j, b) => (M[a * free.length + b] = dot(columns[i], columns[j]) + (a === b ? damping * lengths[a] : 0))));
      const step = solveInPlace(M, Float64Array.from(free, (i) => -slope[i]), free.length, 1);
      if (!step) break;
      const tried = map.inside(values.map((one, i) => one + (free.includes(i) ? Math.max(-LONGEST, Math.min(LONGEST, step[free.indexOf(i)])) * map.size(i, one) : 0)));
      const there = poleAt(tried);
      if (there && between(there, target) < between(at, target) * (1 - 1e-12)) next = { tried, there };
    }
    if (!next) break;
    [values, at] = [next.tried, next.there];
    damping = Math.max(1e-12, damping / 20);
  }
  return { values, at };
}

// All knobs put a pole, or a pair, at the target and every other pole stays; else as far on the straight way there as they can.
function heldPlace(map, poles, s, target) {
  const k = [...poles.re.keys()].find((j) => poles.re[j] === s.re && poles.im[j] === s.im), scale = largestOf(poles);
  const to = (share) => ({ re: s.re + share * (target.re - s.re), im: s.im > 0 ? s.im + share * (target.im - s.im) : 0 });
  const wanted = (share) => coefficientsOf(withPoleAt(poles, k, to(share)), scale);
  const coefficients = (values) => {
    const now = map.at(values);
    return now && coefficientsOf(now, scale);
  };
  const off = (values, aim) => coefficients(values)?.map((one, row) => one - aim[row]);
  const placed = (share, start) => {
    const aim = wanted(share), values = solvedNumbers(map, (numbers) => off(numbers, aim), start), left = off(values, aim);
    return left && Math.hypot(...left) <= PLACED * Math.hypot(...aim) ? { share, values } : null;
  };
  let best = { share: 0, values: map.start };
  for (let round = 0; round < HELD_ROUNDS && best.share < 1; round++) {
    const now = coefficients(best.values), columns = now && map.differences(coefficients, best.values);
    const ahead = columns && aheadOf(map, best, (share) => combined(columns, now.map((one, row) => one - wanted(share)[row]))?.x);
    let found = null;
    for (let { share, numbers } = ahead ?? best, tries = 0; ahead && !found && tries < 4; share = (best.share + share) / 2, tries++) {
      found = placed(share, numbers);
    }
    const isOver = !found || found.share - best.share < 1e-9;
    best = found ?? best;
    if (isOver) break;
  }
  return { values: best.values, at: nearestPole(map.at(best.values), to(best.share), to(best.share)) };
}

// How far on the way the knobs come within their ranges, as their differences foretell, and their numbers there.
function aheadOf(map, { share: least, values }, stepTo) {
  const foretold = (share) => {
    const step = stepTo(share);
    return step && values.map((one, i) => one - step[i] * map.size(i, one));
  };
  const isInside = (numbers) => numbers && numbers.every((one, i) => one >= map.knobs[i].low && one <= map.knobs[i].high);
  let [low, high] = [least, 1];
  if (isInside(foretold(1))) low = 1;
  while (high - low > 1e-10) {
    const middle = (low + high) / 2;
    if (isInside(foretold(middle))) low = middle;
    else high = middle;
  }
  return { share: low, numbers: map.inside(foretold(low) ?? values) };
}

// One knob: the point of the pole's own branch of the root locus that is nearest to the target, the first one that is met.
function placeOnLocus(map, s, target) {
  const { low, high, log, value } = map.knobs[0], here = log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  const number = (share) => (share === here ? value : share <= 0 ? low : share >= 1 ? high : log ? low * (high / low) ** share : low + (high - low) * share);
  const look = (share, from) => {
    const poles = map.at([number(share)]), at = poles && nearestPole(poles, from, target);
    return at && { share, at, far: between(at, target) };
  };
  const first = { share: here, at: s, far: between(s, target) };
  let best = first;
  for (const direction of [1, -1]) {
    const found = walkLocus(first, direction, look);
    if (found.far < best.far) best = found;
  }
  return { values: [number(best.share)], at: best.at };
}

// Walk a branch to one side as long as the target comes nearer, and find where it is nearest.
function walkLocus(first, direction, look) {
  let [before, here] = [first, first];
  for (let step = SMALLEST_SHARE; here.share !== (direction > 0 ? 1 : 0); step = Math.min(LARGEST_SHARE, step * LONGER)) {
    const share = Math.min(1, Math.max(0, here.share + direction * step)), next = look(share, here.at);
    if (!next) return here;
    if (!(next.far < here.far)) return nearestOf(before, here, next, look);
    [before, here] = [here, next];
  }
  return here;
}

// The point nearest to the target between two of a branch, with one between that is nearer: by parabolas through the squares
// of the three distances, or where those come no further by golden sections.
function nearestOf(before, best, after, look) {
  const golden = (3 - Math.sqrt(5)) / 2;
  let [a, b] = [before, after], last = Infinity;
  for (let round = 0; round < SECTIONS; round++) {
    const width = Math.abs(b.share - a.share), left = best.share - a.share, right = best.share - b.share;
    const u = left * (best.far ** 2 - b.far ** 2), v = right * (best.far ** 2 - a.far ** 2);
    let share = best.share - (left * u - right * v) / (2 * (u - v));
    if (Math.abs(share - best.share) <= SAME_SHARE) break;
    const isInside = (share - a.share) * (share - b.share) < 0;
    if (!isInside || width > 0.6 * last) share = best.share + golden * ((Math.abs(left) > Math.abs(right) ? a : b).share - best.share);
    last = isInside ? width : Infinity;
    const next = share === best.share ? null : look(share, best.at), isBefore = (share - a.share) * (share - best.share) < 0;
    if (!next || width <= SAME_SHARE) break;
    if (next.far < best.far) [a, b, best] = isBefore ? [a, best, next] : [best, b, next];
    else if (isBefore) a = next;
    else b = next;
  }
  return best;
}
