"use strict";

// The numbers of a live page: metrics from the last states of a run, with the bits of the engine, and their text beside
// the printed numbers, by the rules of the engine's `number_text.py`.

const PROGRAM_OPERATIONS = {
  add: (a, b) => a + b,
  sub: (a, b) => a - b,
  mul: (a, b) => a * b,
  div: (a, b) => a / b,
  sqrt: Math.sqrt,
  neg: (a) => -a,
  fabs: Math.abs,
  max: (a, b) => Math.max(a, b),
  min: (a, b) => Math.min(a, b),
  floor: Math.floor,
  lt: (a, b) => a < b,
  le: (a, b) => a <= b,
  gt: (a, b) => a > b,
  ge: (a, b) => a >= b,
  eq: (a, b) => a === b,
  ne: (a, b) => a !== b,
  and: (a, b) => a && b,
  or: (a, b) => a || b,
  not: (a) => !a,
  isnan: Number.isNaN,
  select: (truth, a, b) => (truth ? a : b),
};

// The numbers of a metric from states at the horizon, x from place xAt on, and one step later, z from place zAt on.
function evaluateProgram(program, x, xAt, z, zAt) {
  const { inputs, nodes, results } = program, values = new Float64Array(inputs.length + nodes.length);
  inputs.forEach(([of, place], i) => (values[i] = of === "x" ? x[xAt + place] : z[zAt + place]));
  nodes.forEach(([operation, a, b, c], i) => {
    const known = operation !== "const";
    values[inputs.length + i] = known ? PROGRAM_OPERATIONS[operation](values[a], values[b], values[c]) : Number(a);
  });
  return Float64Array.from(results, (node) => values[node]);
}

// The error of a value at the step: twice its change to half of the step, but at least the resolution of one step; zero
// where two infinite values agree, and infinite where half of the step alone gives none.
function errorOfValue(value, half, least) {
  if (Math.abs(value) === Infinity && Math.abs(half) === Infinity) return 0;
  if (Number.isNaN(half) && !Number.isNaN(value)) return Infinity;
  return Math.max(2 * Math.abs(value - half), least);
}

// The numbers of a loop, by metrics, as pairs of value and error. A run is {x, z}, its states at the horizon and one
// step later, or null if it has diverged. Errors are null without the run at half of the step, and null
// stands for a metric without a program.
function scoresOf(loop, whole, half) {
  const valuesOf = ({ program, labels }, run) =>
    run ? evaluateProgram(program, run.x, 0, run.z, 0) : new Float64Array(labels.length).fill(NaN);
  return loop.metrics.map((metric) => {
    if (!metric.program) return null;
    const values = valuesOf(metric, whole), least = metric.time ? loop.whole.h : 0;
    if (half === undefined) return Array.from(values, (value) => [value, null]);
    const halved = valuesOf(metric, half);
    return Array.from(values, (value, i) => [value, errorOfValue(value, halved[i], least)]);
  });
}

const MOST_DIGITS = 5; // of a measured value, however small its error
const COARSE_DIGITS = 3; // of a value whose error is not known yet
const isPlainSize = (size) => size >= 1e-3 && size < 1e5; // outside of this a number has a power of ten

// |value| / 10^place as the nearest whole number, a half to the even one; exact.
function unitsOf(value, place) {
  const bits = new BigUint64Array(Float64Array.of(Math.abs(value)).buffer)[0], power = Number(bits >> 52n);
  const mantissa = (bits & 0xfffffffffffffn) | (power ? 1n << 52n : 0n), exponent = (power || 1) - 1075;
  const above = (mantissa << BigInt(Math.max(exponent, 0))) * 10n ** BigInt(Math.max(-place, 0));
  const below = 10n ** BigInt(Math.max(place, 0)) << BigInt(Math.max(-exponent, 0));
  const whole = above / below, rest = 2n * (above % below);
  return rest > below || (rest === below && whole & 1n) ? whole + 1n : whole;
}

