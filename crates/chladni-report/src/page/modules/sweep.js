// The drive frequency, and the performance at other frequencies.

import { chart, padded } from "./chart.js";
import { fixed } from "./numbers.js";
import { work, edit } from "./work.js";

const HEIGHT_PX = 92;
/** Range that is tried on either side of the drive, Hz. */
export const SWEEP_HZ = 20;

/** The chart: `show(sweep, model)` draws a sweep, `place(model)` the frequency alone. */
export function sweepChart() {
  const view = chart({ compact: true, height: HEIGHT_PX, still: true, x: { label: "Frequency", unit: "Hz", range: [0, 1] }, y: { label: "", unit: "", range: [0, 1] }, series: [] });
  let swept = null;
  let model = null;
  view.element.hidden = true;

  function draw() {
    if (!model) return;
    view.element.hidden = false;
    const ends = swept ? [swept.frequencies[0].frequency_hz, swept.frequencies[swept.frequencies.length - 1].frequency_hz] : around(work.frequency);
    const near = model.inBand.filter((k) => model.frequency[k] >= ends[0] && model.frequency[k] <= ends[1]);
    const grip = {
      name: "drive", at: work.frequency, label: "Drive frequency", words: (hz) => `${fixed(hz, 1)} Hz`, low: model.band_hz[0], high: model.band_hz[1], step: 1,
      onmove: (hz, moving) => edit({ frequency: Number(hz.toFixed(1)) }, moving),
    };
    view.update({
      x: { label: "Frequency", unit: "Hz", range: ends }, grips: [grip], ...curve(swept),
      verticals: [{ name: "natural frequency", at: near.map((k) => model.frequency[k]), style: "pole-line" }],
      labels: near.map((k) => ({ x: model.frequency[k], y: 0, text: `mode ${model.inBand.indexOf(k) + 1}` })),
    });
  }

  function around(hz) {
    const [low, high] = model.band_hz;
    return [Math.max(low, hz - SWEEP_HZ), Math.min(high, hz + SWEEP_HZ)];
  }

  return {
    element: view.element,
    range: () => (model ? around(work.frequency).map((hz) => Math.round(hz)) : null),
    place: (fitted) => {
      model = fitted;
      draw();
    },
    show: (found) => {
      swept = found;
      draw();
    },
  };
}

/** κ where the model has error bars; otherwise the share of responses that keep their limits. */
function curve(swept) {
  if (!swept) return { series: [], marks: [], horizontals: [], y: { label: "", unit: "drive frequency", range: [0, 1] } };
  const rows = swept.frequencies;
  const byKappa = rows.some((row) => row.kappa !== null);
  const x = rows.map((row) => row.frequency_hz);
  const y = rows.map((row) => (byKappa ? row.kappa ?? NaN : 100 * row.success_ratio));
  const best = rows.findIndex((row) => row.frequency_hz === swept.suggested_hz);
  return {
    series: [{ x, y, style: "sweep-line" }],
    marks: [{ points: best < 0 ? [] : [[x[best], y[best]]], style: "suggested", sign: "big" }],
    horizontals: byKappa ? [{ at: 1, style: "needed-line" }] : [],
    y: { label: "", unit: byKappa ? "model errors tolerated at other drive frequencies, κ of method mls (1 needed)" : "responses within their limits, %", range: padded([y, [0, 1]], 0.08) },
  };
}
