// The head of the studio: file, undo and redo, downloads, keys; below it the sentence of the result.

import { h } from "./dom.js";
import { counted } from "./numbers.js";
import { findingList } from "./facts.js";
import { undo, redo, canUndo, canRedo } from "./work.js";

const KEYS = [
  ["1 2 3, D, F", "pane, drawer, findings"], ["V H C I P", "select, draw hot, cold, ignored, polygon"], ["arrows, Shift", "move the zone 1 mm, 10 mm; with Ctrl resize it; Alt while dragging: no snap"],
  ["Delete", "delete the zone"], ["Ctrl Z, Ctrl Shift Z", "undo, redo"], ["[ ]", "drive 1 Hz lower, higher"], ["↑ ↓, Space", "in the table: mode, keep or drop"], ["Esc", "cancel or close"], ["?", "this list"],
];
const WORST = ["fault", "caution", "note"];

/** The bar; `menu` are its downloads, `onfield({name, csv})` takes a measured field. */
export function topBar(title, menu, onfield) {
  const facts = h("span", { class: "muted", id: "file-facts" });
  const back = h("button", { type: "button", id: "undo", "aria-label": "Undo", title: "Undo (Ctrl Z)", onclick: undo }, "↶");
  const forth = h("button", { type: "button", id: "redo", "aria-label": "Redo", title: "Redo (Ctrl Shift Z)", onclick: redo }, "↷");
  const file = h("input", { type: "file", id: "measured-file", accept: ".csv,.txt", "aria-label": "Measured field, CSV", onchange: async () => {
    const [chosen] = file.files;
    if (!chosen) return;
    const csv = await chosen.text();
    // so that a file of the same name can be chosen again
    file.value = "";
    onfield({ name: chosen.name, csv });
  } });
  const field = h("label", { class: "file", title: "The velocity that was measured under this drive: response,re,im (CSV)" }, "Measured field…", file);
  const rows = KEYS.map(([key, words]) => [h("dt", {}, key), h("dd", {}, words)]);
  const keys = h("dialog", { id: "keys", "aria-label": "Keys" }, h("h2", {}, "Keys"), h("dl", {}, rows), h("form", { method: "dialog" }, h("button", {}, "Close")));
  const showKeys = () => keys.showModal();
  const element = h("header", { class: "top" }, h("b", {}, "Chladni"), h("b", { class: "file-name" }, title), facts, h("span", { class: "gap" }), back, forth, field, menu, h("button", { type: "button", "aria-label": "Keys", title: "Keys (?)", onclick: showKeys }, "?"), keys);
  const show = () => {
    back.disabled = !canUndo();
    forth.disabled = !canRedo();
  };
  show();
  return { element, show, showKeys, facts: (words) => (facts.textContent = words) };
}

/** The sentence with one button and the findings. */
export function resultBar() {
  const words = h("p", { class: "sentence" });
  const button = h("button", { type: "button", class: "primary", id: "use", hidden: true });
  const badge = h("summary", {});
  const list = h("div", { class: "menu-body" });
  const menu = h("details", { class: "menu badge", id: "findings", hidden: true }, badge, list);
  const element = h("div", { class: "result-bar", "data-worst": "none", role: "region", "aria-label": "Result" }, h("div", { role: "status", "aria-live": "polite" }, words), button, menu);
  let action = null;
  let listed = "";
  button.addEventListener("click", () => action?.());
  return {
    element,
    menu,
    /** `parts`: words or elements; `findings` with `about`; `offer`: {words, action} or null; the edge has the colour of the worst finding, or of `least` where none is worse. */
    show: (parts, findings, offer, least) => {
      words.replaceChildren(...parts.filter(Boolean));
      [button.textContent, action] = [offer?.words ?? "", offer?.action ?? null];
      button.hidden = !offer;
      // during a drag the findings mostly stay the same
      const now = JSON.stringify([findings, least]);
      if (now === listed) return;
      listed = now;
      const worst = WORST.find((severity) => findings.some((one) => one.severity === severity));
      element.dataset.worst = WORST.find((severity) => severity === worst || severity === least) ?? "none";
      menu.hidden = !worst;
      const count = (severity) => findings.filter((one) => one.severity === severity).length;
      badge.textContent = WORST.filter(count).map((severity) => counted(count(severity), severity)).join(", ");
      list.replaceChildren(findingList([...findings].sort((a, b) => WORST.indexOf(a.severity) - WORST.indexOf(b.severity))));
      list.querySelector("details")?.setAttribute("open", "");
    },
  };
}
