// The studio's second pane: stages of the fit, the stabilization diagram, the table of poles.

import { h, redraw } from "./dom.js";
import { state, listen, change, toggleMode } from "./store.js";
import { chart } from "./chart.js";
import { fixed, withBound, SIGMAS } from "./numbers.js";
import { cmifOf, diagram, poleLayers } from "./stabilization.js";
import { work, edit } from "./work.js";

const CHART_PX = 232;
const SIGN = { sure: ["✓", "sure"], weak: ["?", "weak"] };
/** Stages of a fit in the words of the page, in their usual order. */
const STAGES = [
  ["screening", "Screening the FRFs"], ["sketch", "Compressing"], ["pole pool", "Finding poles"], ["poles", "Refining poles"], ["projection", "Projecting the data"],
  ["damping law", "Damping law"], ["shapes", "Shapes"], ["pole pool and local tests", "Peaks one by one"], ["error bars and grades", "Error bars and grades"],
];
/** Largest distance of a click from the peak that it catches, part of the axis. */
const PEAK_PART = 0.008;
/** Number of stages of every fit, by which the bar is divided. */
const USUAL = 6;

/** The pane; `oncancel` stops the fit. */
export function polesPane(oncancel) {
  const count = h("span", { class: "muted" });
  const sure = h("button", { type: "button", id: "keep-sure", disabled: true }, "Keep only sure");
  const all = h("button", { type: "button", hidden: true, onclick: () => change({ dropped: new Set() }) }, "Keep all");
  const view = chart({ compact: true, height: CHART_PX, x: { label: "Frequency", unit: "Hz", range: [0, 1] }, y: { label: "", unit: "dB", range: [0, 1] }, series: [], onrange: (zoom) => change({ range: zoom }) });
  view.svg.id = "stabilization-chart";
  const place = h("input", { type: "number", id: "add-hz", step: "any", min: 0, "aria-label": "Frequency of the mode, Hz" });
  const addRow = h("form", { class: "row add-row", hidden: true, onsubmit: addPole }, "A mode at ", place, " Hz ", h("button", { class: "primary", id: "add-there" }, "Fit with it"), h("button", { type: "button", onclick: () => offer(null) }, "Cancel"), h("span", { class: "muted" }, "Click an empty peak, or type."));
  const adding = h("button", { type: "button", id: "add-pole", disabled: true, onclick: () => offer(addRow.hidden ? "" : null) }, "+ Add pole");
  const taken = h("div", { class: "row added-row", hidden: true });
  const stages = h("ul", { class: "stages", "aria-label": "Stages of the fit" });
  const bar = h("progress", { max: USUAL, value: 0, "aria-label": "Progress of the fit" });
  const atWork = h("div", { class: "at-work" }, stages, h("div", { class: "row" }, bar, h("button", { type: "button", onclick: oncancel }, "Cancel")));
  const body = h("tbody", {});
  const table = h("div", { class: "table-scroll", tabindex: -1 }, h("table", { class: "pole-table" },
    h("thead", {}, h("tr", {}, ["", "#", "f, Hz, ± 95 %", "ζ, %, ± 95 %", "MPC", ""].map((name) => h("th", { scope: "col" }, name)))), body));
  const reasons = h("p", { class: "reasons", role: "status" });
  const element = h("section", { id: "pane-2", class: "pane", tabindex: -1, "aria-label": "Stabilization and poles" },
    h("div", { class: "pane-head" }, h("h2", {}, "2 Poles"), count, h("span", { class: "gap" }), all, sure, adding), atWork, view.element, addRow, taken, reasons, table);
  let model = null;
  let data = null;
  let lanes = null;
  let grades = null;
  [view.element, table].forEach((one) => (one.hidden = true));

  /** Shows the row that adds a pole, at `hz` or at a frequency to be entered; hides it for null. */
  function offer(hz) {
    addRow.hidden = hz === null;
    if (hz === null) return;
    place.value = hz === "" ? "" : peakNear(hz);
    place.focus();
  }

  /** The highest point of the largest singular value within a few pixels of a click. */
  function peakNear(hz) {
    const [first] = cmifOf(data);
    if (!first) return Number(hz.toFixed(3));
    const near = PEAK_PART * (first.x[first.x.length - 1] - first.x[0]);
    let best = -1;
    first.x.forEach((x, k) => { if (Math.abs(x - hz) <= near && !(first.y[k] <= first.y[best])) best = k; });
    return Number((best < 0 ? hz : first.x[best]).toFixed(3));
  }

  function addPole(event) {
    event.preventDefault();
    if (!(place.valueAsNumber > 0)) return;
    edit({ added: [...work.added, place.valueAsNumber] });
    offer(null);
  }

  /** The poles added by hand, each with its outcome and a button that removes it. */
  function showAdded() {
    taken.hidden = !work.added.length;
    redraw(taken, "Added: ", work.added.map((hz, n) => h("button", { type: "button", class: "chip", title: "take it back", onclick: () => edit({ added: work.added.filter((_, k) => k !== n) }) }, `${hz} Hz${fateOf(n)} ✕`)));
  }

  /** What came of the nth added pole; empty while a draft is shown. */
  function fateOf(n) {
    return grades ? `: ${grades[n] ?? "no mode came of it"}` : "";
  }

  function showPoles() {
    if (!model) return;
    const layers = poleLayers(model, data.stabilization, lanes, true);
    const drive = { name: "drive", at: [work.frequency], style: "drive-line" };
    // a model that cannot be rendered has no drive
    view.update({ ...layers, bars: [], verticals: model.references.length > 1 ? [drive] : [] });
    for (const row of body.rows) {
      const k = Number(row.dataset.index);
      row.classList.toggle("out", state.dropped.has(k));
      row.classList.toggle("current", k === state.mode);
      row.querySelector("input").checked = !state.dropped.has(k);
    }
    all.hidden = !state.dropped.size;
    const mode = model.modes[state.mode];
    const number = model.inBand.indexOf(state.mode) + 1;
    reasons.textContent = mode?.reasons.length && number ? `Mode ${number} (${fixed(mode.frequency_hz, 2)} Hz) is ${mode.trust}: ${mode.reasons.join("; ")}.` : "";
  }

  function row(k, place) {
    const mode = model.modes[k];
    const box = h("input", { type: "checkbox", "aria-label": `keep mode ${place + 1}`, "data-mode": place + 1, "data-focus": `mode-${place + 1}`, onchange: () => toggleMode(k), onfocus: () => change({ mode: k }) });
    const [sign, word] = SIGN[mode.trust] ?? ["", mode.trust];
    const cells = [place + 1, withBound(mode.frequency_hz, SIGMAS * mode.frequency_std_hz), withBound(50 * mode.loss_factor, SIGMAS * 50 * mode.loss_factor_std), fixed(mode.mpc, 2)];
    return h("tr", { "data-index": k, onclick: (event) => event.target !== box && change({ mode: k }) }, h("td", {}, box), cells.map((text) => h("td", {}, text)), h("td", { class: mode.trust, title: word }, sign));
  }

  body.addEventListener("keydown", (event) => {
    const by = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (!by) return;
    event.preventDefault();
    const next = body.rows[Math.max(0, Math.min(body.rows.length - 1, event.target.closest("tr").rowIndex - 1 + by))];
    next.querySelector("input").focus();
  });

  sure.addEventListener("click", () => change({ dropped: new Set(model.inBand.filter((k) => model.modes[k].trust !== "sure")) }));
  listen(["dropped", "mode"], showPoles);
  listen(["range"], () => view.zoomTo(state.range));
  return {
    element,
    showPoles,
    /** Stages so far, while a fit runs; null when it is over. */
    progress: (said) => {
      atWork.hidden = !said;
      if (!said) return;
      const word = (name) => STAGES.find(([known]) => known === name)?.[1] ?? name;
      const line = ([name, seconds], sign, style) => h("li", { class: style }, h("span", { "aria-hidden": "true" }, sign), h("span", {}, word(name)), h("span", { class: "muted" }, `${fixed(seconds, 1)} s`));
      redraw(stages, said.over.map((one) => line(one, "✓", "over")), said.running ? line(said.running, "▸", "running") : null);
      bar.value = Math.min(USUAL - 0.5, said.over.length + 0.5);
    },
    fit: (shown, fitted, canAdd, gradesOfAdded) => {
      [data, model, grades] = [shown, fitted, gradesOfAdded];
      const spec = diagram(data, model, (hz) => offer(hz));
      lanes = spec.lanes;
      view.update({ ...spec, series: spec.series.slice(0, 1), y: { ...spec.y, label: "largest singular value" }, right: spec.right && { ...spec.right, label: "order" } });
      adding.disabled = !canAdd;
      showAdded();
      [view.element, table].forEach((one) => (one.hidden = false));
      const weak = model.inBand.filter((k) => model.modes[k].trust !== "sure").length;
      count.textContent = [`${model.inBand.length - weak} sure`, weak ? `${weak} weak` : ""].filter(Boolean).join(", ");
      sure.disabled = !weak || weak === model.inBand.length;
      redraw(body, model.inBand.map(row));
      showPoles();
    },
  };
}
