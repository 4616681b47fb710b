"use strict";

// The points of a curve that are drawn, by the rules of curves.py and style.py, and their paths in an SVG.

const FAR_OFF = 1e5; // points: no coordinate is written beyond, as some browsers draw such lines wrongly

// The places [first, last) of ascending numbers within limits, and one to each side; all if they run back anywhere.
function windowPlaces(x, low, high) {
  if (runsBack(x, 0, x.length)) return [0, x.length];
  const first = placeBefore(x, low, false) + 1, last = placeBefore(x, high, false) + 1;
  return [Math.max(0, first - 1), Math.min(x.length, Math.max(last + 1, 2))];
}

// The place of the last of ascending numbers that is below a limit, or, with `equal`, at it; -1 if none is.
function placeBefore(x, limit, equal) {
  let low = 0, high = x.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (x[middle] < limit || (equal && x[middle] === limit)) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

// True if numbers are not in ascending order.
function runsBack(x, first, last) {
  for (let i = first + 1; i < last; i++) if (x[i] < x[i - 1]) return true;
  return false;
}

// The places of about `points` of the points [first, last) of a curve, by the rule of `thinned` in curves.py: each of
// equally long stretches keeps its extremes, and one gap if it has any; so are both ends. With `straight`, which makes an
// uneven ruler even, the stretches are as wide on it.
function thinnedPlaces(x, y, first, last, points, straight = null) {
  const n = last - first;
  if (n <= points) return Int32Array.from({ length: n }, (_, i) => first + i);
  const back = runsBack(x, first, last), sources = back ? [x, y] : [y];
  const stretches = Math.max(1, Math.floor(points / (2 * sources.length)));
  const kept = new Int32Array(3 * stretches * sources.length + 2);
  const ends = stretchEnds(x, first, last, stretches, back ? null : straight);
  let count = 1;
  kept[0] = first;
  for (let i = 0; i < stretches; i++) {
    const begin = ends[i], end = ends[i + 1], before = count;
    if (begin === end) continue;
    for (const source of sources) count = keepExtremes(source, begin, end, kept, before, count);
  }
  if (kept[count - 1] < last - 1) kept[count++] = last - 1;
  return kept.subarray(0, count);
}

// The ends of some stretches of the points [first, last): as many points in each, or as wide on an uneven ruler.
function stretchEnds(x, first, last, stretches, straight) {
  const ends = new Int32Array(stretches + 1), step = (last - first) / stretches;
  const low = straight?.(x[first]), high = straight?.(x[last - 1]);
  for (let i = 1, place = first; i < stretches; i++) {
    if (straight) while (place < last && straight(x[place]) < low + (high - low) * i / stretches) place++;
    ends[i] = straight ? place : first + Math.trunc(i * step);
  }
  [ends[0], ends[stretches]] = [first, last];
  return ends;
}

// Keep the places of the least and the greatest number of a stretch, and of its first gap, among those kept `from` some
// place on, in their order and each once; returns how many are kept then.
function keepExtremes(source, begin, end, kept, from, count) {
  let low = Infinity, high = -Infinity, least = begin, greatest = begin, gap = -1;
  for (let i = begin; i < end; i++) {
    const value = source[i];
    if (value < low) {
      low = value;
      least = i;
    }
    if (value > high) {
      high = value;
      greatest = i;
    } else if (value !== value && gap < 0) gap = i;
  }
  count = keepPlace(kept, from, count, least);
  count = keepPlace(kept, from, count, greatest);
  return gap < 0 ? count : keepPlace(kept, from, count, gap);
}

// Keep one place more, in order, unless it is kept already; returns how many are kept then.
function keepPlace(kept, from, count, place) {
  let at = count;
  while (at >= from && kept[at - 1] >= place) at--;
  if (at < count && kept[at] === place) return count;
  for (let k = count; k > at; k--) kept[k] = kept[k - 1];
  kept[at] = place;
  return count + 1;
}

// True if the drawn numbers cover their own range many times over, by the rule of `line_of` in style.py.
function chatters(y, places) {
  let count = 0, path = 0, before = NaN, low = Infinity, high = -Infinity;
  for (const place of places) {
    const value = y[place];
    if (!Number.isFinite(value)) continue;
    if (count++) path += Math.abs(value - before);
    if (value < low) low = value;
    if (value > high) high = value;
    before = value;
  }
  return count > 100 && path > 20 * (high - low);
}

// Widen [least, most] by the numbers at some places that a scale can show.
function widen(range, numbers, places, scale) {
  for (const place of places) {
    const number = numbers[place];
    if (!Number.isFinite(number) || (scale === "log" && number <= 0)) continue;
    if (number < range[0]) range[0] = number;
    if (number > range[1]) range[1] = number;
  }
}

let pathBytes = new Uint8Array(65536); // a path while it is written: bytes are much faster than pieces of text
const pathReader = new TextDecoder();
const [BYTE_MINUS, BYTE_POINT, BYTE_SPACE, BYTE_ZERO] = [...new TextEncoder().encode("-. 0")];
const [BYTE_MOVE, BYTE_LINE, BYTE_SIDE, BYTE_HEIGHT] = [...new TextEncoder().encode("MLHV")];

// A coordinate with two decimals.
function coordinate(value) {
  return String(Math.round(100 * Math.min(FAR_OFF, Math.max(-FAR_OFF, value))) / 100);
}

// Write a command of a path, or a space, and a coordinate with two decimals; returns where the next begins.
function putCoordinate(at, command, value) {
  const rounded = Math.round(100 * Math.min(FAR_OFF, Math.max(-FAR_OFF, value)));
  let n = rounded < 0 ? -rounded : rounded, whole = (n / 100) | 0, digit = 1;
  pathBytes[at++] = command;
  if (rounded < 0) pathBytes[at++] = BYTE_MINUS;
  while (whole >= 10 * digit) digit *= 10;
  for (; digit >= 1; digit = (digit / 10) | 0) pathBytes[at++] = BYTE_ZERO + ((whole / digit) | 0) % 10;
  n -= 100 * whole;
  if (!n) return at;
  pathBytes[at++] = BYTE_POINT;
  pathBytes[at++] = BYTE_ZERO + ((n / 10) | 0);
  if (n % 10) pathBytes[at++] = BYTE_ZERO + n % 10;
  return at;
}

// The path of a line or of steps through the points at some places; a number without a place is a gap.
function pathOf(across, up, x, y, places, steps) {
  if (pathBytes.length < 32 * places.length) pathBytes = new Uint8Array(64 * places.length);
  let end = 0, on = false;
  for (let k = 0; k < places.length; k++) {
    const place = places[k], at = across(x[place]), height = up(y[place]);
    if (steps && on) end = putCoordinate(end, BYTE_SIDE, at);
    if (!(Math.abs(height) < Infinity && Math.abs(at) < Infinity)) on = false;
    else if (steps && on) end = putCoordinate(end, BYTE_HEIGHT, height);
    else {
      end = putCoordinate(putCoordinate(end, on ? BYTE_LINE : BYTE_MOVE, at), BYTE_SPACE, height);
      on = true;
    }
  }
  return pathReader.decode(pathBytes.subarray(0, end));
}

// The commands and the points of a printed path, which has absolute moves and lines alone, and may be closed.
function pathPoints(path) {
  const found = [...path.matchAll(/([MLz])(?: (\S+) (\S+))?/g)];
  const column = (i) => Float64Array.from(found, (command) => Number(command[i]));
  return { commands: Uint8Array.from(found, (command) => command[1].charCodeAt(0)), x: column(2), y: column(3) };
}

// The path of such points where they have moved to.
function movedPath({ commands, x, y }, across, up) {
  if (pathBytes.length < 32 * x.length) pathBytes = new Uint8Array(64 * x.length);
  let end = 0;
  for (let k = 0; k < x.length; k++) {
    if (x[k] === x[k]) end = putCoordinate(putCoordinate(end, commands[k], across(x[k])), BYTE_SPACE, up(y[k]));
    else pathBytes[end++] = commands[k]; // it closes the path
  }
  return pathReader.decode(pathBytes.subarray(0, end));
}
