// Modes kept and dropped by hand, as the file that `chladni select` reads.

import { h, takeAway } from "./dom.js";
import { state, listen, change } from "./store.js";
import { counted } from "./numbers.js";

/** The selection as TOML; empty where every mode is kept. Numbers are those of the pole table, from 1. */
export function selectionToml(model, dropped) {
  const numbers = [...dropped].map((index) => model.inBand.indexOf(index) + 1).filter((number) => number > 0).sort((a, b) => a - b);
  if (!numbers.length) return "# every mode is kept: click poles or rows to drop them\n";
  const weak = notSure(model);
  if (weak.length < model.inBand.length && weak.length === dropped.size && weak.every((index) => dropped.has(index))) return `keep = "sure"\n`;
  const named = numbers.map((number) => `${number}: ${model.modes[model.inBand[number - 1]].frequency_hz.toFixed(2)} Hz`).join(", ");
  return `# ${named}\ndrop = [${numbers.join(", ")}]\n`;
}

/** Indices of the modes in the band that are not sure. */
function notSure(model) {
  return model.inBand.filter((index) => model.modes[index].trust !== "sure");
}

/** The selection in words and as TOML, and a button that keeps all modes. */
export function selectionView(model) {
  const take = takeAway("selection.toml", "selection-toml");
  const words = h("p", { role: "status", id: "selection-words" });
  const all = h("button", { type: "button", onclick: () => change({ dropped: new Set() }) }, "Keep all");
  const weak = notSure(model);
  const isMixed = weak.length && weak.length < model.inBand.length;
  const sure = isMixed ? h("button", { type: "button", id: "keep-sure", onclick: () => change({ dropped: new Set(weak) }) }, "Keep only sure") : "";
  const command = h("pre", {}, `chladni select ${model.file ?? "model.json"} selection.toml -o selected.json`);
  const show = () => {
    take.set(selectionToml(model, state.dropped));
    const kept = model.inBand.length - state.dropped.size;
    words.textContent = `${kept} of ${counted(model.inBand.length, "mode")} kept. `;
    words.append(state.dropped.size ? all : "", " ", sure);
  };
  listen(["dropped"], show);
  show();
  return h("div", { class: "selection" }, h("h3", {}, "Selection"), words, take.element, command);
}
