// The board of the studio: zones over the field of the drive.

import { levelMap } from "./colour.js";
import { fieldLayers, limitsOf, unpackField } from "./field.js";
import { zoneEditor } from "./zone_editor.js";
import { actuatorAt, discs, toggleActuator } from "./actuators.js";
import { work, edit } from "./work.js";

/** Colour of the stripes on ground that is not judged: that of the paper. */
const stripe = () => (levelMap() === "rising" ? [19, 21, 24] : [255, 255, 255]);
/** Layers of a field, none of them. */
const NO_FIELD = { surface: null, colour: null, contours: null, marks: null };
/** Columns of the field's pixels during a drag, and after it. */
const [COARSE, FINE] = [90, 180];

/** The board; `onselect` is called with the chosen zone. */
export function board(geometry, onselect) {
  const editor = zoneEditor(geometry, {
    zones: work.zones, id: "zone-board", tool: "select", bare: true, onselect,
    onzones: (zones, moving) => edit({ zones }, moving),
    onpress: (place) => {
      const name = actuatorAt(geometry, place, editor.map.scale());
      if (name) toggleActuator(name, geometry.reference_names);
      return Boolean(name);
    },
  });
  let shown = null;

  function draw(moving) {
    if (!shown) return editor.show({ ...NO_FIELD, extra: discs(geometry, [], "N") });
    const { field, scene } = shown;
    const speeds = Array.from(field.velocity.re, (re, k) => Math.hypot(re, field.velocity.im[k]));
    const layers = fieldLayers(field, field.surface, speeds, limitsOf(field), { columns: moving ? COARSE : FINE, map: levelMap(), stripe: stripe() });
    editor.show({ ...layers, extra: discs(geometry, scene.weights, scene.unit) });
  }

  draw(false);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw(false));
  return {
    editor,
    /** A rendered scene, or null while there is none. */
    show: (scene, moving) => {
      const field = scene && unpackField(scene.field);
      shown = field ? { field, scene } : null;
      draw(moving);
      return field;
    },
    again: () => draw(false),
  };
}
