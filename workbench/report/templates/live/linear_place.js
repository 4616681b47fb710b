"use strict";

// Poles that a reader drags: which knobs move a pole of the closed loop, whether their numbers follow from its place, and the
// numbers that put it there. All is computed from poles, so that nothing is assumed of how the knobs enter the loop.

const NEAR_BY = 1e-4; // of a number, for differences
const UNIQUE = 30; // condition up to which two knobs move a pole to two sides: columns of equal length, 4 degrees apart
const UNIQUE_ALL = 1e4; // the same of all knobs and all coefficients of the characteristic polynomial
const HOLDS = 1e-5; // of a change of coefficients: what knobs that hold the other poles may leave of it
const MOST_PAIRS = 6; // of knobs that are offered, those that move the pole farthest
const LEAST_SIZE = 1e-3; // of the largest pole: the distance from rest by which motions are measured at least
const NEWTON_ROUNDS = 30;

// The poles of a loop as a function of the numbers of some knobs, each {p, x, low, high, log, share, value}.
class PolesOfKnobs {
  constructor(answers, { p, x, knobs }) {
    Object.assign(this, { answers, p, x, knobs, period: answers.linear.period, start: knobs.map(({ value }) => value), blocked: false });
  }

  // The poles {re, im} at some numbers of the knobs; null where the loop has no linear answer.
  at(values) {
    let inputs = this;
    this.knobs.forEach((knob, i) => {
      if (values[i] !== knob.value) inputs = turnedTo(inputs, knob, values[i]);
    });
    const { whole } = this.answers.systems(inputs.p, inputs.x), poles = whole ? polesOf(whole.closed, whole.n, this.period) : null;
    this.blocked ||= !poles;
    return poles;
  }

  // The same knobs without some.
  only(kept) {
    return new PolesOfKnobs(this.answers, { p: this.p, x: this.x, knobs: kept.map((i) => this.knobs[i]) });
  }

  // The numbers within the ranges of the knobs.
  inside(values) {
    return values.map((value, i) => Math.min(this.knobs[i].high, Math.max(this.knobs[i].low, value)));
  }

  // By how much a number of a knob changes, as one whole.
  size(i, value) {
    const { low, high, log } = this.knobs[i];
    return Math.max(Math.abs(value), log ? 0 : 0.01 * (high - low));
  }

  // The change of the vector f(values) with each knob, for a change by its size: a column a knob; null without an answer.
  differences(f, values) {
    const columns = this.knobs.map((_, i) => {
      const size = this.size(i, values[i]), to = (side) => this.inside(values.map((one, j) => (j === i ? one + side * NEAR_BY * size : one)));
      const [below, above] = [to(-1), to(1)], [a, b] = [f(below), f(above)], width = above[i] - below[i];
      return a && b && a.map((one, row) => (b[row] - one) / width * size);
    });
    return columns.every(Boolean) ? columns : null;
  }
}

// What is measured from: a pole at rest, at zero or of a computer at one.
const distanceOf = ({ re, im }, period) => Math.hypot(period ? re - 1 : re, im);
const largestOf = (poles) => poles.re.reduce((most, re, j) => Math.max(most, Math.hypot(re, poles.im[j])), 0);
const apart = (s, { re, im }, j) => Math.hypot(re[j] - s.re, im[j] - s.im);

// The least distance from rest by which motions are measured.
function sizeOfPole(s, poles, period) {
  return Math.max(distanceOf(s, period), LEAST_SIZE * largestOf(poles));
}

// The product of s - pole over all poles but one, each over a weight: [re, im].
function factorsAt(s, { re, im }, weights, without = -1) {
  let a = 1, b = 0;
  for (let j = 0; j < re.length; j++) {
    if (j === without) continue;
    const c = (s.re - re[j]) / weights[j], d = (s.im - im[j]) / weights[j];
    [a, b] = [a * c - b * d, a * d + b * c];
  }
  return [a, b];
}

// The coefficients of the characteristic polynomial of s / scale, below the highest, which is one.
function coefficientsOf({ re, im }, scale) {
  let row = [[1, 0]];
  for (let j = 0; j < re.length; j++) {
    const a = re[j] / scale, b = im[j] / scale;
    row = [...row, [0, 0]].map(([x, y], k) => {
      const [u, v] = k ? row[k - 1] : [0, 0];
      return [x - (u * a - v * b), y - (u * b + v * a)];
    });
  }
  return row.slice(1).map(([x]) => x);
}

// The poles with one of them, and its conjugate, at another place.
function withPoleAt({ re, im }, k, s) {
  const moved = { re: re.slice(), im: im.slice() };
  const other = { re: re[k], im: -im[k] }, off = (j) => apart(other, { re, im }, j);
  const mate = im[k] ? [...re.keys()].reduce((best, j) => (off(j) < off(best) ? j : best), 0) : k;
  [moved.re[mate], moved.im[mate]] = [s.re, -s.im];
  [moved.re[k], moved.im[k]] = [s.re, s.im];
  return moved;
}

// Columns as a matrix, each divided by a length.
function matrixOf(columns, lengths) {
  const n = columns.length, A = new Float64Array(columns[0].length * n);
  columns.forEach((column, j) => column.forEach((one, i) => (A[i * n + j] = one / lengths[j])));
  return A;
}

// The x that makes columns x - b shortest, and the length that is left; null where a column is zero or not finite.
function combined(columns, b) {
  const lengths = columns.map((one) => Math.hypot(...one));
  if (!lengths.every((length) => length > 0 && length < Infinity)) return null;
  const y = leastSquares(matrixOf(columns, lengths), b, b.length, columns.length, 1e-12);
  const left = b.map((one, row) => one - columns.reduce((sum, column, j) => sum + column[row] / lengths[j] * y[j], 0));
  return { x: Array.from(y, (one, j) => one / lengths[j]), left: Math.hypot(...left) };
}

