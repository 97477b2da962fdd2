// The studio: one screen of three panes. The settings are in work.js; this file asks the server for the results.

import { h, sayDrawn } from "./dom.js";
import { array, embedded, split } from "./data.js";
import { state, listen, change } from "./store.js";
import { counted, fixed } from "./numbers.js";
import { selectionToml } from "./selection.js";
import { startOfScene } from "./zones.js";
import { unpack } from "./page.js";
import { Asker, answerTo } from "./ask.js";
import { work, beginWork, edit, onWork, undo, redo } from "./work.js";
import { dataPane } from "./pane_data.js";
import { polesPane } from "./pane_poles.js";
import { panelPane } from "./pane_panel.js";
import { SWEEP_HZ } from "./sweep.js";
import { drawer } from "./drawer.js";
import { downloads } from "./downloads.js";
import { topBar, resultBar } from "./top.js";

/** Time between two questions about the progress of a fit, ms. */
const LOOK_MS = 200;
/** Time from the last change to the question for the best drive, ms. */
const REST_MS = 300;
/** Relative distance within which a dropped pole is found again, or its half-power bandwidth if that is larger. */
const SAME_POLE = 1e-3;
const OF_FIT = ["band", "modes", "added"];

/** Questions about fits carry the number of the page and of the question; a larger number is newer. */
const fits = { draft: new Asker("fit"), full: new Asker("fit"), data: new Asker("data"), page: embedded().page, asked: 0, shown: 0, open: 0 };
const scenes = { draft: new Asker("scene"), best: new Asker("scene"), sweep: new Asker("sweep"), time: new Asker("time"), asked: 0, bestShown: 0, timer: 0 };

/** Fields that were measured under the shown drive, the server's answer on the last one, and the corrected drive. */
const none = () => ({ fields: [], said: null, corrected: null });
let rig = none();

/** The shown fit, the last full fit, and the shown scene. */
let here = null;
let full = null;
let shown = null;
/** The error for which there is no drive of the scene; null without one. */
let refused = null;
/** Head of the last full fit: sentence, findings, better band. */
let head = null;
/** The measured data, drawn before any fit. */
let measured = null;
/** True where a model was opened: nothing is fitted. */
let fromFile = false;
/** The selection that adds modes to the last full fit; empty without any. */
let addedToml = "";
/** True once a scene is set. */
let hasBegun = false;

const poles = polesPane(cancelFit);
const data = dataPane();
const panel = panelPane(cancelScene);
const foot = drawer();
const result = resultBar();
let top = null;

/** Draws the empty studio, then the server's data, then the fit. */
export async function start() {
  const menu = downloads(() => ({ selection: selectionOfScene(), scene: shown && { ...shown.question }, fields: rig.corrected ? rig.fields : [] }), (name) => ({ "scene.toml": panel.scene().toml, "added.toml": addedToml || "# no mode is added\n", "selection.toml": here && selectionToml(here.model, state.dropped) })[name] ?? null);
  top = topBar(embedded().title, menu, askMeasured);
  document.body.classList.add("workbench");
  document.title = `${embedded().title} · Chladni studio`;
  const names = ["Data", "Poles", "Panel"];
  const tabs = h("nav", { class: "pane-tabs", "aria-label": "Panes" }, names.map((name, k) => h("button", { type: "button", onclick: () => showPane(k + 1) }, name)));
  document.getElementById("page").replaceChildren(top.element, result.element, tabs, h("main", {}, data.element, poles.element, panel.element), foot.element);
  showPane(1);
  result.show(["Reading …"], [], null);
  const said = await answerTo("start");
  if (said.error) return result.show([complaint(said.error)], [], null, "fault");
  begin(said);
  sayDrawn();
  askFit(false);
}

/** Draws the first picture and sets the first scene. */
function begin(said) {
  const places = said.data?.geometry ?? null;
  if (said.data) beginScene(places, said.lines_hz);
  fromFile = !said.refit;
  measured = said.data;
  data.start(said);
  panel.start(places);
  top.show();
  if (said.data) {
    const { responses, references, lines } = said.data;
    const [low, high] = said.lines_hz.map((hz) => Number(hz.toPrecision(4)));
    top.facts(`${counted(responses, "response")} × ${counted(references, "reference")}, ${counted(lines, "line")}, ${low} to ${high} Hz`);
  }
  listen(["dropped"], keepDropped);
  onWork(follow);
  addEventListener("keydown", byKey);
}

