// Tables of `chladni bench`: speed against accuracy, and scenes over the number of modes and actuators.

import { h, section, choice, table } from "./dom.js";
import { chart } from "./chart.js";
import { percent } from "./numbers.js";

const SIGNS = ["dot", "square", "triangle", "big"];
/** Columns that distinguish the curves of a scene table. */
const CURVE = ["scene", "asked_method"];

/** Sections of all tables. */
export function tableSections(tables) {
  return tables.map((one, k) => section(`table-${k + 1}`, one.name, view(one), more(one)));
}

function view(one) {
  const has = (...names) => names.every((name) => one.header.includes(name));
  if (has("case", "method", "time_s", "frequency_rmse_over_crlb")) return speedView(one);
  if (has("scene", "method", "modes", "actuators", "window_total")) return sceneView(one);
  return h("p", {}, "This table has no columns that the report knows how to draw; it is shown as it is.");
}

function more(one) {
  return h("details", {}, h("summary", {}, `${one.rows.length} rows`), table(one.header, one.rows, {}));
}

function numbers(one, name) {
  const k = one.header.indexOf(name);
  return one.rows.map((row) => (row[k] === undefined || row[k] === "" ? NaN : Number(row[k])));
}

function words(one, name) {
  const k = one.header.indexOf(name);
  return one.rows.map((row) => row[k] ?? "");
}

function logRange(values) {
  const sound = values.filter((value) => value > 0);
  return sound.length ? [Math.min(...sound) / 1.6, Math.max(...sound) * 1.6] : [0.1, 10];
}

/** Error over the bound against time; the Pareto front joined by a line. */
function speedView(one) {
  const cases = [...new Set(words(one, "case"))];
  const [time, error, of, method] = [numbers(one, "time_s"), numbers(one, "frequency_rmse_over_crlb"), words(one, "case"), words(one, "method")];
  const view = chart({ still: true, height: 380, x: { label: "Time of a fit", unit: "s", range: [0.1, 1], log: true }, y: { label: "Rms frequency error over the bound", unit: "–", range: [0.1, 1], log: true } });
  const show = (index) => {
    const shown = time.map((_, k) => k).filter((k) => of[k] === cases[index] && time[k] > 0 && error[k] > 0);
    const front = shown.filter((k) => !shown.some((other) => other !== k && time[other] <= time[k] && error[other] <= error[k])).sort((a, b) => time[a] - time[b]);
    view.update({
      title: `Speed against accuracy: ${cases[index]}`, caption: "Lower left is better; an error of 1 is what the noise allows. The line joins what no other method beats in both.",
      x: { label: "Time of a fit", unit: "s", range: logRange(shown.map((k) => time[k])), log: true },
      y: { label: "Rms frequency error over the bound", unit: "–", range: logRange([...shown.map((k) => error[k]), 1]), log: true },
      series: [{ x: front.map((k) => time[k]), y: front.map((k) => error[k]), style: "both-line" }],
      horizontals: [{ at: 1, style: "zero-line" }],
      marks: shown.map((k, n) => ({ points: [[time[k], error[k]]], style: front.includes(k) ? "kept" : "dropped", sign: SIGNS[n % SIGNS.length] })),
      labels: shown.map((k) => ({ x: time[k], y: error[k], text: method[k] })),
    });
  };
  show(0);
  return h("div", {}, cases.length > 1 ? choice("Case", cases, 0, show).element : null, view.element);
}

/** Share of responses served on the true panel, over modes and over actuators. */
function sceneView(one) {
  const keys = one.rows.map((_, k) => CURVE.filter((name) => one.header.includes(name)).map((name) => words(one, name)[k]).join(", "));
  const total = numbers(one, "window_total");
  const over = (name, label) => {
    const count = numbers(one, name);
    const series = [...new Set(keys)].map((key, n) => {
      const rows = count.map((_, k) => k).filter((k) => keys[k] === key && Number.isFinite(count[k])).sort((a, b) => count[a] - count[b]);
      return { name: key, x: rows.map((k) => count[k]), y: rows.map((k) => 100 * total[k]), style: `cmif cmif-${n % 6}` };
    });
    const sound = count.filter(Number.isFinite);
    if (new Set(sound).size < 2) return null;
    return chart({
      title: `Served ground over the number of ${name}, on the true panel`, height: 280,
      x: { label, unit: "number", range: [Math.min(...sound) - 0.5, Math.max(...sound) + 0.5] }, y: { label: "Ground that keeps its limit", unit: "%", range: [-2, 104] },
      series, marks: series.map((one) => ({ points: one.x.map((x, k) => [x, one.y[k]]), style: "kept", sign: "dot" })),
    }).element;
  };
  const charts = [over("modes", "Modes summed"), over("actuators", "Actuators driven")].filter(Boolean);
  return charts.length ? h("div", {}, charts) : h("p", {}, `One number of modes and actuators only: ${percent(total[0])} of the ground keeps its limit in the first row.`);
}
