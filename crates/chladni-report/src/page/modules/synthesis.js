// The model's synthesis: FRFs of any pair at any frequency, and the field of given weights.

import { array, split } from "./data.js";

/** Unpacks the model's numbers. */
export function unpackModel(model) {
  const modes = model.modes.length;
  return {
    ...model,
    frequency: array(model.frequency_hz),
    shape: split(array(model.shapes)),
    participation: split(array(model.participations)),
    // an index of the pole table for each mode in the band, in order
    inBand: model.modes.map((mode, k) => [mode, k]).filter(([mode]) => mode.in_band && mode.trust !== "rejected").map(([, k]) => k),
    modeCount: modes,
  };
}

/** The factors [near, far] of r·near + conj(r)·far that a mode's residue r = shape·participation has in the receptance, at ω rad/s. */
export function modeFactors(model, n, omega) {
  const omegaN = 2 * Math.PI * model.frequency[n];
  const eta = model.modes[n].loss_factor;
  if (model.damping === "structural") return [inverse([omegaN ** 2 - omega ** 2, omegaN ** 2 * eta]), [0, 0]];
  const zeta = eta / 2;
  const damped = omegaN * Math.sqrt(Math.max(0, 1 - zeta * zeta));
  const decay = zeta * omegaN;
  // r/(2jω_d)/(jω − s) + conj(r)/(−2jω_d)/(jω − s*)
  const scale = [0, -1 / (2 * damped)];
  return [times(scale, inverse([decay, omega - damped])), times([0, 1 / (2 * damped)], inverse([decay, omega + damped]))];
}

/** Factor from receptance to `kind`: 1, jω or −ω². */
export function kindFactor(kind, omega) {
  if (kind === "mobility") return [0, omega];
  return kind === "accelerance" ? [-omega * omega, 0] : [1, 0];
}

/**
 * The FRF of one pair on a frequency axis, in the kind of the model, without the modes in `dropped`.
 * `terms`: residual terms of the pair, {re, im} per power.
 */
export function synthesise(model, response, reference, terms, frequencies, dropped) {
  const [rows, columns] = [model.responses.length, model.references.length];
  const kept = model.modes.map((mode, k) => k).filter((k) => model.modes[k].trust !== "rejected" && !dropped.has(k));
  const residues = kept.map((n) => times(at(model.shape, n * rows + response), at(model.participation, n * columns + reference)));
  const out = { re: new Float64Array(frequencies.length), im: new Float64Array(frequencies.length) };
  for (let line = 0; line < frequencies.length; line++) {
    const omega = 2 * Math.PI * frequencies[line];
    let [re, im] = [0, 0];
    for (let k = 0; k < kept.length; k++) {
      const [a, b] = residues[k];
      const [near, far] = modeFactors(model, kept[k], omega);
      re += a * near[0] - b * near[1] + a * far[0] + b * far[1];
      im += a * near[1] + b * near[0] + a * far[1] - b * far[0];
    }
    for (let k = 0; k < model.powers.length; k++) {
      const scale = (omega / model.omega_scale) ** model.powers[k];
      re += terms.re[k] * scale;
      im += terms.im[k] * scale;
    }
    [out.re[line], out.im[line]] = times([re, im], kindFactor(model.kind, omega));
  }
  return out;
}

/**
 * Velocities that a scene's weights make at another frequency, or with only the modes that `keeps(n)` names: `shapes` and `terms`
 * are {re, im} with axes (mode, place) and (power, place).
 */
export function velocity(model, modal, shapes, terms, frequencyHz, keeps = () => true) {
  const omega = 2 * Math.PI * frequencyHz;
  const places = terms && model.powers.length ? terms.re.length / model.powers.length : shapes.re.length / model.modeCount;
  const out = { re: new Float64Array(places), im: new Float64Array(places) };
  const add = (source, offset, [a, b], conjugated) => {
    const turn = conjugated ? -1 : 1;
    for (let k = 0; k < places; k++) {
      const [re, im] = [source.re[offset + k], turn * source.im[offset + k]];
      out.re[k] += re * a - im * b;
      out.im[k] += re * b + im * a;
    }
  };
  for (let n = 0; n < model.modeCount; n++) {
    if (model.modes[n].trust === "rejected" || !keeps(n)) continue;
    const [near, far] = modeFactors(model, n, omega);
    add(shapes, n * places, times(near, at(modal.forces, n)), false);
    if (far[0] || far[1]) add(shapes, n * places, times(far, at(modal.mirrored, n)), true);
  }
  for (let k = 0; k < model.powers.length; k++) add(terms, k * places, [(omega / model.omega_scale) ** model.powers[k], 0], false);
  // receptance to velocity: jω
  for (let k = 0; k < places; k++) [out.re[k], out.im[k]] = [-omega * out.im[k], omega * out.re[k]];
  return out;
}

function at(list, k) {
  return [list.re[k], list.im[k]];
}

export function times([a, b], [c, d]) {
  return [a * c - b * d, a * d + b * c];
}

function inverse([a, b]) {
  const square = a * a + b * b;
  return [a / square, -b / square];
}
