// Steps I and J: standing before and after, the change, and what the numbers mean.
import { api, type CaseSummary, type Outcome } from '../api';
import type { App, StepView } from '../app';
import { choice, fill, h, slider } from '../dom';
import { text } from '../text';
import { viewBar } from '../view/bar';
import { Body } from '../view/body';
import { viridisAt } from '../view/colours';
import { at, distances } from '../view/pose';
import { colourBar, niceTop } from '../view/scale';
import { rowsOf } from './rows';

const t = text.result;
type Mode = 'slide' | 'side' | 'change';

export async function resultStep(app: App): Promise<StepView> {
  const panel = h('div', { class: 'panel' }), s = app.summary!;
  app.body = await app.bodyOf(s);
  if (!s.outcome || !app.isReady('outcome')) {
    fill(panel, [h('h2', {}, text.steps.result[0]), h('p', { class: 'quiet' }, app.busy(s.id) ? text.healing.coming : t.none), h('a', { class: 'button', href: `#/case/${s.id}/plan` }, text.steps.plan[0])]);
    if (app.viewer && app.body) { app.viewer.setPanes([{ title: '', bodies: [app.body] }]); app.viewer.frame(); }
    return { panel };
  }
  const files = await api.files(s.id);
  const controls = h('div'), scale = h('div', { class: 'scale' });
  const report = files.find((f) => f.file === 'report.html');
  fill(panel, [h('h2', {}, text.steps.result[0]),
    s.outcome_fresh ? h('p', {}, t.lead) : h('p', { class: 'warning' }, t.stale),
    controls, scale, table(s.outcome), h('p', { class: 'quiet' }, t.noise), h('p', { class: 'quiet' }, t.range),
    h('div', { class: 'buttons' },
      report ? h('a', { class: 'button primary', id: 'report', href: `${api.fileAddress(s.id, report.stage, report.file)}?save=1`, download: '' }, t.report) : null,
      h('button', { onclick: () => print() }, t.print)),
    s.outcome.warnings.length ? h('details', {}, h('summary', {}, t.warnings), h('ul', {}, ...s.outcome.warnings.map((w) => h('li', {}, w)))) : null,
    h('details', {}, h('summary', {}, t.all), h('ul', { class: 'files' }, ...files.filter((f) => !f.file.endsWith('.bin')).map((f) =>
      h('li', {}, h('a', { href: `${api.fileAddress(s.id, f.stage, f.file)}?save=1`, download: '' }, `${f.stage}/${f.file}`), ` ${size(f.bytes)}`))))]);
  if (!app.viewer || !app.body) return { panel };
  const scene = new Result(app, app.body, new Body(app.body.bundle), controls, scale);
  return { panel, tools: scene.tools, close: () => scene.close() };
}

class Result {
  readonly tools: HTMLElement;
  private mode: Mode = 'slide';
  private standing = true;
  private arrows = false;
  private readonly slide: HTMLElement;

  constructor(private readonly app: App, private readonly before: Body, private readonly after: Body,
    controls: HTMLElement, private readonly scale: HTMLElement) {
    const viewer = app.viewer!;
    this.slide = slider(t.slide, { min: 0, max: 1, step: 0.005 }, 0.5, () => '', (v) => { viewer.wipe = v; viewer.draw(); }).element;
    this.tools = h('div', { class: 'tools' }, viewBar(viewer), this.slide);
    fill(controls, [
      choice(t.mode, Object.entries(t.modes) as [Mode, string][], this.mode, (m) => { this.mode = m; this.draw(); }).element,
      choice(t.pose, Object.entries(t.poses), 'standing', (p) => { this.standing = p === 'standing'; this.draw(); }).element,
    ]);
    viewer.wipe = 0.5;
    this.draw();
    viewer.frame();
  }
  private draw(): void {
    const viewer = this.app.viewer!, { before, after } = this;
    const [a, b] = this.standing ? ['before', 'after'] : ['supine', 'healed'];
    for (const body of [before, after]) {
      body.showPlan(null);
      body.showSurgery({ tumour: false, excision: false, seeThrough: false });
      body.paint(null, () => [0, 0, 0]);
      body.showArrows(null);
    }
    before.setPose(at(a));
    after.setPose(at(b));
    fill(this.scale, []);
    this.slide.hidden = this.mode !== 'slide';
    if (this.mode === 'change') {
      const moved = distances(after.bundle.f32(`points.${a}`), after.bundle.f32(`points.${b}`)), top = niceTop(Math.max(...moved));
      after.paint(moved, (v) => viridisAt(v / top));
      after.showArrows(this.arrows ? a : null, b, 5);
      fill(this.scale, [colourBar(`${t.moved} [mm]`, '0', String(top), viridisAt), h('label', { class: 'check' },
        h('input', { type: 'checkbox', checked: this.arrows, onchange: () => { this.arrows = !this.arrows; this.draw(); } }), t.arrows)]);
      viewer.setPanes([{ title: t.moved, bodies: [after] }]);
    } else {
      viewer.setPanes([{ title: t.before, bodies: [before] }, { title: t.after, bodies: [after] }], this.mode === 'slide' ? 'wipe' : 'grid');
    }
    viewer.draw();
  }
  close(): void { this.after.dispose(); }
}

export function table(outcome: Outcome): HTMLElement {
  return h('table', { class: 'measures' }, h('thead', {}, h('tr', {}, h('th', { scope: 'col' }, t.measure), h('th', { scope: 'col' }, t.value))),
    h('tbody', {}, ...rowsOf(outcome).map((r) => h('tr', { class: r.noise ? 'noise' : '' }, h('th', { scope: 'row', title: r.note ?? '' }, r.label), h('td', {}, r.value)))));
}
export const planName = (s: CaseSummary): string => s.plan_name || s.id;
const size = (bytes: number): string => (bytes < 1e6 ? `${Math.ceil(bytes / 1e3)} kB` : `${(bytes / 1e6).toFixed(1)} MB`);
