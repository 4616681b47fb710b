"use strict";

// The figures of a loop of one channel, L = -G: crossovers, margins, and the peaks of S and T. Each is bracketed on a
// grid that holds the frequencies at which a lightly damped pole or zero stands out, and then refined to rounding.

const DEGREES = 180 / Math.PI;
const BANDWIDTH = 10 ** -0.15; // of T at rest, 3 dB less
const TOUCH = 1e-12; // of one: as near as |L| comes to it where it only touches
const BESIDE_NYQUIST = 1 - 1e-6; // where the sign of a number that is zero at Nyquist's frequency is known
const WORTH = 0.7; // of the largest number of a grid: a lower peak cannot be the highest
const WIDE = 1e3, STEP = 10 ** (1 / 6); // how far beyond all roots is looked, and by which steps

class ChannelLoop {
  constructor(system, period, omega, roots) {
    this.response = new LinearResponse(system, period);
    Object.assign(this, { period, D: system.D[0], top: period ? Math.PI / period : Infinity });
    this.omega = searchGrid(omega, [...roots, zerosOf(system)], period);
    const count = this.omega.length;
    for (const name of ["re", "im", "terms"]) this[name] = new Float64Array(count);
    for (let k = 0; k < count; k++) {
      if (!this.at(this.omega[k])) this.lr = this.li = NaN;
      this.re[k] = this.lr;
      this.im[k] = this.li;
      this.terms[k] = this.response.terms[0];
    }
    this.first = this.rises(this.omega[0]) ? { omega: 0, L: Infinity } : this.end(0);
    this.last = period ? this.end(this.top) : { omega: Infinity, L: -this.D };
  }

  // L at a frequency, and its slope by omega; false at a pole.
  at(omega, slope = false) {
    const { response } = this, isFinite = response.at(omega, slope);
    this.lr = -response.re[0];
    this.li = -response.im[0];
    this.dr = -response.dre[0];
    this.di = -response.dim[0];
    return isFinite;
  }

  // L at an end of the axis, where it is real, or infinite.
  end(omega) {
    return { omega, L: this.at(omega) && Math.hypot(this.lr, this.li) < 1e300 ? this.lr : Infinity };
  }

  // Whether |L| grows without an end towards omega = 0, by its slope at a frequency far below all roots but those at zero.
  rises(omega) {
    return !(omega * this.slope(omega, gainSlope) > -0.5);
  }

  // d log L / d omega = (dr + j di) / (lr + j li), times a complex factor a + j b: its real part.
  slope(omega, factor) {
    this.at(omega, true);
    const { lr, li, dr, di } = this, [a, b] = factor(lr, li), size = lr * lr + li * li;
    const qr = (dr * lr + di * li) / size, qi = (di * lr - dr * li) / size;
    return qr * a - qi * b;
  }

  // Where a number of L changes its sign along the grid, refined; `known` says from which size on a sign is sure.
  crossings(value, known = () => 0) {
    const { omega, re, im, terms } = this, found = [];
    for (let k = 0, before = -1; k < omega.length; k++) {
      const here = value(re[k], im[k]);
      if (!(Math.abs(here) > known(terms[k]))) continue;
      if (before >= 0 && here > 0 !== value(re[before], im[before]) > 0) {
        const f = (w) => (this.at(w) ? value(this.lr, this.li) : Infinity);
        found.push(rootBetween(f, omega[before], omega[k], value(re[before], im[before]), here));
      }
      before = k;
    }
    return found;
  }

  // The extremes along the grid of a number of L, each refined by the zero of its slope; `least` is what is worth it.
  peaks(value, factor, least = () => 0) {
    const { omega, re, im } = this, numbers = omega.map((_, k) => value(re[k], im[k])), found = [];
    const floor = least(numbers.reduce((most, one) => (one > most ? one : most), 0));
    for (let k = 1; k < omega.length - 1; k++) {
      if (!(numbers[k] >= numbers[k - 1] && numbers[k] > numbers[k + 1] && numbers[k] >= floor)) continue;
      const slope = (w) => this.slope(w, factor), a = omega[k - 1], b = omega[k + 1], sa = slope(a), sb = slope(b);
      const at = sa > 0 && sb < 0 ? rootBetween(slope, a, b, sa, sb) : omega[k];
      this.at(at);
      found.push({ omega: at, value: value(this.lr, this.li), a, b });
    }
    return found;
  }
}

