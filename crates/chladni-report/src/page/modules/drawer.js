// The drawer at the foot of the studio: commands and files, to copy, that repeat the work.

import { h, takeAway } from "./dom.js";

/** The texts that are files; the others are commands. */
const FILES = ["toml", "added", "selection"];

/** Tabs [id, words, takeAways]; one is open at a time, or none. */
export function drawer() {
  const texts = {
    fit: takeAway("The same fit", "fit-command"), add: takeAway("With the added modes", "add-command"), select: takeAway("Without the dropped modes", "select-command"), scene: takeAway("The same weights", "scene-command"), play: takeAway("The same drive over time", "play-command"), measured: takeAway("The same judgement of the measured field", "measured-command"), correct: takeAway("The same correction", "correct-command"),
    toml: takeAway("scene.toml", "scene-toml"), added: takeAway("added.toml", "added-toml"), selection: takeAway("selection.toml", "selection-toml"),
  };
  const tabs = [["Commands", ["fit", "add", "select", "scene", "play", "measured", "correct"]], ["scene.toml", ["toml"]], ["added.toml", ["added"]], ["selection.toml", ["selection"]]].map(([words, names]) => {
    const body = h("div", { class: "drawer-body", hidden: true }, names.map((name) => texts[name].element));
    const button = h("button", { type: "button", class: "ghost", "aria-expanded": "false", onclick: () => toggle(words) }, words);
    return { words, body, button };
  });
  const current = h("code", { class: "current-command" });
  const element = h("footer", { id: "drawer", "aria-label": "Commands and files" }, tabs.map((tab) => tab.body), h("div", { class: "drawer-bar" }, tabs.map((tab) => tab.button), current));

  function toggle(words) {
    for (const tab of tabs) {
      const open = tab.words === words && tab.body.hidden;
      tab.body.hidden = !open;
      tab.button.setAttribute("aria-expanded", String(open));
    }
  }

  return {
    element,
    set: (name, text) => {
      if (text !== texts[name].text()) texts[name].set(text);
      if (text && !FILES.includes(name) && current.textContent !== text) current.textContent = text;
    },
    toggle: () => toggle(tabs.find((tab) => !tab.body.hidden)?.words ?? tabs[0].words),
    close: () => tabs.forEach((tab) => tab.body.hidden || toggle(tab.words)),
  };
}
