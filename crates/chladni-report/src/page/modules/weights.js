// Weights: phasors at the places of the actuators, and amplitude and phase one by one.

import { h, s, table } from "./dom.js";
import { cssColour } from "./colour.js";
import { fixed } from "./numbers.js";
import { panelMap } from "./panel_map.js";
import { described } from "./described.js";

/** A unit that gives short numbers, and the factor to it. */
function scaled(weights, unit) {
  const most = Math.max(...weights.map(amplitude));
  const [factor, prefix] = [[1, ""], [1e3, "m"], [1e6, "µ"]].find(([factor]) => most * factor >= 0.5) ?? [1e9, "n"];
  return { factor, unit: `${prefix}${unit} peak`, most };
}

const amplitude = (weight) => Math.hypot(weight.re, weight.im);
const phaseDeg = (weight) => (Math.atan2(weight.im, weight.re) * 180) / Math.PI;

/** Both views of a scene's weights. */
export function weightsView(scene, geometry, id) {
  const { weights } = scene;
  const scale = scaled(weights, scene.unit);
  const hint = (weight) => `${weight.reference}: ${fixed(amplitude(weight) * scale.factor, 3)} ${scale.unit}, ${fixed(phaseDeg(weight), 1)}°`;
  const parts = [];
  if (geometry && weights.every((weight) => weight.place)) parts.push(ring(scene, geometry, scale, hint, id));
  else parts.push(h("p", {}, "The positions of the actuators are not known; their weights are listed one by one."));
  parts.push(...described(scene.by_actuator, `${id}-list`).map((one) => one.element));
  const rows = weights.map((weight) => [weight.reference, { number: fixed(amplitude(weight) * scale.factor, 4) }, { number: fixed(phaseDeg(weight), 2) }]);
  parts.push(h("details", { class: "weight-list" }, h("summary", {}, "Weights as a table"), table(["Actuator", { number: `Amplitude (${scale.unit})` }, { number: "Phase (°)" }], rows, {})));
  return h("div", {}, parts);
}

function ring(scene, geometry, scale, hint, id) {
  const { weights } = scene;
  const map = panelMap(geometry.box, geometry.axes, "Weights around the panel", 620);
  map.svg.id = id;
  let nearest = Infinity;
  weights.forEach((a, k) => weights.slice(0, k).forEach((b) => {
    const gap = Math.hypot(a.place[0] - b.place[0], a.place[1] - b.place[1]);
    if (gap > 0) nearest = Math.min(nearest, gap);
  }));
  const [x0, y0, x1, y1] = geometry.box;
  map.draw({
    outlines: [{ points: [[x0, y0], [x1, y0], [x1, y1], [x0, y1]], style: "area" }],
    extra: ({ px, scale: zoom }) => weights.flatMap((weight) => {
      const [x, y] = px(weight.place);
      const most = Math.max(5, Math.min(24, 0.55 * nearest * zoom));
      const radius = Math.max(1.5, scale.most ? most * Math.sqrt(amplitude(weight) / scale.most) : 0);
      const angle = Math.atan2(weight.im, weight.re);
      const d = `M${x} ${y}L${x + radius * Math.cos(angle)} ${y - radius * Math.sin(angle)}`;
      return [
        s("circle", { class: "phasor", cx: x, cy: y, r: radius, fill: cssColour("cyclic", angle / (2 * Math.PI) + 0.5), "data-reference": weight.reference }, s("title", {}, hint(weight))),
        s("path", { class: "hand-casing", d }), s("path", { class: "hand", d }),
      ];
    }),
  });
  const words = "The area of a disc is the amplitude of the actuator there. Its hand and colour are the phase: right 0°, up 90°, left 180°.";
  return h("figure", {}, h("p", { class: "figure-title" }, `Weights around the panel, largest ${fixed(scale.most * scale.factor, 2)} ${scale.unit}`), map.element, h("figcaption", {}, words));
}
