// Up to four plans of one patient: one camera, one scale, the numbers beside each other.
import { api, type CaseSummary } from '../api';
import type { App, StepView } from '../app';
import { choice, fill, h } from '../dom';
import { planName } from '../outcome/panel';
import { families, presetOf } from '../outcome/whatIf';
import { differences } from './difference';
import { rowsOf } from '../outcome/rows';
import { text } from '../text';
import { viewBar } from '../view/bar';
import type { Body } from '../view/body';
import { viridisAt } from '../view/colours';
import { at, distances } from '../view/pose';
import { colourBar, niceTop } from '../view/scale';

const t = text.compare;
type Show = 'after' | 'change' | 'difference';
const most = 4;

export async function compareStep(app: App): Promise<StepView> {
  const panel = h('div', { class: 'panel' }), scale = h('div', { class: 'scale' }), numbers = h('div', { class: 'compare-numbers', role: 'region', 'aria-label': t.measures, tabindex: '0' });
  const own = app.summary!;
  const all = (await api.cases()).filter((c) => !c.broken && c.patient === own.patient && c.outcome);
  let chosen = all.filter((c) => c.id === own.id).concat(all.filter((c) => c.id !== own.id)).slice(0, 2).map((c) => c.id);
  let show: Show = 'after';
  const groups = families(all);
  /** A plan that has been asked "what if" is called by that plan and its model of healing. */
  const nameOf = (c: CaseSummary): string => {
    const plan = groups.find((g) => g.others.includes(c))?.main;
    return plan ? `${planName(plan)}, ${(text.plan.presets[presetOf(c)] ?? presetOf(c)).toLowerCase()}` : planName(c);
  };
  const bodies = new Map<string, Body>();

  const draw = async (): Promise<void> => {
    const members = chosen.map((id) => all.find((c) => c.id === id)!).filter(Boolean);
    fill(numbers, [members.length ? table(members, nameOf) : null]);
    if (!app.viewer) return;
    for (const m of members) {
      const body = bodies.get(m.id) ?? (await app.bodyOf(m));
      if (body) bodies.set(m.id, body);
    }
    const shown = members.filter((m) => bodies.get(m.id)?.has('after'));
    fill(scale, []);
    paint(shown.map((m) => bodies.get(m.id)!), show, scale);
    const before = app.viewer.panes.length;
    app.viewer.setPanes(shown.map((m) => ({ title: nameOf(m), bodies: [bodies.get(m.id)!] })));
    if (before !== shown.length) app.viewer.frame();
  };
  const boxes = h('fieldset', { class: 'checks' }, h('legend', {}, t.choose), ...all.map((c) => {
    const input = h('input', {
      type: 'checkbox', checked: chosen.includes(c.id), onchange: () => {
        if (input.checked && chosen.length >= most) { input.checked = false; app.notify(t.full); return; }
        chosen = input.checked ? [...chosen, c.id] : chosen.filter((id) => id !== c.id);
        void draw();
      },
    });
    return h('label', { class: 'check' }, input, nameOf(c));
  }));
  fill(panel, [h('h2', {}, text.steps.compare[0]), h('p', {}, t.lead), all.length < 2 ? h('p', { class: 'quiet' }, t.none) : null, boxes,
    choice(t.show, Object.entries(t.shows) as [Show, string][], show, (v) => { show = v; void draw(); }).element, scale, numbers]);
  await draw();
  app.viewer?.frame();
  return { panel, tools: app.viewer ? h('div', { class: 'tools' }, viewBar(app.viewer)) : undefined };
}

function paint(bodies: Body[], show: Show, scale: HTMLElement): void {
  for (const body of bodies) {
    body.showPlan(null);
    body.showSurgery({ tumour: false, excision: false, seeThrough: false });
    body.setPose(at('after'));
    body.showArrows(null);
    body.paint(null, () => [0, 0, 0]);
  }
  if (show === 'after' || bodies.length === 0) return;
  const moved = bodies.map((b) => distances(b.bundle.f32('points.before'), b.bundle.f32('points.after')));
  if (show === 'change') {
    const top = niceTop(Math.max(...moved.map((m) => m.reduce((a, b) => Math.max(a, b), 0))));
    bodies.forEach((b, i) => b.paint(moved[i], (v) => viridisAt(v / top)));
    fill(scale, [colourBar(`${text.result.moved} [mm]`, '0', String(top), viridisAt)]);
    return;
  }
  const apart = bodies.map((b) => differences(bodies[0], b));
  const top = niceTop(Math.max(0.1, ...apart.map((d) => d.reduce((a, b) => Math.max(a, b), 0))));
  bodies.forEach((b, i) => b.paint(apart[i], (v) => viridisAt(v / top)));
  fill(scale, [colourBar(`${t.apart} [mm]`, '0', String(top), viridisAt), h('p', { class: 'quiet' }, t.apartNote)]);
}

function table(members: CaseSummary[], nameOf: (c: CaseSummary) => string): HTMLElement {
  const rows = members.map((m) => rowsOf(m.outcome!));
  return h('table', { class: 'measures' },
    h('thead', {}, h('tr', {}, h('th', { scope: 'col' }, t.measure), ...members.map((m) => h('th', { scope: 'col' }, nameOf(m))))),
    h('tbody', {}, ...rows[0].filter((r) => r.first).map((r) => h('tr', {}, h('th', { scope: 'row', title: r.note ?? '' }, r.label), ...rows.map((of) => {
      const cell = of.find((x) => x.label === r.label);
      return h('td', { class: cell?.noise ? 'noise' : '' }, cell?.value ?? '–', cell?.range ? h('small', {}, cell.range) : null);
    })))));
}
