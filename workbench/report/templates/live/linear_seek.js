"use strict";

// What a reader drags: the number of a knob at which a gain crossover is at a wished frequency, and which knobs move it.

const NEARBY = 0.004, WIDER = 1.6; // of the range of a knob: the first look beside its number, and how each next one grows
const REACHED = 1e-9; // of log |L|, which is zero at a crossover
const NUDGE = 1e-4; // of a number, by which it is changed to see what moves
const MOVES = 1e-3; // change of log |L| for a change of a number by itself, below which a knob moves nothing

// Parameters and first states of a loop with the number of a knob; `knob` is {p, x, share, value}, and stands at `value`.
function turnedTo({ p, x }, knob, value) {
  const turned = { p: p.slice(), x: x.slice() };
  for (const name of ["p", "x"]) {
    for (const place of knob[name]) turned[name][place] = knob.share ? turned[name][place] * (value / knob.value) : value;
  }
  return turned;
}

// log |L| of a channel at a frequency as a function of the number of a knob; NaN where the loop has no linear answer.
function gainOfKnob(answers, inputs, knob, channel, omega) {
  return (value) => {
    const { p, x } = turnedTo(inputs, knob, value), { cut } = answers.systems(p, x), own = cut && answers.alone(cut, channel);
    if (!own) return NaN;
    const response = new LinearResponse(own, answers.linear.period);
    return response.at(omega) ? Math.log(Math.hypot(response.re[0], response.im[0])) : NaN;
  };
}

// The number of a knob within its range at which f is zero, the first one that is met from where it stands, else the one
// at which f came nearest to zero: {value, reached}. `blocked` says that a part of the range has no answer.
function soughtNumber(f, { low, high, log, value }) {
  const number = (share) => (share <= 0 ? low : share >= 1 ? high : log ? low * (high / low) ** share : low + (high - low) * share);
  const here = log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  const g = (share) => f(share === here ? value : number(share)), start = g(here);
  let best = { share: here, size: Math.abs(start) }, blocked = false;
  if (!(best.size > 0)) return { value, reached: best.size === 0, blocked: start !== start };
  let sides = [1, -1].map((direction) => ({ direction, share: here, at: start }));
  for (let step = NEARBY; sides.length; step *= WIDER) {
    for (const side of sides) {
      const share = Math.min(1, Math.max(0, side.share + side.direction * step)), at = g(share), size = Math.abs(at);
      if (size < best.size) best = { share, size };
      if (size >= 0 && at > 0 !== side.at > 0) {
        const root = rootBetween(g, side.share, share, side.at, at);
        if (Math.abs(g(root)) < REACHED) return { value: number(root), reached: true, blocked: false };
      }
      blocked ||= size !== size;
      Object.assign(side, { share, at, ends: share <= 0 || share >= 1 || size !== size });
    }
    sides = sides.filter(({ ends }) => !ends);
  }
  return { value: best.share === here ? value : number(best.share), reached: false, blocked };
}

// The gain crossover of a channel that is nearest to a frequency, with a knob at a value; null where there is none.
function nearestCrossover(answers, inputs, knob, channel, omega, value) {
  const { p, x } = turnedTo(inputs, knob, value), rows = answers.answer(p, x).margins?.[channel].gainCrossovers ?? [];
  const apart = (row) => Math.abs(Math.log(row.omega / omega));
  return rows.reduce((best, row) => (best === null || apart(row) < apart({ omega: best }) ? row.omega : best), null);
}

// The answer at some inputs, the poles with the knobs that move them, and for each channel with a gain crossover among the frequencies of the page which of the
// knobs move |L| at the highest one, the strongest first, as places among `knobs`; null for a channel without one.
function surveyed(answers, { p, x, knobs }) {
  const answer = answers.answer(p, x), { omega, m } = { omega: answers.omega, m: answers.model.m };
  const channels = Array.from({ length: m }, (_, channel) => {
    const seen = answer.rests ? answer.margins[channel].gainCrossovers.filter((row) => row.omega >= omega[0] && row.omega <= omega.at(-1)) : [];
    if (!seen.length) return null;
    const strengths = knobs.map((knob) => {
      const { low, high, value } = knob, size = Math.abs(value) || (high - low) / 2;
      const f = gainOfKnob(answers, { p, x }, knob, channel, seen.at(-1).omega);
      const [a, b] = [Math.max(low, value - NUDGE * size), Math.min(high, value + NUDGE * size)];
      return Math.abs((f(b) - f(a)) / (b - a)) * size;
    });
    return [...knobs.keys()].filter((i) => strengths[i] > MOVES).sort((i, j) => strengths[j] - strengths[i]);
  });
  const poles = answer.rests ? movedPoles(new PolesOfKnobs(answers, { p, x, knobs })) : [];
  return { answer, channels, poles };
}

// The reply to a question of the page about a loop.
function replyTo(answers, { kind, p, x, knob, knobs, channel, omega, ...asked }) {
  if (kind === "survey") return surveyed(answers, { p, x, knobs });
  if (kind === "poles") return movedPoles(new PolesOfKnobs(answers, { p, x, knobs }));
  if (kind === "pole") return placedPole(new PolesOfKnobs(answers, { p, x, knobs }), asked);
  if (kind === "specification") return specifiedGains(answers, { p, x, channel, ...asked });
  const sought = soughtNumber(gainOfKnob(answers, { p, x }, knob, channel, omega), knob);
  return { ...sought, omega: sought.reached ? omega : nearestCrossover(answers, { p, x }, knob, channel, omega, sought.value) };
}
