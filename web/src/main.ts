// Start: who are we talking to, what does the address ask for, and what changes while we look.
import { api, listen, Refusal } from './api';
import { App, type Step, type StepName, type StepView } from './app';
import { showCases } from './cases/list';
import { compareStep } from './compare/panel';
import { fill, h } from './dom';
import { frame, path } from './frame';
import { healingStep } from './healing/panel';
import { resultStep } from './outcome/panel';
import { usual } from './outcome/whatIf';
import { planStep } from './plan/panel';
import { patientStep } from './slices/panel';
import './style.css';
import { text } from './text';
import { anatomyStep } from './view/anatomy';
import { coverWhenIdle } from './view/cover';
import { noWebgl } from './view/pictures';

const steps: Record<StepName, Step> = {
  patient: patientStep, anatomy: anatomyStep, plan: planStep, healing: healingStep, result: resultStep, compare: compareStep,
};
const app = new App(document.getElementById('app')!);
let shown: { update(): void; changed?(id: string): void; close?(): void; key?(e: KeyboardEvent): boolean } | null = null;
let turn = 0;

async function showCase(id: string, step: StepName, mine: number): Promise<void> {
  const stamp = (): string => {
    const job = app.jobOf(id);
    return job ? `${job.id}${job.state}${job.progress.finished.length}` : '';
  };
  let seen = stamp(); // before asking: what finishes while we draw is not missed
  const summary = await api.case(id);
  if (mine !== turn) return;
  app.summary = summary;
  app.body = null;
  const nav = path(app, step), middle = h('div', { class: 'middle' }), side = h('aside', { class: 'side', 'aria-label': text.steps[step][0] });
  frame(app, h('div', { class: 'workspace' }, nav.element, h('main', { id: 'main', class: 'centre' }, middle), side), '');
  fill(side, [h('p', { class: 'quiet' }, text.working)]);
  const view: StepView = await steps[step](app);
  if (mine !== turn) { view.close?.(); return; }
  fill(side, [view.panel]);
  const scene = view.stage ?? app.viewer?.element ?? (await noWebgl(app, step));
  fill(middle, [scene, view.tools]);
  app.viewer?.draw();
  shown = {
    key: view.key, close: view.close,
    changed(id: string): void {
      if (id !== app.summary?.id) return;
      void api.case(id).then((fresh) => { app.summary = fresh; nav.update(); view.changed?.(); }, () => void show());
    },
    update(): void {
      nav.update();
      view.update?.();
      if (stamp() === seen) return;
      seen = stamp();
      // A stage has finished: read the case again, and show what is new unless somebody is planning.
      void api.case(id).then((fresh) => {
        app.summary = fresh;
        nav.update();
        if (step !== 'plan' && step !== 'patient') void show();
        else if (step === 'plan' && !view.key) void show();
        else view.update?.();
      });
    },
  };
  shown.update();
}

async function show(): Promise<void> {
  const mine = ++turn;
  shown?.close?.();
  shown = null;
  const [, kind, id, step] = location.hash.split('/');
  try {
    if (kind === 'case' && id) await showCase(decodeURIComponent(id), step in steps ? (step as StepName) : 'plan', mine);
    else {
      app.summary = null;
      const page = await showCases(app);
      if (mine === turn) shown = page;
    }
  } catch (problem) {
    const { message, hint } = problem as Refusal;
    frame(app, h('main', { class: 'page', id: 'main' }, h('h2', {}, text.error), h('p', {}, message), h('p', { class: 'quiet' }, hint), h('p', {}, h('a', { href: '#/' }, text.cases.title))), '');
    // It may be there a moment later: look again when a job has changed.
    const jobs = (): string => app.jobs.map((j) => `${j.id}${j.state}${j.progress.finished.length}`).join();
    const before = jobs();
    shown = { update: () => { if (jobs() !== before) void show(); } };
  }
}

async function start(): Promise<void> {
  try {
    app.session = await api.session();
    app.session.healing_presets.sort((a, b) => Number(b === usual) - Number(a === usual));
  } catch (problem) {
    const refused = problem as Refusal;
    frame(app, h('main', { class: 'page', id: 'main' }, h('h2', {}, text.product), h('p', {}, refused.status === 401 ? text.notIn : `${refused.message}. ${refused.hint}`)), '');
    return;
  }
  app.jobs = await api.jobs();
  listen((jobs) => { app.jobs = jobs; shown?.update(); }, (stamps) => {
    const before = app.stamps;
    app.stamps = stamps;
    const ids = [...new Set([...Object.keys(before), ...Object.keys(stamps)])].filter((id) => before[id] !== stamps[id]);
    if (Object.keys(before).length) for (const id of ids) shown?.changed?.(id);
  }, (isLost) => {
    app.lost = isLost;
    const line = document.querySelector<HTMLElement>('.lost');
    if (line) line.hidden = !isLost;
  });
  addEventListener('hashchange', () => void show());
  addEventListener('keydown', (e) => { if (shown?.key?.(e)) e.preventDefault(); });
  setInterval(() => { if (app.jobs.some((j) => j.state === 'running')) shown?.update(); }, 5000);
  coverWhenIdle();
  await show();
}
void start();
Object.assign(window, { sanatrix: app }); // for measuring in the browser test
