// The head of the page: title, warnings, contents, facts of the model.

import { h, section, factList, unbroken } from "./dom.js";
import { counted } from "./numbers.js";

/** Warnings, each with what it is about. */
export function warningList(warnings) {
  if (!warnings.length) return h("p", { class: "calm" }, "No warnings.");
  const items = warnings.map(([about, text]) => h("li", {}, h("b", {}, `${about}: `), unbroken(text)));
  return h("section", { class: "warnings", "aria-label": "Warnings" }, h("h2", {}, counted(warnings.length, "warning")), h("ul", {}, items));
}

/** Links to the sections. */
export function contents(sections) {
  const link = (one) => h("li", {}, h("a", { href: `#${one.id}` }, one.querySelector("h2").textContent));
  return h("nav", { "aria-label": "Contents" }, h("ul", {}, sections.map(link)));
}

/** What the model is. */
export function modelFacts(model) {
  return section("model", "Model", factList(model.facts));
}
