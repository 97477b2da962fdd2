// Curves of one scene: over drive frequency, over the number of modes, over the number of actuators.

import { h } from "./dom.js";
import { chart } from "./chart.js";
import { array, split } from "./data.js";
import { fixed } from "./numbers.js";
import { atResponses, shares } from "./field.js";
import { times } from "./synthesis.js";

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
export function curvesView(scene, model, frfs) {
  const parts = [];
  if (scene.sweep) parts.push(sweepChart(scene));
  if (scene.field && scene.modal) parts.push(overFrequency(scene, model), overModes(scene, model), overActuators(scene, model, frfs));
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
    title: "The scene at other drive frequencies, each with weights of its own (render --sweep)", caption: suggested, height: 240,
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

/** Modes in the order in which they count at the drive frequency: the share of motion that goes with each. */
function byImportance(scene, model) {
  const rows = model.responses.length;
  const omega = 2 * Math.PI * scene.frequency_hz;
  const size = (n) => {
    let square = 0;
    for (let k = 0; k < rows; k++) square += model.shape.re[n * rows + k] ** 2 + model.shape.im[n * rows + k] ** 2;
    const omegaN = 2 * Math.PI * model.frequency[n];
    const force = Math.hypot(scene.modal.forces.re[n], scene.modal.forces.im[n]);
    return (Math.sqrt(square) * force) / Math.hypot(omegaN ** 2 - omega ** 2, omegaN ** 2 * model.modes[n].loss_factor);
  };
  return [...model.inBand].sort((a, b) => size(b) - size(a));
}

function overModes(scene, model) {
  const order = byImportance(scene, model);
  const x = order.map((_, k) => k + 1);
  const inBand = new Set(model.inBand);
  const points = x.map((count) => {
    const kept = new Set(order.slice(0, count));
    return shares(scene.field, speeds(atResponses(scene, model, scene.frequency_hz, (n) => !inBand.has(n) || kept.has(n))));
  });
  return chart({
    title: "The field from its strongest modes alone", height: 240,
    caption: "The same weights; of the modes in the band only so many are summed, those that move most first. Weights made for fewer modes: render --modes N.",
    x: { label: "Modes summed", unit: "number", range: [0.5, Math.max(2, x.length + 0.5)] }, y: percentAxis, series: series(x, points),
    marks: [{ points: points.map((point, k) => [x[k], 100 * point.both]), style: "kept", sign: "dot" }],
  }).element;
}

/** `null` where the page does not carry the residual terms of every pair. */
function overActuators(scene, model, frfs) {
  const [rows, columns, powers] = [model.responses.length, model.references.length, model.powers.length];
  if (!frfs || frfs.responses.length < rows || frfs.references.length < columns) return null;
  const all = split(array(frfs.terms));
  const column = (weight) => model.references.indexOf(weight.reference);
  const order = [...scene.weights].filter((weight) => column(weight) >= 0).sort((a, b) => Math.hypot(b.re, b.im) - Math.hypot(a.re, a.im));
  const x = order.map((_, k) => k + 1);
  const zeros = (count) => ({ re: new Float64Array(count), im: new Float64Array(count) });
  const [forces, mirrored, terms] = [zeros(model.modeCount), zeros(model.modeCount), zeros(powers * rows)];
  const points = order.map((weight) => {
    const j = column(weight);
    const drive = [weight.re, weight.im];
    for (let n = 0; n < model.modeCount; n++) {
      const [a, b] = [model.participation.re[n * columns + j], model.participation.im[n * columns + j]];
      add(forces, n, times([a, b], drive));
      add(mirrored, n, times([a, -b], drive));
    }
    for (let k = 0; k < powers * rows; k++) add(terms, k, times([all.re[k * columns + j], all.im[k * columns + j]], drive));
    return shares(scene.field, speeds(atResponses({ ...scene, modal: { forces, mirrored, terms } }, model, scene.frequency_hz)));
  });
  return chart({
    title: "The field from the strongest actuators alone", height: 240,
    caption: "The same weights, the strongest first, the others still. Weights made for fewer actuators: render --actuators N.",
    x: { label: "Actuators driven", unit: "number", range: [0.5, Math.max(2, x.length + 0.5)] }, y: percentAxis, series: series(x, points),
    marks: [{ points: points.map((point, k) => [x[k], 100 * point.both]), style: "kept", sign: "dot" }],
  }).element;
}

function add(list, n, [re, im]) {
  list.re[n] += re;
  list.im[n] += im;
}
