// A colour bar with name, unit and range.
import { h } from '../dom';

export function colourBar(title: string, low: string, high: string, at: (t: number) => [number, number, number]): HTMLElement {
  const canvas = h('canvas', { width: 160, height: 1, 'aria-hidden': 'true' });
  const context = canvas.getContext('2d')!;
  for (let x = 0; x < 160; ++x) {
    const [r, g, b] = at(x / 159);
    context.fillStyle = `rgb(${r * 255} ${g * 255} ${b * 255})`;
    context.fillRect(x, 0, 1, 1);
  }
  return h('div', { class: 'colour-bar' }, h('span', {}, title), h('div', {}, h('small', {}, low), canvas, h('small', {}, high)));
}
/** A round number at or above x, for the end of a scale. */
export function niceTop(x: number): number {
  if (!(x > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(x));
  return [1, 1.5, 2, 3, 4, 5, 6, 8, 10].map((f) => Number((f * power).toPrecision(2))).find((v) => v >= x - 1e-12) ?? 10 * power;
}
