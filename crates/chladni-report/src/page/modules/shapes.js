// Mode shapes: moving in three dimensions, and as Chladni's figure from above.

import { h, section, choice } from "./dom.js";
import { array, split } from "./data.js";
import { state, listen, change } from "./store.js";
import { colourAt } from "./colour.js";
import { fixed } from "./numbers.js";
import { refined, contours } from "./surface.js";
import { panelMap, colourBar } from "./panel_map.js";
import { turned } from "./complexity.js";
import { motionOf } from "./structure.js";
import { space } from "./space.js";

const CONTOURS = [0.2, 0.4, 0.6, 0.8];
const COLUMNS = 110;

/** The geometry with its numbers unpacked. */
export function unpackGeometry(geometry) {
  if (!geometry) return null;
  const grid = geometry.grid && { x: geometry.grid.x, y: geometry.grid.y, shapes: split(array(geometry.grid.shapes)) };
  return { ...geometry, grid };
}

/** Section of the shapes. */
export function shapeSection(model, geometry, structure) {
  if (!model.inBand.length) return null;
  if (!structure) {
    return section("shapes", "Mode shapes", h("p", {}, "The file holds no positions of the measured nodes, so that no shape can be drawn. Convert the measurement with its geometry, or add the nodes."));
  }
  const axisOnly = geometry?.grid && geometry.shown.length < model.responses.length ? ` The map shows the motion along one axis, at ${geometry.shown.length} of ${model.responses.length} response DOFs.` : "";
  const map = geometry?.grid ? " On the map full lines are contours of motion one way, dashed ones of motion the other way, thick lines stand still." : "";
  const words = `Each shape is turned to the phase at which it is as real as can be; its largest motion is +1.${map}${axisOnly}${aboutStructure(structure)}`;
  return section("shapes", "Mode shapes", h("p", {}, words), ...shapeView(model, geometry, structure));
}

/** Remarks on the picture in space. */
function aboutStructure(structure) {
  const still = structure.count - new Set(structure.moves.filter(Boolean).map(([node]) => node)).size;
  const parts = ["", "Dashed grey is the structure at rest."];
  if (still) parts.push(still === 1 ? "1 node was not measured and stays at rest." : `${still} nodes were not measured and stay at rest.`);
  if (structure.turned) parts.push("The file gives motion along the beam in axes of its own nodes; it is drawn across the beam.");
  return parts.join(" ");
}

function modeChoice(model) {
  const names = model.inBand.map((k, place) => `${place + 1}: ${fixed(model.modes[k].frequency_hz, 2)} Hz${model.modes[k].trust === "weak" ? ", weak" : ""}`);
  const list = choice("Mode", names, 0, (place) => change({ mode: model.inBand[place] }));
  list.select.id = "mode";
  const step = (by) => change({ mode: model.inBand[(Math.max(0, model.inBand.indexOf(state.mode)) + by + model.inBand.length) % model.inBand.length] });
  const buttons = [["‹", -1, "mode before"], ["›", 1, "next mode"]].map(([text, by, label]) => h("button", { type: "button", "aria-label": label, onclick: () => step(by) }, text));
  const show = () => { list.select.selectedIndex = model.inBand.indexOf(state.mode); };
  listen(["mode"], show);
  return h("div", { class: "controls" }, list.element, ...buttons);
}

/** The shape of mode `n` on the grid, turned to the phase at which it is most real. */
export function shapeSurface(model, geometry, n) {
  const { x, y, shapes } = geometry.grid;
  const count = x.length * y.length;
  const part = (list) => Array.from(list.subarray(n * count, (n + 1) * count));
  return { x, y, ...turned(part(shapes.re), part(shapes.im)) };
}

/** A choice of the mode, its shape in space, and the map where the responses span one. */
export function shapeView(model, geometry, structure) {
  const moving = space("Mode shape in three dimensions");
  moving.canvas.id = "shape-3d";
  const map = geometry?.grid ? panelMap(geometry.box, geometry.axes, "Mode shape from above", 560) : null;
  const title = h("p", { class: "figure-title" });
  const show = () => {
    const n = state.mode;
    const mode = model.modes[n];
    const surface = map && shapeSurface(model, geometry, n);
    title.textContent = `Mode ${model.inBand.indexOf(n) + 1}: ${fixed(mode.frequency_hz, 2)} Hz, η = ${fixed(100 * mode.loss_factor, 2)} %, MPC ${fixed(mode.mpc, 3)}`;
    if (surface && !structure.joined) moving.set({ surface });
    else moving.set({ structure, motion: motionOf(model, structure, n) });
    if (!map) return;
    const fine = refined({ ...surface, im: null }, COLUMNS);
    const lines = (sense) => CONTOURS.flatMap((part) => contours(fine.x, fine.y, fine.re, sense * part));
    map.draw({
      surface: fine,
      colour: (k) => (Number.isNaN(fine.re[k]) ? null : colourAt("diverging", 0.5 + 0.5 * fine.re[k])),
      contours: [
        { lines: lines(1), style: "thin" }, { lines: lines(-1), style: "thin dashed" },
        { lines: contours(fine.x, fine.y, fine.re, 0), style: "nodal" },
      ],
      marks: [{ points: geometry.places, style: "response", mark: "dot" }],
      extra: signs(surface),
    });
  };
  listen(["mode"], show);
  show();
  const bar = colourBar((value) => colourAt("diverging", 0.5 + 0.5 * value), [-1, 1], "shape, largest = 1", [{ value: 0, style: "nodal" }]);
  const views = [h("figure", {}, moving.element), map ? h("figure", {}, map.element, bar) : null];
  return [modeChoice(model), title, h("div", { class: "pair" }, views)];
}

/** + and − at the extremes: grey does not tell them apart. */
function signs({ x, y, re }) {
  const extreme = (sense) => re.reduce((best, value, k) => (sense * value > sense * (re[best] ?? -sense * Infinity) ? k : best), -1);
  return ({ px, s }) => [["+", 1], ["−", -1]].filter(([, sense]) => sense * re[extreme(sense)] > 0.1).map(([text, sense]) => {
    const k = extreme(sense);
    const [left, top] = px([x[k % x.length], y[Math.floor(k / x.length)]]);
    return s("text", { class: "zone-name", x: left, y: top + 4, "text-anchor": "middle" }, text);
  });
}