// A number in text: a sign, digits, a tail from the point on and a power of ten or none; of units of 10^place each.
function numberText(negative, units, place, power, brackets = "") {
  const decimals = Math.max(0, -place), digits = (units * 10n ** BigInt(Math.max(0, place))).toString();
  const filled = digits.padStart(decimals + 1, "0"), point = filled.length - decimals;
  return {
    sign: negative && units ? "−" : "",
    whole: filled.slice(0, point),
    tail: (decimals ? `.${filled.slice(point)}` : "") + brackets,
    power: power ? String(power).replace("-", "−") : "",
  };
}

// A number with so many digits that count, as whole units of a power of ten.
function roundedTo(value, digits) {
  const place = Number(value.toExponential(digits - 1).split("e")[1]) - digits + 1;
  return { units: unitsOf(value, place), place };
}

// A finite number without an error.
function printedText(value, digits) {
  const { units, place } = roundedTo(value, digits), top = place + digits - 1;
  const plain = value === 0 || isPlainSize(Number(`${units}e${place}`)), last = Math.min(0, place);
  if (plain) return numberText(value < 0, unitsOf(value, last), last, 0);
  return { ...numberText(value < 0, units, 1 - digits, 0), power: String(top).replace("-", "−") };
}

// The decimal place of the last digit that an error leaves: -4 for 0.0002.
function lastPlaceOf(error) {
  const [mantissa, exponent] = error.toExponential(1).split("e");
  return Number(exponent) - (mantissa.startsWith("1") ? 1 : 0);
}

// A value with its error in brackets, both finite: 0.3532(2) is 0.3532 with an error of 0.0002.
function measuredText(value, error) {
  const size = Math.max(Math.abs(value), error);
  if (size === 0) return numberText(false, 0n, 0, 0);
  const top = Math.floor(Math.log10(size)), most = top - MOST_DIGITS + 1;
  const last = error ? Math.max(lastPlaceOf(error), most) : most, shift = isPlainSize(size) ? 0 : top;
  const digits = unitsOf(error, last) * (shift ? 1n : 10n ** BigInt(Math.max(0, last)));
  return numberText(value < 0, unitsOf(value, last), last - shift, shift, digits ? `(${digits})` : "");
}

// A time in words, of three digits at most.
function secondsText(at) {
  const { units, place } = roundedTo(at, 3), short = Number(`${units}e${place}`);
  const digits = [1, 2, 3].find((k) => Number(short.toExponential(k - 1)) === short);
  const { sign, whole, tail, power } = printedText(short, digits);
  return `${sign}${whole}${tail}${power && `e${power.replace("−", "-")}`}`;
}

// A value and its error, which may not be known yet, in the unit of a cell.
function scaledScore([value, error], scale) {
  return [scale * value, error === null ? null : Math.abs(scale) * error];
}

// A cell's number, or the words in its place; the error is null while it is not known.
function scoreText(value, error, divergedAt) {
  if (divergedAt !== null) return `diverged at ${secondsText(divergedAt)} s`;
  if (value === Infinity) return "never";
  if (error !== null && !(Number.isFinite(error) && value === value)) return "no error estimate";
  if (!Number.isFinite(value)) return "no value";
  return error === null ? printedText(value, COARSE_DIGITS) : measuredText(value, error);
}

// The frame of a column: the longest sign, digits, tail and power that it has held, to which each number is padded, so
// that points stand in one place and the column keeps its width.
class NumberFrame {
  constructor(numbers) {
    Object.assign(this, { sign: "", whole: "", power: "", glyphs: new Map() });
    numbers.forEach((number) => this.grow(number));
  }

  static glyphsOf(tail) {
    const counts = new Map();
    for (const glyph of tail.replace(/\d/g, "0")) counts.set(glyph, (counts.get(glyph) || 0) + 1);
    return counts;
  }

  // The glyphs of all tails, which make the longest one.
  get tail() {
    return [...this.glyphs].sort().map(([glyph, count]) => glyph.repeat(count)).join("");
  }