/** Sets the first scene: a hot quarter of the panel at the default frequency, or the scene in the address. The places of an opened model come with the fit. */
function beginScene(places, band) {
  hasBegun = true;
  beginWork({ zones: places ? startZones(places) : [], frequency: startOfScene([], { band_hz: band }).frequencyHz });
}

/** A quarter of the panel is hot. */
function startZones({ box: [x0, y0, x1, y1] }) {
  const [x, y] = [(x0 + x1) / 2, (y0 + y1) / 2];
  return [{ kind: "hot", points: [[x0, y0], [x, y0], [x, y], [x0, y]].map((point) => point.map((value) => Math.round(1e3 * value) / 1e3)) }];
}

/** Asks the server for the results of changed settings. */
function follow(keys, moving) {
  top.show();
  const has = (names) => names.some((name) => keys.includes(name));
  if (has(["band"])) data.showBand();
  if (!moving || !has(["zones"])) panel.showWork();
  if (has(["frequency"])) {
    poles.showPoles();
    panel.sweep.place(here?.model);
  }
  if (has(["dropped"])) restoreDropped();
  if (has(OF_FIT)) askFit(moving);
  else askScene(moving);
}

// ---- the fit

function askFit(moving) {
  const number = ++fits.asked;
  const question = { page: fits.page, number, draft: moving, band_hz: work.band, modes: work.modes, added_hz: work.added, light: !moving && !fromFile };
  if (!moving) beginProgress();
  (moving ? fits.draft : fits.full).ask(question, (said, more) => {
    if (!moving) endProgress();
    // an older answer never takes the place of a newer one
    if (number < fits.shown || (more && !moving)) return;
    if (said.overtaken && number === fits.asked) return result.show(["Another page of this studio asked for a fit; reload this one to go on here."], [], null);
    if (said.cancelled) return result.show(["The fit was cancelled. "], [], { words: "Fit again", action: () => askFit(false) });
    if (said.overtaken) return;
    if (said.error) return result.show([complaint(said.error)], head?.findings ?? [], here ? null : { words: "Fit again", action: () => askFit(false) }, "fault");
    fits.shown = number;
    showFit(said);
    askScene(moving);
    if (said.head) askData(said, number);
  });
}

/** Asks for the data that take longer than the fit: residuals, sums, diagrams. */
function askData(said, number) {
  fits.data.ask({ page: fits.page, number }, (rest) => {
    if (rest.data && number === fits.shown) showFit({ ...said, draft: null, head: null, data: rest.data });
  });
}

/** A draft as the data of a whole fit: the other data are those of the last full fit, or of the measurement. */
function completed(said) {
  if (!said.draft) return said;
  const { terms, ...changed } = said.draft;
  const before = full?.data ?? { frfs: measured.frfs, cmif: null, stabilization: null };
  const base = full ? { model: full.model, terms: full.terms } : { model: null, terms: null };
  const names = (frfs, side) => frfs[side].map((k, n) => said.draft.model[side][k] === frfs[side === "responses" ? "response_names" : "reference_names"][n]);
  const isSame = before.frfs && ["responses", "references"].every((side) => names(before.frfs, side).every(Boolean));
  const frfs = isSame ? { ...before.frfs, terms, errors: null, sums: { measured: before.frfs.sums.measured }, base } : null;
  return { ...said, data: { ...before, ...changed, frfs } };
}

function showFit(answer) {
  const said = completed(answer);
  const { model, geometry, structure } = unpack(said.data);
  model.file = said.model_file;
  here = { model, geometry, data: said.data };
  if (!hasBegun) beginScene(geometry, model.band_hz);
  // dropped modes have the numbers of the previous fit; they are found again by frequency
  isNumbered = false;
  change({ dropped: new Set(), mode: nearestMode(state.lookedAt) ?? model.inBand[0] ?? 0 });
  isNumbered = true;
  restoreDropped();
  data.fit(said.data, model);
  poles.fit(said.data, model, !fromFile, said.added?.grades);
  const passing = said.draft && !said.head;
  const hasBoard = panel.fit(model, passing ? null : geometry, passing ? undefined : structure);
  data.status.textContent = passing ? `${model.inBand.length} modes, draft` : "";
  if (!passing) {
    head = said.head ?? said.data;
    foot.set("fit", said.command || "# the model was read from its file");
    if (said.added) {
      addedToml = said.added.toml;
      foot.set("add", said.added.command);
      foot.set("added", addedToml || "# no mode is added: click a peak to add one\n");
    }
    if (!hasBoard) shown = null;
  }
  if (!said.draft) full = { data: said.data, model, terms: said.data.frfs?.terms && split(array(said.data.frfs.terms)) };
  showSentence();
  count(passing ? "drafts" : said.head ? "begun" : "fits");
}

