// Stabilization diagram over the CMIF, with the model's poles and their error bars; clicks keep or drop poles.

import { h, section } from "./dom.js";
import { array } from "./data.js";
import { state, listen, change, toggleMode } from "./store.js";
import { chart, padded } from "./chart.js";
import { level, fixed, withBound, SIGMAS } from "./numbers.js";

const NAMES = ["largest singular value", "second", "third", "fourth", "fifth", "sixth"];
const KINDS = [["new at this order", "new", "cross"], ["stable in frequency", "in-frequency", "ring"], ["stable in frequency and damping", "stable", "dot"]];
/** Largest distance of a click from a pole, px. */
const REACH = 18;

/** Section of the diagram. */
export function stabilizationSection(data, model) {
  const { cmif, stabilization } = data;
  if (!cmif && !model) return null;
  const { lanes, ...spec } = diagram(data, model);
  const view = chart({ ...spec, height: 420, onrange: (zoom) => change({ range: zoom }) });
  view.svg.id = "stabilization-chart";
  const bars = model ? barChart(model) : null;
  const show = () => view.update(poleLayers(model, stabilization, lanes));
  listen(["dropped", "mode"], show);
  listen(["range"], () => [view, bars].forEach((one) => one?.zoomTo(state.range)));
  show();
  const how = model ? h("p", { class: "hint" }, "Click near a pole to drop it, again to keep it. With the keyboard: Page Up and Page Down choose a pole, Enter keeps or drops it.") : null;
  const missing = stabilization?.missing ? h("p", {}, `No stabilization diagram: ${stabilization.missing}.`) : null;
  return { element: section("stabilization", "Stabilization diagram", how, missing, view.element, bars?.element), view };
}

/** The chart of the diagram, and the heights of its pole marks; a click away from all poles calls `onempty(hz)`. */
export function diagram(data, model, onempty) {
  const { cmif, stabilization } = data;
  const ends = cmif ? endsOf(array(cmif.frequency_hz)) : model.band_hz;
  const curves = cmif ? cmifSeries(cmif) : [];
  const orders = stabilization?.orders ?? [];
  const top = orders.length ? orders[orders.length - 1] : 1;
  const lanes = { kept: top * 1.05, dropped: top * 1.05 };
  return {
    lanes,
    title: `${orders.length ? "Stabilization diagram over the CMIF" : "Complex mode indicator function"} ${cmif ? cmif.of : ""}`.trim(),
    caption: caption(stabilization),
    x: { label: "Frequency", unit: "Hz", range: ends },
    y: cmif ? { label: "Singular value", unit: cmif.unit, range: padded(curves.map((one) => one.y), 0.05, 140) } : { label: "", unit: "–", range: [0, 1] },
    right: orders.length || model ? { label: "Order of the denominator", unit: "poles", range: [0, top * 1.12] } : undefined,
    series: curves,
    onpick: (x, y, distance) => model && (pick(model, lanes, distance, x) || onempty?.(x)),
    onhover: (x, y, distance) => model && hover(model, lanes, distance, x),
    onkey: (key) => model && byKey(key, model),
  };
}

/** Curves of the singular values. */
export function cmifOf({ cmif }) {
  return cmif ? cmifSeries(cmif) : [];
}

function endsOf(list) {
  return [list[0], list[list.length - 1]];
}

function cmifSeries(cmif) {
  const x = array(cmif.frequency_hz);
  const values = array(cmif.values);
  return Array.from({ length: values.length / x.length }, (_, k) => ({
    name: NAMES[k], x, y: Float64Array.from(values.subarray(k * x.length, (k + 1) * x.length), level), style: `cmif cmif-${k}`,
  }));
}

function caption(stabilization) {
  const columns = "Damped poles of a common denominator (method lscf) at rising order: those of the structure come back at every order and make columns. ";
  return `${stabilization && !stabilization.missing ? columns : ""}The marks at the top are the poles of the model, found by its own method; their bars are 95 % bounds of the natural frequency.`;
}

