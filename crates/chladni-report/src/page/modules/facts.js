// The head of the page: the sentence of the result, findings, contents, facts of the model.

import { h, section, factList, unbroken } from "./dom.js";
import { counted } from "./numbers.js";

const WORDS = { fault: "✕ fault", caution: "▲ caution", note: "note" };

/** Findings by code, faults first. Notes are folded; without a fault all are. */
export function findingList(findings) {
  if (!findings.length) return h("p", { class: "calm" }, "Nothing was found that speaks against it.");
  const groups = new Map();
  for (const finding of findings) {
    const key = `${finding.severity} ${finding.code}`;
    groups.set(key, [...(groups.get(key) ?? []), finding]);
  }
  const all = [...groups.values()];
  const [shown, notes] = [all.filter(([first]) => first.severity !== "note"), all.filter(([first]) => first.severity === "note")];
  const count = (severity) => findings.filter((one) => one.severity === severity).length;
  const summary = ["fault", "caution", "note"].filter(count).map((severity) => counted(count(severity), severity)).join(", ");
  const folded = notes.length ? h("details", {}, h("summary", {}, counted(count("note"), "note")), h("ul", {}, notes.map(group))) : null;
  const list = h("div", {}, shown.length ? h("ul", {}, shown.map(group)) : null, shown.length ? folded : h("ul", {}, notes.map(group)));
  const worst = findings[0].severity;
  return h("details", { class: `findings ${worst}`, open: worst === "fault", "aria-label": "Findings" }, h("summary", {}, summary), list);
}

/** The findings of one code: the first in full, the others folded. */
function group([first, ...more]) {
  const about = new Set([first, ...more].map((one) => one.about));
  const others = more.length ? h("details", {}, h("summary", {}, `${more.length} more like it`), h("ul", {}, more.map((one) => h("li", {}, says(one))))) : null;
  return h("li", {}, h("b", { class: first.severity }, WORDS[first.severity]), ` ${[...about].join(", ")}: `, says(first), others);
}

function says({ text, help }) {
  return [unbroken(text), help ? [". Next: ", unbroken(help)] : "", "."];
}

/** Links to the sections. */
export function contents(sections) {
  const link = (one) => h("li", {}, h("a", { href: `#${one.id}` }, one.querySelector("h2").textContent));
  return h("nav", { "aria-label": "Contents" }, h("ul", {}, sections.map(link)));
}

/** Facts on the model. */
export function modelFacts(model) {
  return section("model", "Model", factList(model.facts));
}
