// Steps A and B: the images in three planes with the tissue in colour, and one crosshair for all.
import { api, isScanOnly, type Point, type VolumeHead } from '../api';
import type { App, StepView } from '../app';
import type { Bundle } from '../bundle';
import { fill, h, notes } from '../dom';
import { text } from '../text';
import { labelColours } from '../view/colours';
import { Solid } from './solid';

const t = text.patient;
/** Image axes of each plane: right and down in voxel directions (+i left, +j posterior, +k superior). */
const planes = [
  { name: t.planes[0], across: 0, down: 1, through: 2, flipDown: false, letters: ['A', 'P', 'R', 'L'] },
  { name: t.planes[1], across: 0, down: 2, through: 1, flipDown: true, letters: ['S', 'I', 'R', 'L'] },
  { name: t.planes[2], across: 1, down: 2, through: 0, flipDown: true, letters: ['S', 'I', 'A', 'P'] },
] as const;

export async function patientStep(app: App): Promise<StepView> {
  const panel = h('div', { class: 'panel' });
  if (!app.isReady('segment')) {
    fill(panel, [h('h2', {}, text.steps.patient[0]), h('p', { class: 'quiet' }, text.working)]);
    return { panel, stage: h('div', { class: 'slices' }) };
  }
  const [volume, body] = await Promise.all([api.volume(app.summary!.id), app.bodyOf(app.summary!)]);
  app.body = body;
  return new Slices(app, panel, volume).view();
}

class Slices {
  private at: Point;
  private overlay = true;
  private readonly labels: Uint8Array;
  private readonly grey: Uint8Array | null;
  private readonly canvases = planes.map((p) => h('canvas', { tabIndex: 0, role: 'img', 'aria-label': p.name }));
  private readonly where = h('p', { class: 'where', 'aria-live': 'polite' });
  private readonly tumour: Point | null;
  private readonly solid: Solid | null = null;

  constructor(private readonly app: App, private readonly panel: HTMLElement, private readonly data: Bundle<VolumeHead>) {
    this.labels = data.u8('labels');
    this.grey = data.has('grey') ? data.u8('grey') : null;
    this.tumour = this.centreOf(8);
    const middle = data.head.size.map((n) => Math.floor(n / 2)) as Point;
    const kept = app.crosshair?.id === app.summary!.id ? this.voxelAt(app.crosshair.at) : null;
    this.at = kept ?? this.tumour ?? middle;
    if (app.viewer && app.body) this.solid = new Solid(app, (mm) => { this.at = this.voxelAt(mm); this.draw(); });
  }

  view(): StepView {
    const { head } = this.data, scanned = isScanOnly(this.app.summary!);
    fill(this.panel, [h('h2', {}, text.steps.patient[0]), h('p', {}, t.lead(scanned)), this.where,
      this.tumour ? h('button', { onclick: () => { this.at = [...this.tumour!] as Point; this.draw(); } }, t.showTumour) : null,
      h('label', { class: 'check' }, h('input', { type: 'checkbox', checked: true, id: 'overlay', onchange: () => { this.overlay = !this.overlay; this.draw(); } }), t.overlay),
      this.grey ? null : h('p', { class: 'quiet' }, scanned ? t.estimated : t.noGrey),
      h('ul', { class: 'legend' }, ...[1, 2, 3, 4, 5, 8, 9].filter((label) => this.labels.includes(label)).map((label) => h('li', {}, swatch(labelColours[label]), t.tissues[label]))),
      notes(this.app.summary!.stages.slice(0, 2).flatMap((s) => s.warnings))]);
    const stage = h('div', { class: 'slices' }, ...planes.map((p, i) => {
      const canvas = this.canvases[i];
      canvas.width = head.size[p.across];
      canvas.height = head.size[p.down];
      canvas.style.aspectRatio = `${head.size[p.across] * head.spacing_mm[p.across]} / ${head.size[p.down] * head.spacing_mm[p.down]}`;
      canvas.addEventListener('pointerdown', (e) => this.point(i, e));
      canvas.addEventListener('pointermove', (e) => { if (e.buttons & 1) this.point(i, e); });
      canvas.addEventListener('wheel', (e) => { e.preventDefault(); this.step(p.through, e.deltaY > 0 ? 1 : -1); }, { passive: false });
      canvas.addEventListener('keydown', (e) => {
        const forward = ['ArrowUp', 'ArrowRight', 'f'].includes(e.key), back = ['ArrowDown', 'ArrowLeft', 'b'].includes(e.key);
        if (forward || back) { e.preventDefault(); this.step(p.through, forward ? 1 : -1); }
      });
      return h('figure', {}, h('div', { class: 'slice' }, canvas, ...p.letters.map((letter, k) => h('span', { class: `letter ${['top', 'bottom', 'left', 'right'][k]}`, 'aria-hidden': 'true' }, letter))), h('figcaption', {}, p.name));
    }), this.solid ? h('figure', { class: 'solid' }, this.app.viewer!.element, h('figcaption', {}, t.solid)) : null);
    this.draw();
    return {
      panel: this.panel, stage, close: () => this.solid?.close(),
      key: (e) => {
        if (e.key !== 'g' || e.ctrlKey || (e.target as HTMLElement).tagName === 'INPUT') return false;
        document.querySelector<HTMLInputElement>('#overlay')?.click();
        return true;
      },
    };
  }

