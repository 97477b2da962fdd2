// The report from top to bottom.

import { h, measureAll, sayDrawn } from "./dom.js";
import { array } from "./data.js";
import { reset, change } from "./store.js";
import { unpackModel } from "./synthesis.js";
import { findingList, contents, modelFacts } from "./facts.js";
import { frfSection, sumSection } from "./frfs.js";
import { stabilizationSection } from "./stabilization.js";
import { poleSection } from "./poles.js";
import { macSection } from "./mac.js";
import { complexitySection } from "./complexity.js";
import { shapeSection, unpackGeometry } from "./shapes.js";
import { unpackStructure } from "./structure.js";
import { sceneSection } from "./scenes.js";
import { zoneSection } from "./zones.js";
import { tableSections } from "./tables.js";

/** Part of the lines from which on a band is shown as all lines. */
const NEARLY_ALL = 0.98;

/** Model and geometry of the page's data, ready for the views. */
export function unpack(data) {
  const model = data.model && unpackModel(data.model);
  return { model, geometry: unpackGeometry(data.geometry), structure: unpackStructure(data.structure) };
}

/** The sections of identification, which depend on no scene: pairs of an anchor and a function that makes the section, or null. */
function fitParts(data, { model, geometry, structure }) {
  return [
    ["sum", () => data.frfs && sumSection(data.frfs, model)],
    ["poles", () => model && poleSection(model)],
    ["frfs", () => data.frfs && frfSection(data.frfs, model)],
    ["model", () => model && modelFacts(model)],
    ["stabilization", () => stabilizationSection(data, model)?.element],
    ["shapes", () => model && shapeSection(model, geometry, structure)],
    ["mac", () => model && macSection(data.mac, model)],
    ["complexity", () => model && complexitySection(model)],
  ];
}

/** Sets the first frequency range of the charts: the fitted band, where that is a part of the lines. */
function showBand(frfs, { band_hz: [low, high] }) {
  const lines = array(frfs.lines);
  const whole = lines[lines.length - 1] - lines[0];
  if (high - low < NEARLY_ALL * whole) change({ range: [low, high] });
}

/** The sentence of the result, and its findings. */
export function resultHead(data) {
  return [h("h1", {}, data.title || "Chladni report"), data.sentence ? h("p", { class: "sentence" }, data.sentence) : "", findingList(data.findings)];
}

/** Unfolds and draws everything for printing, and folds it again afterwards. */
function completeForPrint() {
  const folded = () => [...document.querySelectorAll("details:not([open])")];
  let opened = [];
  addEventListener("beforeprint", () => {
    opened = folded();
    opened.forEach((one) => (one.open = true));
    measureAll();
  });
  addEventListener("afterprint", () => opened.forEach((one) => (one.open = false)));
}

/** Draws the whole page. */
export function show(data) {
  reset();
  completeForPrint();
  const parts = unpack(data);
  const { model, geometry } = parts;
  if (model?.inBand.length) change({ mode: model.inBand[0] });
  const sections = [
    ...fitParts(data, parts).map(([, make]) => make()),
    ...data.scenes.map((scene, k) => sceneSection(scene, k + 1, model, geometry)),
    zoneSection(geometry, data.scenes, model),
    ...tableSections(data.tables),
  ].filter(Boolean);
  const head = h("header", {}, resultHead(data), contents(sections));
  document.getElementById("page").replaceChildren(head, h("main", {}, sections));
  if (model && data.frfs) showBand(data.frfs, model);
  sayDrawn();
}
