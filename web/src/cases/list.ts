// All cases, grouped by patient. No pictures of anybody in lists.
import { api, type CaseSummary } from '../api';
import type { App } from '../app';
import { fill, h } from '../dom';
import { frame } from '../frame';
import { families, presetOf } from '../outcome/whatIf';
import { estimate, inWords } from '../run/eta';
import { text } from '../text';
import { newCaseDialog } from './newCase';

const t = text.cases;

export async function showCases(app: App): Promise<{ update(): void; changed(): void }> {
  const list = h('div', { class: 'patients', id: 'main' });
  const make = h('button', { class: 'primary', onclick: () => newCaseDialog(app) }, t.make);
  frame(app, h('main', { class: 'page' }, h('div', { class: 'page-head' }, h('div', {}, h('h2', {}, t.title), h('p', { class: 'quiet' }, t.lead)), make), list), '');
  let cases: CaseSummary[] = [], jobsSeen = '';
  const draw = (): void => {
    const known = new Set(cases.map((c) => c.id));
    const coming = app.jobs.filter((j) => j.kind === 'create' && !known.has(j.case) && j.state !== 'done')
      .filter((j, i, all) => all.findIndex((k) => k.case === j.case) === i);
    const groups = new Map<string, CaseSummary[]>();
    for (const c of cases) groups.set(c.patient ?? c.id, [...(groups.get(c.patient ?? c.id) ?? []), c]);
    fill(list, [
      cases.length + coming.length === 0 ? h('p', { class: 'empty' }, t.none) : null,
      ...coming.map((j) => comingCard(app, j.case)),
      ...[...groups].map(([patient, members]) => h('section', { class: 'patient' },
        h('div', { class: 'patient-head' }, h('h3', {}, patient),
          members.filter((m) => m.outcome).length > 1
            ? h('a', { class: 'button', href: `#/case/${members[0].id}/compare` }, t.compare) : null),
        h('ul', {}, ...families(members).flatMap(({ main, others }) => [row(app, main, reload), ...others.map((c) => row(app, c, reload, true))])))),
    ]);
  };
  const reload = async (): Promise<void> => {
    cases = (await app.attempt(() => api.cases())) ?? cases;
    draw();
  };
  await reload();
  return {
    changed: () => void reload(),
    update(): void {
      const states = app.jobs.map((j) => `${j.id}${j.state}${j.step}`).join();
      if (states !== jobsSeen) { jobsSeen = states; void reload(); } else draw();
    },
  };
}

function comingCard(app: App, id: string): HTMLElement {
  const job = app.jobOf(id)!;
  const { fraction, secondsLeft } = estimate(job, [], Date.now() / 1000);
  const failed = job.state === 'failed' || job.state === 'cancelled';
  return h('section', { class: 'patient coming' }, h('h3', {}, id),
    failed ? h('p', { class: 'message' }, job.message)
      : h('p', { class: 'quiet' }, `${text.run.title} ${Math.round(100 * fraction)} % · ${text.run.left(inWords(secondsLeft))}`),
    failed ? h('button', { onclick: () => app.attempt(() => api.resume(job.id)) }, text.run.goOn) : null);
}

function row(app: App, c: CaseSummary, reload: () => Promise<void>, isWhatIf = false): HTMLElement {
  if (c.broken) return h('li', {}, h('strong', {}, c.id), h('span', { class: 'quiet' }, t.broken));
  const state = app.busy(c.id) ? 'working' : c.outcome ? (c.outcome_fresh ? 'fresh' : 'stale') : 'none';
  return h('li', { class: isWhatIf ? 'what-if-row' : '' },
    h('a', { class: 'case-link', href: `#/case/${c.id}/${c.outcome_fresh ? 'result' : 'plan'}` },
      h('strong', {}, isWhatIf ? t.whatIf(text.plan.presets[presetOf(c)] ?? presetOf(c)) : c.plan_name || c.id),
      c.plan_name && !isWhatIf ? h('small', { class: 'quiet' }, c.id) : null),
    h('span', {}, isWhatIf ? '' : c.side ? text.side[c.side] : t.noPlan),
    h('span', { class: 'quiet' }, c.outcome && c.outcome_fresh ? t.outcome(c.outcome.excised_cm3, c.outcome.excised_percent) : ''),
    h('span', { class: `state ${state}` }, t.states[state]),
    h('button', {
      class: 'plain', 'aria-label': `${t.remove} ${c.id}`,
      onclick: async () => { if (confirm(t.removeSure)) { await app.attempt(() => api.remove(c.id)); await reload(); } },
    }, t.remove));
}
