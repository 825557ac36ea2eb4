// The job of this case: what it does, how far it is, when it ends, and what to do when it failed.
import { api } from '../api';
import type { App } from '../app';
import { h } from '../dom';
import { text } from '../text';
import { estimate, inWords } from './eta';

export function progressCard(app: App): HTMLElement | null {
  const job = app.summary ? app.jobOf(app.summary.id) : undefined;
  if (!job || job.state === 'done') return null;
  if (job.state === 'running' || job.state === 'queued') {
    const { fraction, secondsLeft } = estimate(job, app.summary!.stages, Date.now() / 1000);
    const stage = app.summary!.stages.find((s) => s.name === job.progress.stage);
    const percent = Math.round(100 * fraction);
    return h('section', { class: 'card progress' },
      h('h2', {}, job.state === 'queued' ? text.run.queued : text.run.title),
      h('div', { class: 'bar', role: 'progressbar', 'aria-label': text.run.title, 'aria-valuenow': percent, 'aria-valuemin': 0, 'aria-valuemax': 100 },
        bar(percent)),
      h('p', {}, `${percent} %`, job.state === 'running' ? ` · ${text.run.left(inWords(secondsLeft))}` : ''),
      h('p', { class: 'quiet' }, stage ? `${stage.letter} ${stage.title}` : job.progress.stage,
        ` ${Math.round(100 * job.progress.fraction)} %`),
      h('p', { class: 'quiet' }, text.run.close),
      h('button', { onclick: () => app.attempt(() => api.cancel(job.id)) }, text.run.stop));
  }
  return h('section', { class: `card ${job.state === 'failed' ? 'bad' : ''}` },
    h('h2', {}, job.state === 'failed' ? text.run.failed : text.run.cancelled),
    job.state === 'failed' ? h('p', { class: 'message' }, job.message) : null,
    h('button', { class: 'primary', onclick: () => app.attempt(() => api.resume(job.id)) }, text.run.goOn));
}

function bar(percent: number): HTMLElement {
  const part = h('span');
  part.style.width = `${percent}%`;
  return part;
}
