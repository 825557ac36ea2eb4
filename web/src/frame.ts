// The frame around the steps: banner, path at the left, messages.
import type { App, StepName } from './app';
import { fill, h } from './dom';
import { progressCard } from './run/progress';
import { text } from './text';
import { cover } from './view/cover';

const brand = (): HTMLElement => h('a', { class: 'brand', href: '#/' }, h('span', { class: 'mark', 'aria-hidden': 'true' }), text.product);

export function frame(app: App, content: HTMLElement, title: string): void {
  fill(app.root, [
    h('a', { class: 'skip', href: '#main' }, text.skip),
    h('header', { class: 'banner' }, brand(), h('h1', {}, title), h('p', { class: 'notice' }, text.notice), h('button', { class: 'plain', id: 'cover', onclick: cover }, text.cover.now)),
    h('div', { class: 'lost', role: 'alert', hidden: !app.lost }, text.lost),
    content,
    h('div', { class: 'toasts' }),
  ]);
}

export const stepStages: Record<StepName, string[]> = {
  patient: ['image', 'segment'], anatomy: ['mesh', 'unload', 'supine'], plan: ['surgery'], healing: ['heal'],
  result: ['upright', 'outcome'], compare: [],
};

/** The path A-J: where one is, and what is computed. */
export function path(app: App, current: StepName): { element: HTMLElement; update(): void } {
  const id = app.summary!.id;
  const items = (Object.keys(stepStages) as StepName[]).map((name) => {
    const [title, lead, letters] = text.steps[name];
    const marks = h('span', { class: 'marks' });
    const element = h('li', {}, h('a', {
      href: `#/case/${id}/${name}`, class: name === current ? 'current' : '', 'aria-current': name === current ? 'step' : undefined,
    }, h('span', { class: 'letters', 'aria-hidden': 'true' }, letters), h('span', { class: 'words' }, h('strong', {}, title), h('small', {}, lead)), marks));
    return { name, element, marks };
  });
  const job = h('div', { class: 'job', 'aria-live': 'polite' });
  const update = (): void => {
    for (const { name, marks } of items) {
      fill(marks, stepStages[name].map((stage) => {
        const state = app.stageState(stage);
        return h('i', { class: `dot ${state}`, title: `${stage}: ${text.stageWord[state]}` });
      }));
    }
    fill(job, [progressCard(app)]);
  };
  update();
  // On a phone the steps are a row that scrolls.
  requestAnimationFrame(() => {
    const row = items[0].element.parentElement, here = items.find((i) => i.name === current)!.element;
    if (row) row.scrollLeft = here.offsetLeft - row.offsetLeft - 40;
  });
  return {
    element: h('nav', { class: 'path', 'aria-label': text.path },
      h('div', { class: 'path-case' }, h('a', { href: '#/' }, `← ${text.cases.title}`), h('strong', {}, id),
        h('small', {}, app.summary!.plan_name || (app.summary!.side ? text.side[app.summary!.side] : text.cases.noPlan))),
      h('ol', {}, ...items.map((i) => i.element)), job),
    update,
  };
}
