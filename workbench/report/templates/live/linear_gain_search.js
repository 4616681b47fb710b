"use strict";

// The search for the largest ki: numbers of k so near to one another that the limits, a little wider, are met at one of them if
// the limits themselves are met between; the best of them are halved. Then the gains are refined with the frequencies.

const FIRST_SLACK = 0.1, LAST_SLACK = 5e-4; // between neighbouring numbers of k, as a share
const LOCAL_SLACK = 0.015; // from which on neighbours have one largest ki, if one of them meets the limits
const NEARLY = 1e-5; // of k
const WIDEST = 0.3, LOOKS = 4; // of k about a start that is forbidden, and places there on each side
const INNER = 1e-4; // of the largest k: smaller ones are as good as zero
const GOLDEN = (3 - Math.sqrt(5)) / 2;
const MOST_NODES = 2000, MOST_MOVES = 12;

// Numbers of k from `low` to `high` with the share by which each stands for its neighbours, or the shift about zero.
function gainNodes(low, high) {
  const most = Math.max(Math.abs(low), Math.abs(high)), inner = INNER * most, ratio = 1 + 2 * FIRST_SLACK, nodes = [];
  const add = (k, shift = 0) => k >= low && k <= high && nodes.push({ k, slack: shift ? 0 : FIRST_SLACK, shift });
  for (let k = inner; k < most * ratio; k *= ratio) {
    add(k);
    add(-k);
  }
  add(0, inner);
  for (const k of [low, high]) if (k !== 0) nodes.push({ k, slack: FIRST_SLACK, shift: 0 });
  return nodes;
}

// The same numbers halved: each stands for half as much.
function halvedNodes(nodes, low, high) {
  return nodes.flatMap(({ k, slack, shift }) => {
    const halves = slack ? [k * (1 - slack / 2), k * (1 + slack / 2)] : [-shift / 2, 0, shift / 2];
    const inside = halves.filter((one) => one >= low && one <= high), all = inside.length < halves.length ? [...inside, k] : inside;
    return all.map((one) => ({ k: one, slack: slack / 2, shift: slack ? 0 : shift / 2 }));
  });
}

// The nodes in groups of neighbours.
function neighbours(nodes) {
  const groups = [];
  for (const node of nodes.sort((a, b) => a.k - b.k)) {
    const last = groups.at(-1)?.at(-1), width = 3 * node.slack * Math.abs(node.k) + 2 * node.shift;
    if (last && node.k - last.k <= width) groups.at(-1).push(node);
    else groups.push([node]);
  }
  return groups;
}

// The best gains {k, ki} of a plane in a range of k, nearly; null where none meets the limits. `least` is a ki to be exceeded.
function searchedGains(plane, bounds, count, least = -Infinity) {
  const [low, high] = bounds.range, seen = new Map();
  let nodes = gainNodes(low, high), best = null, floor = least;
  const take = (one) => one.ki > floor && ([best, floor] = [one, one.ki]);
  for (let slack = FIRST_SLACK; nodes.length && nodes.length < MOST_NODES && slack > LAST_SLACK; slack /= 2) {
    for (const node of nodes) {
      const { floor: own, cap } = bounds.at(node.k), wide = { floor: Math.max(floor, own / (1 + slack)), cap: cap * (1 + slack) };
      node.bound = plane.top(node.k, wide, count.asks, node.slack, node.shift);
      if (!(node.bound > floor)) continue;
      if (!seen.has(node.k)) seen.set(node.k, plane.top(node.k, { floor: own, cap }, count.asks));
      take({ k: node.k, ki: seen.get(node.k) });
    }
    nodes = nodes.filter(({ bound }) => bound > floor);
    for (const group of slack <= LOCAL_SLACK ? neighbours(nodes) : []) {
      const [first, last] = [group[0], group.at(-1)], reach = (node) => node.shift + node.slack * Math.abs(node.k);
      const inside = [...seen].filter(([k, ki]) => ki > 0 && k >= first.k - reach(first) && k <= last.k + reach(last));
      if (!inside.length) continue; // no number meets the limits yet: halve on
      const [k] = inside.reduce((most, one) => (one[1] > most[1] ? one : most));
      take(refinedGains(plane, bounds, count, { k }, 4 * slack, NEARLY));
      for (const node of group) node.bound = -Infinity;
    }
    nodes = halvedNodes(nodes.filter(({ bound }) => bound > floor), low, high);
  }
  return best;
}

// The number between a and b at which f is largest, from `m` between them on, by golden sections to `near`; f may be -Infinity
// where it does not exist. Gives {at, value}.
function largestBetween(f, a, m, b, near, fm = f(m)) {
  for (let round = 0; round < 80 && b - a > near; round++) {
    const right = b - m > m - a, x = right ? m + GOLDEN * (b - m) : m - GOLDEN * (m - a), fx = f(x);
    if (fx > fm) {
      if (right) a = m;
      else b = m;
      [m, fm] = [x, fx];
    } else if (right) b = x;
    else a = x;
  }
  return { at: m, value: fm };
}

// The k about gains with the largest ki, as {k, ki}: within a share of k, or beyond it while ki grows there.
function refinedGains(plane, bounds, count, { k }, share, near) {
  const [low, high] = bounds.range, size = Math.max(Math.abs(k), INNER * Math.max(Math.abs(low), Math.abs(high)));
  const f = (one) => plane.top(one, bounds.at(one), count.asks);
  let best = { at: k, value: f(k) };
  for (let wide = share; best.value === -Infinity && wide < WIDEST; wide *= 2) { // frequencies that are new may forbid the start
    for (let i = -LOOKS; i <= LOOKS; i++) {
      const at = Math.min(high, Math.max(low, k + (i / LOOKS) * wide * size)), value = f(at);
      if (value > best.value) best = { at, value };
    }
  }
  for (let round = 0; round < MOST_MOVES; round++) {
    const width = share * size, a = Math.max(low, best.at - width), b = Math.min(high, best.at + width);
    for (const end of [a, b]) {
      const value = f(end);
      if (value > best.value) best = { at: end, value };
    }
    best = largestBetween(f, a, best.at, b, near * size, best.value);
    const inside = [a, b].every((end) => end === low || end === high || Math.abs(best.at - end) > 0.01 * width);
    if (inside) break;
  }
  return { k: best.at, ki: best.value };
}