  // Make room for a number; true if there was too little.
  grow(number) {
    let grown = false;
    for (const part of ["sign", "whole", "power"]) {
      if (number[part].length > this[part].length) [this[part], grown] = [number[part], true];
    }
    for (const [glyph, count] of NumberFrame.glyphsOf(number.tail)) {
      if (count > (this.glyphs.get(glyph) || 0)) grown = Boolean(this.glyphs.set(glyph, count));
    }
    return grown;
  }

  // What a number, or a smaller frame, lacks before it, behind it and in its power.
  padding({ sign, whole, tail, power }) {
    const own = NumberFrame.glyphsOf(tail);
    const lacks = [...this.glyphs].sort().map(([glyph, count]) => glyph.repeat(count - (own.get(glyph) || 0)));
    return {
      before: (sign ? "" : this.sign) + this.whole.slice(0, this.whole.length - whole.length),
      behind: lacks.join(""),
      power: this.power.slice(0, this.power.length - power.length),
    };
  }
}

const TIMES_TEN = "\u2009×\u200910";

function elementOf(document, name, className, ...parts) {
  const element = document.createElement(name);
  if (className) element.className = className;
  element.append(...parts);
  return element;
}

// What a number lacks to its frame, as invisible digits that are no text for copying or reading aloud: the elements
// before it and those behind it.
function padsOfNumber(document, number, frame) {
  const { before, behind, power } = frame.padding(number);
  const pad = (text) => {
    const element = elementOf(document, "span", "pad");
    element.dataset.pad = text;
    return element;
  };
  return [
    before ? [pad(before)] : [],
    [
      ...(behind ? [pad(behind)] : []),
      ...(frame.power && !number.power ? [pad(TIMES_TEN)] : []),
      ...(power ? [elementOf(document, "sup", "", pad(power))] : []),
    ],
  ];
}

// A number of the printed page as text, with its padding, so that it is as long as the frame of its column.
function printedNumberOf(element) {
  const text = [...element.childNodes].find((node) => node.nodeType === 3);
  const textOf = (node) => (node.dataset && node.dataset.pad) || node.textContent;
  const before = text === element.firstChild ? "" : textOf(element.firstChild);
  const [, sign, whole, tail] = /^(−?)([\d\u2009∞]*)(.*)$/.exec(text.data.replace(TIMES_TEN, ""));
  const behind = [...element.children].filter((child) => child.matches(".pad") && child !== element.firstChild);
  return {
    sign: sign || before.replace(/[^−]/g, ""),
    whole: before.replace("−", "") + whole,
    tail: tail + behind.map(textOf).join("").replace(TIMES_TEN, ""),
    power: [...element.querySelectorAll("sup")].map((sup) => textOf(sup.firstChild)).join(""),
  };
}

// The live cells of a column and the frame that their numbers share with the printed ones.
class LiveColumn {
  constructor(document, cells, scores) {
    const { cellIndex } = cells[0].element, rows = [...cells[0].element.closest("tbody").rows];
    this.document = document;
    this.cells = cells;
    const places = rows.map((row) => row.cells[cellIndex]).filter(Boolean);
    this.numbers = places.flatMap((place) => [...place.querySelectorAll(".number")]);
    this.printed = new NumberFrame(this.numbers.map(printedNumberOf));
    this.scores = scores.filter((pair) => pair.every(Number.isFinite));
    this.pads = null; // of the printed numbers, while there are live ones
    this.reserve();
  }

  // The frame of what is printed, with room for coarse numbers and longer errors.
  reserve() {
    const longer = this.scores.flatMap(([value, error]) => {
      const number = measuredText(value, error), [digits, brackets] = number.tail.split("(");
      return [{ ...number, tail: `${digits}(00${brackets ? "0" : ""})` }, printedText(value, COARSE_DIGITS)];
    });
    this.frame = new NumberFrame([this.printed, ...longer]);
  }

