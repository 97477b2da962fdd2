// The studio: band, number of modes, zones and drive frequency in the reader's hand; fit, weights and field follow.

import { h, section, slider, tick, takeAway } from "./dom.js";
import { array, embedded, split } from "./data.js";
import { state, reset, change } from "./store.js";
import { unpack, fitParts, resultHead } from "./page.js";
import { findingList, contents } from "./facts.js";
import { sceneBody } from "./scenes.js";
import { zoneBoard, sceneNumbers, startOfScene, sceneToml } from "./zones.js";
import { fixed } from "./numbers.js";

/** The address of this page carries what the server wants to be shown with every question. */
const headers = { "Content-Type": "application/json", Authorization: `Bearer ${new URLSearchParams(location.search).get("token")}` };

/** Asks the server; an answer that another question has overtaken is null. */
class Asker {
  constructor(path) {
    this.path = path;
    this.running = false;
    this.next = null;
  }

  /** One question at a time; of those that wait only the last is asked. */
  ask(question, answer) {
    this.next = { question, answer };
    if (!this.running) this.run();
  }

  async run() {
    this.running = true;
    while (this.next) {
      const { question, answer } = this.next;
      this.next = null;
      let said;
      try {
        const response = await fetch(this.path, { method: "POST", headers, body: JSON.stringify(question) });
        said = response.ok ? await response.json() : { error: await response.text() };
      } catch {
        said = { error: "the studio does not answer: was it ended?" };
      }
      answer(said, this.next !== null);
    }
    this.running = false;
  }
}

/** Questions about fits are numbered from page to page, and from question to question of a page: what comes later is newer. */
const fits = { draft: new Asker("/api/fit"), full: new Asker("/api/fit"), page: embedded().page, asked: 1, shown: 0 };
const drafts = new Asker("/api/scene");
const finals = new Asker("/api/scene");

/** The fit of the moment: what is shown of it, and the last full one. */
let here = null;
let full = null;
/** What was asked for last: answers to older questions are not shown. */
let asked = 0;
/** The last question whose best drive is shown. */
let best = 0;

/** Draws the page, and fits for the first time. */
export function start() {
  const page = document.getElementById("page");
  page.replaceChildren(h("p", { role: "status" }, "Fitting …"));
  fits.full.ask({ page: fits.page, number: fits.asked }, (said) => {
    const trouble = said.overtaken ? "Another page of this studio asked for a fit; reload this one to go on here." : said.error;
    if (trouble) page.replaceChildren(h("p", { class: "error", role: "alert" }, trouble));
    else draw(page, said);
  });
}

/** Where each part of the fit stands, by its anchor: the diagram beside the controls, the others below the scene. */
const holders = new Map();

function draw(page, said) {
  const head = h("div", {});
  const { model, geometry } = unpack(said.data);
  const first = { ...startOfScene([], model), zones: geometry ? startZones(geometry) : [] };
  for (const [id] of fitParts(said.data, model, geometry)) holders.set(id, h("div", {}));
  const { controls, command } = fitControls(said, head);
  const scene = geometry ? scenePanel(first, geometry) : h("p", {}, "The file holds no positions of the nodes: no scene can be drawn.");
  const below = [...holders].filter(([id]) => id !== "stabilization").map(([, holder]) => holder);
  const studio = section("studio", "Studio", controls, holders.get("stabilization"), command);
  page.replaceChildren(head, h("main", {}, studio, section("scene", "Scene", scene), below));
  showFit(said, head);
  document.documentElement.dataset.drawn = String(Math.round(performance.now()));
}

/** A quarter of the panel is hot. */
function startZones({ box: [x0, y0, x1, y1] }) {
  const [x, y] = [(x0 + x1) / 2, (y0 + y1) / 2];
  return [{ kind: "hot", points: [[x0, y0], [x, y0], [x, y], [x0, y]].map((point) => point.map((value) => Math.round(1e3 * value) / 1e3)) }];
}

