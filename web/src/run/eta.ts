// How long a run will still take, from what its stages usually take and how fast this one is.
import type { Job, Stage } from '../api';

/** Seconds on two cores with the standard mesh; what a case has measured itself replaces them. */
const usual: Record<string, number> = {
  phantom: 40, image: 1, segment: 5, mesh: 20, unload: 6, supine: 6, surgery: 2, heal: 45, upright: 10, outcome: 15,
};
const order = ['image', 'segment', 'mesh', 'unload', 'supine', 'surgery', 'heal', 'upright', 'outcome'];

export interface Estimate { fraction: number; secondsLeft: number }

export function estimate(job: Job, stages: Stage[], now_s: number): Estimate {
  const last = job.kind === 'create' ? 'supine' : 'outcome';
  const wanted = order.slice(0, order.indexOf(last) + 1).filter((name) =>
    job.progress.finished.includes(name) || name === job.progress.stage ||
    (stages.find((s) => s.name === name)?.state ?? 'missing') !== 'fresh');
  const list = job.kind === 'create' ? ['phantom', ...wanted] : wanted;
  const known = (name: string): number => Math.max(0.5, stages.find((s) => s.name === name)?.seconds || usual[name] || 5);
  const phantomDone = job.progress.stage !== 'phantom' && (job.step > 0 || job.progress.stage !== '');
  let done = 0, all = 0;
  for (const name of list) {
    all += known(name);
    if (job.progress.finished.includes(name) || (name === 'phantom' && phantomDone)) done += known(name);
    else if (name === job.progress.stage) done += known(name) * Math.min(1, job.progress.fraction);
  }
  const gone = Math.max(0, now_s - job.started_s);
  // The usual times are a first guess; after a while the run's own speed counts.
  const pace = done > 0.1 * all && gone > 5 ? Math.min(6, Math.max(0.3, gone / done)) : 1;
  return { fraction: all > 0 ? done / all : 0, secondsLeft: Math.max(0, (all - done) * pace) };
}

export function inWords(seconds: number): string {
  if (seconds < 50) return `${Math.max(5, Math.ceil(seconds / 5) * 5)} s`;
  return `${Math.round(seconds / 60) || 1} min`;
}
