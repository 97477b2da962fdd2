// The studio's third pane: the board with the field, the drive, its performance, and shapes.

import { h, choice, redraw } from "./dom.js";
import { passing } from "./store.js";
import { fixed, significant } from "./numbers.js";
import { levelMap } from "./colour.js";
import { keeps, levelBar } from "./field.js";
import { shapeView } from "./shapes.js";
import { timeView } from "./time.js";
import { measuredView } from "./measured.js";
import { PROFILES, sceneToml } from "./zones.js";
import { actuatorList, used } from "./actuators.js";
import { board } from "./board.js";
import { sweepChart } from "./sweep.js";
import { work, edit } from "./work.js";

const [COLD, HOT] = [1, 2];
/** Trials of the stress table that are shown, four at most: a part of the name, and the words for it. */
const TRIALS = [["lower or higher", "f ± 0.2 %"], ["a finger", "Light touch"], ["amplitudes and phases", "Drives"], ["one dead", "One dead"], ["drift", "Drift"]];
const MOST_TRIALS = 4;

/** The pane; `oncancel` stops what is being computed. */
export function panelPane(oncancel) {
  const size = h("span", { class: "muted" });
  const chip = h("span", { class: "chip", id: "scene-status", role: "status" });
  const cancel = h("button", { type: "button", class: "link", hidden: true, onclick: oncancel }, "cancel");
  const tabs = ["Field", "Measured", "Time", "Mode"].map((name) => h("button", { type: "button", role: "tab", id: `tab-${name.toLowerCase()}`, "aria-selected": "false", onclick: () => open(name) }, name));
  const field = h("div", { class: "field-tab", role: "tabpanel", "aria-labelledby": "tab-field" });
  const mode = h("div", { class: "mode-tab", role: "tabpanel", "aria-labelledby": "tab-mode", hidden: true });
  const time = h("div", { class: "time-tab", role: "tabpanel", "aria-labelledby": "tab-time", hidden: true });
  const measured = h("div", { class: "measured-tab", role: "tabpanel", "aria-labelledby": "tab-measured", hidden: true });
  const fieldError = h("p", { class: "error", id: "field-error", role: "alert", hidden: true });
  const fieldView = h("div", {});
  measured.append(fieldError, fieldView);
  const inTime = h("div", { id: "in-time" });
  const result = h("div", { id: "result" });
  const legend = h("div", { id: "level-legend" });
  const element = h("section", { id: "pane-3", class: "pane", tabindex: -1, "aria-label": "Panel" },
    h("div", { class: "pane-head" }, h("h2", {}, "3 Panel"), size, h("span", { class: "gap" }), chip, cancel, h("span", { role: "tablist", class: "segments" }, tabs)), field, measured, time, mode);
  let geometry = null;
  let view = null;
  let actuators = null;
  let forget = null;
  let chosen = null;
  let table = null;
  const sweep = sweepChart();

  function open(name) {
    tabs.forEach((tab) => tab.setAttribute("aria-selected", String(tab.textContent === name)));
    [["Field", field], ["Measured", measured], ["Time", time], ["Mode", mode]].forEach(([own, part]) => (part.hidden = own !== name));
  }

  const number = (label, id, key, unit, factor = 1) => {
    const input = h("input", { type: "number", id, step: "any", min: 0, onchange: () => input.checkValidity() && input.value !== "" && edit({ [key]: input.valueAsNumber / factor }) });
    return { element: h("label", {}, `${label} `, input, ` ${unit}`), show: () => (input.value = Number((factor * work[key]).toFixed(3))) };
  };
  const numbers = [number("Drive", "scene-frequency", "frequency", "Hz"), number("±", "scene-limen", "limen", "dB"), number("Border", "scene-transition", "transition", "mm", 1e3)];
  const duration = (label, id, key, words) => {
    const input = h("input", { type: "number", id, step: "any", min: 1, placeholder: words, onchange: () => input.checkValidity() && edit({ [key]: input.value === "" ? null : input.valueAsNumber / 1e3 }) });
    return { element: h("label", {}, `${label} `, input, " ms"), show: () => (input.value = work[key] === null ? "" : Number((1e3 * work[key]).toFixed(3))) };
  };
  const durations = [duration("Burst", "burst-duration", "burst", "none"), duration("Ramps", "burst-ramp", "ramp", "auto")];
  time.append(h("div", { class: "row" }, durations.map((one) => one.element)), inTime);
  const profile = choice("Threshold", PROFILES, 0, () => edit({ profile: profile.select.value }));
  profile.select.id = "scene-threshold";
  const file = h("input", { type: "file", id: "scene-threshold-table", accept: ".csv,.txt", "aria-label": "Threshold table, CSV", onchange: async () => {
    const [chosen] = file.files;
    if (!chosen) return;
    table = { name: chosen.name, csv: await chosen.text() };
    profile.select.replaceChildren(...[...PROFILES, table.name].map((name) => h("option", {}, name)));
    edit({ profile: table.name });
  } });
  const zoneRow = h("div", { class: "row zone-row" });

  /** Controls of the chosen zone: its level, and a button that deletes it. */
  function showZone(index) {
    chosen = index;
    const zone = work.zones[index ?? -1];
    if (!zone) return redraw(zoneRow, h("span", { class: "muted" }, work.zones.length ? "Choose a zone to move, resize or delete it." : "Draw a hot zone: it is felt, all the rest is quiet."));
    const db = h("input", { type: "number", id: "zone-level", "data-focus": "level", step: 0.5, min: 0, max: 40, value: zone.level_db ?? 0, onchange: () => db.checkValidity() && levelled(index, db.valueAsNumber || 0) });
    const level = zone.kind === "hot" ? h("label", {}, "louder by ", db, " dB") : null;
    const remove = h("button", { type: "button", id: "zone-delete", onclick: () => view.editor.remove(index) }, "Delete");
    redraw(zoneRow, h("b", {}, `Zone ${index + 1}: ${zone.kind}`), level, remove, h("span", { class: "muted" }, "Arrows move it, Ctrl+arrows resize."));
  }

  function levelled(index, db) {
    const { level_db: _, ...plain } = work.zones[index];
    view.editor.put(work.zones.map((zone, k) => (k === index ? { ...plain, ...(db ? { level_db: db } : {}) } : zone)));
  }

  function buildField() {
    view = board(geometry, showZone);
    actuators = actuatorList(geometry.reference_names);
    const [x0, y0, x1, y1] = geometry.box;
    size.textContent = `${Math.round(1e3 * (x1 - x0))} × ${Math.round(1e3 * (y1 - y0))} mm`;
    const bar = h("div", { class: "row legend-row" }, legend, h("span", { class: "muted" }, "▲ hot  • cold  ✕ missed  stripes: not judged"));
    const drive = h("div", { class: "row" }, numbers[0].element, profile.element, h("label", { class: "file", title: "Threshold table, CSV" }, "Table…", file), numbers[1].element, numbers[2].element, actuators.element);
    field.replaceChildren(view.editor.tools, zoneRow, h("div", { class: "board-holder" }, view.editor.element), bar, sweep.element, drive, result);
    showZone(null);
    showWork();
  }

  function showWork() {
    [...numbers, ...durations].forEach((one) => one.show());
    redraw(legend, levelBar({ hot: work.limen, cold: -work.limen }, levelMap()));
    if (!work.burst) showTime(null);
    else if (!inTime.dataset.burst) showTime({ error: "Computing the drive over time …" });
    profile.select.value = work.profile;
    actuators?.show();
    if (!view) return;
    view.editor.set(work.zones);
    // actuators may be on or off now
    view.again();
    showZone(chosen);
  }

  /** The scene over time; null where it is a steady tone. */
  function showTime(said) {
    inTime.dataset.burst = said?.time ? `${work.burst}` : "";
    redraw(inTime, said?.time ? timeView(said.time, geometry, "time-field") : h("p", { class: "muted" }, said?.error ?? "A steady tone: set the length of a burst to see hot and cold ground over time."));
  }

  /** A measured field; null where none is of this drive. */
  function showMeasured(said) {
    fieldError.hidden = true;
    redraw(fieldView, said ? measuredView(said, geometry) : h("p", { class: "muted" }, "No field of this drive is measured. Download drive.wav, play it, and open what the vibrometer measured: Measured field… in the top bar (CSV: response,re,im)."));
    if (said) open("Measured");
  }

  /** A field that was refused; the one before stays. */
  function refuseField(words) {
    fieldError.textContent = words;
    fieldError.hidden = false;
    open("Measured");
  }

  function tiles(scene, shown) {
    const { points } = scene.indices;
    const speeds = Array.from(shown.velocity.re, (re, k) => Math.hypot(re, shown.velocity.im[k]));
    const of = (ground) => speeds.map((_, k) => k).filter((k) => shown.ground[k] === ground);
    const count = (ground) => `${of(ground).filter((k) => keeps(shown, k, speeds[k])).length} of ${of(ground).length}`;
    const db = (value) => (Number.isFinite(value) ? `${fixed(value, 1)} dB` : "–");
    const force = Number.isFinite(points.max_force_n) ? ["Largest force", `${significant(1e3 * points.max_force_n, 3)} mN`] : ["Largest voltage", `${significant(points.max_voltage_v, 3)} V`];
    const rows = [["Hot felt", count(HOT), points.hot_ratio < 1], ["Cold quiet", count(COLD), points.cold_ratio < 1], ["Contrast", db(points.contrast_db)], ["Least margin", db(points.margin_db), points.margin_db < 0], force];
    return h("dl", { class: "tiles" }, rows.map(([word, text, isBad]) => h("div", {}, h("dt", {}, word), h("dd", { class: isBad ? "bad" : "" }, text))));
  }

  function trials(scene) {
    const rows = TRIALS.flatMap(([part, word]) => (scene.stress ?? []).filter((row) => row.trial.includes(part)).slice(0, 1).map((row) => [word, row]));
    const cell = ([word, row]) => h("div", { title: `${row.trial}: ${row.cases} cases` }, h("span", {}, word), h("b", {}, `${fixed(100 * row.min_worst_5_percent, 0)} %`), h("meter", { min: 0, max: 1, low: 0.8, high: 0.95, optimum: 1, value: row.min_worst_5_percent }));
    return rows.slice(0, MOST_TRIALS).map(cell);
  }

  function weightTable(scene) {
    const rows = scene.weights.map((weight) => h("tr", {}, h("td", {}, weight.reference), h("td", {}, fixed(1e3 * Math.hypot(weight.re, weight.im), 4)), h("td", {}, fixed((Math.atan2(weight.im, weight.re) * 180) / Math.PI, 2))));
    const head = h("tr", {}, h("th", {}, "Actuator"), h("th", { class: "number" }, `Amplitude (m${scene.unit} peak)`), h("th", {}, "Phase (°)"));
    return h("details", { class: "menu weights" }, h("summary", {}, "Weights"), h("div", { class: "menu-body" }, h("table", {}, h("thead", {}, head), h("tbody", {}, rows))));
  }

  return {
    element,
    chip,
    sweep,
    showWork,
    /** Shows the board before any fit, or a text in its place. */
    start: (places) => {
      open("Field");
      geometry = places;
      showMeasured(null);
      if (geometry) buildField();
      else field.replaceChildren(h("p", { class: "card" }, "The file holds no positions of the nodes: no scene can be drawn. Shapes and damping work as for any file."));
    },
    /** Shows the shapes of a new model, and the drive frequency among its modes. */
    fit: (model, fitted, structure) => {
      // a draft does not tell whether there are shapes
      const hasShapes = structure && model.inBand.length > 0;
      if (structure !== undefined) tabs[3].disabled = !hasShapes;
      if (hasShapes) {
        forget?.();
        let parts;
        [parts, forget] = passing(() => shapeView(model, fitted, structure));
        mode.replaceChildren(...parts);
      }
      const few = model.references.length < 2;
      if (few && structure !== undefined) {
        field.replaceChildren(noField());
        if (hasShapes) mode.append(noField());
        open(hasShapes ? "Mode" : "Field");
      }
      if (fitted?.grid) {
        if (!geometry) {
          geometry = fitted;
          buildField();
        }
      }
      sweep.place(model);
      return !few && Boolean(geometry);
    },
    /** The scene's file, and the threshold table that it names. */
    scene: () => {
      const text = sceneToml({ frequencyHz: work.frequency, profile: work.profile, limenDb: work.limen, transitionM: work.transition, zones: work.zones, burst: [work.burst, work.ramp], use: geometry && used(geometry.reference_names) });
      return { toml: text, threshold: PROFILES.includes(work.profile) ? null : table };
    },
    hasHot: () => work.zones.some((zone) => zone.kind === "hot"),
    hasBoard: () => Boolean(view),
    /** Shows what is being computed; nothing where `words` are empty. */
    busy: (words, canCancel = false) => {
      chip.textContent = words;
      chip.title = words;
      chip.classList.toggle("busy", Boolean(words));
      cancel.hidden = !canCancel;
    },
    /** Shows a rendered scene; `moving` is true during a drag. */
    show: (scene, moving) => {
      const shown = view.show(scene, moving);
      redraw(result, tiles(scene, shown), h("div", { class: "trials" }, trials(scene), weightTable(scene)));
      result.dataset.method = scene.method;
      result.dataset.answers = String(Number(result.dataset.answers ?? 0) + 1);
    },
    /** Takes the scene off that no drive was computed for. */
    noScene: () => {
      view?.show(null, false);
      result.replaceChildren();
    },
    showTime,
    showMeasured,
    refuseField,
    openField: () => open("Field"),
    key: (key) => view?.editor.toolKey(key) ?? false,
  };
}

function noField() {
  return h("div", { class: "card" }, h("b", {}, "No field can be rendered from this file: it has one reference."),
    h("p", {}, "A field that differs between zones needs several references: at least one per zone, better 8 or more. Shapes, damping and downloads work as for any file."));
}
