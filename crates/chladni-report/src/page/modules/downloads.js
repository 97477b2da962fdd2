// Results as files: the studio's server makes them, the browser saves them.

import { h } from "./dom.js";
import { fileOf } from "./ask.js";

/** Names and descriptions of the files, and true for those that need a rendered scene. */
const FILES = [
  ["model.json", "Model, without dropped modes", false], ["weights.json", "Weights", true], ["drive.wav", "Drive signals: the burst, or 2 s", true], ["drive.json", "Channels and full scale of drive.wav", true],
  ["calibration.json", "Knowledge of the rig, once a field has corrected the drive", true],
  ["scene.toml", "Scene", true], ["added.toml", "Modes added", false], ["selection.toml", "Modes kept and dropped", false], ["report.html", "Report", false],
];

/** A menu. `question()` gives {selection, scene or null, fields}; `text(name)` gives a file that the page itself has, or null. */
export function downloads(question, text) {
  const said = h("p", { class: "muted", role: "status" });
  const buttons = FILES.map(([name, words, ofScene]) => ({ ofScene, element: h("button", { type: "button", class: "ghost", "data-file": name, onclick: () => take(name, ofScene) }, h("b", {}, name), ` ${words}`) }));
  const menu = h("details", { class: "menu", id: "download" }, h("summary", {}, "Download"), h("div", { class: "menu-body" }, buttons.map((one) => one.element), said));

  async function take(name, ofScene) {
    said.textContent = `preparing ${name} …`;
    try {
      const { selection, scene, fields } = question();
      if (ofScene && !scene) throw new Error("no scene is rendered yet: draw a hot zone");
      const own = text(name);
      save(name, own === null ? await fileOf({ name, selection, scene, fields }) : new Blob([own], { type: "text/plain" }));
      said.textContent = `${name} is saved`;
    } catch (error) {
      said.textContent = error.message;
    }
  }

  return menu;
}

function save(name, blob) {
  const url = URL.createObjectURL(blob);
  const link = h("a", { href: url, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  // the browser has begun to save by then
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
