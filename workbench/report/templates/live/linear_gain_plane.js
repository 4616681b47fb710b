"use strict";

// The plane of the gains (k, ki) of a PI. At a frequency the law is k - j ki / w, a point of the complex plane. With the loop
// gain a (law + d) the limit Ms forbids it the disc about -1/a - d of the radius 1/(Ms |a|), and Mt forbids another one (Astrom,
// Panagopoulos and Hagglund 1998, Automatica 34, 585-601). So each frequency forbids an interval of ki, for each k.

const MOST_GAPS = 12; // of free numbers ki, for one k, that are looked at from above
const LEAST_GAP = 1e-9; // of ki: what is narrower is rounding

// Rows of a loop in frequency, which `LawOfKnobs` makes: w, the inverse g = 1/a, the rest e and the derivative s of a gain kd.
class GainPlane {
  constructor(rows, kd, { Ms, Mt }, sign) {
    const n = rows.length, kinds = Number.isFinite(Mt) ? 2 : 1;
    Object.assign(this, { n, kd, sign, count: kinds * n, shrunk: { slack: 0, shift: 0 } });
    for (const name of ["w", "x", "y", "r", "size"]) this[name] = new Float64Array(kinds * n);
    for (const name of ["low", "high"]) this[name] = new Float64Array(kinds * n); // of the column that was asked for last
    const far = Mt * Mt / (Mt * Mt - 1), wide = Mt / (Mt * Mt - 1);
    for (let i = 0; i < n; i++) {
      const { w, gr, gi, er, ei, sr, si } = rows[i], size = Math.sqrt(gr * gr + gi * gi);
      const dr = sign * er + kd * sr, di = sign * ei + kd * si;
      this.w[i] = w;
      this.x[i] = -sign * gr - dr;
      this.y[i] = -sign * gi - di;
      this.r[i] = size / Ms;
      if (kinds === 1) continue;
      this.w[n + i] = w;
      this.x[n + i] = -far * sign * gr - dr;
      this.y[n + i] = -far * sign * gi - di;
      this.r[n + i] = wide * size;
    }
    this.size.set(this.r);
  }

  // Make the discs smaller, so that whatever k within a share `slack` of k, or a distance `shift`, meets the limits, has this k
  // between the smaller ones, with gains in proportion.
  shrink(slack, shift) {
    const { shrunk, count, x, y, r, size } = this;
    if (shrunk.slack === slack && shrunk.shift === shift) return;
    Object.assign(shrunk, { slack, shift });
    for (let i = 0; i < count; i++) size[i] = r[i] * (1 - slack) - slack * Math.sqrt(x[i] * x[i] + y[i] * y[i]) - shift;
  }

  // The intervals of ki above `floor` that are forbidden at k: their number.
  column(k, floor) {
    const { count, w, x, y, size, low, high } = this;
    let found = 0;
    for (let i = 0; i < count; i++) {
      const r = size[i], off = k - x[i];
      if (!(r > off && r > -off)) continue;
      const half = Math.sqrt(r * r - off * off), top = w[i] * (half - y[i]);
      if (!(top > floor)) continue;
      low[found] = w[i] * (-half - y[i]);
      high[found] = top;
      found += 1;
    }
    return found;
  }

  // The highest stable ki from `floor` to `cap` that is free at k, -Infinity where there is none; `isStable` asks the loop.
  top(k, { floor, cap }, isStable, slack = 0, shift = 0) {
    this.shrink(slack, shift);
    const { low, high } = this, found = this.column(k, floor);
    let top = cap;
    for (let gap = 0; gap < MOST_GAPS && top > floor; gap++) {
      for (let moved = true; moved;) {
        moved = false;
        for (let i = 0; i < found; i++) {
          if (!(low[i] < top && top <= high[i])) continue;
          top = low[i];
          moved = true;
        }
      }
      if (!(top > floor)) break;
      let bottom = floor;
      for (let i = 0; i < found; i++) if (low[i] < top && high[i] > bottom) bottom = high[i];
      if (top - bottom > LEAST_GAP * top && isStable(this, k, (top + bottom) / 2)) return top;
      top = bottom;
    }
    return -Infinity;
  }

  // The turn of 1 + L along the frequencies, up to a factor that all gains have: by how often it crosses the negative axis.
  turn(k, ki) {
    const { n, w, x, y } = this, first = Math.atan2(-ki / w[0] - y[0], k - x[0]);
    let re = 0, im = 0, turns = 0, before = k - x[0], beside = -ki / w[0] - y[0];
    for (let i = 1; i < n; i++, before = re, beside = im) {
      re = k - x[i];
      im = -ki / w[i] - y[i];
      if (im >= 0 === beside >= 0 || (re >= 0 && before >= 0)) continue;
      const cross = before * im - beside * re;
      if (im >= 0 ? cross < 0 : cross > 0) turns += im >= 0 ? -1 : 1;
    }
    return Math.atan2(beside, before) - first + 2 * Math.PI * turns;
  }
}

// Whether gains stabilise: the poles of the loop are counted at one of them, and at others Nyquist's curve turns more often.
class StabilityCount {
  constructor(unstable) {
    Object.assign(this, { unstable, anchor: null });
    this.asks = (plane, k, ki) => this.isStable(plane, k, ki);
  }

  isStable(plane, k, ki) {
    const turn = plane.turn(k, ki);
    this.anchor ??= { turn, count: this.unstable(k, ki, plane.kd) };
    return Math.round(this.anchor.count - (turn - this.anchor.turn) / Math.PI) === 0;
  }
}
