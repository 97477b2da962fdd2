// The actuators on the board: discs of amplitude and phase, and which of them may be driven.

import { h, s } from "./dom.js";
import { fixed } from "./numbers.js";
import { work, edit } from "./work.js";

/** Radii of the discs, and largest distance of a press from one, px. */
const [LEAST, MOST, REACH] = [3.5, 11, 11];

/** True where the actuator may be driven. */
const isOn = (name) => !work.off.includes(name);

function toggle(name, names) {
  const off = isOn(name) ? [...work.off, name] : work.off.filter((one) => one !== name);
  // the last one cannot be switched off
  if (off.length < names.length) edit({ off });
}

/** Names of the actuators that may be driven; null where all may. */
export function used(names) {
  const on = names.filter(isOn);
  return on.length && on.length < names.length ? on : null;
}

/** The actuator at a place; null where there is none. */
export function actuatorAt(geometry, place, scale) {
  const far = (at) => (at ? Math.hypot(at[0] - place[0], at[1] - place[1]) * scale : Infinity);
  const k = geometry.references.reduce((best, at, n) => (far(at) < far(geometry.references[best]) ? n : best), 0);
  return far(geometry.references[k]) <= REACH ? geometry.reference_names[k] : null;
}

export const toggleActuator = toggle;

/** Discs for the map's `extra`: the area is the amplitude, the hand the phase. A cross is an actuator that is off. */
export function discs(geometry, weights, unit) {
  const most = Math.max(1e-30, ...weights.map((weight) => Math.hypot(weight.re, weight.im)));
  return ({ px }) => geometry.references.flatMap((at, k) => {
    if (!at) return [];
    const name = geometry.reference_names[k];
    const weight = weights.find((one) => one.reference === name);
    const [x, y] = px(at);
    if (!isOn(name)) return [s("path", { class: "actuator-off", d: `M${x - 4} ${y - 4}l8 8m0 -8l-8 8` }, s("title", {}, `${name}: off`))];
    const share = weight ? Math.hypot(weight.re, weight.im) / most : 0;
    const radius = LEAST + (MOST - LEAST) * Math.sqrt(share);
    const angle = weight ? Math.atan2(weight.im, weight.re) : 0;
    const words = weight ? `${name}: ${fixed(1e3 * most * share, 3)} m${unit}, ${fixed((angle * 180) / Math.PI, 0)}°. Click: off` : name;
    const hand = share > 0 ? s("path", { class: "actuator-hand", d: `M${x} ${y}L${x + radius * Math.cos(angle)} ${y - radius * Math.sin(angle)}` }) : null;
    return [s("circle", { class: "actuator", cx: x, cy: y, r: radius }, s("title", {}, words)), hand].filter(Boolean);
  });
}

/** A folded list with a box for each actuator. */
export function actuatorList(names) {
  const summary = h("summary", {});
  const boxes = names.map((name) => h("input", { type: "checkbox", onchange: () => toggle(name, names) }));
  const show = () => {
    const on = names.filter(isOn).length;
    summary.textContent = on === names.length ? `Actuators: all ${on}` : `Actuators: ${on} of ${names.length}`;
    boxes.forEach((box, k) => (box.checked = isOn(names[k])));
  };
  const all = h("button", { type: "button", onclick: () => edit({ off: [] }) }, "All on");
  show();
  return { element: h("details", { class: "menu" }, summary, h("div", { class: "menu-body tick-list" }, all, names.map((name, k) => h("label", {}, boxes[k], ` ${name}`)))), show };
}