  // Write the cells that are new, and all of the column if its frame has grown; without live cells it is as printed.
  write(isNew) {
    const live = this.cells.filter((cell) => cell.content !== null), fresh = live.filter(isNew);
    const grown = fresh.filter(({ content }) => typeof content !== "string" && this.frame.grow(content)).length > 0;
    if (!live.length) this.reserve();
    if (grown || !live.length || !this.pads) this.padPrinted(live.length > 0);
    (grown ? live : fresh).forEach((cell) => this.writeCell(cell));
  }

  // Pad the printed numbers to the frame of the live ones, or leave them as they were.
  padPrinted(isLive) {
    if (this.pads) this.pads.forEach((pad) => pad.remove());
    this.pads = isLive ? [] : null;
    for (const number of isLive ? this.numbers : []) {
      const [before, behind] = padsOfNumber(this.document, this.printed, this.frame);
      number.prepend(...before);
      number.append(...behind);
      this.pads.push(...before, ...behind);
    }
  }

  writeCell({ span, content, coarse }) {
    const isText = typeof content === "string", { sign, whole, tail, power } = content;
    span.className = `live-number${isText ? " words" : ""}${coarse ? " coarse" : ""}`;
    if (isText) return span.replaceChildren(content);
    const [before, behind] = padsOfNumber(this.document, content, this.frame);
    const raised = power ? [TIMES_TEN, elementOf(this.document, "sup", "", power)] : [];
    span.replaceChildren(...before, `${sign}${whole}${tail}`, ...raised, ...behind);
  }
}

// The live cells of a page: show(place, scores, divergedAt) writes the numbers of a loop, and null in place of scores
// takes them away; clear(place) does so too, and clear() does it for all loops.
class LiveTables {
  constructor(document, data) {
    this.document = document;
    this.cells = [];
    const columns = new Map();
    for (const element of document.querySelectorAll("[data-cell]")) {
      const cell = data.cells[Number(element.dataset.cell)];
      if (!cell) continue;
      const key = `${cell.table} ${cell.column}`, live = { ...cell, element, span: null, content: null };
      columns.set(key, [...(columns.get(key) || []), live]);
      this.cells.push(live);
    }
    const printed = ({ loop, metric, number, scale, quantity }) =>
      quantity ? [NaN, NaN] : scaledScore(data.loops[loop].scores[metric][number], scale);
    this.columns = [...columns.values()].map((cells) => new LiveColumn(document, cells, cells.map(printed)));
  }

  show(place, scores, divergedAt = null) {
    const isCoarse = divergedAt === null && Boolean(scores) && scores.some((pairs) => pairs && pairs[0][1] === null);
    this.change((cell) => cell.loop === place && !cell.quantity, ({ metric, number, scale }) => {
      if (divergedAt !== null) return scoreText(NaN, null, divergedAt);
      if (!scores || !scores[metric]) return null; // without a program
      return scoreText(...scaledScore(scores[metric][number], scale), null);
    }, isCoarse);
  }

  clear(place) {
    this.change((cell) => (place === undefined || cell.loop === place) && !cell.quantity, () => null, false);
  }

  // Write the numbers of a linear answer of a loop; null takes them away.
  showLinear(place, answer) {
    this.change((cell) => cell.loop === place && Boolean(cell.quantity), (cell) => {
      const value = answer && answer.value(cell);
      return typeof value === "number" ? measuredText(value, 0) : value;
    }, false);
  }

  // Give some cells new contents, and write the columns that have changed.
  change(isMeant, contentOf, coarse) {
    const meant = new Set(this.cells.filter(isMeant));
    for (const cell of meant) {
      Object.assign(cell, { content: contentOf(cell), coarse });
      if (cell.content === null && cell.span) {
        cell.span.remove();
        cell.span = null;
      }
      if (cell.content !== null && !cell.span) {
        cell.span = elementOf(this.document, "span", "live-number");
        cell.span.setAttribute("aria-live", "off");
        cell.element.append(cell.span);
      }
    }
    const isNew = (cell) => meant.has(cell);
    this.columns.filter(({ cells }) => cells.some(isNew)).forEach((column) => column.write(isNew));
  }
}

function openTables(document, data) {
  return new LiveTables(document, data);
}
