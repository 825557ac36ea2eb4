// Without WebGL: the pictures that the server's simulation made, those of this step first.
import { api, type ResultFile } from '../api';
import type { App, StepName } from '../app';
import { h } from '../dom';
import { text } from '../text';

const t = text.view;
/** By what each step asks for; the patient's photographs stay where they are. */
const wanted: Record<StepName, string[]> = {
  patient: ['overlay.png'], anatomy: ['poses.png', 'overlay.png'], plan: ['fig4_plan.png', 'poses.png'],
  healing: ['fig5_species.png', 'fig6_volume.png', 'species_means.png'], result: ['views.png', 'fig7_displacement.png', 'poses.png'], compare: ['views.png'],
};
export function picturesFor(step: StepName, files: ResultFile[]): ResultFile[] {
  return wanted[step].flatMap((name) => files.filter((f) => f.file === name));
}

export async function noWebgl(app: App, step: StepName): Promise<HTMLElement> {
  const id = app.summary!.id;
  const files = picturesFor(step, (await app.attempt(() => api.files(id))) ?? []);
  return h('div', { class: 'pictures', tabIndex: 0 }, h('p', { class: 'quiet' }, t.noWebgl),
    files.length === 0 ? h('p', {}, t.noPictures) : null,
    ...files.map((f) => h('figure', {}, h('img', { src: api.fileAddress(id, f.stage, f.file), alt: t.pictures[f.file] ?? f.file, loading: 'lazy' }),
      h('figcaption', {}, t.pictures[f.file] ?? f.file))));
}
