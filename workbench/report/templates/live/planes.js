"use strict";

// Planes of complex numbers drawn again: points and arrows as whole sets, axes of one scale that grow together, and the
// lines of constant damping and natural frequency of a map of poles, by the rules of `pole_maps.py`.

const ARROW_HEAD = 6.5, ARROW_HALF = 2.4; // points, as in plane.py
const DAMPING_LINES = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95];
const RING_COUNT = 5; // lines of natural frequencies, about
const GRID_LETTERS = 6.5; // points
const GRID_ROOM = 9; // points between two names of a grid

// The paths of a cross, a ring and a dot about a point.
function shapePath(shape, x, y) {
  const at = (dx, dy) => `${coordinate(x + dx)} ${coordinate(y + dy)}`, r = shape === "pole" ? 2.8 : 2.1;
  if (shape === "pole") return `M${at(-r, -r)}L${at(r, r)}M${at(-r, r)}L${at(r, -r)}`;
  return `M${at(-r, 0)}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`;
}

// All points, or all arrows, of a mark, in place of the printed ones; or pale, of an earlier run or of a held setting.
class LiveSet {
  constructor(look, printed, kind, parent) {
    Object.assign(this, { look, printed, kind });
    const name = kind === "now" ? "live-set" : `live-pale live-set ${kind}`;
    this.element = svgElement("g", { class: name }, parent);
    if (kind === "now") printed?.classList.add("pinned");
  }

  take({ x, y, u, v, label }) {
    Object.assign(this, { x, y, u, v, label });
  }

  draw(across, up, box, size) {
    const { look, x, y, u, v } = this, places = [...x.keys()].filter((k) => isInBox(across.at(x[k]), up.at(y[k]), box));
    const paths = places.map((k) => {
      const at = [across.at(x[k]), up.at(y[k])];
      return u ? headPath(...at, across.slope * u[k], up.slope * v[k]) : shapePath(look.shape, ...at);
    });
    const fill = u ? look.color : look.shape === "pole" ? "none" : "var(--cffffff, #ffffff)";
    this.element.replaceChildren();
    if (!paths.length) return;
    const style = `fill: ${fill}; stroke: ${look.color}; stroke-width: ${u ? 0 : 1.2}`;
    svgElement("path", { d: paths.join(""), style }, this.element);
    if (!this.label) return;
    const top = places.reduce((best, k) => (y[k] > y[best] ? k : best), places[0]);
    writeNumber(this.label, "", across.at(x[top]) + 5, up.at(y[top]) - 3, size, "start", this.element);
  }

  remove() {
    this.element.remove();
    if (this.kind === "now") this.printed?.classList.remove("pinned");
  }
}

function isInBox(x, y, { left, top, width, height }) {
  return x >= left - 1 && x <= left + width + 1 && y >= top - 1 && y <= top + height + 1;
}

// The head of an arrow with its middle at a point, along a direction on the sheet.
function headPath(x, y, u, v) {
  const size = Math.hypot(u, v), [a, b] = [u / size, v / size];
  if (!(size > 0)) return "";
  const tip = [x + a * ARROW_HEAD / 2, y + b * ARROW_HEAD / 2], base = [tip[0] - a * ARROW_HEAD, tip[1] - b * ARROW_HEAD];
  const corners = [tip, [base[0] - b * ARROW_HALF, base[1] + a * ARROW_HALF], [base[0] + b * ARROW_HALF, base[1] - a * ARROW_HALF]];
  return `M${corners.map((corner) => corner.map(coordinate).join(" ")).join("L")}z`;
}

// Let both rulers of a panel of equal axes hold their printed ranges and others, and a unit be as long on both; gives
// which of them has changed.
function fitEqual(x, y, across, up) {
  const ends = [[x, across], [y, up]].map(([{ printed }, [least, most]]) => [Math.min(printed.low, least), Math.max(printed.high, most)]);
  const still = ends.every(([low, high], i) => low === [x, y][i].printed.low && high === [x, y][i].printed.high);
  if (still || x.printed.fixed || !ends.flat().every(Number.isFinite)) return [x.set(x.printed.low, x.printed.high), y.set(y.printed.low, y.printed.high)];
  const unit = Math.max(...ends.map(([low, high], i) => (high - low) / Math.abs([x, y][i].length)));
  return [x, y].map((ruler, i) => {
    const middle = (ends[i][0] + ends[i][1]) / 2, half = unit * Math.abs(ruler.length) / 2;
    return ruler.set(middle - half, middle + half);
  });
}