/** Counts drawings, for tests that wait for them. */
function count(what) {
  document.documentElement.dataset[what] = String(Number(document.documentElement.dataset[what] ?? 0) + 1);
}

let looking = 0;

function beginProgress() {
  clearInterval(looking);
  poles.progress({ over: [], running: null });
  data.status.textContent = "fitting …";
  if (!here) result.show([h("b", {}, "Finding poles. "), "The data are drawn; zones can be drawn meanwhile."], [], null);
  fits.open += 1;
  looking = setInterval(async () => {
    const said = await answerTo("progress");
    if (fits.open && said.over) poles.progress(said);
  }, LOOK_MS);
}

function endProgress() {
  fits.open = Math.max(0, fits.open - 1);
  if (fits.open) return;
  clearInterval(looking);
  poles.progress(null);
  data.status.textContent = "";
}

function cancelFit() {
  answerTo("cancel");
}

// ---- dropped poles: kept as frequencies, since numbers change with every fit

function nearestMode(hz) {
  if (hz === undefined || !here) return null;
  const far = (k) => Math.abs(here.model.frequency[k] - hz);
  const best = here.model.inBand.reduce((a, b) => (a === null || far(b) < far(a) ? b : a), null);
  return best !== null && far(best) <= Math.max(SAME_POLE, here.model.modes[best].loss_factor / 2) * hz ? best : null;
}

/** False while the set of dropped poles has the numbers of another model. */
let isNumbered = true;

/** Stores the frequencies of the dropped poles in the settings. */
function keepDropped() {
  if (!here || !isNumbered) return;
  const dropped = [...state.dropped].map((k) => Number(here.model.frequency[k].toFixed(4))).sort((a, b) => a - b);
  if (JSON.stringify(dropped) !== JSON.stringify(work.dropped)) edit({ dropped });
  showSelection();
}

function restoreDropped() {
  if (!here) return;
  const wanted = new Set(work.dropped.map(nearestMode).filter((k) => k !== null));
  const same = wanted.size === state.dropped.size && [...wanted].every((k) => state.dropped.has(k));
  isNumbered = false;
  if (!same) change({ dropped: wanted });
  isNumbered = true;
  showSelection();
}

function droppedNumbers() {
  return here ? [...state.dropped].map((k) => here.model.inBand.indexOf(k) + 1).filter((number) => number > 0) : [];
}

/** The selection file of a scene; empty where every mode is kept. */
function selectionOfScene() {
  return droppedNumbers().length ? selectionToml(here.model, state.dropped) : "";
}

function showSelection() {
  state.lookedAt = here.model.frequency[state.mode];
  foot.set("selection", selectionToml(here.model, state.dropped));
  foot.set("select", droppedNumbers().length ? `chladni select ${here.model.file} selection.toml -o selected.json` : "");
}

// ---- the scene

function askScene(moving) {
  if (!panel.hasBoard()) return;
  const scene = panel.scene();
  foot.set("toml", scene.toml);
  clearTimeout(scenes.timer);
  scenes.best.cancel();
  scenes.sweep.cancel();
  scenes.time.cancel();
  forgetMeasured();
  if (!work.burst) foot.set("play", "");
  if (!here || here.model.references.length < 2) return;
  const number = ++scenes.asked;
  if (!panel.hasHot()) {
    scenes.draft.cancel();
    return refuseScene("draw a hot zone");
  }
  const question = { ...scene, selection: selectionOfScene() };
  panel.busy(moving ? "fast" : "fast; computing the best drive …", !moving);
  const fast = { ...question, method: "fast" };
  scenes.draft.ask(fast, (said) => showScene(said, fast, number, true));
  if (moving) return;
  scenes.timer = setTimeout(() => {
    const best = { ...question, method: "best" };
    scenes.best.ask(best, (said) => {
      if (said.cancelled) return;
      showScene(said, best, number, false);
      if (said.error) return;
      if (work.burst) askTime(best, number);
      askSweep(question, number);
    });
  }, REST_MS);
}

