// Hot and cold zones drawn on the panel, as the scene file that `chladni render` reads.

import { choice, h, section, takeAway } from "./dom.js";
import { tomlNumber } from "./numbers.js";
import { panelMap } from "./panel_map.js";

/** Corners are put on this raster, m. */
const RASTER = 0.001;
/** A key moves the corner so far, m. */
const STEP = 0.005;

/** Threshold profiles that need no table; the first one holds where a scene names none. */
const PROFILES = ["paper", "classic", "press-flat"];

/** The scene as TOML. `zones`: [{kind, points}] in m. */
export function sceneToml({ frequencyHz, profile, limenDb, transitionM, zones }) {
  const point = ([x, y]) => `[${tomlNumber(x, 4)}, ${tomlNumber(y, 4)}]`;
  const polygons = zones.map(({ kind, points }) => `\n[[zones.polygon]]\nkind = "${kind}"\npoints_m = [${points.map(point).join(", ")}]\n`);
  return `frequency_hz = ${tomlNumber(frequencyHz, 3)}\n\n[threshold]\n${profile === PROFILES[0] ? "" : `profile = ${JSON.stringify(profile)}\n`}limen_db = ${tomlNumber(limenDb, 2)}\n\n[zones]\ntransition_m = ${tomlNumber(transitionM, 4)}\n${polygons.join("")}`;
}

/** Hot zones and a drawing board: rectangles by pointer or by keys, polygons point by point. `onzones(zones, moving)` tells of every change. */
export function zoneBoard(geometry, first, onzones, id) {
  let zones = first;
  let kind = "hot";
  let shape = "rectangle";
  let drawing = null;
  let cursor = null;
  const map = panelMap(geometry.box, geometry.axes, "Board for zones: drag a rectangle, or move the corner with arrow keys and set it with Enter", 640);
  map.svg.id = id;
  map.svg.classList.add("board");
  const list = h("ul", { class: "zone-list" });

  const rounded = (place) => place.map((value, k) => {
    const [low, high] = [map.ends[k], map.ends[k + 2]];
    return Math.round(Math.min(high, Math.max(low, value)) / RASTER) * RASTER;
  });
  const rectangle = ([x0, y0], [x1, y1]) => {
    const [a, b, c, d] = [Math.min(x0, x1), Math.min(y0, y1), Math.max(x0, x1), Math.max(y0, y1)];
    return [[a, b], [c, b], [c, d], [a, d]];
  };
  const hasArea = (points) => Math.abs(points.reduce((sum, [x, y], k) => {
    const [nx, ny] = points[(k + 1) % points.length];
    return sum + x * ny - nx * y;
  }, 0)) > 2 * RASTER * RASTER;

  function tell(moving) {
    onzones(drawing && drawing.points.length > 2 && hasArea(drawing.points) ? [...zones, { kind: drawing.kind, points: drawing.points }] : zones, moving);
  }

  function draw() {
    const outline = ({ kind: of, points }, style, k) => ({ points, style: `${of}-zone${style}`, text: of, id: k });
    const outlines = zones.map((zone, k) => outline(zone, "", k));
    if (drawing) outlines.push(outline({ kind: drawing.kind, points: drawing.points }, " open"));
    const [x0, y0, x1, y1] = geometry.box;
    map.draw({
      outlines: [{ points: [[x0, y0], [x1, y0], [x1, y1], [x0, y1]], style: "area" }, ...outlines],
      marks: [
        { points: geometry.places, style: "response", mark: "dot" },
        { points: geometry.references.filter(Boolean), style: "actuator", mark: "ring" },
        { points: cursor ? [cursor] : [], style: "cursor", mark: "cross" },
      ],
    });
    list.replaceChildren(...zones.map((zone, k) => {
      const corners = zone.points.map(([x, y]) => `${Math.round(1e3 * x)}, ${Math.round(1e3 * y)}`).join("; ");
      return h("li", {}, h("b", {}, zone.kind), ` ${corners} mm `, h("button", { type: "button", onclick: () => put(zones.filter((_, n) => n !== k)) }, "Remove"));
    }));
  }

  function put(next, moving = false) {
    zones = next;
    draw();
    tell(moving);
  }

  function finish() {
    const done = drawing;
    drawing = null;
    if (done && done.points.length > 2 && hasArea(done.points)) put([...zones, { kind: done.kind, points: done.points }]);
    else draw();
  }

  map.svg.addEventListener("pointerdown", (event) => {
    const at = rounded(map.where(event));
    map.svg.focus({ preventScroll: true });
    event.preventDefault();
    cursor = null;
    if (shape === "polygon") {
      drawing = { kind, points: [...(drawing?.points ?? []), at] };
      draw();
      return;
    }
    map.svg.setPointerCapture?.(event.pointerId);
    drawing = { kind, from: at, points: rectangle(at, at) };
  });
  map.svg.addEventListener("pointermove", (event) => {
    if (!drawing?.from || !event.buttons) return;
    drawing = { ...drawing, points: rectangle(drawing.from, rounded(map.where(event))) };
    draw();
    tell(true);
  });
  map.svg.addEventListener("pointerup", () => { if (drawing?.from) finish(); });
  map.svg.addEventListener("dblclick", () => { if (shape === "polygon") finish(); });
  map.svg.addEventListener("keydown", (event) => {
    const moves = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, STEP], ArrowDown: [0, -STEP] };
    const middle = () => rounded([(geometry.box[0] + geometry.box[2]) / 2, (geometry.box[1] + geometry.box[3]) / 2]);
    if (moves[event.key]) {
      cursor = cursor ? rounded([cursor[0] + moves[event.key][0], cursor[1] + moves[event.key][1]]) : middle();
      if (drawing?.from) drawing = { ...drawing, points: rectangle(drawing.from, cursor) };
    } else if (event.key === "Enter") {
      cursor ??= middle();
      if (shape === "polygon") drawing = { kind, points: [...(drawing?.points ?? []), cursor] };
      else if (drawing?.from) return event.preventDefault(), finish();
      else drawing = { kind, from: cursor, points: rectangle(cursor, cursor) };
    } else if (event.key === "Escape") drawing = null;
    else return;
    event.preventDefault();
    draw();
    tell(true);
  });

  const radio = (name, value, words, checked, onchange) => h("label", { class: "control" }, h("input", { type: "radio", name, value, checked, onchange }), ` ${words}`);
  const kinds = ["hot", "cold", "ignore"].map((value) => radio(`${id}-kind`, value, value, value === "hot", () => { kind = value; }));
  const shapes = ["rectangle", "polygon"].map((value) => radio(`${id}-shape`, value, value, value === "rectangle", () => {
    shape = value;
    drawing = null;
    draw();
  }));
  const close = h("button", { type: "button", onclick: finish }, "Close polygon");
  const clear = h("button", { type: "button", onclick: () => put([]) }, "Clear");
  draw();
  return {
    element: h("div", {}, h("div", { class: "controls" }, h("span", {}, "Draw "), kinds, h("span", { class: "gap" }), shapes, close, clear), map.element, list),
    zones: () => zones,
  };
}