/** A draft as the data of a whole fit: what it does not change is that of the last full one. */
function completed(said) {
  if (!said.draft) return said;
  const { data, model, terms } = full;
  const { terms: own, ...changed } = said.draft;
  const frfs = data.frfs && { ...data.frfs, terms: own, errors: null, sums: { measured: data.frfs.sums.measured }, base: { model, terms } };
  return { ...said, data: { ...data, ...changed, frfs } };
}

/** What of a draft is still to be drawn. */
let waiting = 0;

function showFit(answer, head) {
  const said = completed(answer);
  const { pair } = state;
  clearTimeout(waiting);
  reset();
  // the DOFs of a studio are the same in every fit
  state.pair = pair;
  const { model, geometry } = unpack(said.data);
  model.file = said.model_file;
  here = { model, geometry };
  if (model.inBand.length) change({ mode: model.inBand[0] });
  const parts = fitParts(said.data, model, geometry);
  const put = ([id, make]) => holders.get(id).replaceChildren(...[make()].filter(Boolean));
  if (said.draft) {
    // what is in view at once, the rest while the hand rests
    const [now, later] = [true, false].map((wanted) => parts.filter(([id]) => isInView(holders.get(id)) === wanted));
    now.forEach(put);
    const next = () => {
      if (!later.length) return count("drafts");
      put(later.shift());
      waiting = setTimeout(next);
    };
    waiting = setTimeout(next);
    return;
  }
  full = { data: said.data, model, terms: said.data.frfs?.terms && split(array(said.data.frfs.terms)) };
  parts.forEach(put);
  const sections = ["studio", "scene", ...holders.keys()].map((id) => document.getElementById(id)).filter((one) => one?.tagName === "SECTION" && one.id !== "stabilization");
  head.replaceChildren(...resultHead(said.data), contents(sections));
  count("fits");
}

function isInView(element) {
  const { top, bottom } = element.getBoundingClientRect();
  return bottom > 0 && top < innerHeight;
}

/** Counts what was drawn, for who waits for it. */
function count(what) {
  document.documentElement.dataset[what] = String(Number(document.documentElement.dataset[what] ?? 0) + 1);
}

/** Band and number of modes; asks for a draft while the hand moves, for a full fit when it lets go. */
function fitControls(said, head) {
  const status = h("span", { class: "muted", role: "status", id: "fit-status" }, `${said.data.model.modes.filter((mode) => mode.in_band && mode.trust !== "rejected").length} modes`);
  const command = takeAway("The same fit again", "fit-command");
  command.set(said.command || "# the model was read from its file");
  if (!said.refit) return { controls: h("p", {}, "This is a model that was fitted before: band and number of modes are those of its file. Open the FRFs to change them. ", status), command: null };
  const [low, high] = said.lines_hz;
  const step = (high - low) / 1000;
  const words = (hz) => `${fixed(hz, 1)} Hz`;
  const band = said.data.model.band_hz;
  const from = slider("Band from", { min: low, max: high, step, value: band[0], words }, (_, moving) => ask(moving));
  const to = slider("to", { min: low, max: high, step, value: band[1], words }, (_, moving) => ask(moving));
  from.input.id = "band-from";
  to.input.id = "band-to";
  const count = h("input", { type: "number", id: "modes", min: 1, max: 1000, step: 1, disabled: true, oninput: () => ask(true), onchange: () => ask(false) });
  count.value = said.data.model.modes.filter((mode) => mode.in_band && mode.trust !== "rejected").length;
  const auto = tick("decided by evidence", true, (checked) => {
    count.disabled = checked;
    ask(false);
  });

  function ask(moving) {
    const ends = [from.input.valueAsNumber, to.input.valueAsNumber].sort((a, b) => a - b);
    const whole = ends[0] <= low + step && ends[1] >= high - step;
    const number = ++fits.asked;
    const question = { page: fits.page, number, draft: moving, band_hz: whole ? null : ends.map((hz) => Number(hz.toFixed(3))), modes: count.disabled ? null : count.valueAsNumber || null };
    const asker = moving ? fits.draft : fits.full;
    if (!moving) status.textContent = "fitting …";
    asker.ask(question, (answer, more) => {
      // an older answer never takes the place of a newer one
      if (number < fits.shown || answer.overtaken || (more && !moving)) return;
      fits.shown = number;
      if (answer.error) {
        status.textContent = answer.error;
        return;
      }
      showFit(answer, head);
      const found = here.model.inBand.length;
      status.textContent = `${found} modes${moving ? ", draft" : ""}${number < fits.asked ? "; fitting …" : ""}`;
      if (count.disabled) count.value = found;
      if (!moving) command.set(answer.command);
      scenes.again?.(moving);
    });
  }

  const counts = h("label", { class: "control" }, "Modes ", count);
  return { controls: h("div", { class: "controls" }, from.element, to.element, counts, auto, status), command: command.element };
}