// The frequencies of the page, those between which roots lie beyond them, and those at which roots stand out.
function searchGrid(omega, roots, period) {
  const hints = roots.map((one) => rootFrequencies(one, period)), sizes = hints.flatMap(({ sizes }) => sizes);
  const top = period ? BESIDE_NYQUIST * Math.PI / period : Infinity, fastest = Math.max(0, ...sizes);
  const slow = Math.min(...sizes.filter((size) => size > 1e-9 * fastest)), numbers = [...omega];
  const low = Math.min(omega[0], slow) / WIDE, high = Math.min(top, WIDE * Math.max(omega[omega.length - 1], fastest));
  for (let w = omega[0] / STEP; w > low; w /= STEP) numbers.push(w);
  for (let w = omega[omega.length - 1] * STEP; w < high; w *= STEP) numbers.push(w);
  if (period) numbers.push(top);
  for (const { around } of hints) numbers.push(...around);
  const sorted = Float64Array.from(numbers).sort();
  return sorted.filter((w, i) => w > 0 && w <= top && (i === 0 || w > sorted[i - 1]));
}

const logGain = (re, im) => Math.log(re * re + im * im);
const gainSlope = () => [1, 0];
const fallSlope = () => [-1, 0];

// All gain crossovers, with their phase margins in degrees, in (-180, 180].
function gainCrossovers(loop) {
  const found = loop.crossings(logGain);
  const highest = loop.omega[loop.omega.length - 1];
  if (!loop.period && Math.abs(loop.D) < 1 && Math.hypot(loop.re.at(-1), loop.im.at(-1)) > 1) {
    const f = (w) => (loop.at(w) ? logGain(loop.lr, loop.li) : NaN);
    let above = highest;
    for (let k = 0; k < 60 && f(above) > 0; k++) above *= 10;
    if (f(above) < 0) found.push(rootBetween(f, above / 10, above));
  }
  for (const [sign, slope] of [[1, gainSlope], [-1, fallSlope]]) { // humps below one and hollows above it
    for (const { omega, value, a, b } of loop.peaks((re, im) => sign * logGain(re, im), slope, () => -2)) {
      const f = (w) => (loop.at(w) ? sign * logGain(loop.lr, loop.li) : NaN), ends = [f(a), f(b)];
      if (!(ends[0] < 0 && ends[1] < 0) || value < -TOUCH) continue;
      loop.at(omega);
      if (value < TOUCH) found.push(omega);
      else if (!found.some((w) => w > a && w < b)) {
        found.push(rootBetween(f, a, omega), rootBetween(f, omega, b));
      }
    }
  }
  for (const { omega, L } of [loop.first, loop.last]) {
    if (Math.abs(Math.abs(L) - 1) < 1e-14 && Number.isFinite(omega)) found.push(omega);
  }
  return found.sort((a, b) => a - b).map((omega) => {
    loop.at(omega);
    const isEnd = omega === 0 || omega === loop.top, phase = Math.atan2(isEnd ? 0 : -loop.li, -loop.lr) * DEGREES;
    return { omega, phase: phase > -180 ? phase : 180 };
  });
}

// All phase crossovers, with the factors of gain -1 / L.
function phaseCrossovers(loop) {
  const sure = (terms) => 8 * loop.response.n * Number.EPSILON * terms;
  const found = loop.crossings((re, im) => im, sure).filter((omega) => loop.at(omega) && loop.lr < 0);
  const rows = found.filter((omega) => {
    loop.at(omega);
    return Math.abs(loop.li) <= 1e-6 * Math.abs(loop.lr); // and no jump through a pole
  }).map((omega) => {
    loop.at(omega);
    return { omega, gain: -1 / loop.lr };
  });
  const ends = [loop.first, loop.last].filter(({ L }) => L < 0 && Number.isFinite(L));
  return [...ends.map(({ omega, L }) => ({ omega, gain: -1 / L })), ...rows].sort((a, b) => a.omega - b.omega);
}

