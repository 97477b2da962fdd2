// Colour maps that are readable with colour blindness and in grey, with the anchors of the chart files.

const ANCHORS = {
  // lightness rises evenly
  sequential: [[42, 18, 84], [52, 80, 140], [36, 126, 140], [80, 172, 112], [176, 212, 74], [253, 236, 116]],
  diverging: [[8, 48, 107], [66, 130, 190], [176, 208, 230], [250, 250, 248], [248, 205, 155], [214, 120, 40], [115, 48, 6]],
  cyclic: [[236, 226, 214], [120, 165, 205], [62, 84, 160], [44, 24, 62], [130, 40, 62], [205, 120, 88], [236, 226, 214]],
  // lightness rises evenly, from blue by grey to orange: fields on dark ground
  rising: [[10, 18, 48], [28, 62, 122], [58, 100, 152], [122, 128, 138], [196, 142, 86], [242, 164, 74], [255, 204, 120]],
  white: [[255, 255, 255], [150, 190, 222], [40, 110, 175], [5, 40, 90]],
};

/** Red, green, blue of `t` in 0..1, clamped; grey where it is no number. */
export function colourAt(map, t) {
  const anchors = ANCHORS[map];
  if (Number.isNaN(t)) return [128, 128, 128];
  const place = Math.min(1, Math.max(0, t)) * (anchors.length - 1);
  const below = Math.min(anchors.length - 2, Math.floor(place));
  return anchors[below].map((from, k) => Math.round(from + (place - below) * (anchors[below + 1][k] - from)));
}

/** The same colour as CSS. */
export function cssColour(map, t) {
  return `rgb(${colourAt(map, t).join(",")})`;
}

/** True where white letters are more readable than black ones. */
export function isDark([r, g, b]) {
  return 0.299 * r + 0.587 * g + 0.114 * b < 135;
}

/** The value of a colour of the page's theme, for canvases. */
export function themeColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** The map of field levels in the page's theme. */
export function levelMap() {
  return matchMedia("(prefers-color-scheme: dark)").matches ? "rising" : "diverging";
}
