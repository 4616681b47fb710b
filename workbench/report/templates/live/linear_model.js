"use strict";

// The linear model of a loop at a state: kernels give its motion and its Jacobians, cut at the inputs of the plant.

// Values and their Jacobian by states and drives, as a module of the page makes them.
class LinearValues {
  constructor(module, march, size, drives) {
    Object.assign(this, { march, size, drives, kernel: new Kernel(module, march, 1) });
    this.J = new Float64Array((size + drives) * (size + drives));
  }

  // Evaluate at a state x, with all parameters.
  at(p, x) {
    const { kernel, march, size, drives, J } = this, { rows, columns, heights } = march;
    kernel.load(p, "0");
    kernel.x.fill(0);
    kernel.x.set(x);
    kernel.advance(1, 1, 0);
    this.heights = kernel.x.subarray(size, size + heights);
    J.fill(0);
    for (let k = 0; k < rows.length; k++) J[rows[k] * (size + drives) + columns[k]] = kernel.x[size + heights + k];
    return this;
  }

  // Whether the state lies on a corner, where a derivative is that of no piece.
  get isCornered() {
    const { kernel, march, size } = this, { corners } = march, first = size + march.heights + march.rows.length;
    for (let k = 0; k < corners; k++) if (Math.abs(kernel.x[first + k]) <= kernel.x[first + corners + k]) return true;
    return false;
  }

  // The largest share of the motion of the states `must` that changes with time itself, and the state.
  driven(must) {
    const { kernel, march, size } = this, { timed } = march;
    const first = size + march.heights + march.rows.length + 2 * march.corners, worst = { share: 0, state: -1 };
    for (const i of timed ? must : []) {
      const [one, two, terms] = [0, 1, 2].map((k) => kernel.x[first + k * timed + i]);
      const share = Math.max(Math.abs(one), Math.abs(two)) / terms;
      if (share > worst.share || Number.isNaN(share)) Object.assign(worst, { share, state: i });
    }
    return worst;
  }
}

// The flow of a period with its sensitivities.
class LinearFlow {
  constructor(module, march, size, drives) {
    Object.assign(this, { march, size, drives, kernel: new Kernel(module, march, STEPS_AT_ONCE) });
    this.start = Float64Array.from(march.start);
    this.p = null;
  }

  // The state after a period that starts at x, into `end`, and its Jacobian (n, n + drives) into J.
  at(p, time, x, end, J) {
    const { kernel, march, size, drives, start } = this, { rows, columns, others } = march;
    const count = p.length - 1, width = size + drives; // the last of p is the time
    this.p ||= new Float64Array(count + others.length + 1);
    this.p.set(p.subarray(0, count));
    others.forEach((place, i) => (this.p[count + i] = x[place]));
    this.p[count + others.length] = time;
    kernel.load(this.p, "0");
    rows.forEach((place, i) => (kernel.x[i] = x[place]));
    kernel.x.set(start, rows.length);
    for (let done = 0; done < march.substeps; done += STEPS_AT_ONCE) {
      kernel.advance(1, Math.min(STEPS_AT_ONCE, march.substeps - done), done);
    }
    end.set(x);
    J.fill(0);
    for (let i = 0; i < size; i++) J[i * width + i] = 1;
    rows.forEach((place, i) => {
      end[place] = kernel.x[i];
      J[place * width + place] = 0;
      columns.forEach((column, k) => (J[place * width + column] = kernel.x[rows.length * (1 + k) + i]));
    });
  }
}

// A loop of the page that is made linear at any state, for the parameters and first states that it has taken.
class LinearModel {
  constructor(linear, modules) {
    const n = linear.states.length, m = linear.channels.length;
    Object.assign(this, { linear, n, m, isSampled: linear.period !== null });
    const made = (Part, march) => march && new Part(modules[march.module], march, n, m);
    this.values = made(LinearValues, linear.values);
    this.jump = made(LinearValues, linear.jump);
    this.flow = made(LinearFlow, linear.flow);
    this.p = new Float64Array(linear.places.length + 1); // and the time behind them
    this.start = new Float64Array(n);
    for (const [name, size] of [["change", n], ["after", n], ["end", n]]) this[name] = new Float64Array(size);
    for (const [name, size] of [["A", n * n], ["B", n * m], ["C", m * n], ["D", m * m], ["closed", n * n]]) {
      this[name] = new Float64Array(size);
    }
    this.J = new Float64Array(n * (n + m));
    this.first = new Float64Array(n * n);
    this.instant = this.isSampled ? Math.round(linear.t / linear.period) : linear.t;
  }

