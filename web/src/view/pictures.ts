// Without WebGL: the pictures that the simulation made, with the same content.
import { api } from '../api';
import type { App } from '../app';
import { h } from '../dom';
import { text } from '../text';

export async function noWebgl(app: App): Promise<HTMLElement> {
  const id = app.summary!.id;
  const files = ((await app.attempt(() => api.files(id))) ?? []).filter((f) => f.file.endsWith('.png'));
  return h('div', { class: 'pictures' }, h('p', { class: 'quiet' }, text.view.noWebgl),
    files.length === 0 ? h('p', {}, text.view.noPictures) : null,
    ...files.map((f) => h('figure', {}, h('img', { src: api.fileAddress(id, f.stage, f.file), alt: f.file, loading: 'lazy' }),
      h('figcaption', {}, f.file.replace(/_/g, ' ').replace('.png', '')))));
}
