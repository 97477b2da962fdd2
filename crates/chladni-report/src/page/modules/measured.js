// The studio's view of a measured field: every response in the colour of its level, missed limits, and the likely causes.

import { h } from "./dom.js";
import { levelMap } from "./colour.js";
import { fixed, printed } from "./numbers.js";
import { fieldLayers, levelBar, limitsOf, unpackField, DISC_SIGNS } from "./field.js";
import { panelMap } from "./panel_map.js";

/** Largest width of the map, px. */
const WIDEST = 460;
/** Number of causes that are listed. */
const MOST_CAUSES = 6;

/** The server's answer on a field: the map, the deviation in words, the ranked causes. */
export function measuredView(said, geometry) {
  const field = unpackField(said.scene.field);
  const speeds = Array.from(field.velocity.re, (re, k) => Math.hypot(re, field.velocity.im[k]));
  const map = panelMap(geometry.box, geometry.axes ?? ["x", "y"], `Measured field at ${fixed(said.scene.frequency_hz, 1)} Hz`, WIDEST);
  map.svg.id = "measured-field";
  const limits = limitsOf(field);
  map.draw(fieldLayers(field, null, speeds, limits, { map: levelMap() }));
  const rows = said.causes.slice(0, MOST_CAUSES).map((cause) => h("tr", {}, h("td", {}, printed(cause.words)), h("td", { class: "number" }, fixed(cause.ln_evidence, 1))));
  const head = h("tr", {}, h("th", {}, "Possible cause, likeliest first"), h("th", { class: "number" }, "ln evidence"));
  return [map.element, h("div", { class: "row legend-row" }, levelBar(limits, levelMap()), h("span", { class: "muted" }, `as measured  ${DISC_SIGNS}`)), h("p", {}, `Deviation ${printed(said.deviation)}.`),
    h("table", { id: "causes" }, h("thead", {}, head), h("tbody", {}, rows))];
}
