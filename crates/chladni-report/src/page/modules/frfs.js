// FRFs: the sum over all of them, and any pair of DOFs: measured, synthesised and residual, in magnitude and phase.

import { h, section, choice, tick } from "./dom.js";
import { array, split } from "./data.js";
import { state, listen, change } from "./store.js";
import { chart, padded } from "./chart.js";
import { level, fixed, counted } from "./numbers.js";
import { synthesise } from "./synthesis.js";

/** Levels below the largest one that are shown, dB. */
const RANGE_DB = 100;

function levels(values) {
  return Float64Array.from(values, level);
}

/** The values on lines of the fitted band; NaN elsewhere, so that nothing is drawn. */
export function inBand(model, x, y) {
  if (!model) return y;
  const [low, high] = model.band_hz;
  return y.map((value, k) => (x[k] >= low && x[k] <= high ? value : NaN));
}

/** Section of the sum over all FRFs; `model` may be null. */
export function sumSection(frfs, model) {
  const heading = model && frfs.residuals ? "Synthesis over measured" : model ? "Synthesis" : "Measured";
  const view = chart({ ...sumSpec(frfs, model), height: 280, onrange: (zoom) => change({ range: zoom }) });
  listen(["dropped"], () => view.update({ verticals: sumSpec(frfs, model).verticals }));
  listen(["range"], () => view.zoomTo(state.range));
  return section("sum", heading, view.element);
}

/** Section of single FRFs; `model` may be null. */
export function frfSection(frfs, model) {
  const source = new Source(frfs, model);
  return source.pairs ? section("frfs", "Single FRFs", note(frfs, model), ...pairView(source, frfs, model)) : null;
}

function note(frfs, model) {
  const shown = frfs.responses.length * frfs.references.length;
  const words = [];
  if (!frfs.residuals) words.push("The measured FRFs are not at hand: only the model's synthesis is shown.");
  if (!model) words.push("There is no model: only the measured FRFs are shown.");
  if (shown < frfs.total_pairs) words.push(`To choose from are ${shown} of ${frfs.total_pairs} FRFs, evenly chosen, to keep the page small.`);
  const how = h("span", { class: "hint" }, " Drag across a chart to zoom, double-click to see all; names in the legend switch curves on and off; keys [ and ] take the response before and after.");
  return h("p", {}, words.join(" "), how);
}

export function poleLines(model) {
  return model ? [{ name: "natural frequency", at: model.inBand.filter((k) => !state.dropped.has(k)).map((k) => model.frequency[k]), style: "pole-line" }] : [];
}

function bandLines(model, [low, high]) {
  const inside = model ? model.band_hz.filter((hz) => hz > low && hz < high) : [];
  return inside.length ? [{ name: "border of the fitted band", at: inside, style: "band-line" }] : [];
}

export function range(lists) {
  const [low, high] = padded(lists, 0.05, RANGE_DB);
  return [low, high];
}

/** The chart of the sum over all FRFs. */
export function sumSpec(frfs, model) {
  const x = array(frfs.lines);
  const curve = (name, coded, style) => coded && { name, x, y: style === "measured" ? levels(array(coded)) : inBand(model, x, levels(array(coded))), style };
  const series = [
    curve("measured", frfs.sums.measured, "measured"),
    curve("synthesised", frfs.sums.synthesis, "synthesised"),
    curve("residual", frfs.sums.residual, "residual"),
  ].filter(Boolean);
  const ends = [x[0], x[x.length - 1]];
  return {
    title: `${frfs.quantity}, root mean square over all FRFs`,
    caption: frfs.sums.residual ? "Where the residual is flat and shapeless it is noise; peaks in it are motion that the model lacks." : "",
    x: { label: "Frequency", unit: "Hz", range: ends },
    y: { label: frfs.quantity, unit: frfs.unit, range: range(series.map((one) => one.y)) },
    series,
    verticals: [...poleLines(model), ...bandLines(model, ends)],
  };
}

/** Curves of any pair. */
export class Source {
  constructor(frfs, model) {
    this.frfs = frfs;
    this.model = model;
    this.columns = frfs.references.length;
    this.pairs = frfs.responses.length * this.columns;
    this.lines = array(frfs.lines);
    this.terms = frfs.terms && split(array(frfs.terms));
    // residuals belong to the model of the last full fit, which in the studio may be older than the shown one
    this.base = frfs.base ?? { model, terms: this.terms };
    this.errors = array(frfs.errors);
    if (frfs.residuals) {
      const coded = frfs.residuals;
      this.coarse = { ...coded, frequency: array(coded.frequency_hz), steps: array(coded.steps), values: array(coded.values) };
    }
    this.full = new Map(frfs.full.map((pair) => [`${pair.response} ${pair.reference}`, pair]));
  }

  pair(response, reference) {
    return response * this.columns + reference;
  }

  /** Curves of an offered pair: {frequency, measured, synthesis, residual, all}; null for missing ones. */
  curves(response, reference) {
    const pair = this.pair(response, reference);
    const [i, j] = [this.frfs.responses[response], this.frfs.references[reference]];
    const full = this.full.get(`${i} ${j}`)?.measured;
    const frequency = full || !this.coarse ? this.lines : this.coarse.frequency;
    const own = this.model && { model: this.model, terms: this.terms };
    const whole = this.base.model && this.synthesis(this.base, i, j, pair, frequency, new Set());
    const same = this.base.model === this.model && !state.dropped.size;
    const synthesis = own && (same ? whole : this.synthesis(own, i, j, pair, frequency, state.dropped));
    let measured = null;
    if (full) measured = split(array(full));
    else if (this.coarse) measured = sum(this.residual(pair), whole);
    const residual = measured && synthesis && sum(measured, synthesis, -1);
    return { frequency, measured, synthesis, residual, all: Boolean(full) };
  }

