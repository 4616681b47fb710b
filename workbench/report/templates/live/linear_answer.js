"use strict";

// The linear answer of a loop of the page: where it rests, L at the cut, poles, and the figures of its margins.

const CORNERED = "The loop is on a corner at this point, where a law or its plant switches, and has no linear answer there.";
const NOT_FINITE = "The Jacobians of the loop are not finite at this point.";
const NO_NUMBER = "A number of the loop is not finite.";
const NO_POLES = "The poles of the loop could not be computed.";
const SHARPEST = 1e-4; // damping: the peak of a root with less is not drawn to its top

class LinearAnswers {
  constructor(linear, modules) {
    this.linear = linear;
    this.model = new LinearModel(linear, modules);
    this.omega = Float64Array.from(linear.omega);
  }

  // The systems {whole, cut} of the loop at rest at parameters and first states of the page, and its states x; or a reason.
  systems(p, x0) {
    const { model, linear } = this;
    if (!allFinite(p, 0, p.length) || !allFinite(x0, 0, x0.length)) return { reason: NO_NUMBER };
    model.take(p, x0);
    const { x, reason } = findRest(model);
    if (reason) return { reason };
    if (![model.A, model.B, model.C, model.D, model.closed].every((M) => allFinite(M, 0, M.length))) return { reason: NOT_FINITE };
    if (model.isCornered && !isStraightAt(model, x)) return { reason: CORNERED };
    const [whole, cut] = linear.read.map((read) => reduced(model, read));
    return { x, whole, cut, reason: "" };
  }

  // The system of one channel with the loop closed at the others.
  alone(cut, channel) {
    return cut.m === 1 ? cut : closedAt(cut, [...Array(cut.m).keys()].filter((j) => j !== channel));
  }

  // The answer at parameters and first states of the page; one that fails says why and has nothing else.
  answer(p, x0) {
    const { linear } = this, { m } = this.model, { x, whole, cut, reason } = this.systems(p, x0);
    if (reason) return { rests: false, reason };
    const poles = polesOf(whole.closed, whole.n, linear.period), openPoles = polesOf(cut.A, cut.n, linear.period);
    if (!poles || !openPoles) return { rests: false, reason: NO_POLES };
    const stable = allDecay(whole.closed, whole.n, poles, linear.period);
    const roots = [poles, openPoles], margins = [], omega = drawnFrequencies(this.omega, roots, linear.period);
    const response = new LinearResponse(cut, linear.period), L = loopGain(response, omega);
    for (let i = 0; i < m; i++) {
      const own = this.alone(cut, i);
      const ownRoots = m === 1 ? roots : [...roots, polesOf(own.A, own.n, linear.period) || poles];
      margins.push(marginsOf(new ChannelLoop(own, linear.period, this.omega, ownRoots), stable));
    }
    let diskMargin = stable && m === 1 ? margins[0].diskMargin : null;
    if (stable && m > 1) diskMargin = diskMarginOf(response, searchGrid(this.omega, roots, linear.period), cut.D);
    for (const one of margins) delete one.diskMargin;
    return {
      rests: true, reason: "", x0: x.slice(), omega, L, poles, stable, openPoles, margins, diskMargin,
    };
  }
}

// L = -G at frequencies, [frequency][row][column].
function loopGain(response, omega) {
  const { m } = response, L = { re: new Float64Array(omega.length * m * m), im: new Float64Array(omega.length * m * m) };
  omega.forEach((w, k) => {
    const isFinite = response.at(w);
    for (let i = 0; i < m * m; i++) {
      L.re[k * m * m + i] = isFinite ? -response.re[i] : Infinity;
      L.im[k * m * m + i] = isFinite ? -response.im[i] : 0;
    }
  });
  return L;
}

// The frequencies of the page, and more about each root of little damping, whose peak would fall between two of them.
function drawnFrequencies(omega, roots, period) {
  const more = roots.flatMap((one) => rootFrequencies(one, period, SHARPEST).around);
  const all = Float64Array.from([...omega, ...more.filter((w) => w > omega[0] && w < omega.at(-1))]).sort();
  return all.filter((w, k) => !k || w > all[k - 1]);
}

// The model without the states of a computer that nothing reads.
function reduced({ A, B, C, D, closed, n, m, isSampled }, read) {
  const all = [...Array(n).keys()], channels = [...Array(m).keys()];
  const states = isSampled ? all.filter((j) => read[j]) : all;
  return {
    A: part(A, n, states, states), B: part(B, m, states, channels), C: part(C, n, channels, states), D: D.slice(),
    closed: part(closed, n, states, states), n: states.length, m,
  };
}
