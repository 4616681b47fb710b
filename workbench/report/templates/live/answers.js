"use strict";

// The linear answers of a loop, as they come from the worker, and what pictures and tables show of them, by the rules of
// `loop_gains.py`, `bode_pictures.py`, `nyquist_pictures.py` and `pole_maps.py`. All numbers are the worker's own: here
// they become decibels, degrees, the gains of single channels, circles and ranges.

const GAIN_DEPTH = 160; // decibels below the highest gain, at which a panel ends
const PHASE_TIE = 10; // degrees below 180, from which on a first phase is taken as -180
const LEAST_REACH = 2, MOST_REACH = 20; // of a Nyquist plot that is cut by itself
const WHOLE_REACH = 3; // times that reach: a curve that goes no farther is not cut
const BEYOND_REACH = 4; // times the reach: what is drawn of a curve
const HEAD_PLACES = [0.35, 0.7]; // of the length of a curve: where its arrowheads are
const CIRCLE_POINTS = 120;
const PALE_QUANTITIES = new Set([ // of an earlier run, or of a setting that is held
  "magnitude", "phase", "magnitude of S", "magnitude of T", "imaginary part", "poles of the closed loop",
]);

const degrees = (angle) => (angle * 180) / Math.PI;
const decibelsOf = (size) => (size > 0 ? 20 * Math.log10(size) : NaN);

// The quotient a / b of complex numbers [re, im], without an overflow on the way.
function quotient([ar, ai], [br, bi]) {
  const scale = Math.max(Math.abs(br), Math.abs(bi)), r = br / scale, i = bi / scale, size = scale * (r * r + i * i);
  return [(ar * r + ai * i) / size, (ai * r - ar * i) / size];
}

// The solution of A x = b for complex numbers, by elimination with pivots; both are overwritten.
function solveComplex(A, b) {
  const n = b.length;
  for (let k = 0; k < n; k++) {
    let pivot = k;
    for (let i = k + 1; i < n; i++) if (Math.hypot(...A[i][k]) > Math.hypot(...A[pivot][k])) pivot = i;
    [A[k], A[pivot], b[k], b[pivot]] = [A[pivot], A[k], b[pivot], b[k]];
    for (let i = k + 1; i < n; i++) {
      const factor = quotient(A[i][k], A[k][k]);
      for (let j = k; j < n; j++) A[i][j] = minusProduct(A[i][j], factor, A[k][j]);
      b[i] = minusProduct(b[i], factor, b[k]);
    }
  }
  for (let k = n - 1; k >= 0; k--) {
    for (let j = k + 1; j < n; j++) b[k] = minusProduct(b[k], A[k][j], b[j]);
    b[k] = quotient(b[k], A[k][k]);
  }
  return b;
}

// c - a b for complex numbers.
function minusProduct([cr, ci], [ar, ai], [br, bi]) {
  return [cr - (ar * br - ai * bi), ci - (ar * bi + ai * br)];
}

// The gain of channel i with the loop closed at the others, from the entries L(row, column) of n channels.
function channelGain(L, n, i) {
  if (n === 1) return L(0, 0);
  const rest = [...Array(n).keys()].filter((k) => k !== i);
  const inner = rest.map((row) => rest.map((column) => {
    const [re, im] = L(row, column);
    return [re + Number(row === column), im];
  }));
  const across = solveComplex(inner, rest.map((row) => L(row, i)));
  return rest.reduce((sum, column, k) => minusProduct(sum, L(i, column), across[k]), L(i, i));
}

// The phase in degrees without jumps, by the rule of `phases` in frequency_axis.py.
function phasesOf(omega, re, im) {
  const phase = new Float64Array(omega.length).fill(NaN);
  const held = [...omega.keys()].filter((k) => Number.isFinite(re[k] + im[k]) && (re[k] || im[k]));
  if (!held.length) return phase;
  let last = NaN, turned = 0;
  for (const k of held) {
    const angle = degrees(Math.atan2(im[k], re[k]));
    if (last === last) turned -= 360 * Math.round((angle - last) / 360);
    last = angle;
    phase[k] = angle + turned;
  }
  const [first, second] = held, size = (k) => Math.hypot(re[k], im[k]);
  const slope = second === undefined ? 0 : Math.round(Math.log(size(second) / size(first)) / Math.log(omega[second] / omega[first]));
  const turns = Math.floor((phase[first] - 90 * slope + 180 + PHASE_TIE) / 360);
  for (const k of held) phase[k] -= 360 * turns;
  return phase;
}

