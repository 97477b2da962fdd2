// Complexity plot: the responses of one shape in the complex plane.

import { h, section } from "./dom.js";
import { state, listen } from "./store.js";
import { chart } from "./chart.js";
import { fixed } from "./numbers.js";

/** A mode's shape at the responses, turned to the phase at which it is most real, with a largest motion of 1. */
export function turnedShape(model, n, indices, signs) {
  const rows = model.responses.length;
  const re = indices.map((k, i) => model.shape.re[n * rows + k] * signs[i]);
  const im = indices.map((k, i) => model.shape.im[n * rows + k] * signs[i]);
  return turned(re, im);
}

/** The same for any {re, im}. */
export function turned(re, im) {
  let [a, b] = [0, 0];
  re.forEach((value, k) => {
    if (Number.isNaN(value)) return;
    a += value * value - im[k] * im[k];
    b += 2 * value * im[k];
  });
  const phase = Math.atan2(b, a) / 2;
  const [c, s] = [Math.cos(phase), -Math.sin(phase)];
  const out = { re: re.map((value, k) => value * c - im[k] * s), im: im.map((value, k) => value * c + re[k] * s) };
  const largest = out.re.reduce((most, value) => (Math.abs(value) > Math.abs(most) ? value : most), 0);
  const scale = largest ? 1 / largest : 0;
  return { re: out.re.map((value) => value * scale), im: out.im.map((value) => value * scale) };
}

/** Section of the plot, for the selected mode. */
export function complexitySection(model) {
  if (!model.inBand.length) return null;
  const all = model.responses.map((_, k) => k);
  const ones = all.map(() => 1);
  const axis = (label) => ({ label, unit: "largest = 1", range: [-1.15, 1.15] });
  const view = chart({ square: true, still: true, x: axis("Real part"), y: axis("Imaginary part"), horizontals: [{ at: 0, style: "zero-line" }] });
  view.svg.id = "complexity-chart";
  const show = () => {
    const mode = model.modes[state.mode];
    const { re, im } = turnedShape(model, state.mode, all, ones);
    view.update({
      title: `Mode ${model.inBand.indexOf(state.mode) + 1}, ${fixed(mode.frequency_hz, 2)} Hz: MPC ${fixed(mode.mpc, 3)}, MPD ${fixed(mode.mpd_deg, 1)}°, MCF ${fixed(mode.mcf, 3)}`,
      caption: "Every dot is a response. A real mode lies on the line; a cloud around it is complexity, or noise.",
      marks: [{ points: re.map((value, k) => [value, im[k]]), style: "kept", sign: "dot" }],
    });
  };
  listen(["mode"], show);
  show();
  return section("complexity", "Complexity", h("p", { class: "hint" }, "The mode is chosen with the mode shapes, or in the pole table."), view.element);
}