  synthesis({ model, terms }, i, j, pair, frequency, dropped) {
    const powers = model.powers.length;
    const pick = (part) => Array.from({ length: powers }, (_, k) => part[k * this.pairs + pair]);
    return synthesise(model, i, j, { re: pick(terms.re), im: pick(terms.im) }, frequency, dropped);
  }

  /** Measured − synthesis of an offered pair on the coarse lines; NaN where nothing was measured. */
  residual(pair) {
    const { frequency, steps, least_step, step_ratio, values, block, bits } = this.coarse;
    const lines = frequency.length;
    const blocks = Math.ceil(lines / block);
    const parts = bits === 4 ? (k) => [values[k] >> 4, values[k] & 15] : (k) => [values[2 * k], values[2 * k + 1]];
    const out = { re: new Float64Array(lines), im: new Float64Array(lines) };
    for (let line = 0; line < lines; line++) {
      const code = steps[pair * blocks + Math.floor(line / block)];
      const step = code && least_step * step_ratio ** (code - 1);
      const [re, im] = parts(pair * lines + line).map((part) => (part ? (part - 2 ** (bits - 1)) * step : NaN));
      out.re[line] = re;
      out.im[line] = im;
    }
    return out;
  }
}

function sum(a, b, sense = 1) {
  if (!b) return a;
  return { re: a.re.map((re, k) => re + sense * b.re[k]), im: a.im.map((im, k) => im + sense * b.im[k]) };
}

export const magnitude = (curve) => curve && Float64Array.from(curve.re, (re, k) => level(Math.hypot(re, curve.im[k])));
export const phase = (curve) => curve && Float64Array.from(curve.re, (re, k) => (Math.atan2(curve.im[k], re) * 180) / Math.PI);

function pairView(source, frfs, model) {
  const names = [frfs.response_names, frfs.reference_names];
  const first = frfs.full[0];
  const start = first ? [frfs.responses.indexOf(first.response), frfs.references.indexOf(first.reference)] : [0, 0];
  state.pair ??= start.map((k) => Math.max(0, k));
  const ends = [source.lines[0], source.lines[source.lines.length - 1]];
  const x = { label: "Frequency", unit: "Hz", range: ends };
  const onrange = (zoom) => change({ range: zoom });
  const key = (name) => {
    const step = { "[": -1, "]": 1 }[name];
    if (!step) return false;
    const count = names[0].length;
    change({ pair: [(state.pair[0] + step + count) % count, state.pair[1]] });
    return true;
  };
  const amplitude = chart({ height: 300, x, y: { label: frfs.quantity, unit: frfs.unit, range: [0, 1] }, series: [], onrange, onkey: key });
  const angle = chart({ height: 190, x, y: { label: "Phase", unit: "degrees", range: [-180, 180], step: 90 }, series: [], onrange, onkey: key });
  amplitude.svg.id = "frf-magnitude";
  angle.svg.id = "frf-phase";
  const response = choice("Response", names[0], state.pair[0], (k) => change({ pair: [k, state.pair[1]] }));
  const reference = choice("Reference", names[1], state.pair[1], (k) => change({ pair: [state.pair[0], k] }));
  response.select.id = "response";
  reference.select.id = "reference";
  const telling = frfs.full.filter((pair) => frfs.responses.includes(pair.response) && frfs.references.includes(pair.reference));
  const jump = choice("Notable FRFs", telling.map((pair) => `${pair.label}: ${pair.why}`), 0, (k) => {
    change({ pair: [frfs.responses.indexOf(telling[k].response), frfs.references.indexOf(telling[k].reference)] });
  });
  let residualShown = true;
  const withResidual = tick("residual", true, (checked) => {
    residualShown = checked;
    show();
  });

  function show() {
    const [i, j] = state.pair;
    response.select.selectedIndex = i;
    reference.select.selectedIndex = j;
    const { frequency, measured, synthesis, residual, all } = source.curves(i, j);
    const parts = [["measured", measured, "measured"], ["synthesised", synthesis, "synthesised"], ["residual", residualShown ? residual : null, "residual"]];
    const series = (of, breaks) => parts.filter(([, curve]) => curve).map(([name, curve, style]) => ({ name, x: frequency, y: style === "measured" ? of(curve) : inBand(model, frequency, of(curve)), style, breaks }));
    const amplitudes = series(magnitude);
    const error = source.errors?.[source.pair(i, j)];
    const difference = Number.isFinite(error) ? `, residual ${fixed(100 * error, 2)} % of the measured rms in the band` : "";
    const thin = measured && !all ? `Shown are ${counted(frequency.length, "line")} of ${frfs.total_lines}, all near resonances; notable FRFs have all.` : "";
    amplitude.update({
      title: `${frfs.quantity} of response / reference ${names[0][i]} / ${names[1][j]}${difference}`,
      caption: `${state.dropped.size ? "The synthesis leaves the dropped modes out. " : ""}${thin}`,
      y: { label: frfs.quantity, unit: frfs.unit, range: range(amplitudes.map((one) => one.y)) },
      series: amplitudes,
      verticals: [...poleLines(model), ...bandLines(model, ends)],
    });
    angle.update({ series: series(phase, 180).filter((one) => one.name !== "residual") });
  }

  listen(["pair", "dropped"], show);
  listen(["range"], () => [amplitude, angle].forEach((view) => view.zoomTo(state.range)));
  show();
  const controls = h("div", { class: "controls" }, response.element, reference.element, telling.length ? jump.element : null, model && frfs.residuals ? withResidual : null);
  return [controls, amplitude.element, angle.element];
}