// Some five round numbers up to the most.
function ringsUpTo(most) {
  const wanted = Math.max(most / RING_COUNT, 1e-300), power = 10 ** Math.floor(Math.log10(wanted));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= wanted * (1 - 1e-12)) ?? most;
  return Array.from({ length: 11 }, (_, k) => step * (k + 1)).filter((ring) => ring <= most);
}

// The lines of a map of poles for the ranges of its rulers: [{x, y, name}].
function poleGrid(x, y, period) {
  const arc = (radius, from, to, map = (point) => point) => Array.from({ length: 61 }, (_, k) => {
    const angle = from + (to - from) * k / 60;
    return map([radius * Math.cos(angle), radius * Math.sin(angle)]);
  });
  const line = (points, name) => ({ points, name }), half = Math.PI / 2;
  if (period === null) {
    const reach = 2.5 * Math.max(Math.abs(x.low), y.high), rings = ringsUpTo(Math.max(-x.low, 0.5 * y.high));
    const rays = DAMPING_LINES.flatMap((damping) => {
      const angle = Math.PI - Math.acos(damping), at = (sign) => [[0, 0], [reach * Math.cos(angle), sign * reach * Math.sin(angle)]];
      return [line(at(1), String(damping)), line(at(-1), "")];
    });
    return [...rays, ...rings.map((ring) => line(arc(ring, half, 3 * half), `${shortNumber(ring, 3)} rad/s`))];
  }
  const map = ([a, b]) => [Math.exp(a) * Math.cos(b), Math.exp(a) * Math.sin(b)]; // z of s times the period
  const top = Math.PI / period, seen = Math.min(top, Math.max(Math.abs(x.low - 1), y.high) / period);
  const spirals = DAMPING_LINES.flatMap((damping) => [1, -1].map((sign) => {
    const root = Math.sqrt(1 - damping ** 2), points = Array.from({ length: 100 }, (_, k) => {
      const size = (Math.PI / root) * k / 99;
      return map([-damping * size, sign * root * size]);
    });
    return line(points, sign > 0 ? String(damping) : "");
  }));
  const rings = [...ringsUpTo(0.99 * seen), ...(seen >= top ? [top] : [])].flatMap((ring) => [1, -1].map((sign) =>
    line(arc(ring * period, half, Math.PI, ([a, b]) => map([a, sign * b])), sign > 0 ? `${shortNumber(ring, 3)} rad/s` : "")));
  return [...spirals, ...rings];
}

// Draw the lines of a grid within a panel, each with its name at its last point in the panel, off the names before.
function drawGrid(lines, across, up, box, parent) {
  const names = [], inner = { left: box.left + 8, top: box.top + 6, width: box.width - 16, height: box.height - 12 };
  const paths = lines.map(({ points, name }) => {
    const at = points.map(([x, y]) => [across.at(x), up.at(y)]);
    if (name) nameLine(at, name, inner, names);
    return `M${at.map((point) => point.map(coordinate).join(" ")).join("L")}`;
  });
  svgElement("path", { class: "live-guides", d: paths.join("") }, parent);
  for (const { x, y, name } of names) writeNumber(name, "", x, y + 0.35 * GRID_LETTERS, GRID_LETTERS, "middle", parent);
}

// The place of the name of a line: the last point within a box that is off the names before, if there is one.
function nameLine(points, name, box, names) {
  const width = GRID_LETTERS * 0.5 * name.length, dense = points.flatMap(([x, y], k) => {
    const [a, b] = points[k + 1] ?? [x, y];
    return Array.from({ length: 24 }, (_, i) => [x + (a - x) * i / 24, y + (b - y) * i / 24]);
  });
  for (const [x, y] of dense.reverse()) {
    if (!isInBox(x - width / 2, y, box) || !isInBox(x + width / 2, y, box)) continue;
    const free = names.every((one) => Math.abs(one.y - y) > GRID_ROOM || Math.abs(one.x - x) > (one.width + width) / 2 + 2);
    if (free) return void names.push({ x, y, name, width });
  }
}
