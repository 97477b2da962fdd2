// The field of a scene: level re threshold, zones, limits, and the responses that miss their limits; the same field moving.

import { h, s, slider } from "./dom.js";
import { array, split } from "./data.js";
import { colourAt, cssColour } from "./colour.js";
import { level, fixed, signed } from "./numbers.js";
import { refined, contours } from "./surface.js";
import { panelMap, colourBar } from "./panel_map.js";
import { velocity } from "./synthesis.js";
import { space } from "./space.js";

/** Ends of the colours, dB re threshold. */
export const RANGE_DB = 12;
const COLUMNS = 200;
/** Reach of the slider on either side of the drive frequency, part of it. */
const BESIDE = 0.1;

const [IGNORED, COLD, HOT] = [0, 1, 2];
/** Part of a limit that a velocity may miss it by: the page has velocities in single precision. */
const ROUNDING = 1e-6;

/** A scene's field with its numbers unpacked; null where only the weights are known. */
export function unpackField(field) {
  if (!field) return null;
  const surface = field.surface && { x: field.surface.x, y: field.surface.y, ...split(array(field.surface.velocity)), ground: array(field.surface.ground) };
  return { ...field, ground: array(field.ground), velocity: split(array(field.velocity)), ground_on_grid: array(field.ground_on_grid), surface };
}

/** A scene's drive in modal coordinates. */
export function unpackModal(modal) {
  if (!modal) return null;
  const on = modal.terms_on_grid && split(array(modal.terms_on_grid));
  return { forces: split(array(modal.forces)), mirrored: split(array(modal.mirrored)), terms: split(array(modal.terms)), termsOnGrid: on };
}

/** Limits of a field, dB re threshold: hot ground lies above `hot`, in the loudest zone above `loudest`, cold ground below `cold`. */
export function limitsOf(field) {
  const [hot, cold] = [field.felt, field.quiet].map((speed) => level(speed / field.threshold));
  return { hot, cold, loudest: hot + level(Math.max(1, ...field.levels)) };
}

/** True where a response keeps its limit. */
export function keeps(field, k, speed) {
  if (field.ground[k] === HOT) return speed >= field.felt * field.levels[k] * (1 - ROUNDING);
  return field.ground[k] !== COLD || speed <= field.quiet * (1 + ROUNDING);
}

/** Shares of judged responses that keep their limits: {hot, cold, both}. */
export function shares(field, speeds) {
  const of = (wanted) => {
    const judged = speeds.map((_, k) => k).filter((k) => wanted(field.ground[k]));
    return judged.length ? judged.filter((k) => keeps(field, k, speeds[k])).length / judged.length : NaN;
  };
  return { hot: of((ground) => ground === HOT), cold: of((ground) => ground === COLD), both: of((ground) => ground !== IGNORED) };
}

/** The field's map with its colour bar, a slider over frequency where the model is at hand, and the moving surface. */
export function fieldView(scene, model, geometry, id) {
  const { field } = scene;
  const box = geometry?.box ?? [0, 1].map((k) => Math.min(...field.places.map((place) => place[k]))).concat([0, 1].map((k) => Math.max(...field.places.map((place) => place[k]))));
  const map = panelMap(box, geometry?.axes ?? ["x", "y"], `Field at ${fixed(scene.frequency_hz, 1)} Hz`);
  map.svg.id = id;
  const title = h("p", { class: "figure-title" });
  const said = h("p", { class: "muted", role: "status" });
  const limits = limitsOf(field);
  const moving = field.surface ? space(`Field at ${fixed(scene.frequency_hz, 1)} Hz in three dimensions`) : null;

  function show(frequencyHz) {
    const here = frequencyHz === scene.frequency_hz || !scene.modal;
    const surface = here ? field.surface : elsewhere(scene, model, geometry, frequencyHz);
    const at = here ? field.velocity : atResponses(scene, model, frequencyHz);
    title.textContent = `Field at ${fixed(frequencyHz, 1)} Hz (${here ? scene.judged_on : "the same weights in the model"})`;
    const speeds = Array.from(at.re, (re, k) => Math.hypot(re, at.im[k]));
    const { hot, cold, both } = shares(field, speeds);
    said.textContent = `At the responses: hot ${fixed(100 * hot, 1)} %, cold ${fixed(100 * cold, 1)} %, both ${fixed(100 * both, 1)} % keep their limits.`;
    map.draw(fieldLayers(field, surface, speeds, limits));
    if (moving && surface) moving.set({ surface });
  }

  const parts = [title, map.element, levelBar(limits, "sequential"), said];
  if (scene.modal?.termsOnGrid && geometry?.grid) {
    const f = scene.frequency_hz;
    const step = Number((f / 2000).toPrecision(1));
    const control = slider("The same weights at", { min: f * (1 - BESIDE), max: f * (1 + BESIDE), step: "any", value: f, words: (hz) => `${fixed(hz, 1)} Hz` }, (hz) => show(Math.abs(hz - f) < step ? f : hz));
    const back = h("button", { type: "button", onclick: () => { control.set(f); show(f); } }, "Drive frequency");
    parts.push(h("div", { class: "controls" }, control.element, back));
  }
  show(scene.frequency_hz);
  const maps = h("figure", {}, ...parts, h("figcaption", {}, caption(field, limits)));
  return { element: h("div", { class: "pair" }, maps, moving ? h("figure", {}, h("p", { class: "figure-title" }, "The field in motion"), moving.element) : null), map };
}

/** The signs of responses that miss their limits, on discs. */
export const DISC_SIGNS = "✕ too loud  △ too weak";

