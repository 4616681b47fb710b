"use strict";

// A loop whose L is a (k + ki b + kd s + e) by the numbers of three knobs, as those of a PID are: a, s and e in frequency, from
// the linear loop at a few numbers. What the other knobs are, and the rest of the law, stays as it is now.

const TURN = 0.15; // the most that a and e change from one frequency to the next, by their size
const DEEPEST = 12; // halvings of the step between two frequencies
const MOST_ROWS = 3000;
const NOTHING = 1e-5; // of the largest ki
const SAME_LAW = 1e-6; // of the integral action: how nearly it is 1/s, or h/(z - 1), times what the gain k acts on

class LawOfKnobs {
  // `knobs` are {k, ki, kd}, the last one null where it stays as it is; the rows are for limits of S and T.
  constructor(answers, { p, x, channel }, knobs, { Ms, Mt }) {
    const { period } = answers.linear;
    Object.assign(this, { answers, inputs: { p, x }, channel, knobs, period, rho: period ? -period / 2 : 0, rows: [], reason: "" });
    const size = ({ value, low, high }) => value || high || low, most = (knob) => (knob ? Math.max(Math.abs(knob.low), Math.abs(knob.high)) : 0);
    this.most = { k: most(knobs.k), ki: most(knobs.ki), kd: most(knobs.kd) };
    this.least = Math.min(1 - 1 / Ms, Number.isFinite(Mt) ? Mt / (Mt + 1) : 1);
    this.wide = 2 + (Number.isFinite(Mt) ? (Mt * Mt + Mt) / (Mt * Mt - 1) : 0);
    this.sizes = { k: size(knobs.k), ki: size(knobs.ki), kd: knobs.kd ? size(knobs.kd) : 0 };
    const { k, ki, kd } = this.sizes, places = [[0, ki, 0], [k, ki, 0], [0, 2 * ki, 0], ...(kd ? [[0, ki, kd]] : [])];
    const systems = places.map((gains) => this.systems(gains));
    this.reason = systems.find(({ reason }) => reason)?.reason ?? "";
    if (this.reason) return;
    const own = systems.map(({ cut }) => answers.alone(cut, channel));
    this.responses = own.map((one) => new LinearResponse(one, period));
    this.fill(searchGrid(answers.omega, [...own.slice(1, 2), ...own.slice(3)].flatMap((one) => [polesOf(one.A, one.n, period), zerosOf(one)]).filter(Boolean), period));
  }

  // The parameters and first states of the page with gains (k, ki, kd).
  inputsAt([k, ki, kd]) {
    const { knobs } = this, turned = turnedTo(turnedTo(this.inputs, knobs.k, k), knobs.ki, ki);
    return knobs.kd ? turnedTo(turned, knobs.kd, kd) : turned;
  }

  systems(gains) {
    const { p, x } = this.inputsAt(gains);
    return this.answers.systems(p, x);
  }

  // How many poles of the closed loop do not decay with gains.
  unstable(gains) {
    const { whole } = this.systems(gains), { period } = this, poles = whole ? polesOf(whole.closed, whole.n, period) : null;
    if (!poles) return Infinity;
    return poles.re.reduce((count, re, i) => count + !((period ? 1 - Math.hypot(re, poles.im[i]) : -re) > 0), 0);
  }

  // What discs need of the loop at a frequency; null where it is infinite or nothing.
  row(omega) {
    const { responses, sizes, period } = this, w = period ? (2 / period) * Math.tan((omega * period) / 2) : omega;
    if (!responses.every((one) => one.at(omega))) return null;
    const L = responses.map(({ re, im }) => [-re[0], -im[0]]), minus = (u, v, size) => [(u[0] - v[0]) / size, (u[1] - v[1]) / size];
    const a = minus(L[1], L[0], sizes.k), b = minus(L[2], L[0], sizes.ki), square = a[0] * a[0] + a[1] * a[1];
    const over = ([re, im]) => [(re * a[0] + im * a[1]) / square, (im * a[0] - re * a[1]) / square]; // over a
    const [gr, gi] = over([1, 0]), rest = over(L[0]), [sr, si] = L[3] ? over(minus(L[3], L[0], sizes.kd)) : [0, 0];
    const integral = over(b), [er, ei] = [rest[0] - sizes.ki * this.rho, rest[1] + sizes.ki / w];
    const off = Math.hypot(integral[0] - this.rho, integral[1] + 1 / w), allowed = SAME_LAW * Math.hypot(this.rho, 1 / w);
    const noise = (1e-12 * Math.hypot(...L[2])) / Math.abs(sizes.ki) / Math.sqrt(square);
    const isRow = [w, gr, gi, er, ei, sr, si].every(Number.isFinite) && square > 0;
    return isRow ? { omega, w, gr, gi, er, ei, sr, si, isLaw: off <= allowed + noise } : null;
  }

  // Whether gains within the ranges can come near to a disc of a frequency.
  matters({ w, gr, gi, er, ei, sr, si }) {
    const { most, least, rho } = this;
    const reach = most.k + most.ki * (1 / w - rho) + most.kd * Math.hypot(sr, si) + Math.hypot(er, ei);
    return least * Math.hypot(gr, gi) <= 2 * reach;
  }

  // Whether a frequency forbids more than gains ki that are as good as zero, as low ones do.
  isHigh({ w, gr, gi, er, ei }) {
    return w * (Math.hypot(gr, gi) * this.wide + Math.hypot(er, ei) + this.most.k) > NOTHING * this.most.ki;
  }

  // Rows at frequencies, and between them where they differ by more than a little.
  fill(omegas) {
    const rows = [];
    const add = (before, after, depth) => {
      const far = Math.hypot(after.gr - before.gr, after.gi - before.gi) > TURN * Math.hypot(after.gr, after.gi);
      const bends = Math.hypot(after.er - before.er, after.ei - before.ei) > TURN * (Math.hypot(after.er, after.ei) + Math.hypot(after.gr, after.gi));
      if ((far || bends) && depth < DEEPEST && before.isLaw && after.isLaw && (this.matters(before) || this.matters(after)) && rows.length < MOST_ROWS) {
        const middle = this.row(Math.sqrt(before.omega * after.omega));
        if (middle) {
          add(before, middle, depth + 1);
          add(middle, after, depth + 1);
          return;
        }
      }
      rows.push(after);
    };
    for (const omega of omegas) {
      const here = this.row(omega);
      if (!here || (!rows.length && !this.isHigh(here))) continue;
      if (rows.length) add(rows.at(-1), here, 0);
      else rows.push(here);
    }
    const last = rows.findLastIndex((row) => this.matters(row));
    this.rows = rows.slice(0, last + 3);
    const middle = rows.length && Math.sqrt(rows[0].omega * rows.at(-1).omega), upper = rows.filter(({ omega }) => omega >= middle);
    const wrong = upper.filter(({ isLaw }) => !isLaw).length; // few of a PID, by rounding
    if (!rows.length || wrong > upper.length / 10) this.reason = "structure";
  }

  // Insert frequencies.
  insert(omegas) {
    for (const omega of omegas) {
      const at = this.rows.findIndex((row) => row.omega >= omega), here = at >= 0 && this.rows[at].omega === omega ? null : this.row(omega);
      if (here) this.rows.splice(at < 0 ? this.rows.length : at, 0, here);
    }
  }
}
