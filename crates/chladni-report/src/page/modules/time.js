// A scene in time: its figure, every response, and the ground at any instant.

import { h, slider } from "./dom.js";
import { array } from "./data.js";
import { colourAt, cssColour } from "./colour.js";
import { fixed } from "./numbers.js";
import { chart } from "./chart.js";
import { described } from "./described.js";
import { panelMap, colourBar } from "./panel_map.js";

/** Ends of the colours, dB re threshold, and the code of ground without a level. */
const RANGE_DB = 12;
const NONE = 255;
/** Number of shades in a chart of levels: about as many as the eye distinguishes. */
const SHADES = 24;
/** Speed of the scene on the page: seconds of the scene in a second. */
const PACE = 0.1;

/** The views of a scene in time; null for a steady tone. */
export function timeView(time, geometry, id) {
  if (!time) return null;
  const parts = [h("h3", {}, "In time"), h("p", {}, `${time.sentence}.`)];
  const traces = described(time.figure, `${id}-traces`);
  const mark = (seconds) => traces[0].update({ verticals: [{ name: "shown below", at: [1e3 * seconds], style: "pole-line" }] });
  parts.push(...traces.map((one) => one.element));
  if (time.places) parts.push(...places(time));
  if (time.ground) parts.push(ground(time, geometry, id, mark));
  return h("div", { class: "time" }, parts);
}

/** Every response over time, from hot to cold ground. */
function places(time) {
  const { names, hot, unjudged, count, step_s: step } = time.places;
  const codes = array(time.places.codes);
  const level = (row, k) => codes[row * count + k];
  const shade = (row, k) => Math.round((level(row, k) / (NONE - 1)) * (SHADES - 1));
  const strips = Array.from({ length: SHADES }, (_, k) => ({ colour: cssColour("sequential", k / (SHADES - 1)), runs: [] }));
  for (let row = 0; row < names.length; row++) {
    let from = 0;
    for (let k = 1; k <= count; k++) {
      if (k < count && shade(row, k) === shade(row, from)) continue;
      strips[shade(row, from)].runs.push([1e3 * step * from, 1e3 * step * k, names.length - 1 - row]);
      from = k;
    }
  }
  const said = (ms, y) => {
    const [row, k] = [Math.ceil(names.length - y) - 1, Math.floor(ms / (1e3 * step))];
    if (!names[row] || k < 0 || k >= count) return null;
    return `${names[row]}: ${fixed(RANGE_DB * (2 * (level(row, k) / (NONE - 1)) - 1), 1)} dB re threshold`;
  };
  const view = chart({
    title: "Every response over time", height: 260, strips, onhover: said, horizontals: [hot, hot + unjudged].slice(0, unjudged ? 2 : 1).map((above) => ({ at: names.length - above, style: "border-line" })),
    caption: unjudged
      ? `${hot} hot responses above the upper line, cold ones below the lower line; the ${unjudged} between the lines are not judged. Colours as in the field.`
      : `${hot} hot responses above the line, cold ones below; colours as in the field.`,
    x: { label: "Time", unit: "ms", range: [0, 1e3 * step * count] }, y: { label: "Responses", unit: "number", range: [0, names.length] },
  });
  view.element.classList.add("time-places");
  return [view.element, levelBar()];
}

/** The ground at the instant of a slider. */
function ground(time, geometry, id, mark) {
  const { x, y, count, step_s: step, hot, area_m: area } = time.ground;
  const codes = array(time.ground.codes);
  const box = geometry?.box ?? [x[0], y[0], x[x.length - 1], y[y.length - 1]];
  const map = panelMap(box, geometry?.axes ?? ["x", "y"], "Field over time");
  map.svg.id = id;
  const title = h("p", { class: "figure-title" });
  const size = x.length * y.length;
  const corners = ([x0, y0, x1, y1]) => [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
  const outlines = [{ points: corners(area), style: "area" }, ...hot.map((points) => ({ points, style: "hot-zone" }))];
  let playing = false;
  let [last, place] = [0, 0];

  function show(frame) {
    place = frame;
    title.textContent = `The ground at ${fixed(1e3 * step * frame, 0)} ms`;
    const colour = (k) => {
      const code = codes[frame * size + k];
      return code === NONE ? null : colourAt("sequential", code / (NONE - 1));
    };
    map.draw({ surface: { x, y }, colour, outlines });
    mark(step * frame);
  }

  const control = slider("Time", { min: 0, max: count - 1, step: 1, value: 0, words: (frame) => `${fixed(1e3 * step * frame, 0)} ms` }, (frame) => show(frame));
  const button = h("button", { type: "button", onclick: () => play(!playing) }, "Play");

  function play(on) {
    playing = on;
    button.textContent = on ? "Pause" : "Play";
    last = performance.now();
    if (on) requestAnimationFrame(run);
  }

  function run(now) {
    if (!playing || !button.isConnected) return;
    const passed = Math.floor((PACE * (now - last)) / 1000 / step);
    if (passed > 0) {
      last = now;
      const next = (place + passed) % count;
      control.set(next);
      show(next);
    }
    requestAnimationFrame(run);
  }

  show(0);
  const caption = `Level of the amplitude re the threshold. "Play" runs ${fixed(1 / PACE, 0)} times slower than the scene.`;
  return h("figure", {}, title, map.element, levelBar(), h("div", { class: "controls" }, control.element, button), h("figcaption", {}, caption));
}

function levelBar() {
  const colour = (value) => colourAt("sequential", 0.5 + (0.5 * value) / RANGE_DB);
  return colourBar(colour, [-RANGE_DB, RANGE_DB], "velocity, dB re threshold");
}
