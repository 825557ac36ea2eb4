// Steps I and J: standing before and after, the change, and what the numbers mean.
import { api, type CaseSummary } from '../api';
import type { App, StepView } from '../app';
import { choice, fill, h, slider } from '../dom';
import { text } from '../text';
import { viewBar } from '../view/bar';
import { Body } from '../view/body';
import { viridisAt } from '../view/colours';
import { at, distances } from '../view/pose';
import { colourBar, niceTop } from '../view/scale';
import { rowsOf, type Row } from './rows';
import { whatIf } from './whatIf';
import { photographs } from '../view/photograph';

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
  const files = await api.files(s.id), others = await whatIf(app);
  const controls = h('div'), scale = h('div', { class: 'scale' });
  const report = files.find((f) => f.file === 'report.html');
  fill(panel, [h('h2', {}, text.steps.result[0]),
    s.outcome_fresh ? h('p', {}, t.lead) : h('p', { class: 'warning' }, t.stale),
    controls, scale, table(rowsOf(s.outcome).filter((r) => r.first)),
    h('details', {}, h('summary', {}, t.moreIndices), table(rowsOf(s.outcome).filter((r) => !r.first))), others.element, h('p', { class: 'quiet' }, t.noise), h('p', { class: 'quiet' }, t.range(Boolean(s.outcome.wall_range ?? s.outcome.scan_only))),
    h('div', { class: 'buttons' },
      s.outcome_fresh && report ? h('a', { class: 'button primary', id: 'report', href: `${api.fileAddress(s.id, report.stage, report.file)}?save=1`, download: '' }, t.report) : app.session.abilities.report && s.outcome_fresh
        ? h('button', { id: 'make-report', disabled: app.busy(s.id), onclick: () => app.attempt(() => api.run(s.id, {})) }, t.makeReport) : null,
      h('button', { onclick: () => print() }, t.print)),
    s.outcome.warnings.length ? h('details', {}, h('summary', {}, t.warnings), h('ul', {}, ...s.outcome.warnings.map((w) => h('li', {}, w)))) : null,
    h('details', {}, h('summary', {}, t.all), h('ul', { class: 'files' }, ...files.filter((f) => !f.file.endsWith('.bin')).map((f) =>
      h('li', {}, h('a', { href: `${api.fileAddress(s.id, f.stage, f.file)}?save=1`, download: '' }, `${f.stage}/${f.file}`), ` ${size(f.bytes)}`))))]);
  const update = (): void => others.update();
  if (!app.viewer || !app.body) return { panel, update };
  const scene = new Result(app, app.body, new Body(app.body.bundle), controls, scale);
  return { panel, update, tools: scene.tools, close: () => scene.close() };
}

class Result {
  readonly tools: HTMLElement;
  private mode: Mode = 'slide';
  private standing = true;
  private arrows = false;
  private photo: Awaited<ReturnType<typeof photographs>> | null = null;
  private readonly photoButton = h('button', { id: 'photograph', 'aria-pressed': 'false', onclick: () => void this.togglePhoto() }, t.photograph);
  private readonly slide: HTMLElement;

  constructor(private readonly app: App, private readonly before: Body, private readonly after: Body,
    controls: HTMLElement, private readonly scale: HTMLElement) {
    const viewer = app.viewer!;
    const wipe = slider(t.slide, { min: 0, max: 1, step: 0.005 }, 0.5, () => '', (v) => { viewer.wipe = v; viewer.draw(); });
    viewer.onWipe = (v) => wipe.set(v);
    this.slide = wipe.element;
    this.tools = h('div', { class: 'tools' }, viewBar(viewer), this.slide);
    fill(controls, [
      choice(t.mode, Object.entries(t.modes) as [Mode, string][], this.mode, (m) => { this.mode = m; this.draw(); }).element,
      choice(t.pose, Object.entries(t.poses), 'standing', (p) => { this.standing = p === 'standing'; this.draw(); }).element,
      app.summary!.photograph ? this.photoButton : null,
    ]);
    viewer.wipe = 0.5;
    this.draw();
    viewer.frame();
  }
  /** Clay first: somebody has to ask for the photograph, every time. */
  private async togglePhoto(): Promise<void> {
    if (this.photo) { this.photo.dispose(); this.photo = null; } else {
      this.photoButton.disabled = true;
      const bundle = await this.app.attempt(() => api.photograph(this.app.summary!.id));
      this.photoButton.disabled = false;
      if (bundle) this.photo = await photographs(bundle);
    }
    this.photoButton.setAttribute('aria-pressed', String(this.photo !== null));
    this.draw();
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
    before.group.visible = after.group.visible = true;
    this.photoButton.hidden = !this.standing || this.mode === 'change';
    this.slide.hidden = this.mode !== 'slide';
    if (this.mode === 'change') {
      const moved = distances(after.bundle.f32(`points.${a}`), after.bundle.f32(`points.${b}`)), top = niceTop(Math.max(...moved));
      after.paint(moved, (v) => viridisAt(v / top));
      // The longest arrow about as long as a fingertip, whatever the change.
      const times = [1, 2, 5, 10, 20, 50].find((f) => f * top >= 15) ?? 50;
      after.showArrows(this.arrows ? a : null, b, times);
      fill(this.scale, [colourBar(`${t.moved} [mm]`, '0', String(top), viridisAt), h('label', { class: 'check' },
        h('input', { type: 'checkbox', checked: this.arrows, onchange: () => { this.arrows = !this.arrows; this.draw(); } }), t.arrows(times))]);
      viewer.setPanes([{ title: t.moved, bodies: [after] }]);
    } else {
      const own = this.standing ? this.photo : null;
      before.group.visible = after.group.visible = own === null;
      viewer.setPanes([{ title: t.before, bodies: [before], extra: own ? [own.before] : [] }, { title: t.after, bodies: [after], extra: own ? [own.after] : [] }], this.mode === 'slide' ? 'wipe' : 'grid');
    }
    viewer.draw();
  }
  close(): void {
    this.app.viewer!.onWipe = null;
    this.before.group.visible = true;
    this.photo?.dispose();
    this.after.dispose();
  }
}

/** One column of numbers per plan; with one plan, what was before stands beside it. */
export function table(rows: Row[]): HTMLElement {
  const cell = (r: Row): HTMLElement => h('td', {}, r.value, r.range ? h('small', {}, r.range) : null);
  return h('table', { class: 'measures' }, h('thead', {}, h('tr', {}, h('th', { scope: 'col' }, t.measure), h('th', { scope: 'col' }, t.was), h('th', { scope: 'col' }, t.value))),
    h('tbody', {}, ...rows.map((r) => h('tr', { class: r.noise ? 'noise' : '' }, h('th', { scope: 'row', title: r.note ?? '' }, r.label), h('td', {}, r.before ?? ''), cell(r)))));
}
export const planName = (s: CaseSummary): string => s.plan_name || s.id;
const size = (bytes: number): string => (bytes < 1e6 ? `${Math.ceil(bytes / 1e3)} kB` : `${(bytes / 1e6).toFixed(1)} MB`);
