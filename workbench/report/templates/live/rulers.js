"use strict";

// The ruler of a panel that grows where live numbers leave it, with its marks and their numbers.

const NICE_STEPS = [1, 2, 2.5, 5, 10];
const MOST_MARKS = 9; // at a ruler, as at the printed ones
const ROOM_ACROSS = 3, ROOM_UPWARDS = 2; // sizes of the letters: the room that a number takes along a ruler
const LETTER_WIDTHS = { ".": 0.25, "−": 0.69 }; // of the size of the letters; a digit takes half of it
const SMALLEST_LETTERS = 0.7; // of their printed size, where wide numbers have little room
const AIR = 0.02; // of a ruler that has grown: the least distance of the curves from its ends

// The ends of a ruler that holds its printed range and all numbers from least to most; a grown end stands at a mark.
function grownRange(ruler, least, most, count) {
  const straight = straightOf(ruler), printed = [straight(ruler.low), straight(ruler.high)];
  const wanted = [Math.min(printed[0], straight(least)), Math.max(printed[1], straight(most))];
  const whole = wanted[1] - wanted[0];
  if (ruler.fixed || !(whole > printed[1] - printed[0]) || !Number.isFinite(whole)) return [ruler.low, ruler.high];
  const step = ruler.scale === "log" ? 1 : niceStep(whole, count, ruler.steps).step, air = ruler.scale === "log" ? 0 : AIR * whole;
  const low = wanted[0] < printed[0] ? step * Math.floor((wanted[0] - air) / step) : printed[0];
  const high = wanted[1] > printed[1] ? step * Math.ceil((wanted[1] + air) / step) : printed[1];
  const back = ruler.scale === "log" ? (number) => 10 ** number : (number) => number;
  return [low === printed[0] ? ruler.low : back(low), high === printed[1] ? ruler.high : back(high)];
}

// The function that makes a ruler even, as `straight` in rulers.py does.
function straightOf({ scale, low, high, cut }) {
  if (scale === "log") return Math.log10;
  if (typeof cut !== "number") return (number) => number;
  const slope = (cut - low) / (high - cut);
  return (number) => (number > cut ? cut + slope * (number - cut) : number);
}

// The step 1, 2, 2.5 or 5 times a power of ten that divides a length into at most `count` parts, and its decimals; or
// the least of the `steps` that does, as 45 degrees.
function niceStep(length, count, steps = []) {
  const own = steps.find((one) => length / one <= count * (1 + 1e-9));
  if (own) return { step: own, decimals: -Math.floor(Math.log10(own)) };
  const power = Math.floor(Math.log10(length / count)), part = length / count / 10 ** power;
  const nice = NICE_STEPS.find((one) => part <= one * (1 + 1e-9)) ?? 10;
  return {step: Number(`${nice}e${power}`), decimals: (nice === 2.5 ? 1 : 0) - power - (nice === 10 ? 1 : 0)};
}

// The marks of a ruler: [place, text before the raised part, raised part], and the power of ten that all share, or 0.
// Where their numbers are wider than the room, in sizes of the letters, even in the smallest letters, there are fewer.
function rulerMarks(scale, low, high, count, room, steps = []) {
  if (scale === "log") return { power: 0, marks: decades(Math.log10(low), Math.log10(high), count) };
  const fits = ({ marks }) => SMALLEST_LETTERS * widestText(marks) <= room;
  const choices = Array.from({ length: Math.max(1, count - 1) }, (_, i) => linearMarks(low, high, count - i, room, steps));
  const enough = choices.filter(({ marks }) => marks.length > 1), narrow = (a, b) => widestText(a.marks) - widestText(b.marks);
  return choices.find(fits) ?? [...(enough.length ? enough : choices)].sort(narrow)[0];
}