function showScene(said, question, number, light) {
  // during a drag an older answer is shown too; the best drive is not replaced by a quick one
  if (number <= scenes.bestShown || (number < scenes.asked && !light) || said.cancelled) return;
  if (said.error) return number === scenes.asked ? refuseScene(said.error, true) : undefined;
  if (!light) {
    scenes.bestShown = number;
    panel.busy("computing other frequencies …", true);
  }
  refused = null;
  shown = { question, said };
  panel.show(said.scene, light);
  foot.set("scene", said.command);
  showSentence();
}

/** Says why there is no drive, and leaves none of another scene. An error may be long: the sentence has room for it. */
function refuseScene(why, isError = false) {
  shown = null;
  refused = isError ? why : null;
  panel.noScene();
  panel.sweep.show(null);
  panel.showTime(work.burst ? { error: why } : null);
  foot.set("scene", "");
  foot.set("play", "");
  showSentence();
  panel.busy(isError ? "no drive" : why);
}

/** Asks for the scene over time, under the best drive. */
function askTime(question, number) {
  scenes.time.ask(question, (said) => {
    if (said.cancelled || number !== scenes.asked) return;
    panel.showTime(said);
    foot.set("play", said.command ?? "");
    if (said.findings && shown) shown.said.findings.push(...said.findings.map((one) => ({ ...one, about: "Time" })));
    showSentence();
  });
}

/** Asks for the scene at other frequencies, once the best drive is known. */
function askSweep(question, number) {
  const [low, high] = here.model.band_hz;
  const range = [Math.max(low, Math.ceil(work.frequency - SWEEP_HZ)), Math.min(high, Math.floor(work.frequency + SWEEP_HZ))];
  if (number !== scenes.asked || !(range[0] < range[1])) return panel.busy("");
  scenes.sweep.ask({ ...question, method: "default", range_hz: range }, (said) => {
    if (said.cancelled || number !== scenes.asked) return;
    panel.busy("");
    panel.sweep.show(said.sweep ?? null);
    if (!shown) return;
    shown.sweep = said.sweep;
    showSentence();
  });
}

// ---- measured fields

/** Forgets the measured fields, since the drive has changed. */
function forgetMeasured() {
  if (!rig.fields.length) return;
  rig = none();
  panel.showMeasured(null);
  panel.openField();
  foot.set("measured", "");
  foot.set("correct", "");
}

/** Takes a field of the shown drive; a second one of the same drive replaces the first. */
async function askMeasured(file) {
  const isBest = shown && scenes.bestShown === scenes.asked;
  if (!isBest) return panel.refuseField("A measured field belongs to a drive: wait for the best one.");
  const before = rig;
  const fields = [...(before.corrected ? before.fields : before.fields.slice(0, -1)), file];
  const number = scenes.asked;
  panel.busy(`comparing ${file.name} …`);
  const said = await answerTo("measured", { scene: shown.question, fields });
  if (number !== scenes.asked || rig !== before) return;
  panel.busy("");
  if (said.error) return panel.refuseField(said.error);
  rig = { fields, said, corrected: null };
  panel.showMeasured(said);
  foot.set("measured", said.command);
  showSentence();
  count("measuredFields");
}

/** Asks for the drive that all fields so far correct. */
async function correct() {
  const before = rig;
  panel.busy("correcting the drive …");
  const said = await answerTo("correct", { scene: shown.question, fields: rig.fields });
  if (rig !== before) return;
  panel.busy("");
  if (said.error) return panel.refuseField(said.error);
  rig = { ...rig, corrected: said };
  panel.show(said.scene, false);
  panel.openField();
  foot.set("correct", said.command);
  showSentence();
  count("corrections");
}

function cancelScene() {
  clearTimeout(scenes.timer);
  [scenes.best, scenes.sweep, scenes.time].forEach((asker) => asker.cancel());
  panel.busy("");
}

// ---- sentences and findings

function complaint(words) {
  return h("span", { class: "error", role: "alert" }, words);
}

