// A scene: facts, indices with and without drive, field, weights, curves, stress.

import { h, section, factList, table } from "./dom.js";
import { fixed, percent, significant } from "./numbers.js";
import { fieldView, unpackField, unpackModal } from "./field.js";
import { weightsView } from "./weights.js";
import { curvesView } from "./curves.js";
import { timeView } from "./time.js";

/** Section of one scene; `number` counts from 1. */
export function sceneSection(scene, number, model, geometry) {
  const name = scene.name ? `Scene ${number}: ${scene.name}` : `Scene ${number}`;
  return section(`scene-${number}`, name, ...sceneBody(scene, number, model, geometry));
}

/** The content of the section; `light` leaves the curves out, which take time. */
export function sceneBody(coded, number, model, geometry, light = false) {
  const scene = { ...coded, field: unpackField(coded.field), modal: model && unpackModal(coded.modal) };
  return [
    factList(scene.facts),
    indexTable(scene),
    levels(scene),
    scene.field ? fieldView(scene, model, geometry, `field-${number}`).element : h("p", {}, "The field is not shown: weights alone do not carry it, and their scene and model do not lie beside them."),
    weightsView(scene, geometry, `weights-${number}`),
    timeView(scene.time, geometry, `time-${number}`),
    light ? null : curvesView(scene, model),
    stressView(scene),
  ].filter(Boolean);
}

function indexTable(scene) {
  const { points, area } = scene.indices;
  const least = area && area.hot_ratio !== null && area.cold_ratio !== null ? Math.min(area.hot_ratio, area.cold_ratio) : null;
  const row = (name, ...shares) => [name, ...shares.map((share) => ({ number: percent(share) }))];
  return table([`Share that keeps its limit (${scene.judged_on})`, { number: "At the responses" }, { number: "Over the area" }, { number: "With no drive" }], [
    row("Hot ground that is felt", points.hot_ratio, area?.hot_ratio, 0),
    row("Cold ground that is quiet", points.cold_ratio, area?.cold_ratio, 1),
    row("The smaller of the two", points.min_ratio, least, 0),
    row("Hot and cold together", points.success_ratio, null, points.silence_ratio),
  ], { class: "indices" });
}

function levels({ indices: { points }, field }) {
  const hasLevels = field?.levels.some((level) => level > 1);
  const db = (value) => (value === null || value === undefined ? "–" : `${fixed(value, 1)} dB`);
  const rows = [
    ["Contrast", `${db(points.contrast_db)} between the weakest hot${hasLevels ? " response, less the level of its zone," : ""} and the strongest cold response`],
    ["Margin", `${db(points.margin_db)} from the nearest limit${points.margin_db < 0 ? " (negative: some response misses it)" : ""}`],
  ];
  if (Number.isFinite(points.max_force_n)) rows.push(["Largest force", `${significant(1e3 * points.max_force_n, 3)} mN peak`]);
  if (Number.isFinite(points.max_voltage_v)) rows.push(["Largest voltage", `${significant(points.max_voltage_v, 3)} V peak`]);
  return factList(rows);
}

function stressView(scene) {
  if (!scene.stress?.length) return null;
  const bar = (share) => h("meter", { min: 0, max: 1, low: 0.8, high: 0.95, optimum: 1, value: share, "aria-hidden": "true" });
  const rows = scene.stress.map((row) => [row.trial, { number: String(row.cases) }, { number: percent(row.success_mean) }, { number: percent(row.success_worst_5_percent) }, { number: percent(row.min_worst_5_percent) }, bar(row.success_worst_5_percent)]);
  return h("div", { class: "stress" }, h("h3", {}, "When the panel is not the model"),
    table(["Trial", { number: "Cases" }, { number: "Responses served, mean" }, { number: "95 % of the cases reach" }, { number: "The same, smaller of hot and cold" }, ""], rows, {}));
}
