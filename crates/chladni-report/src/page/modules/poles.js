// Pole table with bounds, complexity, trust and reasons; a box keeps or drops each mode.

import { h, section, table } from "./dom.js";
import { state, listen, change, toggleMode } from "./store.js";
import { fixed, withBound, SIGMAS } from "./numbers.js";
import { selectionView } from "./selection.js";

const TRUST = { sure: "✓ sure", weak: "? weak", rejected: "× rejected" };

/** Section of the poles. */
export function poleSection(model) {
  const others = (wanted) => model.modes.map((mode, k) => k).filter((k) => wanted(model.modes[k]));
  const outside = others((mode) => !mode.in_band && mode.trust !== "rejected");
  const rejected = others((mode) => mode.trust === "rejected");
  const bare = model.modes.every((mode) => mode.frequency_std_hz === 0) ? " This model carries no bounds." : "";
  const words = `Natural frequencies are undamped (|s|/2π). Bounds are 95 % (1.96 standard deviations). A real shape has the modal phase collinearity MPC 1, mean phase deviation MPD 0° and modal complexity factor MCF 0.${bare}`;
  return section(
    "poles",
    "Poles",
    h("p", {}, words),
    ...counting(model),
    more("Poles outside the band (residual terms)", model, outside),
    more("Rejected candidates", model, rejected, "on-screen"),
    selectionView(model),
  );
}

/** Number of modes up to which weak ones are listed among the others. */
const FEW = 24;

/** Table of the modes in the band; of many modes the weak ones are folded. */
function counting(model) {
  if (!model.inBand.length) return [h("p", {}, "No mode in the band.")];
  const weak = model.inBand.filter((k) => model.modes[k].trust !== "sure");
  if (model.inBand.length <= FEW || !weak.length || weak.length === model.inBand.length) return [poleTable(model, model.inBand, true)];
  const sure = model.inBand.filter((k) => model.modes[k].trust === "sure");
  return [poleTable(model, sure, true), h("details", { class: "weak-modes" }, h("summary", {}, `Weak modes: ${weak.length}`), poleTable(model, weak, true))];
}

/** Poles that are folded; `where` is a class for the style sheet. */
function more(title, model, indices, where = "") {
  return indices.length ? h("details", { class: where }, h("summary", {}, `${title}: ${indices.length}`), poleTable(model, indices, false)) : null;
}

function poleTable(model, indices, inBand) {
  const header = [inBand ? "Keep" : "", { number: "Mode" }, { number: "Natural frequency (Hz)" }, { number: "Loss factor η (%)" }, { number: "Damping ratio ζ (%)" },
    { number: "MPC (0 to 1)" }, { number: "MPD (°)" }, { number: "MCF (0 to 1)" }, "Trust"];
  const boxes = new Map();
  const rows = indices.map((k) => {
    const mode = model.modes[k];
    const number = inBand ? String(model.inBand.indexOf(k) + 1) : "–";
    const box = inBand ? h("input", { type: "checkbox", "aria-label": `keep mode ${number}`, "data-mode": number, onchange: () => toggleMode(k) }) : "";
    boxes.set(k, box);
    const look = inBand ? h("button", { type: "button", class: "link", title: "show its shape", onclick: () => change({ mode: k }) }, number) : number;
    const reasons = mode.reasons.length ? `: ${mode.reasons.join("; ")}` : "";
    return [
      box, { number: look },
      { number: withBound(mode.frequency_hz, SIGMAS * mode.frequency_std_hz) },
      { number: withBound(100 * mode.loss_factor, SIGMAS * 100 * mode.loss_factor_std) },
      { number: withBound(50 * mode.loss_factor, SIGMAS * 50 * mode.loss_factor_std) },
      { number: fixed(mode.mpc, 3) }, { number: fixed(mode.mpd_deg, 1) }, { number: fixed(mode.mcf, 3) },
      h("span", {}, h("span", { class: mode.trust }, TRUST[mode.trust]), reasons),
    ];
  });
  const element = table(header, rows, { class: "poles" });
  const lines = element.querySelectorAll("tbody tr");
  const show = () => indices.forEach((k, place) => {
    if (boxes.get(k)) boxes.get(k).checked = !state.dropped.has(k);
    lines[place].classList.toggle("out", state.dropped.has(k));
    lines[place].classList.toggle("current", k === state.mode);
  });
  listen(["dropped", "mode"], show);
  show();
  return element;
}