/** Radius of the disc of a response, px. */
const RADIUS = 7;

function caption(field, { hot, cold, loudest }) {
  const lines = field.surface ? [" (full line)", " (dashed line); hatched ground is not judged"] : ["", `; ${DISC_SIGNS}`];
  const louder = loudest > hot ? `, in the loudest zone above ${signed(loudest)} dB` : "";
  return `Level of the velocity re the threshold of ${fixed(1e3 * field.threshold, 3)} mm/s peak. Hot ground is to lie above ${signed(hot)} dB${lines[0]}${louder}, cold ground below ${signed(cold)} dB${lines[1]}. Levels beyond ±${RANGE_DB} dB have the colours of the ends.`;
}

/** The colours of levels, with the limits. */
export function levelBar({ hot, cold }, map) {
  const colour = (value) => colourAt(map, 0.5 + (0.5 * value) / RANGE_DB);
  return colourBar(colour, [-RANGE_DB, RANGE_DB], "dB re threshold", [{ value: hot, style: "felt" }, { value: cold, style: "quiet" }]);
}

/** Layers of the map for a surface and speeds at the responses: `look` = {columns, map, stripe} of the pixels. */
export function fieldLayers(field, surface, speeds, limits, look = { columns: COLUMNS, map: "sequential", stripe: [255, 255, 255] }) {
  const judged = (wanted) => speeds.map((_, k) => k).filter(wanted);
  const marks = [
    [judged((k) => field.ground[k] === HOT && keeps(field, k, speeds[k])), "response hot-mark", "triangle", "felt as wished"],
    [judged((k) => field.ground[k] === COLD && keeps(field, k, speeds[k])), "response cold-mark", "ring", "quiet as wished"],
    [judged((k) => field.ground[k] === IGNORED), "response", "dot", "not judged"],
    [judged((k) => !keeps(field, k, speeds[k])), "response missed", "cross", "misses its limit"],
  ].map(([list, style, mark, word]) => ({
    points: list.map((k) => field.places[k]), style, mark,
    hints: list.map((k) => `${field.names[k]}: ${fixed(level(speeds[k] / field.threshold), 1)} dB re threshold, ${word}`),
  }));
  const [x0, y0, x1, y1] = field.area_m;
  const outlines = [{ points: [[x0, y0], [x1, y0], [x1, y1], [x0, y1]], style: "area" }, ...field.hot.map((points) => ({ points, style: "hot-zone", text: "hot" }))];
  if (!surface) return { outlines, extra: discs(field, speeds, look.map) };
  const fine = refined(surface, look.columns);
  const levels = fine.re.map((re, k) => {
    const speed = Math.hypot(re, fine.im[k]);
    return Number.isNaN(speed) ? NaN : level(Math.max(1e-15, speed / field.threshold));
  });
  const ground = groundAt(surface);
  const colour = (k, x, y, row, column) => {
    if (Number.isNaN(levels[k])) return null;
    const hatched = ground(x, y) === IGNORED && (row + column) % 6 < 2;
    return hatched ? look.stripe : colourAt(look.map, 0.5 + (0.5 * levels[k]) / RANGE_DB);
  };
  const lines = (at, style) => ({ lines: contours(fine.x, fine.y, levels, at), style });
  return { surface: fine, colour, contours: [lines(limits.hot, "felt"), lines(limits.cold, "quiet")], outlines, marks };
}

/** A disc for each response, with a cross on cold ones that are felt and a triangle on hot ones that are not. */
function discs(field, speeds, map) {
  return ({ px }) => field.places.flatMap((place, k) => {
    const [x, y] = px(place);
    const db = level(Math.max(1e-15, speeds[k] / field.threshold));
    const missed = !keeps(field, k, speeds[k]);
    const isHot = field.ground[k] === HOT;
    const words = `${field.names[k]}: ${fixed(db, 1)} dB re threshold, ${missed ? (isHot ? "too weak" : "too loud") : "as wished or not judged"}`;
    const disc = s("circle", { class: missed ? "measured-point missed-point" : "measured-point", cx: x, cy: y, r: RADIUS, fill: cssColour(map, 0.5 + (0.5 * db) / RANGE_DB) }, s("title", {}, words));
    if (!missed) return [disc];
    const d = isHot ? `M${x} ${y - 4.5}l4.5 8h-9z` : `M${x - 4} ${y - 4}l8 8m0 -8l-8 8`;
    return [disc, s("path", { class: "missed-sign casing", d }), s("path", { class: "missed-sign", d })];
  });
}

function groundAt({ x, y, ground }) {
  if (!ground) return () => COLD;
  const place = (axis, value) => Math.max(0, Math.min(axis.length - 1, Math.round(((value - axis[0]) / (axis[axis.length - 1] - axis[0])) * (axis.length - 1))));
  return (px, py) => ground[place(y, py) * x.length + place(x, px)];
}

/** The field of the weights at another frequency, on the grid of the shapes. */
function elsewhere(scene, model, geometry, frequencyHz) {
  const { x, y, shapes } = geometry.grid;
  return { x, y, ground: scene.field.ground_on_grid, ...velocity(model, scene.modal, shapes, scene.modal.termsOnGrid, frequencyHz) };
}

/** The field of the weights at another frequency, at the responses. `keepsMode` may leave modes out. */
export function atResponses(scene, model, frequencyHz, keepsMode) {
  const all = velocity(model, scene.modal, model.shape, scene.modal.terms, frequencyHz, keepsMode);
  const places = scene.field.names.map((name) => model.responses.indexOf(name));
  return { re: places.map((k) => all.re[k]), im: places.map((k) => all.im[k]) };
}
