// Curves of one scene: over drive frequency, over the number of modes, over the number of actuators.

import { h } from "./dom.js";
import { chart } from "./chart.js";
import { described } from "./described.js";
import { atResponses, shares } from "./field.js";

/** Number of frequencies of the curve of unchanged weights, and its reach on either side, part of the drive frequency. */
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

const drawn = (figure) => described(figure, `${figure.name}-chart`).map((one) => one.element);

/** All curves for which a scene has data. */
export function curvesView(scene, model) {
  const parts = [];
  if (scene.sweep) parts.push(...drawn(scene.sweep));
  if (scene.field && scene.modal) parts.push(overFrequency(scene, model));
  parts.push(...scene.curves.flatMap(drawn));
  return parts.length ? h("div", { class: "curves" }, parts) : null;
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