// The marks of an even ruler with at most so many parts.
function linearMarks(low, high, count, room, steps) {
  const { step, decimals } = niceStep(high - low, count, steps), places = [];
  for (let k = Math.ceil(low / step - 1e-9); k <= high / step + 1e-9; k++) places.push(k * step);
  const largest = Math.floor(Math.log10(Math.max(...places.map(Math.abs))));
  const written = (power) => places.map((place) => [place, decimalText(place, power, decimals), ""]);
  const plain = written(0);
  if (!Number.isFinite(largest)) return { power: 0, marks: plain }; // no mark but that of 0
  const short = written(largest);
  if (largest >= 4 || largest <= -3) return { power: largest, marks: short };
  const shared = SMALLEST_LETTERS * widestText(plain) > room && widestText(short) < widestText(plain);
  return shared ? { power: largest, marks: short } : { power: 0, marks: plain };
}

// Powers of ten between two exponents, at most so many.
function decades(low, high, count) {
  const step = Math.max(1, Math.ceil((high - low) / count)), marks = [];
  for (let k = step * Math.ceil(low / step - 1e-9); k <= high + 1e-9; k += step) {
    marks.push([10 ** k, "10", withMinus(k)]);
  }
  return marks;
}

// A number over a power of ten, with the decimals that its step has.
function decimalText(number, power, decimals) {
  const text = (number / 10 ** power).toFixed(Math.min(20, Math.max(0, decimals + power)));
  return withMinus(Number(text) === 0 ? text.replace("-", "") : text);
}

// A number as text with a true minus sign.
function withMinus(number) {
  return String(number).replace("-", "−");
}

// The width of the widest text, in sizes of its letters.
function widestText(marks) {
  return Math.max(0, ...marks.map(([, text, raised]) => textWidth(text) + 0.7 * textWidth(raised)));
}

// The width of a text, in sizes of its letters.
function textWidth(text) {
  return [...text].reduce((sum, letter) => sum + (LETTER_WIDTHS[letter] ?? 0.5), 0);
}

// A ruler along a side of a panel: its printed range, and the range that it has grown to.
class LiveRuler {
  constructor(printed, start, length, letters) {
    Object.assign(this, { printed, start, length, low: printed.low, high: printed.high });
    this.straight = straightOf(printed);
    this.even = printed.scale !== "log" && typeof printed.cut !== "number";
    const room = letters.size * (length < 0 ? ROOM_UPWARDS : ROOM_ACROSS);
    this.count = Math.max(1, Math.min(MOST_MARKS, Math.floor(Math.abs(length) / room)));
    this.measure();
  }

  // Keep what places numbers: coordinate = offset + slope * number, or its logarithm.
  measure() {
    const low = this.straight(this.low), slope = this.length / (this.straight(this.high) - low);
    const offset = this.start - slope * low, { straight } = this;
    this.slope = slope;
    this.offset = offset;
    this.at = this.even ? (number) => offset + slope * number : (number) => offset + slope * straight(number);
  }

  get grown() {
    return this.low !== this.printed.low || this.high !== this.printed.high;
  }

  // Grow to hold all numbers from least to most, or go back to the printed range; true if the range has changed.
  fit(least, most) {
    return this.set(...grownRange(this.printed, least, most, this.count));
  }

  // Stand from low to high; true if that is new.
  set(low, high) {
    if (low === this.low && high === this.high) return false;
    [this.low, this.high] = [low, high];
    this.measure();
    return true;
  }

  // The coordinate of a number on the printed sheet.
  printedAt(number) {
    const low = this.straight(this.printed.low), whole = this.straight(this.printed.high) - low;
    return this.start + this.length * (this.straight(number) - low) / whole;
  }

  // The move of a coordinate of the printed sheet to where its number stands now: [factor, shift].
  get move() {
    const low = this.straight(this.printed.low), slope = this.length / (this.straight(this.printed.high) - low);
    const factor = this.slope / slope;
    return [factor, this.offset - factor * (this.start - slope * low)];
  }
}