/** Poles of every order, and those of the model. */
export function poleLayers(model, stabilization, lanes, compact = false) {
  const marks = [];
  if (stabilization?.order) {
    const [order, frequency, stability] = [array(stabilization.order), array(stabilization.frequency_hz), array(stabilization.stability)];
    KINDS.forEach(([name, style, sign], kind) => {
      const points = [];
      order.forEach((value, k) => { if (stability[k] === kind) points.push([frequency[k], value]); });
      marks.push({ name, points, style: compact && kind < 2 ? "new" : style, sign: compact ? ["tiny", "tiny", "small"][kind] : sign, right: true });
    });
  }
  if (!model) return { marks };
  const place = (k) => [model.frequency[k], state.dropped.has(k) ? lanes.dropped : lanes.kept];
  const of = (wanted) => model.inBand.filter(wanted).map(place);
  const chosen = state.mode;
  if (compact) {
    const graded = (sure) => of((k) => !state.dropped.has(k) && (model.modes[k].trust === "sure") === sure);
    marks.push({ points: graded(true), style: "kept", sign: "down", right: true }, { points: graded(false), style: "doubted", sign: "down", right: true });
  } else marks.push({ name: "pole of the model, kept", points: of((k) => !state.dropped.has(k)), style: "kept", sign: "big", right: true });
  marks.push({ name: "dropped", points: of((k) => state.dropped.has(k)), style: "dropped", sign: "cross", right: true });
  marks.push({ points: model.inBand.includes(chosen) ? [place(chosen)] : [], style: "chosen", sign: compact ? "down" : "big", right: true });
  const bars = model.inBand.map((k) => ({ x: model.frequency[k], y: lanes.kept, dx: SIGMAS * model.modes[k].frequency_std_hz, dy: 0, style: "error-bar", right: true }));
  const lines = model.inBand.filter((k) => !state.dropped.has(k)).map((k) => model.frequency[k]);
  return { marks, bars, verticals: [{ name: "natural frequency", at: lines, style: "pole-line" }] };
}

function pick(model, lanes, distance, x) {
  const k = nearest(model, x);
  // only the distance along frequency counts, since a whole column belongs to its pole
  const isNear = k !== null && along(model, lanes, distance, x, k) <= REACH;
  if (isNear) toggleMode(k);
  return isNear;
}

function nearest(model, x) {
  const far = (k) => Math.abs(model.frequency[k] - x);
  return model.inBand.reduce((best, k) => (best === null || far(k) < far(best) ? k : best), null);
}

/** Distance along frequency, px, from distances to two places of the same height. */
function along(model, lanes, distance, x, k) {
  const there = distance(model.frequency[k], lanes.kept, true);
  const here = distance(x, lanes.kept, true);
  return Math.sqrt(Math.max(0, there ** 2 - here ** 2));
}

function hover(model, lanes, distance, x) {
  const k = nearest(model, x);
  if (k === null || along(model, lanes, distance, x, k) > REACH) return "";
  const mode = model.modes[k];
  const number = model.inBand.indexOf(k) + 1;
  return `mode ${number}: ${withBound(mode.frequency_hz, SIGMAS * mode.frequency_std_hz)} Hz, η ${withBound(100 * mode.loss_factor, SIGMAS * 100 * mode.loss_factor_std)} %`;
}

function byKey(key, model) {
  const place = Math.max(0, model.inBand.indexOf(state.mode));
  const count = model.inBand.length;
  if (!count) return false;
  if (key === "PageUp" || key === "PageDown") change({ mode: model.inBand[(place + (key === "PageDown" ? 1 : count - 1)) % count] });
  else if (key === "Enter" || key === " ") toggleMode(model.inBand[place]);
  else return false;
  return true;
}

/** Loss factor over frequency with both bounds. */
function barChart(model) {
  const modes = () => model.inBand.map((k) => [k, model.modes[k]]);
  const layers = () => {
    const points = (wanted) => modes().filter(wanted).map(([, mode]) => [mode.frequency_hz, 100 * mode.loss_factor]);
    return {
      bars: modes().map(([k, mode]) => ({
        x: mode.frequency_hz, y: 100 * mode.loss_factor, dx: SIGMAS * mode.frequency_std_hz, dy: 100 * SIGMAS * mode.loss_factor_std,
        style: state.dropped.has(k) ? "error-bar faint" : "error-bar",
      })),
      marks: [
        { name: "sure", points: points(([k, mode]) => mode.trust === "sure" && !state.dropped.has(k)), style: "kept", sign: "dot" },
        { name: "weak", points: points(([k, mode]) => mode.trust === "weak" && !state.dropped.has(k)), style: "doubted", sign: "square" },
        { name: "dropped", points: points(([k]) => state.dropped.has(k)), style: "dropped", sign: "cross" },
      ].filter((group) => group.points.length),
    };
  };
  const bars = layers().bars;
  const view = chart({
    title: "Loss factor with 95 % bounds",
    caption: bars.every((bar) => bar.dy === 0) ? "This model carries no bounds." : `The widest bound is ± ${fixed(Math.max(...bars.map((bar) => bar.dy)), 5)} %.`,
    height: 230,
    x: { label: "Natural frequency", unit: "Hz", range: model.band_hz },
    y: { label: "Loss factor", unit: "%", range: padded([bars.flatMap((bar) => [bar.y - bar.dy, bar.y + bar.dy])], 0.2) },
    ...layers(),
    onpick: (x, y, distance) => {
      const near = modes().map(([k, mode]) => [distance(mode.frequency_hz, 100 * mode.loss_factor), k]).sort((a, b) => a[0] - b[0])[0];
      if (near && near[0] <= REACH) toggleMode(near[1]);
    },
    onrange: (zoom) => change({ range: zoom }),
  });
  listen(["dropped"], () => view.update(layers()));
  return view;
}
