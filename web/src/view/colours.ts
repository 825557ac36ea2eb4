// Colour maps: viridis for magnitudes (uniform, safe for colour-blind eyes), fixed colours of tissue.
const viridis: [number, number, number][] = [
  [68, 1, 84], [72, 40, 120], [62, 74, 137], [49, 104, 142], [38, 130, 142],
  [31, 158, 137], [53, 183, 121], [109, 205, 89], [180, 222, 44], [253, 231, 37],
];
/** 0..1 to red, green, blue in 0..1; outside is held at the ends. */
export function viridisAt(t: number): [number, number, number] {
  if (!Number.isFinite(t)) return [0.6, 0.6, 0.6];
  const x = Math.max(0, Math.min(1, t)) * (viridis.length - 1);
  const i = Math.min(viridis.length - 2, Math.floor(x)), s = x - i;
  return [0, 1, 2].map((c) => (viridis[i][c] * (1 - s) + viridis[i + 1][c] * s) / 255) as [number, number, number];
}

/** Cool - white - warm for signed differences, white at 0. */
export function divergingAt(t: number): [number, number, number] {
  const s = Math.max(-1, Math.min(1, t)), a = Math.abs(s);
  const end = s < 0 ? [33, 102, 172] : [178, 24, 43];
  return end.map((c) => (247 * (1 - a) + c * a) / 255) as [number, number, number];
}

export const clay = 0xe6d9cf;
export const clayInside = 0xb3a49d;
export const tumour = 0x7a1f5c;
export const excision = 0x1f7f8c;
export const incision = 0x9b1c31;

/** Label table of docs/user/labels.md: colours of the overlay, index is the label. */
export const labelColours: [number, number, number][] = [
  [0, 0, 0], [236, 204, 132], [214, 120, 108], [205, 150, 120], [150, 60, 60], [225, 225, 215],
  [120, 150, 190], [150, 90, 60], [170, 40, 160], [150, 80, 60], [60, 90, 200],
];
