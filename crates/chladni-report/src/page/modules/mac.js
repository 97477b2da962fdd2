// AutoMAC: the MAC of every shape with every other.

import { h, s, section } from "./dom.js";
import { array } from "./data.js";
import { change } from "./store.js";
import { colourAt, isDark } from "./colour.js";
import { fixed } from "./numbers.js";
import { colourBar } from "./panel_map.js";

/** Largest width of the matrix, width beside it, and least distance of the numbers at its edge, px. */
const WIDEST = 620;
const BESIDE = 100;
const NUMBER_GAP = 18;
/** Width of the title of the axis, px. */
const TITLE = 190;
/** MAC above which two shapes are hardly two modes. */
const HIGH = 0.5;

/** Section of the matrix. */
export function macSection(mac, model) {
  if (!mac) return null;
  const values = array(mac.values);
  const count = mac.count;
  const room = Math.min(WIDEST, document.documentElement.clientWidth - BESIDE);
  const side = Math.min(30, room / count);
  const size = side * count;
  // the title of the axis is longer than few modes
  const beside = Math.max(0, 0.5 * (TITLE - size));
  const cells = Array.from(values, (value, k) => {
    const [row, column] = [Math.floor(k / count), k % count];
    const rgb = colourAt("white", value);
    const hint = `modes ${row + 1} and ${column + 1}, ${name(model, row)} and ${name(model, column)}: MAC ${fixed(value, 3)}`;
    const y = size - (row + 1) * side;
    const parts = [s("rect", { x: column * side, y, width: side, height: side, fill: `rgb(${rgb.join(",")})` }, s("title", {}, hint))];
    if (side >= 22 && value >= 0.005) {
      parts.push(s("text", { class: isDark(rgb) ? "on-dark" : "on-light", x: (column + 0.5) * side, y: y + side / 2 + 3, "text-anchor": "middle", "font-size": 9 }, fixed(value, 2)));
    }
    return parts;
  });
  const every = [1, 2, 5, 10, 20].find((step) => step * side >= NUMBER_GAP) ?? 50;
  const numbers = Array.from({ length: count }, (_, k) => k + 1).filter((number) => number % every === 0).flatMap((number) => [
    s("text", { x: (number - 0.5) * side, y: size + 15, "text-anchor": "middle" }, number),
    s("text", { x: -6, y: size - (number - 0.5) * side + 4, "text-anchor": "end" }, number),
  ]);
  const svg = s("svg", { class: "chart mac", id: "mac-chart", viewBox: `${-48 - beside} -6 ${size + 54 + 2 * beside} ${size + 44}`, width: size + 54 + 2 * beside, height: size + 44, role: "img", "aria-label": "AutoMAC matrix" },
    cells, numbers, s("rect", { class: "frame", x: 0, y: 0, width: size, height: size }),
    s("text", { x: size / 2, y: size + 33, "text-anchor": "middle" }, "Mode (number in the pole table)"),
    s("text", { transform: `translate(-34 ${size / 2}) rotate(-90)`, "text-anchor": "middle" }, "Mode"));
  svg.addEventListener("click", (event) => {
    const cell = [...svg.querySelectorAll("rect")].indexOf(event.target);
    if (cell >= 0 && cell < values.length) change({ mode: model.inBand[Math.floor(cell / count)] });
  });
  return section("mac", "AutoMAC", h("p", {}, words(values, count)), h("figure", {}, h("div", { class: "scroll" }, svg), colourBar((value) => colourAt("white", value), [0, 1], "MAC, 0 to 1")));
}

function name(model, row) {
  return `${fixed(model.modes[model.inBand[row]].frequency_hz, 1)} Hz`;
}

function words(values, count) {
  let [most, at] = [-1, [0, 0]];
  for (let row = 0; row < count; row++) {
    for (let column = row + 1; column < count; column++) {
      if (values[row * count + column] > most) [most, at] = [values[row * count + column], [row + 1, column + 1]];
    }
  }
  if (most < 0) return "One shape agrees with itself.";
  const verdict = most > HIGH ? "Shapes that agree so far are hardly two modes, or the responses are too few to tell them apart." : "The responses tell all shapes apart.";
  return `The largest value beside the diagonal is ${fixed(most, 3)} (modes ${at.join(" and ")}). ${verdict}`;
}