  private step(axis: number, by: number): void {
    this.at[axis] = Math.max(0, Math.min(this.data.head.size[axis] - 1, this.at[axis] + by));
    this.draw();
  }
  private point(plane: number, e: PointerEvent): void {
    const p = planes[plane], box = this.canvases[plane].getBoundingClientRect(), { size } = this.data.head;
    const x = Math.floor(((e.clientX - box.left) / box.width) * size[p.across]);
    const y = Math.floor(((e.clientY - box.top) / box.height) * size[p.down]);
    this.at[p.across] = Math.max(0, Math.min(size[p.across] - 1, x));
    this.at[p.down] = Math.max(0, Math.min(size[p.down] - 1, p.flipDown ? size[p.down] - 1 - y : y));
    this.draw();
  }
  private voxelAt(mm: Point): Point {
    const { origin_mm, spacing_mm, size } = this.data.head;
    return mm.map((x, c) => Math.max(0, Math.min(size[c] - 1, Math.round((x - origin_mm[c]) / spacing_mm[c])))) as Point;
  }
  private index(i: number, j: number, k: number): number {
    const { size } = this.data.head;
    return (k * size[1] + j) * size[0] + i;
  }
  private draw(): void {
    planes.forEach((_, i) => this.drawPlane(i));
    const { origin_mm, spacing_mm } = this.data.head;
    const mm = this.at.map((v, c) => origin_mm[c] + v * spacing_mm[c]);
    this.app.crosshair = { id: this.app.summary!.id, at: mm as Point };
    this.solid?.show(mm as Point);
    this.where.textContent = `${t.position(mm)} · ${t.tissues[this.labels[this.index(...this.at)]] ?? ''}`;
  }
  private drawPlane(number: number): void {
    const p = planes[number], { size } = this.data.head, w = size[p.across], ht = size[p.down];
    const context = this.canvases[number].getContext('2d')!, image = context.createImageData(w, ht);
    const voxel: Point = [0, 0, 0];
    voxel[p.through] = this.at[p.through];
    for (let y = 0; y < ht; ++y) {
      voxel[p.down] = p.flipDown ? ht - 1 - y : y;
      for (let x = 0; x < w; ++x) {
        voxel[p.across] = x;
        const at = this.index(...voxel), label = this.labels[at], out = 4 * (y * w + x);
        const colour = labelColours[label] ?? [255, 255, 255], alpha = label === 0 ? 0 : this.grey ? (this.overlay ? 0.35 : 0) : 1;
        const base = this.grey ? this.grey[at] : 8, shade = this.overlay || this.grey ? 1 : 0.65;
        for (let c = 0; c < 3; ++c) image.data[out + c] = shade * (base * (1 - alpha) + colour[c] * alpha);
        image.data[out + 3] = 255;
      }
    }
    context.putImageData(image, 0, 0);
    const x = this.at[p.across] + 0.5, y = (p.flipDown ? ht - 1 - this.at[p.down] : this.at[p.down]) + 0.5;
    context.strokeStyle = '#27d3c3';
    context.lineWidth = 0.6;
    context.beginPath();
    context.moveTo(x, 0); context.lineTo(x, y - 5); context.moveTo(x, y + 5); context.lineTo(x, ht);
    context.moveTo(0, y); context.lineTo(x - 5, y); context.moveTo(x + 5, y); context.lineTo(w, y);
    context.stroke();
  }
  private centreOf(label: number): Point | null {
    const { size } = this.data.head, sum = [0, 0, 0];
    let count = 0;
    for (let k = 0; k < size[2]; ++k) for (let j = 0; j < size[1]; ++j) for (let i = 0; i < size[0]; ++i) {
      if (this.labels[this.index(i, j, k)] === label) { sum[0] += i; sum[1] += j; sum[2] += k; ++count; }
    }
    return count ? (sum.map((s) => Math.round(s / count)) as Point) : null;
  }
}

function swatch([r, g, b]: [number, number, number]): HTMLElement {
  const element = h('i', { class: 'swatch', 'aria-hidden': 'true' });
  element.style.background = `rgb(${r} ${g} ${b})`;
  return element;
}