// The condition of columns of equal length.
function conditionOfColumns(columns) {
  const rows = columns[0].length, { s } = singularValues(matrixOf(columns, columns.map((one) => Math.hypot(...one))), rows, columns.length), size = [...s];
  return Math.max(...size) / Math.min(...size);
}

// The poles on and above the real axis that a knob moves, each with the choices of knobs that place it, the best one first:
// {knobs, holds}, where `knobs` are their places in the list, and `holds` says that the other poles stay.
function movedPoles(map) {
  const poles = map.at(map.start), none = () => [0, 0];
  if (!poles) return [];
  const all = [...poles.re.keys()].filter((k) => poles.im[k] >= 0).map((k) => ({ k, s: { re: poles.re[k], im: poles.im[k] } }));
  const size = all.map(({ s }) => sizeOfPole(s, poles, map.period));
  const weights = all.map(({ s }, i) => poles.re.map((_, j) => Math.max(apart(s, poles, j), 1e-12 * size[i])));
  const slopes = all.map(({ k, s }, i) => factorsAt(s, poles, weights[i], k));
  const f = (values) => {
    const now = map.at(values);
    return now && all.flatMap(({ k, s }, i) => factorsAt(s, now, weights[i].map((one, j) => (j === k ? 1 : one))));
  };
  const columns = map.knobs.map((_, i) => {
    const along = (values) => f(map.start.map((one, j) => (j === i ? values[0] : one)));
    return map.only([i]).differences(along, [map.start[i]])?.[0];
  });
  const motions = all.map((_, i) => columns.map((column) => (column ? quotient(-column[2 * i], -column[2 * i + 1], ...slopes[i]) : none())));
  const moving = map.knobs.map((_, j) => motions.some((one, i) => Math.hypot(...one[j]) > MOVES * size[i]));
  const whole = wholeDesign(map, poles, [...moving.keys()].filter((j) => moving[j]));
  return all.map(({ k, s }, i) => {
    const { pairs, single } = choicesOf(motions[i], s, MOVES * size[i]), { first = [], last = [] } = whole(k, s);
    return { ...s, choices: [...first, ...pairs, ...single, ...last].map((one) => ({ holds: false, ...one })) };
  }).filter(({ choices }) => choices.length);
}

// The pairs of knobs that move a pair of poles to two sides, and the single knobs, by the motions [re, im] with each.
function choicesOf(motions, { im }, least) {
  const far = (i) => Math.hypot(...motions[i]), single = [...motions.keys()].filter((i) => far(i) > least).sort((i, j) => far(j) - far(i));
  const area = ([i, j]) => Math.abs(motions[i][0] * motions[j][1] - motions[i][1] * motions[j][0]);
  const pairs = im > 0 ? single.flatMap((i, n) => single.slice(n + 1).map((j) => [i, j])) : [];
  const unique = pairs.filter((pair) => conditionOfColumns(pair.map((i) => motions[i])) <= UNIQUE).sort((one, two) => area(two) - area(one));
  return { pairs: unique.slice(0, MOST_PAIRS).map((knobs) => ({ knobs })), single: single.map((i) => ({ knobs: [i] })) };
}

// A function that gives the choice of all knobs that move anything, if they move a pole by itself and there is one way to do so:
// first of all where they enter linearly, as the gains of a state feedback, and last where they do not.
function wholeDesign(map, poles, places) {
  if (places.length < 2) return () => ({});
  const own = map.only(places), scale = largestOf(poles);
  const coefficients = (values) => {
    const now = own.at(values);
    return now && coefficientsOf(now, scale);
  };
  const columns = places.length <= poles.re.length ? own.differences(coefficients, own.start) : null;
  const isUnique = columns?.every((one) => Math.hypot(...one) > 0) && conditionOfColumns(columns) <= UNIQUE_ALL;
  const order = isUnique && isStraight(own, coefficients, columns) ? "first" : "last";
  return (k, s) => {
    const ways = s.im > 0 ? [[1, 0], [0, 1]] : [[1, 0]], step = NEAR_BY * (s.im > 0 ? Math.min(s.im, scale) : scale);
    if (!isUnique || places.length <= ways.length) return {};
    const isHeld = ways.every(([a, b]) => {
      const [back, on] = [-1, 1].map((side) => coefficientsOf(withPoleAt(poles, k, { re: s.re + side * step * a, im: s.im + side * step * b }), scale));
      const change = on.map((one, row) => (one - back[row]) / step);
      return combined(columns, change)?.left <= HOLDS * Math.hypot(...change);
    });
    return isHeld ? { [order]: [{ knobs: places, holds: true }] } : {};
  };
}

// True if f changes along all knobs together as its differences say: by a tenth of their sizes, or what is left of their ranges.
function isStraight(map, f, columns) {
  const values = map.inside(map.start.map((one, i) => one + 0.1 * map.size(i, one) * (one < map.knobs[i].high ? 1 : -1)));
  const shares = values.map((one, i) => (one - map.start[i]) / map.size(i, map.start[i])), [before, after] = [f(map.start), f(values)];
  if (!after) return false;
  const change = after.map((one, row) => one - before[row]);
  const off = change.map((one, row) => one - columns.reduce((sum, column, i) => sum + shares[i] * column[row], 0));
  return Math.hypot(...off) <= HOLDS * Math.hypot(...change);
}