// The numbers of a curve at a frequency, on the straight line over its logarithm; NaN outside.
function betweenFrequencies(omega, numbers, at) {
  const place = omega.findIndex((one) => one >= at);
  if (place < 0 || at < omega[0]) return NaN;
  if (place === 0) return numbers[0];
  const share = Math.log(at / omega[place - 1]) / Math.log(omega[place] / omega[place - 1]);
  return numbers[place - 1] + share * (numbers[place] - numbers[place - 1]);
}

// The linear answers of a loop with some numbers.
class LoopAnswer {
  constructor(answer, { channels, period }) {
    Object.assign(this, { ...answer, count: channels.length, period, known: new Map() });
  }

  // What is worked out once.
  once(key, make) {
    if (!this.known.has(key)) this.known.set(key, make());
    return this.known.get(key);
  }

  // The gain {re, im} of a channel over the frequencies, with the loop closed at the others.
  gain(channel) {
    return this.once(`gain ${channel}`, () => {
      const { omega, L, count } = this, re = new Float64Array(omega.length), im = new Float64Array(omega.length);
      for (let k = 0; k < omega.length; k++) {
        const entry = (row, column) => {
          const place = (k * count + row) * count + column;
          return [L.re[place], L.im[place]];
        };
        [re[k], im[k]] = channelGain(entry, count, channel);
      }
      return { re, im };
    });
  }

  // The decibels of L, S or T of a channel.
  magnitude(channel, of) {
    return this.once(`magnitude ${of} ${channel}`, () => {
      const { re, im } = this.gain(channel);
      return re.map((x, k) => {
        const L = Math.hypot(x, im[k]), away = Math.hypot(1 + x, im[k]);
        return decibelsOf(of === "L" ? L : of === "S" ? 1 / away : L / away);
      });
    });
  }

  phase(channel) {
    const { re, im } = this.gain(channel);
    return this.once(`phase ${channel}`, () => phasesOf(this.omega, re, im));
  }

  // The distance from zero up to which Nyquist curves of some channels are drawn.
  reach(channels) {
    let largest = 0, least = LEAST_REACH;
    for (const channel of channels) {
      const { re, im } = this.gain(channel);
      re.forEach((x, k) => {
        largest = Math.max(largest, Math.hypot(x, im[k]));
        if (!k || !(im[k - 1] * im[k] < 0)) return;
        const at = re[k - 1] + (im[k - 1] / (im[k - 1] - im[k])) * (x - re[k - 1]);
        if (at < 0 && at > -MOST_REACH) least = Math.max(least, -1.3 * at);
      });
    }
    return largest <= WHOLE_REACH * least ? largest : least;
  }

  // The crossovers of a channel that lie within the frequencies: [frequency, where a line begins, where it ends].
  crossovers(channel, of) {
    const { omega } = this, margins = this.margins?.[channel], inside = (row) => row.omega >= omega[0] && row.omega <= omega.at(-1);
    if (!margins) return [];
    if (of === "gain margins") {
      return margins.phaseCrossovers.filter(inside).map((row) => [row.omega, 0, -decibelsOf(row.gain)]);
    }
    return margins.gainCrossovers.filter(inside).map((row) => {
      const drawn = betweenFrequencies(omega, this.phase(channel), row.omega) - row.phase;
      const base = 360 * Math.round((drawn + 180) / 360) - 180;
      return [row.omega, base, base + row.phase];
    }).filter(([, , end]) => Number.isFinite(end));
  }

  // The circles that the curve of a single channel touches, as {x, y}.
  circle(of) {
    const Ms = this.margins?.[0]?.Ms, alpha = this.diskMargin?.alpha, none = Number.isFinite(alpha) && alpha < 2;
    if (of === "circle of Ms") return Number.isFinite(Ms) ? circlePoints(-1, 1 / Ms) : circlePoints(0, NaN);
    if (!none) return circlePoints(0, NaN);
    const far = -(2 + alpha) / (2 - alpha), near = -(2 - alpha) / (2 + alpha);
    return circlePoints((far + near) / 2, (near - far) / 2);
  }

  // The Nyquist curve of a channel, or with the scale -1 its mirror image, as far as it is drawn.
  nyquist(channel, scale, reach) {
    const { re, im } = this.gain(channel), far = (k) => !(Math.hypot(re[k], im[k]) <= BEYOND_REACH * reach);
    return { x: re.map((x, k) => (far(k) ? 0 : x)), y: im.map((y, k) => (far(k) ? NaN : scale * y)) };
  }

