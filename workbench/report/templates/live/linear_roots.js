"use strict";

// Roots of functions of one number between two at which their signs differ, and peaks between three.

const MOST_HALVINGS = 120;

// The x between a and b at which f is zero, to rounding, by Brent's method (1973, chapter 4); f(a) and f(b) differ in sign.
function rootBetween(f, a, b, fa = f(a), fb = f(b)) {
  let c = a, fc = fa, d = b - a, e = d;
  for (let round = 0; round < MOST_HALVINGS; round++) {
    if (fb > 0 === fc > 0) {
      c = a;
      fc = fa;
      d = e = b - a;
    }
    if (Math.abs(fc) < Math.abs(fb)) {
      [a, b, c] = [b, c, b];
      [fa, fb, fc] = [fb, fc, fb];
    }
    const least = Number.EPSILON * Math.abs(b), half = (c - b) / 2;
    if (Math.abs(half) <= least || fb === 0) return b;
    if (Math.abs(e) >= least && Math.abs(fa) > Math.abs(fb)) {
      const s = fb / fa;
      let p = 2 * half * s, q = 1 - s;
      if (a !== c) {
        const t = fa / fc, r = fb / fc;
        p = s * (2 * half * t * (t - r) - (b - a) * (r - 1));
        q = (t - 1) * (r - 1) * (s - 1);
      }
      if (p > 0) q = -q;
      p = Math.abs(p);
      if (2 * p < Math.min(3 * half * q - Math.abs(least * q), Math.abs(e * q))) {
        e = d;
        d = p / q;
      } else d = e = half;
    } else d = e = half;
    a = b;
    fa = fb;
    b += Math.abs(d) > least ? d : Math.sign(half) * least;
    fb = f(b);
  }
  return b;
}

// The x between a and b, both positive, at which f is largest, by golden sections of its logarithm,
// to `near` relative; what is largest is known to the square of that.
function peakBetween(f, a, b, near) {
  const share = (Math.sqrt(5) - 1) / 2;
  let low = Math.log(a), high = Math.log(b), x = high - share * (high - low), y = low + share * (high - low);
  let fx = f(Math.exp(x)), fy = f(Math.exp(y));
  for (let round = 0; round < 60 && high - low > near; round++) {
    if (fx > fy) {
      [high, y, fy] = [y, x, fx];
      x = high - share * (high - low);
      fx = f(Math.exp(x));
    } else {
      [low, x, fx] = [x, y, fy];
      y = low + share * (high - low);
      fy = f(Math.exp(y));
    }
  }
  return Math.exp(fx > fy ? x : y);
}
