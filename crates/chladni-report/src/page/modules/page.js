// The report from top to bottom.

import { h } from "./dom.js";
import { reset, change } from "./store.js";
import { unpackModel } from "./synthesis.js";
import { warningList, contents, modelFacts } from "./facts.js";
import { frfSection } from "./frfs.js";
import { stabilizationSection } from "./stabilization.js";
import { poleSection } from "./poles.js";
import { macSection } from "./mac.js";
import { complexitySection } from "./complexity.js";
import { shapeSection, unpackGeometry } from "./shapes.js";
import { sceneSection } from "./scenes.js";
import { zoneSection } from "./zones.js";
import { tableSections } from "./tables.js";

/** Model and geometry of the page's data, ready for the views. */
export function unpack(data) {
  const model = data.model && unpackModel(data.model);
  return { model, geometry: unpackGeometry(data.geometry) };
}

/** The sections of identification, all that depends on the fit and on no scene: pairs of an anchor and what makes its section, or null. */
export function fitParts(data, model, geometry) {
  return [
    ["model", () => model && modelFacts(model)],
    ["poles", () => model && poleSection(model)],
    ["frfs", () => data.frfs && frfSection(data.frfs, model)],
    ["stabilization", () => stabilizationSection(data, model)?.element],
    ["mac", () => model && macSection(data.mac, model)],
    ["shapes", () => model && shapeSection(model, geometry)],
    ["complexity", () => model && complexitySection(model)],
  ];
}

/** Draws the whole page. */
export function show(data) {
  reset();
  const { model, geometry } = unpack(data);
  if (model?.inBand.length) change({ mode: model.inBand[0] });
  const sections = [
    ...fitParts(data, model, geometry).map(([, make]) => make()),
    ...data.scenes.map((scene, k) => sceneSection(scene, k + 1, model, geometry)),
    zoneSection(geometry, data.scenes, model),
    ...tableSections(data.tables),
  ].filter(Boolean);
  const head = h("header", {}, h("h1", {}, data.title || "Chladni report"), warningList(data.warnings), contents(sections));
  document.getElementById("page").replaceChildren(head, h("main", {}, sections));
  document.documentElement.dataset.drawn = String(Math.round(performance.now()));
}