  // The arrowheads on a Nyquist curve, or on its mirror image: {x, y, u, v}.
  heads(channel, scale, reach) {
    const { re, im } = this.gain(channel), seen = [...re.keys()].filter((k) => Math.hypot(re[k], im[k]) <= reach);
    const heads = { x: [], y: [], u: [], v: [] };
    if (seen.length < 3) return heads;
    const length = [0];
    for (let k = seen[0] + 1; k <= seen.at(-1); k++) length.push(length.at(-1) + Math.hypot(re[k] - re[k - 1], im[k] - im[k - 1]));
    if (!(length.at(-1) > 0.15 * reach)) return heads;
    for (const share of HEAD_PLACES) {
      const k = seen[0] + Math.max(1, length.findIndex((one) => one >= share * length.at(-1)));
      heads.x.push(re[k]);
      heads.y.push(scale * im[k]);
      heads.u.push(scale * (re[k] - re[k - 1])); // towards higher frequencies; of the mirror image towards zero
      heads.v.push(im[k] - im[k - 1]);
    }
    return heads;
  }

  // The numbers of a mark: a curve {x, y}, points {x, y}, or arrows {x, y, u, v}; `channels` share its `panel`.
  numbers({ quantity, channel, scale }, look, channels, panel) {
    const { omega } = this;
    if (quantity === "magnitude") return { x: omega, y: this.magnitude(channel, "L") };
    if (quantity === "magnitude of S" || quantity === "magnitude of T") {
      return { x: omega, y: this.magnitude(channel, quantity.at(-1)) };
    }
    if (quantity === "phase") return { x: omega, y: this.phase(channel) };
    if (quantity === "imaginary part") {
      const { x, y } = panel, printed = Math.max(...[x.low, x.high, y.low, y.high].map(Math.abs)); // may show more
      return this.nyquist(channel, scale, Math.max(this.reach(channels), printed));
    }
    if (quantity === "arrowheads") return this.heads(channel, scale, this.reach(channels));
    if (quantity.startsWith("circle")) return this.circle(quantity);
    if (quantity.startsWith("poles")) {
      const { re, im } = quantity === "poles of the closed loop" ? this.poles : this.openPoles;
      return { x: re, y: im };
    }
    const rows = this.crossovers(channel, quantity);
    if (look === "points") return { x: rows.map(([x]) => x), y: rows.map(([, , end]) => end) };
    return { x: Float64Array.from(rows.flatMap(([x]) => [x, x, x])), y: Float64Array.from(rows.flatMap(([, base, end]) => [base, end, NaN])) };
  }

  // The ranges {x, y} that a panel needs for marks of some quantities and channels; null for what says nothing of one.
  range(quantities, channels) {
    const has = (start) => quantities.some((one) => one.startsWith(start));
    if (has("imaginary part")) return this.nyquistRange(channels);
    if (has("poles")) return this.poleRange();
    const curves = channels.flatMap((i) => (has("phase") ? [this.phase(i)] : has("magnitude of") ? ["S", "T"].map((of) => this.magnitude(i, of)) : [this.magnitude(i, "L")]));
    const held = curves.flatMap((curve) => [...curve].filter(Number.isFinite)), high = Math.max(...held);
    const low = Math.min(...held);
    if (has("phase")) return { x: [Infinity, -Infinity], y: [low, high] };
    return { x: [Infinity, -Infinity], y: [Math.max(low, high - GAIN_DEPTH), high] };
  }

  nyquistRange(channels) {
    const reach = this.reach(channels);
    let low = -1.35, high = 0.15, up = 0.6;
    for (const channel of channels) {
      const { re, im } = this.gain(channel);
      re.forEach((x, k) => {
        if (!(Math.hypot(x, im[k]) <= reach)) return;
        [low, high, up] = [Math.min(low, x), Math.max(high, x), Math.max(up, Math.abs(im[k]))];
      });
    }
    const room = 0.06 * Math.max(high - low, 2 * up);
    return { x: [low - room, high + room], y: [-up - room, up + room] };
  }

  poleRange() {
    const re = [...this.poles.re, ...this.openPoles.re], im = [...this.poles.im, ...this.openPoles.im];
    const near = this.period !== null && Math.max(...re.map((x, k) => Math.hypot(x - 1, im[k]))) < 0.25;
    const anchors = this.period === null ? [0] : near ? [1] : [-1, 1];
    const across = [...re, ...anchors], up = Math.max(...im.map(Math.abs), this.period !== null && !near ? 1 : 0);
    const low = Math.min(...across), high = Math.max(...across), size = Math.max(high - low, 2 * up, 1e-12);
    const room = 0.12 * size, top = Math.max(up, 0.25 * size);
    return { x: [low - room, high + room], y: [-top - room, top + room] };
  }