const square = (re, im) => re * re + im * im;
const PEAKS = { // of each: its square by L, the factor of d log L in half the slope of its logarithm, and it at L = infinity
  S: [(re, im) => 1 / square(1 + re, im), (re, im) => quotient(-re, -im, 1 + re, im), 0],
  T: [(re, im) => square(re, im) / square(1 + re, im), (re, im) => quotient(1, 0, 1 + re, im), 1],
  balance: [
    (re, im) => square(1 - re, im) / square(1 + re, im),
    (re, im) => quotient(-2 * re, -2 * im, 1 - re * re + im * im, -2 * re * im), 1,
  ],
};

function quotient(ar, ai, br, bi) {
  const size = br * br + bi * bi;
  return [(ar * br + ai * bi) / size, (ai * br - ar * bi) / size];
}

// The largest of a kind over all frequencies, the ends included.
function highestPeak(loop, kind) {
  const [value, factor, limit] = PEAKS[kind];
  const ends = [loop.first, loop.last].map(({ omega, L }) => ({ omega, value: Number.isFinite(L) ? value(L, 0) : limit }));
  const all = [...ends, ...loop.peaks(value, factor, (most) => WORTH * most)];
  const best = all.reduce((most, one) => (one.value > most.value ? one : most));
  return { gain: Math.sqrt(best.value), omega: best.omega };
}

// The frequency at which T has fallen by 3 dB from what it is at rest; null if it never does.
function bandwidthOf(loop) {
  const [value, , limit] = PEAKS.T, rest = Number.isFinite(loop.first.L) ? value(loop.first.L, 0) : limit;
  const least = rest * BANDWIDTH ** 2, k = loop.omega.findIndex((_, i) => value(loop.re[i], loop.im[i]) < least);
  if (!(rest > 0) || k < 0) return null;
  const f = (w) => (loop.at(w) ? value(loop.lr, loop.li) : limit) - least;
  return rootBetween(f, k ? loop.omega[k - 1] : 0, loop.omega[k]);
}

const orNull = (number) => (Number.isFinite(number) ? number : null);

// The figures of a loop as the page shows them; what does not exist is null.
function marginsOf(loop, stable) {
  const gains = gainCrossovers(loop), phases = phaseCrossovers(loop);
  const shown = { stable, gainCrossovers: gains, phaseCrossovers: phases.filter(({ omega }) => Number.isFinite(omega)) };
  const none = { low: null, high: null, omegaLow: null, omegaHigh: null };
  const empty = { gainMargin: none, phaseMargin: null, omegaPhase: null, delayMargin: null, omegaDelay: null };
  Object.assign(shown, empty, { Ms: null, omegaMs: null, Mt: null, omegaMt: null, bandwidth: null, diskMargin: null });
  if (!stable) return shown;
  const low = phases.filter(({ gain }) => gain < 1).reduce((best, one) => (best && best.gain > one.gain ? best : one), null);
  const high = phases.filter(({ gain }) => gain > 1).reduce((best, one) => (best && best.gain < one.gain ? best : one), null);
  shown.gainMargin = {
    low: low && low.gain, high: high && high.gain, omegaLow: low && orNull(low.omega), omegaHigh: high && orNull(high.omega),
  };
  for (const { omega, phase } of gains) {
    if (shown.phaseMargin === null || Math.abs(phase) < shown.phaseMargin) {
      Object.assign(shown, { phaseMargin: Math.abs(phase), omegaPhase: omega });
    }
    const delay = (phase < 0 ? phase + 360 : phase) / DEGREES / omega;
    if (omega > 0 && (shown.delayMargin === null || delay < shown.delayMargin)) {
      Object.assign(shown, { delayMargin: delay, omegaDelay: omega });
    }
  }
  if (!loop.period && Math.abs(loop.D) > 1) Object.assign(shown, { delayMargin: 0, omegaDelay: null });
  const S = highestPeak(loop, "S"), T = highestPeak(loop, "T"), balance = highestPeak(loop, "balance");
  Object.assign(shown, { Ms: S.gain, omegaMs: orNull(S.omega), Mt: T.gain, omegaMt: orNull(T.omega) });
  return Object.assign(shown, {
    bandwidth: bandwidthOf(loop), diskMargin: { alpha: 2 / balance.gain, omega: orNull(balance.omega) },
  });
}
