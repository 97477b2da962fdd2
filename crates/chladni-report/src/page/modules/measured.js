// The studio's view of a measured field: every response coloured by what was measured there, missed limits, and the likely causes.

import { h, s } from "./dom.js";
import { levelMap, cssColour } from "./colour.js";
import { level, fixed, printed } from "./numbers.js";
import { fieldLayers, keeps, levelBar, unpackField, RANGE_DB } from "./field.js";
import { panelMap } from "./panel_map.js";

const HOT = 2;
/** Radius of a response, px, and the largest width of the map, px. */
const [RADIUS, WIDEST] = [7, 460];
/** Causes that are listed. */
const MOST_CAUSES = 6;

/** What the server said of a field: the map, the deviation in words, the ranked causes. */
export function measuredView(said, geometry) {
  const field = unpackField(said.scene.field);
  const speeds = Array.from(field.velocity.re, (re, k) => Math.hypot(re, field.velocity.im[k]));
  const map = panelMap(geometry.box, geometry.axes ?? ["x", "y"], `Measured field at ${fixed(said.scene.frequency_hz, 1)} Hz`, WIDEST);
  map.svg.id = "measured-field";
  const limenDb = level(field.felt / field.threshold);
  map.draw({ outlines: fieldLayers(field, null, speeds, limenDb).outlines, extra: points(field, speeds) });
  const rows = said.causes.slice(0, MOST_CAUSES).map((cause) => h("tr", {}, h("td", {}, printed(cause.words)), h("td", { class: "number" }, fixed(cause.ln_evidence, 1))));
  const head = h("tr", {}, h("th", {}, "Possible cause, likeliest first"), h("th", { class: "number" }, "ln evidence"));
  return [map.element, h("div", { class: "row legend-row" }, levelBar(limenDb, levelMap()), h("span", { class: "muted" }, "as measured  ✕ too loud  △ too weak")), h("p", {}, `Deviation ${printed(said.deviation)}.`),
    h("table", { id: "causes" }, h("thead", {}, head), h("tbody", {}, rows))];
}

/** A disc for each response; a cross over cold ground that is felt, a triangle over hot ground that is not. */
function points(field, speeds) {
  return ({ px }) => field.places.flatMap((place, k) => {
    const [x, y] = px(place);
    const db = level(Math.max(1e-15, speeds[k] / field.threshold));
    const missed = !keeps(field, k, speeds[k]);
    const isHot = field.ground[k] === HOT;
    const words = `${field.names[k]}: ${fixed(db, 1)} dB re threshold, ${missed ? (isHot ? "too weak" : "too loud") : "as wished or not judged"}`;
    const disc = s("circle", { class: missed ? "measured-point missed-point" : "measured-point", cx: x, cy: y, r: RADIUS, fill: cssColour(levelMap(), 0.5 + (0.5 * db) / RANGE_DB) }, s("title", {}, words));
    if (!missed) return [disc];
    const d = isHot ? `M${x} ${y - 4.5}l4.5 8h-9z` : `M${x - 4} ${y - 4}l8 8m0 -8l-8 8`;
    return [disc, s("path", { class: "missed-sign casing", d }), s("path", { class: "missed-sign", d })];
  });
}