/** Filled by the scene's panel: renders again after a fit. */
const scenes = {};

/** Board, numbers, and what comes of them. */
function scenePanel(first, geometry) {
  let zones = first.zones;
  const result = h("div", { id: "result" });
  const status = h("span", { class: "muted", role: "status", id: "scene-status" });
  const toml = takeAway("scene.toml", "scene-toml");
  const command = takeAway("The same weights again", "scene-command");
  const numbers = sceneNumbers(first, () => {
    drive.set(numbers.values().frequencyHz);
    ask(false);
  }, true);
  const [low, high] = here?.model.band_hz ?? [first.frequencyHz / 3, first.frequencyHz * 2];
  const drive = slider("Drive frequency", { min: low, max: high, step: "any", value: first.frequencyHz, words: (hz) => `${fixed(hz, 1)} Hz` }, (hz, moving) => {
    numbers.setFrequency(Number(hz.toFixed(1)));
    ask(moving);
  });
  drive.input.id = "drive";
  const board = zoneBoard(geometry, zones, (next, moving) => {
    zones = next;
    ask(moving);
  }, "zone-board");

  function ask(moving) {
    if (here) {
      [drive.input.min, drive.input.max] = here.model.band_hz;
    }
    const text = sceneToml({ ...numbers.values(), zones });
    toml.set(text);
    if (!zones.some((zone) => zone.kind === "hot")) {
      status.textContent = "draw a hot zone";
      return;
    }
    const number = ++asked;
    // `fast` at once; when the hand has let go `best` follows, which takes longer
    const scene = { toml: text, threshold: numbers.table() };
    drafts.ask({ ...scene, method: "fast" }, (said) => show(said, number, moving));
    if (moving) return;
    status.textContent = "computing the best drive …";
    finals.ask({ ...scene, method: "best" }, (said) => show(said, number, false, true));
  }

  function show(said, number, light, isBest = false) {
    // while the hand moves an answer of a moment ago is better than none; nothing is better than the best
    if ((number < asked && !light) || number <= best) return;
    if (said.error) {
      status.textContent = said.error;
      return;
    }
    const { model, geometry: places } = here;
    if (isBest) best = number;
    if (isBest || light) status.textContent = "";
    const body = sceneBody(said.scene, 1, model, places, light);
    result.replaceChildren(findingList(said.findings.map((finding) => ({ about: "Scene", ...finding }))), ...body);
    result.dataset.method = said.scene.method;
    result.dataset.answers = String(Number(result.dataset.answers ?? 0) + 1);
    command.set(said.command);
  }

  scenes.again = ask;
  // the first scene, as soon as the fit is shown
  queueMicrotask(() => ask(false));
  return h("div", {},
    h("p", {}, "Drag rectangles onto the panel, or set the corners of a polygon; without a cold zone all the rest is cold. With the keyboard: arrow keys move a corner, Enter sets it, Escape gives up."),
    numbers.element, h("div", { class: "controls" }, drive.element, status), h("div", { class: "pair" }, h("div", {}, board.element), h("div", {}, toml.element, command.element)), result);
}
