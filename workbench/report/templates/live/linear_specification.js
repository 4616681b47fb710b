"use strict";

// A specification that a reader turns: the PI, or with Kd the PID, of the largest Ki with |S| <= Ms and |T| <= Mt within the ranges
// of its knobs. The poles of the loop and its own margins have the last word.

const ROUNDS = 14; // of gains and the frequencies at which they come too near to a limit
const TOUCHES = 1e-6; // of a limit: how far the gains may be beyond it
const NEAR_LIMIT = 1.1; // of a limit: peaks that are looked at
const BESIDE = [-0.3, -0.1, 0, 0.1, 0.3]; // of the distance of two frequencies: what is looked at about a peak
const INSIDE = 2e-6; // of a limit: by how much the search stays within it, so that the margins of the loop do
const AROUND_START = 0.02; // of k: the first look about gains
const DERIVATIVES = 6; // numbers kd from which the search may begin
const FINELY = 1e-7; // of k
const SLIGHTLY = 1e-5, SECTIONED = 0.02; // of k, and of the range of kd about its best number
const NEXT_TO_ZERO = 0.01; // of the range of kd
const CLIMBS = 30, GROWS = 1e-4; // steps of three gains, and the share by which ki grows at least
const AT_END = 1e-6; // of the range of a knob

// The ranges of (k, ki) in the plane, for gains with a sign.
class GainBounds {
  constructor({ k, ki }, rho, sign) {
    const turned = ({ low, high }) => (sign > 0 ? [low, high] : [-high, -low]);
    Object.assign(this, { rho, k: turned(k) });
    const [low, high] = turned(ki);
    Object.assign(this, { floor: Math.max(0, low), cap: high });
    this.range = [this.k[0] + rho * Math.max(0, high), this.k[1] + rho * this.floor];
  }

  // The least and the largest ki at a place k + rho ki of the plane.
  at(place) {
    const { floor, cap, rho, k: [low, high] } = this;
    if (!rho) return { floor, cap };
    return { floor: Math.max(floor, (place - low) / rho), cap: Math.min(cap, (place - high) / rho) };
  }
}

class Specification {
  constructor(law, limits, sign) {
    Object.assign(this, { law, limits, sign, bounds: new GainBounds(law.knobs, law.rho, sign) });
    this.count = new StabilityCount((place, ki, kd) => law.unstable(this.gains({ k: place, ki, kd })));
  }

  // What the knobs are at a place of the plane.
  gains({ k, ki, kd }) {
    return [k - this.law.rho * ki, ki, kd].map((one) => this.sign * one);
  }

  plane(kd) {
    return new GainPlane(this.law.rows, kd, this.limits, this.sign);
  }

  // The gains of the largest ki: {k, ki, kd}; null where none in the ranges meets the limits.
  best() {
    for (let round = 0; round < 3; round++) {
      const start = this.start(), found = start && this.settled(start);
      if (!start || found) return found ?? null;
    }
    return null;
  }

  // The best gains on the frequencies as they are: with Kd as small as may be, and where there are none, with more of it.
  start() {
    for (const kd of this.derivatives()) {
      const found = searchedGains(this.plane(kd), this.bounds, this.count);
      if (found) return { ...found, kd };
    }
    return null;
  }

  // The numbers kd from which the search may begin.
  derivatives() {
    const [low, high] = this.derivativeRange, most = Math.max(Math.abs(low), Math.abs(high));
    const all = Array.from({ length: DERIVATIVES }, (_, i) => most * 3 ** -i).flatMap((one) => [one, -one]);
    return [...new Set([low, high, 0, ...all])].filter((one) => one >= low && one <= high).sort((a, b) => Math.abs(a) - Math.abs(b));
  }

  get derivativeRange() {
    const { law: { knobs: { kd } }, sign } = this;
    if (!kd) return [0, 0];
    return sign > 0 ? [kd.low, kd.high] : [-kd.high, -kd.low];
  }

