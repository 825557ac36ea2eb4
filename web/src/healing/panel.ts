// Step H: ninety days on a cut through the operated breast, and the volume of the operated region.
import { BufferAttribute, BufferGeometry, Color, DoubleSide, Mesh, MeshBasicMaterial } from 'three';
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { api, type HealingHead } from '../api';
import type { App, StepView } from '../app';
import type { Bundle } from '../bundle';
import { choice, fill, h, slider } from '../dom';
import { text } from '../text';
import { viewBar } from '../view/bar';
import { viridisAt } from '../view/colours';
import { at } from '../view/pose';
import { colourBar } from '../view/scale';
import { cutTetrahedra } from './cut';

const t = text.healing;

export async function healingStep(app: App): Promise<StepView> {
  const panel = h('div', { class: 'panel' });
  const id = app.summary!.id;
  // The server reads a whole result; its last part is the standing pose.
  if (!app.isReady('heal') || !app.isReady('upright')) {
    fill(panel, [h('h2', {}, text.steps.healing[0]), h('p', { class: 'quiet' }, app.busy(id) ? t.coming : t.none)]);
    app.body = await app.bodyOf(app.summary!);
    if (app.viewer && app.body) { app.viewer.setPanes([{ title: '', bodies: [app.body] }]); app.viewer.frame(); }
    return { panel };
  }
  const data = await api.healing(id);
  app.body = await app.bodyOf(app.summary!);
  return new HealingView(app, panel, data).view();
}

class HealingView {
  private frame = 0;
  private species = 0;
  private axis: 0 | 1 | 2 = 2;
  private offset = 0;
  private readonly mesh = new Mesh(new BufferGeometry(), new MeshBasicMaterial({ vertexColors: true, side: DoubleSide }));
  private readonly bar = h('div');
  private readonly dayWord = h('p', { class: 'where' });

  constructor(private readonly app: App, private readonly panel: HTMLElement, private readonly data: Bundle<HealingHead>) {
    this.species = Math.max(0, data.head.species.findIndex((s) => s.key === 'eta'));
    this.frame = 0;
  }

  view(): StepView {
    const { app, data } = this, { days, species, history } = data.head;
    const chart = h('div', { class: 'chart' });
    const day = slider(t.day, { min: 0, max: days.length - 1, step: 1 }, this.frame, (i) => `${days[i].toFixed(0)}`, (i) => { this.frame = i; this.draw(); });
    fill(this.panel, [h('h2', {}, text.steps.healing[0]), h('p', {}, t.lead), this.dayWord, day.element,
      choice(t.field, species.map((s, i) => [String(i), s.label] as [string, string]), String(this.species), (v) => { this.species = Number(v); this.draw(); }).element,
      choice(t.plane, [['2', t.planes.z], ['1', t.planes.y], ['0', t.planes.x]] as [string, string][], '2', (v) => { this.axis = Number(v) as 0 | 1 | 2; this.look(); this.draw(); }).element,
      slider(t.move, { min: -60, max: 60, step: 1 }, 0, (v) => `${v} mm`, (v) => { this.offset = v; this.draw(); }).element,
      this.bar, h('h3', {}, t.volume), chart]);
    let tools: HTMLElement | undefined;
    if (app.viewer && app.body) {
      app.body.setPose(at('supine'));
      app.body.showPlan(null);
      app.body.paint(null, () => [0, 0, 0]);
      app.body.showArrows(null);
      app.body.showSurgery({ tumour: false, excision: false, seeThrough: true, opacity: 0.22 });
      app.viewer.setPanes([{ title: '', bodies: [app.body], extra: [this.mesh] }]);
      app.viewer.frame();
      this.look();
      tools = h('div', { class: 'tools' }, viewBar(app.viewer));
    }
    this.draw();
    requestAnimationFrame(() => plot(chart, history));
    return { panel: this.panel, tools, close: () => this.mesh.geometry.dispose() };
  }

  /** Square to the cut, from the side that radiologists use, close to the operated region. */
  private look(): void {
    const { viewer, body } = this.app;
    if (!viewer || !body) return;
    const centre = body.head.tumour?.centre.supine;
    if (centre) viewer.orbit.target.set(...centre);
    viewer.orbit.distance = 0.55 * viewer.orbit.home.distance;
    viewer.orbit.view((['left', 'front', 'below'] as const)[this.axis]);
  }
  private draw(): void {
    const { data, app } = this, { species, days, history } = data.head;
    const points = data.f32(`points.${this.frame}`), values = data.f32(`species.${this.frame}`), n = species.length;
    const centre = app.body?.head.tumour?.centre.supine ?? [0, 0, 0];
    const cut = cutTetrahedra(points, data.u32('cells'), (v) => values[v * n + this.species], this.axis, centre[this.axis] + this.offset);
    let top = 1;
    for (let f = 0; f < days.length; ++f) {
      const all = data.f32(`species.${f}`);
      for (let i = this.species; i < all.length; i += n) top = Math.max(top, all[i]);
    }
    const rgb = new Float32Array(cut.positions.length), colour = new Color();
    cut.values.forEach((v, i) => { colour.setRGB(...viridisAt(v / top), 'srgb').toArray(rgb, 3 * i); });
    this.mesh.geometry.dispose();
    this.mesh.geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(cut.positions, 3)).setAttribute('color', new BufferAttribute(rgb, 3));
    fill(this.bar, [colourBar(`${species[this.species].label} (${t.relative})`, '0', top.toFixed(1), viridisAt)]);
    const row = history.day.findIndex((d) => d >= days[this.frame] - 1e-6);
    const ratio = history.wound_volume_ratio[row < 0 ? history.day.length - 1 : row];
    this.dayWord.textContent = t.ofStart(days[this.frame].toFixed(0), (100 * ratio).toFixed(0));
    app.viewer?.draw();
  }
}

function plot(element: HTMLElement, history: HealingHead['history']): void {
  new uPlot({
    width: Math.max(220, element.clientWidth), height: 170, legend: { show: false }, cursor: { drag: { x: false, y: false } },
    scales: { x: { time: false } },
    axes: [{ label: t.axis, labelSize: 18, size: 34 }, { size: 66, values: (_: uPlot, ticks: number[]) => ticks.map((v) => `${v.toFixed(ticks.every((x) => Number.isInteger(x)) ? 0 : 1)} %`) }],
    series: [{}, { stroke: '#0f5c63', width: 2 }],
  }, [history.day, history.wound_volume_ratio.map((v) => 100 * v)], element);
}
