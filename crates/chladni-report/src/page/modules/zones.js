// Hot and cold zones drawn on the panel, as the scene file that `chladni render` reads.

import { choice, h, section, takeAway } from "./dom.js";
import { tomlNumber } from "./numbers.js";
import { zoneEditor } from "./zone_editor.js";
import { inWords } from "./zone_shapes.js";

/** Threshold profiles that need no table; the first one is the default. */
export const PROFILES = ["paper", "classic", "press-flat"];

/** The scene as TOML. `zones`: [{kind, points, level_db}] in m; `use`: the actuators that may be driven, where these are not all; `burst`: length and
 ramps of a burst in place of a steady tone, s. */
export function sceneToml({ frequencyHz, profile, limenDb, transitionM, zones, use, burst }) {
  const point = ([x, y]) => `[${tomlNumber(x, 4)}, ${tomlNumber(y, 4)}]`;
  const level = ({ kind, level_db: db }) => (db && kind === "hot" ? `level_db = ${tomlNumber(db, 2)}\n` : "");
  const polygons = zones.map((zone) => `\n[[zones.polygon]]\nkind = "${zone.kind}"\n${level(zone)}points_m = [${zone.points.map(point).join(", ")}]\n`);
  const actuators = use ? `\n[actuators]\nuse = [${use.map((name) => JSON.stringify(name)).join(", ")}]\n` : "";
  const time = burst?.[0] ? `\n[time]\n[[time.burst]]\nduration_s = ${tomlNumber(burst[0], 4)}\nramp_s = ${burst[1] ? tomlNumber(burst[1], 4) : '"auto"'}\n` : "";
  return `frequency_hz = ${tomlNumber(frequencyHz, 3)}\n\n[threshold]\n${profile === PROFILES[0] ? "" : `profile = ${JSON.stringify(profile)}\n`}limen_db = ${tomlNumber(limenDb, 2)}\n\n[zones]\ntransition_m = ${tomlNumber(transitionM, 4)}\n${polygons.join("")}${actuators}${time}`;
}

/** Inputs of a scene beside its zones, and their values. */
function sceneNumbers(first, onchange) {
  const number = (label, id, value) => {
    const input = h("input", { type: "number", id, value, step: "any", min: 0, onchange: () => input.checkValidity() && input.value !== "" && onchange() });
    return { element: h("label", { class: "control" }, `${label} `, input), value: () => (Number.isFinite(input.valueAsNumber) ? input.valueAsNumber : value) };
  };
  const frequency = number("Frequency (Hz)", "scene-frequency", first.frequencyHz);
  const limen = number("Margin to the threshold (dB)", "scene-limen", first.limenDb);
  const transition = number("Transition (mm)", "scene-transition", 1e3 * first.transitionM);
  const profile = choice("Threshold", PROFILES, 0, () => onchange());
  profile.select.id = "scene-threshold";
  return {
    element: h("div", { class: "controls" }, frequency.element, profile.element, limen.element, transition.element),
    values: () => ({ frequencyHz: frequency.value(), profile: profile.select.value, limenDb: limen.value(), transitionM: 1e-3 * transition.value() }),
  };
}

/** Default drive frequency, Hz, at which touch is sensitive. */
const USUAL_HZ = 300;

/** The initial scene: drive and hot zones of the first scene, or the default drive without zones. */
export function startOfScene(scenes, model) {
  const first = scenes.find((scene) => scene.field);
  const zones = (first?.field.hot ?? []).map((points) => ({ kind: "hot", points }));
  const [low, high] = model?.band_hz ?? [0, Infinity];
  const usual = low < USUAL_HZ && USUAL_HZ < high ? USUAL_HZ : Math.round((low + high) / 2);
  return { frequencyHz: first?.frequency_hz ?? usual, limenDb: 2, transitionM: 0.01, zones };
}

/** Section with a board, and the scene as TOML. */
export function zoneSection(geometry, scenes, model) {
  if (!geometry) return null;
  if (model && !model.responses.some((name) => name.endsWith("Z"))) {
    return section("zones", "Draw a scene", h("p", {}, "A scene needs responses along Z, across a panel in the x–y plane. This model has none, so no scene can be rendered from it."));
  }
  const start = startOfScene(scenes, model);
  const take = takeAway("scene.toml", "scene-toml");
  let zones = start.zones;
  const show = () => take.set(sceneToml({ ...numbers.values(), zones }));
  const numbers = sceneNumbers(start, show);
  const list = h("ul", { class: "zone-list" });
  const listed = () => list.replaceChildren(...editor.zones().map((zone, k) => h("li", {}, `${inWords(zone)} `, h("button", { type: "button", onclick: () => editor.remove(k) }, "Remove"))));
  const editor = zoneEditor(geometry, {
    zones, id: "zone-board", tool: "hot",
    onzones: (next, moving) => {
      zones = next;
      show();
      if (!moving) listed();
    },
  });
  const clear = h("button", { type: "button", onclick: () => editor.put([]) }, "Clear");
  show();
  listed();
  return section("zones", "Draw a scene",
    h("p", {}, "Drag rectangles onto the panel, or set the corners of a polygon; without a cold zone all the rest is cold. With the keyboard: arrow keys move a corner, Enter sets it, Escape gives up."),
    numbers.element, editor.tools, editor.element, h("div", { class: "controls" }, clear), list, take.element, h("pre", {}, `chladni render ${model?.file ?? "model.json"} scene.toml -o weights.json`));
}
