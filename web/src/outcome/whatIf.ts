// "What if she heals badly?": the same plan under other healing models, each a case of its own.
import { api, type CaseSummary } from '../api';
import type { App } from '../app';
import { fill, h } from '../dom';
import { text } from '../text';
import { noise_mm } from './rows';

const t = text.whatIf;
export const usual = 'vavourakis2016';
export const presetOf = (s: CaseSummary): string => s.parameters['heal.preset'] ?? usual;

/** Everything but the model of healing. */
const rest = (s: CaseSummary): string => JSON.stringify([s.patient, s.plan,
  Object.entries(s.parameters).filter(([k]) => k !== 'heal.preset').sort()]);

/** The case of the same patient, plan and other settings under each model of healing. */
export function sisters(own: CaseSummary, all: CaseSummary[]): Map<string, CaseSummary> {
  const found = new Map<string, CaseSummary>();
  for (const s of all) if (!s.broken && rest(s) === rest(own) && !found.has(presetOf(s))) found.set(presetOf(s), s);
  found.set(presetOf(own), own);
  return found;
}
/** Cases that are one plan under several models of healing, in the order of the list; the usual model
 * speaks for them. Equal plans under one model are two cases, not a what-if. */
export function families(cases: CaseSummary[]): { main: CaseSummary; others: CaseSummary[] }[] {
  const found: CaseSummary[][] = [];
  for (const c of cases) {
    const home = c.broken || !c.plan ? undefined
      : found.find((f) => rest(f[0]) === rest(c) && !f.some((m) => presetOf(m) === presetOf(c)));
    if (home) home.push(c); else found.push([c]);
  }
  return found.map((members) => {
    const main = members.find((m) => presetOf(m) === usual) ?? members[members.length - 1];
    return { main, others: members.filter((m) => m !== main) };
  });
}
/** Least and largest of a number over the models that have been computed. */
export function spread(of: CaseSummary[], value: (s: CaseSummary) => number): { low: number; high: number; models: number } {
  const values = of.filter((s) => s.outcome && s.outcome_fresh).map(value);
  return { low: Math.min(...values), high: Math.max(...values), models: values.length };
}

export async function whatIf(app: App): Promise<{ element: HTMLElement; update(): void }> {
  const own = app.summary!, box = h('section', { class: 'what-if' });
  const begun = new Map<string, string>(); // preset -> its case, before its run has set the preset
  let seen = '';
  const draw = async (): Promise<void> => {
    const known = sisters(own, await api.cases());
    const { low, high, models } = spread([...known.values()], (s) => s.outcome!.max_displacement_upright_mm);
    fill(box, [h('h3', {}, t.title),
      h('div', { class: 'buttons' }, ...app.session.healing_presets.map((preset) => option(preset, known.get(preset)))),
      h('p', { class: high < noise_mm ? 'quiet' : '' }, models > 1 ? t.range(low, high, models) : t.oneModel)]);
  };
  const option = (preset: string, found?: CaseSummary): HTMLElement => {
    const id = found?.id ?? begun.get(preset);
    const word = text.plan.presets[preset] ?? preset, ready = found?.outcome && found.outcome_fresh;
    const working = id !== undefined && preset !== presetOf(own) && app.busy(id);
    return h('button', {
      'aria-pressed': preset === presetOf(own) ? 'true' : 'false', disabled: working,
      onclick: () => {
        if (preset === presetOf(own)) return;
        if (ready) { location.hash = `#/case/${found.id}/result`; return; }
        void compute(preset, found).then(draw);
      },
    }, word, ready ? null : h('small', {}, working ? ` (${t.working})` : ` (${t.compute})`));
  };
  const compute = (preset: string, found?: CaseSummary): Promise<unknown> => app.attempt(async () => {
    const id = found?.id ?? (await api.copy(own.id, `${own.id}-${preset.split('_').pop()}`)).case;
    if (!found) await api.name(id, `${own.plan_name || own.id}, ${(text.plan.presets[preset] ?? preset).toLowerCase()}`);
    await api.run(id, { set: { 'heal.preset': preset } });
    begun.set(preset, id);
    app.jobs = await api.jobs();
    app.notify(t.started, t.startedHint);
  });
  await draw();
  return {
    element: box,
    update(): void {
      const states = app.jobs.map((j) => `${j.id}${j.state}`).join();
      if (states !== seen) { seen = states; void app.attempt(draw); }
    },
  };
}