  // The best gains about others, with the frequencies at which they would be beyond a limit; null where there are none.
  settled(start) {
    const [low, high] = this.derivativeRange;
    let best = { ...start }, share = AROUND_START;
    for (let round = 0; round < ROUNDS; round++) {
      if (low < high && !round) best = this.climbed(best);
      if (low < high) best = this.refined(best, share);
      else best = { kd: best.kd, ...refinedGains(this.plane(best.kd), this.bounds, this.count, best, share, FINELY) };
      if (!(best.ki > 0)) return null;
      const { worst, omegas } = this.touched(best);
      if (worst >= 1 - TOUCHES) return best;
      this.law.insert(omegas);
      share = Math.max(1e-3, share / 3);
    }
    return best;
  }

  // The gains about some with the largest ki, with kd within a share of itself, or beyond it while ki grows there.
  refined(start, share) {
    const { bounds, count } = this, [low, high] = this.derivativeRange, width = share * Math.abs(start.kd) || share * NEXT_TO_ZERO * (high - low);
    let { k } = start;
    const f = (kd) => {
      const found = refinedGains(this.plane(kd), bounds, count, { k }, share, SLIGHTLY);
      if (found.ki > 0) k = found.k;
      return found.ki;
    };
    let best = { at: start.kd, value: f(start.kd) };
    for (let round = 0; round < MOST_MOVES; round++) {
      const a = Math.max(low, best.at - width), b = Math.min(high, best.at + width);
      for (const end of [a, b]) {
        const value = f(end);
        if (value > best.value) best = { at: end, value };
      }
      if (a < best.at && best.at < b) best = largestBetween(f, a, best.at, b, width * SECTIONED, best.value);
      if ([a, b].every((end) => best.at !== end || end === low || end === high)) break;
    }
    return { kd: best.at, ...refinedGains(this.plane(best.at), bounds, count, { k }, share, FINELY) };
  }

  // Better gains from some on, all three at once: discs are replaced by half planes that touch them, which leaves a linear program,
  // until ki grows no more (Hast, Astrom, Bernhardsson and Boyd 2013, European Control Conference).
  climbed(start) {
    let best = start;
    for (let round = 0; round < CLIMBS; round++) {
      const next = this.linearStep(best);
      if (!next) break;
      const grown = next.ki / best.ki - 1;
      best = next;
      if (!(grown > GROWS)) break;
    }
    return best;
  }

  // The gains of the largest ki in front of the half planes that touch the discs where they are seen from some gains.
  linearStep({ k, ki, kd }) {
    const { bounds, law: { rows, rho, most }, limits: { Ms, Mt }, sign } = this, planes = [], scale = [most.k, most.ki, most.kd];
    const far = (Mt * Mt) / (Mt * Mt - 1), wide = Mt / (Mt * Mt - 1), kinds = Number.isFinite(Mt) ? [[1, 1 / Ms], [far, wide]] : [[1, 1 / Ms]];
    for (const { w, gr, gi, er, ei, sr, si } of rows) {
      for (const [times, radius] of kinds) {
        const cr = sign * (er + times * gr), ci = sign * (ei + times * gi), re = k + cr + kd * sr, im = ci - ki / w + kd * si;
        const size = Math.sqrt(re * re + im * im), r = radius * Math.sqrt(gr * gr + gi * gi), ur = re / size, ui = im / size;
        const a = [ur * scale[0], (-ui / w) * scale[1], (ur * sr + ui * si) * scale[2]], b = r - ur * cr - ui * ci;
        if (Math.abs(a[0]) + Math.abs(a[1]) + Math.abs(a[2]) > -b) planes.push({ a, b, near: size / r });
      }
    }
    planes.sort((one, other) => one.near - other.near);
    const [low, high] = bounds.k, [least, largest] = this.derivativeRange;
    if (rho) planes.unshift({ a: [scale[0], -rho * scale[1], 0], b: low }, { a: [-scale[0], rho * scale[1], 0], b: -high });
    const ends = [[bounds.range[0], bounds.floor, least], [bounds.range[1], bounds.cap, largest]].map((end) => end.map((one, i) => one / scale[i]));
    const z = linearOptimum([0, 1, 0], planes, ...ends)?.map((one, i) => one * scale[i]);
    return z ? { k: z[0], ki: z[1], kd: z[2] } : null;
  }

