"use strict";

// The pictures of a page: on a bench each can be hidden; and what a knob moves is brought into sight where none of it is.

const SEEN = 140; // px of a picture or a table that are enough to see it move

// Boxes above the grid of a bench, one for each picture.
function offerPictures() {
  const head = document.querySelector(".pictures-head"), figures = [...document.querySelectorAll(".pictures-grid figure")];
  if (!head || figures.length < 2) return;
  const boxes = figures.map((figure) => {
    const box = part("input", { type: "checkbox", checked: true });
    box.addEventListener("change", () => (figure.hidden = !box.checked));
    return part("label", {}, box, figure.dataset.title || figure.querySelector(".label").textContent);
  });
  head.append(part("fieldset", { class: "pictures-boxes", "aria-label": "Pictures shown" }, ...boxes));
}

// The height of the window above the bench, where that stands at the bottom.
function heightInSight(panel) {
  const { top, width } = panel.getBoundingClientRect();
  return width > 0.9 * innerWidth ? Math.min(innerHeight, top) : innerHeight;
}

// Bring the nearest of the pictures that loops move to the top of the window, unless one, or a table of theirs, is seen.
function bringIntoSight(data, places, panel) {
  const drawn = [...data.curves, ...data.marks, ...data.linear_marks];
  const names = new Set(drawn.filter(({ loop }) => places.has(loop)).map(({ figure }) => figure));
  const figures = [...document.querySelectorAll("[data-figure]")].filter((one) => names.has(one.dataset.figure) && !one.hidden);
  const cells = [...document.querySelectorAll("[data-cell]")].filter((one) => places.has(data.cells[one.dataset.cell]?.loop));
  const tables = new Set(cells.map((cell) => cell.closest("table")));
  const height = heightInSight(panel), boxes = new Map([...figures, ...tables].map((one) => [one, one.getBoundingClientRect()]));
  const seen = ({ top, bottom }) => Math.min(bottom, height) - Math.max(top, 0) >= Math.min(SEEN, bottom - top);
  if ([...boxes.values()].some(seen)) return;
  const distance = (one) => Math.abs(boxes.get(one).top);
  const [nearest] = (figures.length ? figures : [...tables]).sort((a, b) => distance(a) - distance(b));
  const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  nearest?.scrollIntoView({ block: "start", behavior: calm ? "auto" : "smooth" });
}