function showSentence() {
  const parts = [head?.sentence ? `${head.sentence} ` : ""];
  const findings = [...(head?.findings ?? [])];
  const better = head?.better_band;
  let offer = better && !work.band ? { words: `Fit ${better[0]} to ${better[1]} Hz`, action: () => edit({ band: better }) } : null;
  if (shown) {
    const { scene, findings: found } = shown.said;
    findings.push(...found.map((one) => ({ about: "Scene", ...one })));
    const margin = scene.indices.points.margin_db;
    const spare = Number.isFinite(margin) ? (margin >= 0 ? `, ${fixed(margin, 1)} dB to spare` : `, ${fixed(-margin, 1)} dB short`) : "";
    parts.push(h("b", {}, `Scene ${scene.feasible ? "met" : "missed"} at ${fixed(scene.frequency_hz, 1)} Hz${spare}`));
    const but = scene.reservation;
    const on = here.model.inBand.find((k) => Math.abs(here.model.frequency[k] - scene.frequency_hz) <= 0.5 * here.model.modes[k].loss_factor * here.model.frequency[k]);
    // the chosen modes are numbered anew where some are dropped; the table counts all
    const isOn = on !== undefined && (!but || but.endsWith("lies on the drive"));
    if (isOn) parts.push(`, but mode ${here.model.inBand.indexOf(on) + 1} (${fixed(here.model.frequency[on], 1)} Hz) lies on the drive`);
    else if (but) parts.push(`, but ${but}`);
    parts.push(".");
    const calmer = shown.sweep?.frequencies.find((one) => one.frequency_hz === shown.sweep.suggested_hz && one.success_ratio === 1)?.frequency_hz;
    if (calmer && calmer !== work.frequency && (on !== undefined || !scene.feasible)) offer = { words: `Use ${fixed(calmer, 0)} Hz`, action: () => edit({ frequency: calmer }) };
  }
  if (refused) parts.push(complaint(refused));
  if (rig.corrected) {
    const { scene, findings: found } = rig.corrected;
    findings.splice(0, findings.length, ...found.map((one) => ({ about: "Correction", ...one })));
    const margin = scene.indices.points.margin_db;
    const spare = Number.isFinite(margin) ? `, ${fixed(Math.abs(margin), 1)} dB ${margin >= 0 ? "to spare" : "short"}` : "";
    parts.splice(0, parts.length, h("b", {}, `Corrected from ${counted(rig.fields.length, "field")}: the scene is ${scene.feasible ? "met" : "missed"} in the corrected model${spare}${scene.reservation ? `, but ${scene.reservation}` : ""}. `), "Play the new drive and measure once more to confirm.");
    offer = null;
  } else if (rig.said) {
    findings.splice(0, findings.length, ...rig.said.findings.map((one) => ({ about: "Measured field", ...one })));
    parts.splice(0, parts.length, h("b", {}, rig.said.sentence));
    offer = { words: "Correct", action: correct };
  }
  const isMissed = (rig.said ?? shown?.said)?.scene.indices.points.min_ratio < 1 && !rig.corrected;
  result.show(parts, findings, offer, refused ? "fault" : isMissed ? "caution" : undefined);
}

// ---- keys and panes

function showPane(number) {
  document.body.dataset.pane = String(number);
  document.querySelectorAll(".pane-tabs button").forEach((button, k) => button.setAttribute("aria-pressed", String(k + 1 === number)));
}

function byKey(event) {
  const typing = event.target.closest?.("input:not([type=checkbox]):not([type=radio]), select, textarea, dialog");
  const isUndo = (event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z";
  if (isUndo && !typing) (event.shiftKey ? redo : undo)();
  else if (event.key === "Escape") closeAll();
  else if (typing || event.ctrlKey || event.metaKey || event.altKey) return;
  else if ("123".includes(event.key)) {
    showPane(Number(event.key));
    document.getElementById(`pane-${event.key}`).focus();
  } else if (event.key === "d" || event.key === "D") foot.toggle();
  else if (event.key === "f" || event.key === "F") result.menu.open = !result.menu.open;
  else if (event.key === "[" || event.key === "]") edit({ frequency: Number((work.frequency + (event.key === "[" ? -1 : 1)).toFixed(1)) });
  else if (event.key === "?") top.showKeys();
  else if (!panel.key(event.key.toLowerCase())) return;
  event.preventDefault();
}

function closeAll() {
  foot.close();
  document.querySelectorAll("details.menu[open]").forEach((menu) => (menu.open = false));
  if (fits.open) cancelFit();
  cancelScene();
}
