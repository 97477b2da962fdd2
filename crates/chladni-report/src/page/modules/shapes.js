// Mode shapes: moving in three dimensions, and as Chladni's figure from above.

import { h, section, choice } from "./dom.js";
import { array, split } from "./data.js";
import { state, listen, change } from "./store.js";
import { colourAt } from "./colour.js";
import { fixed } from "./numbers.js";
import { refined, contours } from "./surface.js";
import { panelMap, colourBar } from "./panel_map.js";
import { turned, turnedShape } from "./complexity.js";
import { space } from "./space.js";

const CONTOURS = [0.2, 0.4, 0.6, 0.8];
const COLUMNS = 110;

/** The geometry with its numbers unpacked. */
export function unpackGeometry(geometry) {
  if (!geometry) return null;
  const grid = geometry.grid && { x: geometry.grid.x, y: geometry.grid.y, shapes: split(array(geometry.grid.shapes)) };
  return { ...geometry, xyz: array(geometry.xyz), grid };
}

/** Section of the shapes. */
export function shapeSection(model, geometry) {
  if (!model.inBand.length) return null;
  if (!geometry) {
    return section("shapes", "Mode shapes", h("p", {}, "The file holds no positions of the nodes, so that no shape can be drawn. Convert the measurement with its geometry, or add the nodes."));
  }
  const body = geometry.grid ? onGrid(model, geometry) : atPoints(model, geometry);
  const axisOnly = geometry.shown.length < model.responses.length ? ` Shown is the motion along one axis, at ${geometry.shown.length} of ${model.responses.length} response DOFs.` : "";
  const words = `Each shape is turned to the phase at which it is as real as can be; its largest motion is +1. Full lines are contours of motion one way, dashed ones of motion the other way, thick lines stand still.${axisOnly}`;
  return section("shapes", "Mode shapes", h("p", {}, words), ...body);
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

/** The shape of mode `n` on the grid, turned real. */
export function shapeSurface(model, geometry, n) {
  const { x, y, shapes } = geometry.grid;
  const count = x.length * y.length;
  const part = (list) => Array.from(list.subarray(n * count, (n + 1) * count));
  return { x, y, ...turned(part(shapes.re), part(shapes.im)) };
}

function onGrid(model, geometry) {
  const moving = space("Mode shape in three dimensions");
  moving.canvas.id = "shape-3d";
  const map = panelMap(geometry.box, geometry.axes, "Mode shape from above", 560);
  const title = h("p", { class: "figure-title" });
  const show = () => {
    const n = state.mode;
    const mode = model.modes[n];
    const surface = shapeSurface(model, geometry, n);
    title.textContent = `Mode ${model.inBand.indexOf(n) + 1}: ${fixed(mode.frequency_hz, 2)} Hz, η = ${fixed(100 * mode.loss_factor, 2)} %, MPC ${fixed(mode.mpc, 3)}`;
    moving.set({ surface });
    const fine = refined({ ...surface, im: null }, COLUMNS);
    const lines = (sense) => CONTOURS.flatMap((part) => contours(fine.x, fine.y, fine.re, sense * part));
    map.draw({
      surface: fine,
      colour: (k) => (Number.isNaN(fine.re[k]) ? null : colourAt("diverging", 0.5 + 0.5 * fine.re[k])),
      contours: [
        { pieces: lines(1), style: "thin" }, { pieces: lines(-1), style: "thin dashed" },
        { pieces: contours(fine.x, fine.y, fine.re, 0), style: "nodal" },
      ],
      marks: [{ points: geometry.places, style: "response", mark: "dot" }],
      extra: signs(surface),
    });
  };
  listen(["mode"], show);
  show();
  const bar = colourBar((value) => colourAt("diverging", 0.5 + 0.5 * value), [-1, 1], "shape, largest = 1", [{ value: 0, style: "nodal" }]);
  return [modeChoice(model), title, h("div", { class: "pair" }, h("figure", {}, moving.element), h("figure", {}, map.element, bar))];
}

/** + and − at the extremes, so that grey tells them apart. */
function signs({ x, y, re }) {
  const extreme = (sense) => re.reduce((best, value, k) => (sense * value > sense * (re[best] ?? -sense * Infinity) ? k : best), -1);
  return ({ px, s }) => [["+", 1], ["−", -1]].filter(([, sense]) => sense * re[extreme(sense)] > 0.1).map(([text, sense]) => {
    const k = extreme(sense);
    const [left, top] = px([x[k % x.length], y[Math.floor(k / x.length)]]);
    return s("text", { class: "zone-name", x: left, y: top + 4, "text-anchor": "middle" }, text);
  });
}

function atPoints(model, geometry) {
  const moving = space("Mode shape in three dimensions");
  moving.canvas.id = "shape-3d";
  const title = h("p", { class: "figure-title" });
  const show = () => {
    const mode = model.modes[state.mode];
    title.textContent = `Mode ${model.inBand.indexOf(state.mode) + 1}: ${fixed(mode.frequency_hz, 2)} Hz`;
    moving.set({ xyz: geometry.xyz, ...turnedShape(model, state.mode, geometry.shown, geometry.signs) });
  };
  listen(["mode"], show);
  show();
  return [modeChoice(model), title, h("figure", {}, moving.element)];
}
