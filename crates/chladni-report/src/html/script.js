"use strict";
// Without this script the page shows every figure; with it, one of several at choice, and values under the pointer.
for (const choice of document.querySelectorAll(".choice")) {
  const figures = [...choice.querySelectorAll("figure")], select = choice.querySelector("select");
  const show = () => figures.forEach((figure, k) => { figure.hidden = k !== select.selectedIndex; });
  choice.querySelector("label").hidden = false;
  select.addEventListener("change", show);
  show();
}

const value = ([low, high, log], part) => log ? low * (high / low) ** part : low + (high - low) * part;
const digits = (number, span) => {
  const places = Math.max(0, Math.min(9, 3 - Math.floor(Math.log10(Math.abs(span) || 1))));
  return number.toFixed(places).replace("-", "−");
};

// Points of a path in the writer's form: M x y l dx dy dx dy ... M ...
function points(path) {
  const out = [];
  for (const part of path.getAttribute("d").split("M").slice(1)) {
    const [x, y, ...steps] = (part.match(/-?\d*\.?\d+/g) || []).map(Number);
    let here = [x, y];
    out.push(here);
    for (let k = 0; k + 1 < steps.length; k += 2) {
      here = [here[0] + steps[k], here[1] + steps[k + 1]];
      out.push(here);
    }
  }
  return out;
}

for (const svg of document.querySelectorAll("svg")) {
  const plots = [...svg.querySelectorAll(".plot")].map((group) => ({ group, ...JSON.parse(group.dataset.plot) }));
  const figure = svg.closest("figure");
  if (!plots.length || !figure) continue;
  const readout = document.createElement("div");
  readout.className = "readout";
  readout.hidden = true;
  figure.append(readout);
  svg.addEventListener("pointerleave", () => { readout.hidden = true; });
  svg.addEventListener("pointermove", (event) => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const plot = plots.find(({ box: [l, t, r, b] }) => at.x >= l && at.x <= r && at.y >= t && at.y <= b);
    readout.hidden = !plot;
    if (!plot) return;
    const [left, top, right, bottom] = plot.box;
    const xText = (px) => digits(value(plot.x, (px - left) / (right - left)), plot.x[1] - plot.x[0]) + " " + plot.units[0];
    const yText = (px) => digits(value(plot.y, (bottom - px) / (bottom - top)), plot.y[1] - plot.y[0]) + " " + plot.units[1];
    plot.curves ??= [...plot.group.querySelectorAll("path[data-name]")]
      .filter((path) => path.getAttribute("fill") === "none").map((path) => ({ name: path.dataset.name, list: points(path) }));
    const lines = [xText(at.x)];
    for (const { name, list } of plot.curves.filter(({ list }) => list.length > 200)) {
      const near = list.reduce((best, point) => Math.abs(point[0] - at.x) < Math.abs(best[0] - at.x) ? point : best);
      if (Math.abs(near[0] - at.x) < 3) lines.push(name + ": " + yText(near[1]));
    }
    if (lines.length === 1) lines.push(yText(at.y));
    readout.textContent = lines.join("\n");
    const place = figure.getBoundingClientRect(), x = event.clientX - place.left, y = event.clientY - place.top;
    const beyond = x + 16 + readout.offsetWidth > place.width;
    readout.style.left = (beyond ? Math.max(0, x - 12 - readout.offsetWidth) : x + 16) + "px";
    readout.style.top = y + 12 + "px";
  });
}
