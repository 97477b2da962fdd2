// The studio's first pane: the measured FRFs with the band on them, and any single FRF.

import { h, choice } from "./dom.js";
import { array } from "./data.js";
import { state, listen, change } from "./store.js";
import { chart } from "./chart.js";
import { fixed, significant } from "./numbers.js";
import { Source, inBand, magnitude, phase, range, sumSpec } from "./frfs.js";
import { work, edit } from "./work.js";

/** Heights of the charts, px. */
const [SUM_PX, FRF_PX, PHASE_PX] = [184, 210, 92];
/** Distance of a band's ends from those of the data, part of the lines, up to which it is all lines. */
const WHOLE = 1e-3;

const PARTS = { dB: magnitude, Re: (curve) => curve && Float64Array.from(curve.re), Im: (curve) => curve && Float64Array.from(curve.im) };

/** The pane. `start` shows the measured data, `fit` a model over them; `status` shows the state of the fit. */
export function dataPane() {
  const sum = chart({ compact: true, height: SUM_PX, x: axis([0, 1]), y: { label: "rms of all FRFs", unit: "dB", range: [-1, 1] }, series: [] });
  const single = chart({ compact: true, height: FRF_PX, x: axis([0, 1]), y: { label: "", unit: "dB", range: [-1, 1] }, series: [], onrange: (zoom) => change({ range: zoom }) });
  const angle = chart({ compact: true, height: PHASE_PX, x: axis([0, 1]), y: { label: "phase", unit: "°", range: [-180, 180], step: 180 }, series: [], onrange: (zoom) => change({ range: zoom }) });
  single.svg.id = "frf-magnitude";
  const kind = h("span", { class: "chip" });
  const facts = h("dl", { class: "facts" });
  const [from, to] = ["from", "to"].map((name) => h("input", { type: "number", step: "any", "aria-label": `band ${name}, Hz`, onchange: typed }));
  const whole = h("button", { type: "button", class: "ghost", onclick: () => edit({ band: null }) }, "Whole file");
  const status = h("span", { class: "muted", role: "status", id: "fit-status" });
  const part = choice("", Object.keys(PARTS), 0, () => showPair());
  part.select.setAttribute("aria-label", "Part of the FRF");
  const response = choice("FRF", [], 0, (k) => change({ pair: [k, state.pair[1]] }));
  const reference = choice("/", [], 0, (k) => change({ pair: [state.pair[0], k] }));
  const modes = h("input", { type: "number", id: "modes", min: 1, max: 1000, step: 1, "aria-label": "Most modes", onchange: () => modes.checkValidity() && edit({ modes: modes.valueAsNumber || null }) });
  const auto = h("input", { type: "checkbox", id: "by-evidence", checked: true, onchange: () => edit({ modes: auto.checked ? null : modes.valueAsNumber || null }) });
  const bandRow = h("div", { class: "row" }, "Band ", from, " to ", to, " Hz ", whole);
  const modesRow = h("div", { class: "row" }, h("label", {}, auto, " modes by evidence"), h("label", {}, " at most ", modes));
  const holder = h("div", {}, h("div", { class: "row" }, response.element, reference.element, part.element), single.element, angle.element);
  const element = h("section", { id: "pane-1", class: "pane", tabindex: -1, "aria-label": "Data and band" },
    h("div", { class: "pane-head" }, h("h2", {}, "1 Data and band"), status, kind), sum.element, bandRow, holder, facts, modesRow);

  let frfs = null;
  let model = null;
  let source = null;
  let lines = [0, 1];

  function typed() {
    const ends = [from.valueAsNumber, to.valueAsNumber];
    if (ends.every(Number.isFinite) && ends[0] < ends[1]) setBand(ends, false);
  }

  function setBand(ends, moving) {
    const [low, high] = [Math.min(...ends), Math.max(...ends)];
    const room = WHOLE * (lines[1] - lines[0]);
    const isWhole = low <= lines[0] + room && high >= lines[1] - room;
    edit({ band: isWhole ? null : [low, high].map((hz) => Number(hz.toFixed(3))) }, moving);
  }

  function showBand() {
    const ends = work.band ?? lines;
    [from.value, to.value] = ends.map((hz) => Number(hz.toFixed(2)));
    const grip = (k, name) => ({
      name: `band-${name}`, at: ends[k], label: `Band ${name}`, words: (hz) => `${fixed(hz, 1)} Hz`, low: lines[0], high: lines[1], step: (lines[1] - lines[0]) / 1000,
      onmove: (hz, moving) => setBand(k ? [ends[0], hz] : [hz, ends[1]], moving),
    });
    const grips = bandRow.hidden ? [] : [grip(0, "from"), grip(1, "to")];
    sum.update({ grips, shades: [[lines[0], ends[0]], [ends[1], lines[1]]] });
  }

  function showPair() {
    if (!frfs || !source?.pairs) return;
    const [i, j] = state.pair;
    response.select.selectedIndex = i;
    reference.select.selectedIndex = j;
    const { frequency, measured, synthesis } = source.curves(i, j);
    const name = part.select.value;
    const curves = [["measured", measured], ["synthesised", synthesis]].filter(([, curve]) => curve);
    const series = (of, breaks) => curves.map(([style, curve]) => ({ name: style, x: frequency, y: style === "measured" ? of(curve) : inBand(model, frequency, of(curve)), style, breaks }));
    const shown = series(PARTS[name]);
    const ends = range(shown.map((one) => one.y));
    single.update({ x: axis(lines), y: { label: `${frfs.quantity.toLowerCase()} ${frfs.response_names[i]} / ${frfs.reference_names[j]}`, unit: name === "dB" ? frfs.unit : frfs.unit.replace("dB re 1 ", ""), range: ends }, series: shown });
    angle.update({ x: axis(lines), series: series(phase, 180) });
  }

  function showFacts() {
    const scaled = model.unit_modal_mass ? "mass-scaled" : "not mass-scaled";
    const rows = [["Unexplained", `${significant(100 * model.relative_error, 2)} %`], ["χ²/dof", significant(model.chi2_per_dof, 3)], ["Damping", model.damping], ["Shapes", scaled]];
    facts.replaceChildren(...rows.map(([word, text]) => h("div", {}, h("dt", {}, word), h("dd", {}, text))));
  }

  /** Shows FRFs alone or with the model; `data` are those of the page. */
  function show(data, fitted) {
    [frfs, model] = [data.frfs, fitted];
    if (!frfs) return;
    source = new Source(frfs, model);
    const all = array(frfs.lines);
    lines = [all[0], all[all.length - 1]];
    if (!state.pair && source.pairs) {
      const first = frfs.full[0];
      state.pair = first ? [frfs.responses.indexOf(first.response), frfs.references.indexOf(first.reference)].map((k) => Math.max(0, k)) : [0, 0];
      for (const [list, names] of [[response, frfs.response_names], [reference, frfs.reference_names]]) list.select.replaceChildren(...names.map((name) => h("option", {}, name)));
    }
    const spec = sumSpec(frfs, model);
    sum.update({ ...spec, y: { ...spec.y, label: "rms of all FRFs" }, verticals: [] });
    kind.textContent = frfs.quantity.toLowerCase();
    showBand();
    showPair();
  }

  listen(["pair", "dropped"], showPair);
  listen(["range"], () => [single, angle].forEach((view) => view.zoomTo(state.range)));
  return {
    element,
    status,
    start: (said) => {
      bandRow.hidden = !said.refit;
      modesRow.hidden = !said.refit;
      if (said.data) show(said.data, null);
    },
    fit: (data, fitted) => {
      show(data, fitted);
      showFacts();
      const count = fitted.inBand.length;
      auto.checked = work.modes === null;
      modes.value = work.modes ?? count;
    },
    showBand,
  };
}

function axis(ends) {
  return { label: "Frequency", unit: "Hz", range: ends };
}
