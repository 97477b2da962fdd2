// Charts that the figures of a report describe, drawn as these say: what is drawn of a view is said once, for files and for the page.

import { h } from "./dom.js";
import { array } from "./data.js";
import { chart } from "./chart.js";

/** Room above the height of a figure's box, for axes: px. */
const AROUND_PX = 52;

/** The charts of a figure {title, caption, charts}; `charts` are those of `chart`, `element` holds them all. */
export function described(figure, id) {
  const last = figure.charts.length - 1;
  const charts = figure.charts.map((one, k) => chart({ ...spec(one), title: k ? "" : figure.title, caption: k === last ? figure.caption : "" }));
  charts[0].svg.id = id;
  return { element: h("div", { class: "described" }, charts.map((one) => one.element)), charts };
}

function spec({ x, y, height, layers }) {
  const of = (kind) => layers.filter((layer) => layer[kind]);
  return {
    x, y, height: height + AROUND_PX,
    series: of("lines").flatMap(({ name, style, lines }) => lines.map(([x, y]) => ({ name, style, x: array(x), y: array(y) }))),
    marks: of("points").map(({ points: [x, y], ...mark }) => ({ ...mark, points: Array.from(array(x), (value, k) => [value, array(y)[k]]) })),
    horizontals: of("levels").flatMap(({ levels, style }) => levels.map((at) => ({ at, style }))),
    verticals: of("verticals").map(({ verticals, name, style }) => ({ name, at: verticals, style })),
    labels: of("words").map(({ words, at: [x, y] }) => ({ x, y, text: words })),
  };
}