  // The share of the distance from -1 that the limits ask for, at a frequency and of S or T.
  distance({ w, gr, gi, er, ei, sr, si }, { k, ki, kd }, kind) {
    const { sign, limits } = this, re = k + sign * er + kd * sr, im = -ki / w + sign * ei + kd * si;
    const far = Math.hypot(re + sign * gr, im + sign * gi);
    return kind ? (far * limits.Mt) / Math.hypot(re, im) : (far * limits.Ms) / Math.hypot(gr, gi);
  }

  // The least share, and the frequencies of all small ones.
  touched(gains) {
    const { rows } = this.law, omegas = [];
    let worst = Infinity;
    for (const kind of Number.isFinite(this.limits.Mt) ? [0, 1] : [0]) {
      const shares = rows.map((row) => this.distance(row, gains, kind));
      for (let i = 1; i < rows.length - 1; i++) {
        if (!(shares[i] < NEAR_LIMIT && shares[i] <= shares[i - 1] && shares[i] < shares[i + 1])) continue;
        const f = (logarithm) => {
          const row = this.law.row(Math.exp(logarithm));
          return row ? -this.distance(row, gains, kind) : -Infinity;
        };
        const { at, value } = largestBetween(f, ...[i - 1, i, i + 1].map((j) => Math.log(rows[j].omega)), 1e-7, -shares[i]);
        worst = Math.min(worst, -value);
        const width = Math.log(rows[i + 1].omega / rows[i - 1].omega) / 2;
        omegas.push(...BESIDE.map((share) => Math.exp(at + share * width)));
      }
    }
    return { worst, omegas };
  }

  // Of gains with ki at its end, those with k in the middle of what then is allowed.
  centred({ k, ki, kd }) {
    const { bounds: { cap, range }, law: { rho } } = this, plane = this.plane(kd), last = cap * (1 - 1e-9);
    if (!(ki >= last)) return { k, ki, kd };
    const isFree = (one) => plane.top(one, this.bounds.at(one), this.count.asks) >= last;
    const [low, high] = range.map((end) => {
      let [inside, outside] = [k, end];
      for (let round = 0; round < 30 && !isFree(outside) && Math.abs(outside - inside) > 1e-3 * Math.abs(k); round++) {
        const middle = (inside + outside) / 2;
        if (isFree(middle)) inside = middle;
        else outside = middle;
      }
      return isFree(outside) ? outside : inside;
    });
    return { k: (low + high) / 2, ki, kd };
  }
}

// The reply to a turned specification: the numbers of the knobs {k, ki, kd}, the knobs that stand at an end of their range, and the
// margins of the loop with them; or a reason, in a word, or as the loop says it.
function specifiedGains(answers, { p, x, channel, gains: [k, ki, kd], Ms, Mt }) {
  const began = performance.now(), law = new LawOfKnobs(answers, { p, x, channel }, { k, ki, kd: kd ?? null }, { Ms, Mt });
  if (law.reason) return { reason: law.reason };
  const signs = ki.low >= 0 ? [1] : ki.high <= 0 ? [-1] : ki.value < 0 ? [-1, 1] : [1, -1];
  let isFound = false;
  for (const sign of signs) {
    const specification = new Specification(law, { Ms: Ms * (1 - INSIDE), Mt: Mt * (1 - INSIDE) }, sign);
    let found = specification.best();
    isFound ||= Boolean(found);
    for (let round = 0; found && round < 2; round++) {
      const centred = specification.centred(found), values = specification.gains(centred), inputs = law.inputsAt(values);
      const { margins, stable, rests } = answers.answer(inputs.p, inputs.x), own = rests ? margins[channel] : {};
      if (stable && own.Ms <= Ms && !(own.Mt > Mt)) {
        return { reason: "", values: kd ? values : values.slice(0, 2), Ms: own.Ms, Mt: own.Mt, milliseconds: performance.now() - began };
      }
      law.insert([own.omegaMs, own.omegaMt].filter((omega) => omega > 0));
      found = stable ? specification.settled(found) : null;
    }
  }
  return { reason: isFound ? "unproved" : "none" };
}
