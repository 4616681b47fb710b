"use strict";

// The bars and points of a figure drawn again from live numbers: a bar slimmer than the printed one behind it, a point
// at the end of a thin line from the printed one. A number that is not finite is a word in their place.

const LIVE_THICKNESS = 0.6; // of a printed bar
const WORD_SIZE = 0.85; // of the letters of the figure: a word in the place of a bar or a point
const BESIDE_MARK = 4; // points between the start of a bar, or a point, and this word

// Words that belong to a printed bar or point: they move with it as they are, and come back as they were.
class PrintedWords {
  constructor(element, x, y) {
    Object.assign(this, { element, x, y });
  }

  moveBy([acrossBy, acrossTo], [upBy, upTo]) {
    const across = (acrossBy - 1) * this.x + acrossTo, up = (upBy - 1) * this.y + upTo;
    this.element.setAttribute("transform", `translate(${coordinate(across)} ${coordinate(up)})`);
  }

  restore() {
    this.element.removeAttribute("transform");
  }
}

// The words of a group of bars or points, each with the middle of its bar, or its point, on the printed sheet.
function printedWords(group, look, x, y) {
  return [...group.querySelectorAll(".words")].map((element) => {
    const i = Number(element.dataset.index);
    if (look.look === "points") return new PrintedWords(element, x.printedAt(look.x[i]), y.printedAt(look.y[i]));
    const middle = (x.printedAt(look.starts[i]) + x.printedAt(look.ends[i])) / 2;
    return new PrintedWords(element, middle, y.printedAt(look.places[i]));
  });
}

// A live bar or point, one of those of a printed group.
class LiveMark {
  constructor(look, index, printed, size, parent) {
    Object.assign(this, { look, index, size, numbers: {} });
    this.printed = [...printed.querySelectorAll(`[data-index="${index}"]`)];
    for (const element of this.printed) element.classList.add("pinned");
    this.sample = printed.querySelector(".mark use");
    this.element = svgElement("g", { class: "live-mark" }, parent);
  }

  // Take new numbers: those along x and y, of which one may stay as printed.
  take(numbers) {
    this.numbers = numbers;
  }

  // Widen the ranges of both rulers by the numbers.
  widen(across, up, x, y) {
    widen(across, [this.numbers.x], [0], x.printed.scale);
    widen(up, [this.numbers.y], [0], y.printed.scale);
  }

  draw(x, y, box) {
    this.element.replaceChildren();
    if (this.look.look === "bars") this.drawBar(x, y, box);
    else this.drawPoint(x, y);
  }

  drawBar(x, y, { left, width }) {
    const { look, index } = this, value = this.numbers.x, inside = (at) => Math.min(left + width, Math.max(left, at));
    const start = inside(x.at(look.starts[index])), end = inside(x.at(value)), middle = y.at(look.places[index]);
    if (!(Number.isFinite(value) && Number.isFinite(end))) return this.say(value, start, middle);
    const half = LIVE_THICKNESS * Math.abs(y.at(look.thick) - y.at(0)) / 2;
    const foot = coordinate(middle + half), head = coordinate(middle - half);
    const path = `M${coordinate(start)} ${foot}H${coordinate(end)}V${head}H${coordinate(start)}z`;
    const style = `fill: ${look.fill}; stroke: ${look.color}; stroke-width: 0.6`;
    svgElement("path", { d: path, style }, this.element);
    const text = numberLike(look.texts[index] ?? "", look.ends[index], value);
    const size = Math.min(this.size, 2 * half);
    if (!text || size * textWidth(text) + 3 > Math.abs(end - start)) return;
    const base = middle + DIGIT_HEIGHT * size / 2;
    const written = writeNumber(text, "", (start + end) / 2, base, size, "middle", this.element);
    written.setAttribute("style", `fill: ${look.ink}; stroke: none`);
  }

  drawPoint(x, y) {
    const { look, index, numbers } = this, printed = [x.at(look.x[index]), y.at(look.y[index])];
    const now = [x.at(numbers.x ?? look.x[index]), y.at(numbers.y ?? look.y[index])];
    const odd = [numbers.x, numbers.y].find((number) => number !== undefined && !Number.isFinite(number));
    if (odd !== undefined || !now.every(Number.isFinite)) return this.say(odd ?? numbers.x ?? numbers.y, ...printed);
    const path = `M${printed.map(coordinate).join(" ")}L${now.map(coordinate).join(" ")}`;
    svgElement("path", { d: path, style: `fill: none; stroke: ${look.color}; stroke-width: 0.6` }, this.element);
    const mark = this.element.appendChild(this.sample.cloneNode());
    mark.setAttribute("x", coordinate(now[0]));
    mark.setAttribute("y", coordinate(now[1]));
  }

  // A word in the place of a number that is not finite; one that has no logarithm is written.
  say(value, x, y) {
    const size = WORD_SIZE * this.size, odd = value === Infinity ? "never" : "diverged";
    const word = Number.isFinite(value) ? withMinus(Number(value.toPrecision(3))) : odd;
    writeNumber(word, "", x + BESIDE_MARK, y + DIGIT_HEIGHT * size / 2, size, "start", this.element);
  }

  remove() {
    this.element.remove();
    for (const element of this.printed) element.classList.remove("pinned");
  }
}

// A number with as many decimals as a text that is the printed one; nothing if the text is anything else.
function numberLike(text, printed, value) {
  const found = /^[-−]?\d+(?:\.(\d+))?$/.exec(text);
  if (!found) return "";
  const decimals = (found[1] ?? "").length;
  const same = Math.abs(Number(text.replace("−", "-")) - printed) <= 0.5 * 10 ** -decimals * (1 + 1e-9);
  return same ? withMinus(value.toFixed(decimals)) : "";
}
