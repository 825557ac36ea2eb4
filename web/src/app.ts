// What the page knows: session, cases, jobs, bodies; and what a step of the path is.
import { api, type CaseSummary, type Job, type Session, type StageState } from './api';
import { Body } from './view/body';
import { Viewer } from './view/viewer';
import { h } from './dom';
import { text } from './text';

export type StepName = 'patient' | 'anatomy' | 'plan' | 'healing' | 'result' | 'compare';
export interface StepView {
  panel: HTMLElement;
  /** Stands in the middle instead of the 3-D view. */
  stage?: HTMLElement;
  /** Below the view: sliders. */
  tools?: HTMLElement;
  /** The case or a job has changed. */
  update?(): void;
  /** The case was changed here or on another page. */
  changed?(): void;
  key?(event: KeyboardEvent): boolean;
  close?(): void;
}
export type Step = (app: App) => StepView | Promise<StepView>;

export class App {
  session!: Session;
  jobs: Job[] = [];
  summary: CaseSummary | null = null;
  viewer: Viewer | null = null;
  body: Body | null = null;
  lost = false;
  stamps: Record<string, string> = {};
  /** Where the crosshair is, as imaged (prone) [mm]: the same in the images and in 3-D. */
  crosshair: { id: string; at: [number, number, number] } | null = null;
  private readonly bodies = new Map<string, { stamp: string; body: Body }>();

  constructor(readonly root: HTMLElement) {
    try { this.viewer = new Viewer(); } catch { this.viewer = null; }
  }

  jobOf(id: string): Job | undefined {
    return this.jobs.find((j) => j.case === id && (j.state === 'running' || j.state === 'queued'))
      ?? this.jobs.find((j) => j.case === id);
  }
  busy(id: string): boolean {
    const job = this.jobOf(id);
    return job?.state === 'running' || job?.state === 'queued';
  }
  stageState(name: string): StageState | 'running' {
    const job = this.summary ? this.jobOf(this.summary.id) : undefined;
    if (job?.state === 'running' && job.progress.stage === name && !job.progress.finished.includes(name)) return 'running';
    return this.summary?.stages.find((s) => s.name === name)?.state ?? 'missing';
  }
  isReady(name: string): boolean { const s = this.stageState(name); return s === 'fresh' || s === 'stale'; }

  /** The 3-D body of a case, kept while its results stay the same. */
  async bodyOf(summary: CaseSummary): Promise<Body | null> {
    if (!this.viewer || !summary.stages.some((s) => s.name === 'mesh' && s.seconds > 0)) return null;
    const stamp = summary.stages.map((s) => `${s.state}${s.seconds}`).join();
    const kept = this.bodies.get(summary.id);
    if (kept?.stamp === stamp) return kept.body;
    const body = new Body(await api.scene(summary.id));
    kept?.body.dispose();
    this.bodies.set(summary.id, { stamp, body });
    return body;
  }

  notify(message: string, hint = ''): void {
    const box = h('div', { class: 'toast', role: 'alert' }, h('strong', {}, message), hint ? h('span', {}, hint) : null,
      h('button', { class: 'plain', 'aria-label': text.close, onclick: () => box.remove() }, '×'));
    document.querySelector('.toasts')?.append(box);
    setTimeout(() => box.remove(), 12000);
  }
  /** Runs something that asks the server; what it refuses is shown, not thrown. */
  async attempt<T>(work: () => Promise<T>): Promise<T | undefined> {
    try { return await work(); } catch (problem) {
      const { message, hint } = problem as { message: string; hint?: string };
      this.notify(message || text.error, hint);
      return undefined;
    }
  }
}
