// Curves of one scene: over drive frequency, over the number of modes, over the number of actuators.

import { h } from "./dom.js";
import { chart } from "./chart.js";
import { fixed } from "./numbers.js";
import { atResponses, shares } from "./field.js";

/** Frequencies of the curve of unchanged weights, and how far it goes, part of the drive frequency. */
const POINTS = 121;
const BESIDE = 0.06;

const percentAxis = { label: "Responses served", unit: "%", range: [-2, 104] };

const toPercent = (values) => values.map((value) => 100 * value);

/** Speeds at the responses. */
function speeds({ re, im }) {
  return re.map((value, k) => Math.hypot(value, im[k]));
}

function series(x, points) {
  return [["hot", "hot-line"], ["cold", "cold-line"], ["both", "both-line"]].map(([key, style]) => ({ name: key, x, y: toPercent(points.map((point) => point[key])), style }));
}

/** All curves that a scene's data allow. */
export function curvesView(scene, model) {
  const parts = [];
  if (scene.sweep) parts.push(sweepChart(scene));
  if (scene.field && scene.modal) parts.push(overFrequency(scene, model));
  if (scene.curves?.modes.length) parts.push(overModes(scene.curves, scene));
  if (scene.curves?.actuators.length) parts.push(overActuators(scene.curves, scene));
  return parts.length ? h("div", { class: "curves" }, parts) : null;
}

function sweepChart(scene) {
  const rows = scene.sweep.frequencies;
  const x = rows.map((row) => row.frequency_hz);
  const touched = rows.some((row) => row.touched_ratio !== null);
  const list = [{ name: "undisturbed", x, y: rows.map((row) => 100 * row.success_ratio), style: "both-line" }];
  if (touched) list.push({ name: "with a finger in the hot zone", x, y: rows.map((row) => (row.touched_ratio === null ? NaN : 100 * row.touched_ratio)), style: "cold-line" });
  const suggested = scene.sweep.suggested_hz === null ? "" : `Suggested: ${fixed(scene.sweep.suggested_hz, 1)} Hz.`;
  return chart({
    title: "The scene at other drive frequencies, each with weights of its own", caption: suggested, height: 240,
    x: { label: "Drive frequency", unit: "Hz", range: [Math.min(...x), Math.max(...x)] }, y: percentAxis, series: list,
    marks: [{ points: rows.map((row) => [row.frequency_hz, 100 * row.success_ratio]), style: "kept", sign: "dot" }],
  }).element;
}

function overFrequency(scene, model) {
  const f = scene.frequency_hz;
  const x = Array.from({ length: POINTS }, (_, k) => f * (1 + BESIDE * ((2 * k) / (POINTS - 1) - 1)));
  const points = x.map((hz) => shares(scene.field, speeds(atResponses(scene, model, hz))));
  const near = model.inBand.map((k) => model.frequency[k]).filter((hz) => hz >= x[0] && hz <= x[POINTS - 1]);
  return chart({
    title: "These weights at other frequencies, in the model", height: 240,
    caption: "How far the drive may drift, or the panel warm up, before the scene is lost.",
    x: { label: "Frequency", unit: "Hz", range: [x[0], x[POINTS - 1]] }, y: percentAxis, series: series(x, points),
    verticals: [{ name: "drive frequency", at: [f], style: "band-line" }, { name: "natural frequency", at: near, style: "pole-line" }],
  }).element;
}

/** Over the number of modes or of actuators; `own` is what the scene's own weights have of them. */
function overCount(points, label, title, caption, own, scene) {
  const x = points.map((point) => point.count);
  const served = scene.indices.points.success_ratio;
  return chart({
    title, caption, height: 240,
    x: { label, unit: "number", range: [0.5, Math.max(2, x[x.length - 1] + 0.5)] }, y: percentAxis, series: series(x, points),
    marks: [
      { points: points.map((point) => [point.count, 100 * point.both]), style: "kept", sign: "dot" },
      { name: `this scene's own weights (${scene.method})`, points: [[own, 100 * served]], style: "doubted", sign: "square" },
    ],
  }).element;
}

function overModes({ method, modes }, scene) {
  const caption = `For each number weights of their own, made by method ${method} with the modes that count most at the drive frequency, the others folded into residual terms. All are judged in the whole model.`;
  return overCount(modes, "Modes summed", "The scene with fewer modes", caption, scene.modes_used, scene);
}

function overActuators({ method, actuators }, scene) {
  const caption = `For each number weights of their own, made by method ${method} for the actuators that are strongest in this scene's weights. Rendering for a given number of actuators chooses them better.`;
  return overCount(actuators, "Actuators driven", "The scene with fewer actuators", caption, scene.actuators_used, scene);
}