  // The number of a cell of a table, or the words in its place.
  value({ quantity, channel }) {
    if (!this.rests) return "no answer";
    if (quantity === "largest real part of a pole") return this.poles.re.length ? Math.max(...this.poles.re) : "none";
    if (quantity === "largest pole, absolute value") {
      return this.poles.re.length ? Math.max(...this.poles.re.map((x, k) => Math.hypot(x, this.poles.im[k]))) : "none";
    }
    if (quantity === "least damping of a pole") return leastDamping(this.poles, this.period);
    if (quantity === "disk margin") return numberOr(this.diskMargin?.alpha, "unstable");
    const margins = this.margins?.[channel];
    if (!margins) return "not known";
    if (!margins.stable) return "unstable";
    const { gainMargin, phaseMargin, delayMargin, Ms, Mt } = margins;
    const factors = { "gain margin": gainMargin?.high, "gain may fall by": 1 / gainMargin?.low };
    if (quantity in factors) return numberOr(inDecibels(factors[quantity]), "no limit");
    const numbers = { "phase margin": phaseMargin, "delay margin": delayMargin, Ms, Mt };
    return numberOr(numbers[quantity], "no limit");
  }
}

function numberOr(value, words) {
  return Number.isFinite(value) ? value : words;
}

// A factor in decibels, null where there is none.
function inDecibels(factor) {
  return Number.isFinite(factor) && factor > 0 ? decibelsOf(factor) : null;
}

// The least -Re(s) / |s| of poles, of those of a computer after s = log(z) / period.
function leastDamping({ re, im }, period) {
  let least = Infinity;
  re.forEach((x, k) => {
    const size = Math.hypot(x, im[k]);
    if (!size) return;
    const real = period === null ? x : Math.log(size), imaginary = period === null ? im[k] : Math.atan2(im[k], x);
    const damping = -real / Math.hypot(real, imaginary);
    if (damping < least) least = damping;
  });
  return Number.isFinite(least) ? least : "none";
}

// The points of a circle about a real number, from its start to its start.
function circlePoints(middle, radius) {
  const angle = (_, k) => (2 * Math.PI * k) / CIRCLE_POINTS, each = { length: CIRCLE_POINTS + 1 };
  const x = Float64Array.from(each, (one, k) => middle + radius * Math.cos(angle(one, k)));
  const y = Float64Array.from(each, (one, k) => radius * Math.sin(angle(one, k)));
  return radius === radius ? { x, y } : { x: Float64Array.of(0), y: Float64Array.of(NaN) };
}

// What a figure shows of linear answers. `links` are its marks, `plate` its plate, and `shown` lists {answers, kind,
// label}: by loops those of now (kind "now"), and pale ones. Gives curves, pale curves, sets of points and arrows, and
// the ranges of panels; `refused` is a sentence where a loop has no answer now.
function linearDrawing(links, plate, shown) {
  const drawing = { curves: [], pale: [], sets: [], planes: new Map(), refused: "" };
  for (const { answers, kind, label } of shown) {
    for (const link of links) {
      const answer = answers.get(link.loop);
      if (!answer) continue;
      if (!answer.rests) {
        if (kind === "now") drawing.refused = answer.reason;
        continue;
      }
      addMark(drawing, link, links, plate, answer, kind, label);
    }
  }
  return drawing;
}

function addMark(drawing, link, links, plate, answer, kind, label) {
  const { figure, panel, series, loop } = link, beside = links.filter((one) => one.panel === panel && one.loop === loop);
  const channels = [...new Set(beside.map((one) => one.channel))], { look } = plate.panels[panel].series[series];
  const make = () => answer.numbers(link, look, channels, plate.panels[panel]);
  if (kind !== "now" && !(PALE_QUANTITIES.has(link.quantity) && link.scale > 0)) return;
  const numbers = answer.once(`${figure} ${panel} ${series}`, make);
  const mark = { panel, series, kind, label, ...numbers };
  if (["points", "arrows"].includes(look)) drawing.sets.push(mark);
  else drawing[kind === "now" ? "curves" : "pale"].push(mark);
  const ranges = drawing.planes.get(panel) ?? { ranges: new Set(), period: answer.period, poles: link.quantity.startsWith("poles") };
  ranges.ranges.add(answer.once(`range ${figure} ${panel}`, () => answer.range(beside.map((one) => one.quantity), channels)));
  drawing.planes.set(panel, ranges);
}