  // Take over the parameters and the first states of the page.
  take(p, x0) {
    const { places, given, states } = this.linear, from = (place) => (place < p.length ? p[place] : x0[place - p.length]);
    places.forEach((place, i) => (this.p[i] = place < 0 ? Number(given[i]) : from(place)));
    states.forEach((place, i) => (this.start[i] = from(place)));
  }

  // The motion at a state into `change`, A, B, C and D of the loop that is cut, and `closed`, A of the whole.
  evaluate(x) {
    if (this.isSampled) this.evaluatePeriod(x);
    else this.evaluateRate(x);
    this.close();
  }

  // What arrives at the cut is what drives there: it depends on states alone.
  drive(state) {
    const { values, linear, p, m } = this;
    p[p.length - 1] = linear.t;
    values.at(p, state);
    const arrivals = values.heights.slice(values.heights.length - m);
    linear.drive.forEach((place, i) => (p[place] = arrivals[i]));
    return values;
  }

  evaluateRate(x) {
    const { n, m, p, A, B, C, D } = this, width = n + m;
    this.drive(x);
    const { heights, J } = this.values.at(p, x);
    this.change.set(heights.subarray(0, n));
    for (let i = 0; i < n; i++) {
      for (let j = 0; j < n; j++) A[i * n + j] = J[i * width + j];
      for (let j = 0; j < m; j++) B[i * m + j] = J[i * width + n + j];
    }
    for (let i = 0; i < m; i++) {
      for (let j = 0; j < n; j++) C[i * n + j] = J[(n + i) * width + j];
      for (let j = 0; j < m; j++) D[i * m + j] = J[(n + i) * width + n + j];
    }
  }

  // A period: the jump of the computer, what then arrives at the plant, and the flow to the next instant.
  evaluatePeriod(x) {
    const { n, m, p, A, B, C, D, J, after, end, first, jump, linear } = this, width = n + m;
    p[p.length - 1] = this.instant;
    jump.at(p, x);
    after.set(jump.heights.subarray(0, n));
    for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) first[i * n + j] = jump.J[i * width + j];
    const seen = this.drive(after).J;
    if (this.flow) this.flow.at(p, linear.t, after, end, J);
    else {
      end.set(after);
      J.fill(0);
      for (let i = 0; i < n; i++) J[i * width + i] = 1;
    }
    A.fill(0);
    C.fill(0);
    for (let i = 0; i < n; i++) {
      this.change[i] = end[i] - x[i];
      addRowTimes(A, i * n, J, i * width, first, n);
      for (let j = 0; j < m; j++) B[i * m + j] = J[i * width + n + j];
    }
    for (let i = 0; i < m; i++) {
      addRowTimes(C, i * n, seen, (n + i) * width, first, n);
      for (let j = 0; j < m; j++) D[i * m + j] = seen[(n + i) * width + n + j];
    }
  }

  // A of the loop whose drives are what arrives.
  close() {
    const { n, m, A, B, C, D, closed } = this, states = [...Array(n).keys()], channels = [...Array(m).keys()];
    const whole = closedAt({ A, B, C, D, n, m }, channels);
    if (whole) closed.set(whole.A);
    else closed.fill(NaN);
  }

  // Whether the state at which it was evaluated last lies on a corner.
  get isCornered() {
    return this.values.isCornered || Boolean(this.jump && this.jump.isCornered);
  }

  driven(must) {
    const found = [this.values, this.jump].filter(Boolean).map((values) => values.driven(must));
    return found.reduce((worst, one) => (one.share > worst.share || Number.isNaN(one.share) ? one : worst));
  }
}

// Add a row of n numbers times a matrix (n, n) to another row.
function addRowTimes(target, at, row, from, M, n) {
  for (let l = 0; l < n; l++) {
    const a = row[from + l];
    if (a === 0) continue;
    for (let j = 0; j < n; j++) target[at + j] += a * M[l * n + j];
  }
}