/** What a scene says beside its zones: inputs and their values. With `takesTable` a threshold table may be chosen, which `table()` holds as text. */
export function sceneNumbers(first, onchange, takesTable = false) {
  const number = (label, id, value, step, min) => {
    const input = h("input", { type: "number", id, value, step, min, onchange: () => input.checkValidity() && input.value !== "" && onchange() });
    return { element: h("label", { class: "control" }, `${label} `, input), value: () => (Number.isFinite(input.valueAsNumber) ? input.valueAsNumber : value), set: (to) => { input.value = to; } };
  };
  const frequency = number("Frequency (Hz)", "scene-frequency", first.frequencyHz, "any", 0.001);
  const limen = number("Limen (dB)", "scene-limen", first.limenDb, "any", 0);
  const transition = number("Transition (mm)", "scene-transition", 1e3 * first.transitionM, "any", 0);
  const profile = choice("Threshold", PROFILES, 0, () => onchange());
  profile.select.id = "scene-threshold";
  let table = null;
  const file = h("input", { type: "file", id: "scene-threshold-table", accept: ".csv,.txt", onchange: async () => {
    const [chosen] = file.files;
    if (!chosen) return;
    table = { name: chosen.name, csv: await chosen.text() };
    profile.select.replaceChildren(...[...PROFILES, table.name].map((name) => h("option", {}, name)));
    profile.select.selectedIndex = PROFILES.length;
    onchange();
  } });
  const choose = takesTable ? h("label", { class: "control" }, "or a table (CSV) ", file) : null;
  return {
    element: h("div", { class: "controls" }, frequency.element, profile.element, choose, limen.element, transition.element),
    table: () => (profile.select.selectedIndex < PROFILES.length ? null : table),
    values: () => ({ frequencyHz: frequency.value(), profile: profile.select.value, limenDb: limen.value(), transitionM: 1e-3 * transition.value() }),
    setFrequency: frequency.set,
  };
}

/** A drive that is well felt, Hz. */
const USUAL_HZ = 300;

/** Where a scene begins: the drive and the hot zones of the first scene, or a usual drive and nothing. */
export function startOfScene(scenes, model) {
  const first = scenes.find((scene) => scene.field);
  const zones = (first?.field.hot ?? []).map((points) => ({ kind: "hot", points }));
  const [low, high] = model?.band_hz ?? [0, Infinity];
  const usual = low < USUAL_HZ && USUAL_HZ < high ? USUAL_HZ : Math.round((low + high) / 2);
  return { frequencyHz: first?.frequency_hz ?? usual, limenDb: 2, transitionM: 0.01, zones };
}

/** Section: a board, and the scene as TOML to take along. */
export function zoneSection(geometry, scenes, model) {
  if (!geometry) return null;
  const start = startOfScene(scenes, model);
  const take = takeAway("scene.toml", "scene-toml");
  let zones = start.zones;
  const show = () => take.set(sceneToml({ ...numbers.values(), zones }));
  const numbers = sceneNumbers(start, () => show());
  const board = zoneBoard(geometry, zones, (next) => { zones = next; show(); }, "zone-board");
  show();
  return section("zones", "Draw a scene",
    h("p", {}, "Drag rectangles onto the panel, or set the corners of a polygon; without a cold zone all the rest is cold. With the keyboard: arrow keys move a corner, Enter sets it, Escape gives up."),
    numbers.element, board.element, take.element, h("pre", {}, `chladni render ${model?.file ?? "model.json"} scene.toml -o weights.json`));
}
