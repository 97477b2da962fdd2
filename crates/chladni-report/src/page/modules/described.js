// Charts by their description in the data. The program describes such a view once, for files and for the page.

import { array } from "./data.js";
import { chart } from "./chart.js";

/** Height of a chart beyond that of its box, for axes, px. */
const AROUND_PX = 52;

/** The charts of a figure {title, caption, charts}. */
export function described(figure, id) {
  const last = figure.charts.length - 1;
  const views = figure.charts.map((one, k) => chart({ ...spec(one), title: k ? "" : figure.title, caption: k === last ? figure.caption : "" }));
  views[0].svg.id = id;
  return views;
}

function spec({ x, y, height, layers }) {
  const of = (kind) => layers.filter((layer) => layer[kind]);
  const stems = of("stems").map(({ stems: at, ...rest }) => ({ ...rest, points: pairs(at) }));
  const hints = stems.flatMap((layer) => layer.points.map(([x], k) => [x, layer.hints[k]]));
  const beside = (value) => hints.reduce((best, hint) => (Math.abs(hint[0] - value) < Math.abs(best[0] - value) ? hint : best), hints[0]);
  return {
    x, y, height: height + AROUND_PX, still: stems.length > 0, stems, onhover: (value) => (hints.length ? beside(value)[1] : ""),
    series: of("lines").flatMap(({ name, style, lines }) => lines.map(([x, y]) => ({ name, style, x: array(x), y: array(y) }))),
    marks: [...stems, ...of("points").map(({ points, ...mark }) => ({ ...mark, points: pairs(points) }))],
    horizontals: of("levels").flatMap(({ levels, style }) => levels.map((at) => ({ at, style }))),
    verticals: of("verticals").map(({ verticals, name, style }) => ({ name, at: verticals, style })),
    labels: of("words").map(({ words, at: [x, y] }) => ({ x, y, text: words })),
  };
}

function pairs([x, y]) {
  const [xs, ys] = [array(x), array(y)];
  return Array.from(xs, (value, k) => [value, ys[k]]);
}
