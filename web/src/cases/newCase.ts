// A new case: from the built-in patient, a segmented MRI, or an MRI series.
import { api } from '../api';
import type { App } from '../app';
import { choice, fill, h, slider } from '../dom';
import { text } from '../text';

const t = text.make;
type Source = 'builtin' | 'labels' | 'dicom';

export function newCaseDialog(app: App): void {
  let source: Source = 'builtin', density = 'scattered', detail = 'paper', volume = 600, seed = 1;
  const name = h('input', { type: 'text', value: 'patient', maxLength: 40, required: true, autocomplete: 'off', 'aria-describedby': 'name-hint' });
  const fields = h('div', { class: 'fields' }), note = h('p', { class: 'message', role: 'status' });
  const file = (accept: string, many = false): HTMLInputElement => h('input', { type: 'file', accept, multiple: many });
  const volumes = '.nii,.gz,.nrrd,.mha';
  const labels = file(volumes), image = file(volumes), plan = file('.json'), series = file('', true), scan = file('.ply,.obj,.stl');
  const preset = h('select', {}, h('option', { value: 'sanatrix' }, 'Sanatrix'), h('option', { value: 'pelicano' }, 'Pelicano'));
  const labelled = (words: string, input: HTMLElement): HTMLElement => h('label', { class: 'field' }, h('span', {}, words), input);

  const draw = (): void => fill(fields, source === 'builtin' ? [
    slider(t.volume, { min: 150, max: 1500, step: 10 }, volume, (v) => `${v} cm³`, (v) => { volume = v; }).element,
    choice(t.density, Object.entries(t.densities), density, (v) => { density = v; }).element,
    slider(t.seed, { min: 1, max: 50, step: 1 }, seed, String, (v) => { seed = v; }).element,
  ] : source === 'labels' ? [labelled(t.labelFile, labels), labelled(t.preset, preset), labelled(t.imageFile, image), labelled(t.planFile, plan)]
    : [labelled(t.dicomFiles, series), app.session.abilities.scan ? labelled(t.scanFile, scan) : null, labelled(t.planFile, plan)]);

  const sources: [Source, string][] = [['builtin', t.builtin], ['labels', t.labels]];
  if (app.session.abilities.dicom) sources.push(['dicom', t.dicom]);
  const go = h('button', { class: 'primary', type: 'submit' }, t.go);
  const form = h('form', {
    method: 'dialog', onsubmit: async (event: Event) => {
      event.preventDefault();
      go.disabled = true;
      const done = await app.attempt(async () => {
        const wish: Record<string, unknown> = { name: name.value.trim() || 'patient', set: { 'mesh.preset': detail } };
        if (source === 'builtin') wish.builtin = { seed, volume_cm3: volume, density };
        else if (!(await addFiles(wish))) return false;
        await api.create(wish);
        return true;
      });
      go.disabled = false;
      if (done) dialog.close();
    },
  }, h('h2', {}, t.title),
  choice(t.source, sources, source, (v) => { source = v; draw(); }).element,
  h('label', { class: 'field' }, h('span', {}, t.name), name), h('p', { class: 'quiet', id: 'name-hint' }, t.nameHint), fields,
  choice(t.detail, Object.entries(t.details), detail, (v) => { detail = v; }).element, note,
  h('div', { class: 'buttons' }, h('button', { type: 'button', onclick: () => dialog.close() }, text.cancel), go));

  const upload = async (input: HTMLInputElement): Promise<string | undefined> => {
    const files = [...(input.files ?? [])];
    let batch = '';
    for (const [i, f] of files.entries()) {
      note.textContent = t.uploading(Math.round((100 * i) / files.length));
      batch = await api.upload(f, batch);
    }
    note.textContent = '';
    return batch || undefined;
  };
  const addFiles = async (wish: Record<string, unknown>): Promise<boolean> => {
    const main = source === 'labels' ? labels : series;
    if (!main.files?.length) { note.textContent = t.needsFile; return false; }
    if (source === 'labels') {
      wish.labels = await upload(labels);
      wish.labels_preset = preset.value;
      wish.image = await upload(image);
    } else {
      wish.image = await upload(series);
      wish.scan = await upload(scan);
    }
    wish.plan = await upload(plan);
    return true;
  };
  draw();
  const dialog = h('dialog', { class: 'new-case', onclose: () => dialog.remove() }, form);
  document.body.append(dialog);
  dialog.showModal();
}
