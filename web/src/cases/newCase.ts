// A new case: from the built-in patient, an MRI, a segmented MRI, or a surface scan alone.
import { api } from '../api';
import type { App } from '../app';
import { choice, fill, h, slider } from '../dom';
import { text } from '../text';

const t = text.make;
type Source = 'builtin' | 'mri' | 'labels' | 'scan';
const volumes = '.nii,.gz,.nrrd,.mha,.zip', surfaces = '.ply,.stl,.zip';

/** Files that a form field was given. A scan with photographs comes as a zip: its files name each
 * other, and the server forgets the names of what is uploaded. */
class Files {
  readonly input: HTMLInputElement;
  constructor(accept: string, many = false, folder = false) {
    this.input = h('input', { type: 'file', accept, multiple: many });
    if (folder) this.input.setAttribute('webkitdirectory', '');
  }
  get list(): File[] { return [...(this.input.files ?? [])].filter((f) => !f.name.startsWith('.')); }
  field(label: string): HTMLElement { return h('label', { class: 'field' }, h('span', {}, label), this.input); }
}

export function newCaseDialog(app: App): void {
  const can = app.session.abilities;
  let source: Source = 'builtin', density = 'scattered', detail = 'paper', volume = 600, seed = 1;
  const name = h('input', { type: 'text', value: 'patient', maxLength: 40, required: true, autocomplete: 'off', 'aria-describedby': 'name-hint' });
  const fields = h('div', { class: 'fields' }), note = h('p', { class: 'message', role: 'status' });
  const series = new Files('', true, true), image = new Files(volumes), labels = new Files(`${volumes}`), scan = new Files(surfaces);
  const plan = new Files('.json'), tumour = new Files('.json');
  const preset = h('select', {}, ...Object.entries(t.presets).map(([value, word]) => h('option', { value }, word)));
  const densities = (): HTMLElement => choice(t.density, Object.entries(t.densities), density, (v) => { density = v; }).element;

  const form_of: Record<Source, () => (HTMLElement | null)[]> = {
    builtin: () => [slider(t.volume, { min: 150, max: 1500, step: 10 }, volume, (v) => `${v} cm³`, (v) => { volume = v; }).element,
      densities(), slider(t.seed, { min: 1, max: 50, step: 1 }, seed, String, (v) => { seed = v; }).element],
    mri: () => [series.field(t.dicomFiles), image.field(t.volumeFile), can.tumour ? tumour.field(t.tumourFile) : null,
      can.scan ? scan.field(t.scanFile) : null, plan.field(t.planFile)],
    labels: () => [labels.field(t.labelFile), h('label', { class: 'field' }, h('span', {}, t.preset), preset), image.field(t.imageFile),
      can.scan ? scan.field(t.scanFile) : null, plan.field(t.planFile)],
    scan: () => [h('p', { class: 'quiet' }, t.scanOnly), scan.field(t.scanNeeded), densities()],
  };
  const draw = (): void => { note.textContent = ''; fill(fields, form_of[source]()); };

  const sources: [Source, string][] = [['builtin', t.builtin], ['labels', t.labels]];
  if (can.dicom) sources.splice(1, 0, ['mri', t.mri]);
  if (can.scan_only) sources.push(['scan', t.scan]);
  const go = h('button', { class: 'primary', type: 'submit' }, t.go);
  const form = h('form', {
    method: 'dialog', onsubmit: async (event: Event) => {
      event.preventDefault();
      go.disabled = true;
      const done = await app.attempt(async () => {
        const wish = await wanted();
        if (wish) await api.create(wish);
        return wish !== null;
      });
      go.disabled = false;
      if (done) dialog.close();
    },
  }, h('h2', {}, t.title),
  choice(t.source, sources, source, (v) => { source = v; draw(); }).element,
  h('label', { class: 'field' }, h('span', {}, t.name), name), h('p', { class: 'quiet', id: 'name-hint' }, t.nameHint), fields,
  choice(t.detail, Object.entries(t.details), detail, (v) => { detail = v; }).element, note,
  h('div', { class: 'buttons' }, h('button', { type: 'button', onclick: () => dialog.close() }, text.cancel), go));

  /** Sends files; what they were called stays here. */
  const upload = async (files: File[]): Promise<string | undefined> => {
    const all = files.reduce((sum, f) => sum + f.size, 0) || 1;
    let batch = '', sent = 0;
    for (const f of files) {
      note.textContent = t.uploading(Math.round((100 * sent) / all));
      batch = await api.upload(f, batch);
      sent += f.size;
    }
    note.textContent = '';
    return batch || undefined;
  };
  const wanted = async (): Promise<object | null> => {
    const wish: Record<string, unknown> = { name: name.value.trim() || 'patient', set: { 'mesh.preset': detail } };
    if (source === 'builtin') return { ...wish, builtin: { seed, volume_cm3: volume, density } };
    const main = { mri: series.list.length ? series : image, labels, scan }[source];
    if (main.list.length === 0) { note.textContent = t.needsFile; return null; }
    if (source === 'scan') return { ...wish, scan: await upload(scan.list), density };
    if (source === 'labels') Object.assign(wish, { labels: await upload(labels.list), labels_preset: preset.value, image: await upload(image.list) });
    else Object.assign(wish, { image: await upload(main.list), tumour: await upload(tumour.list) });
    return { ...wish, scan: await upload(scan.list), plan: await upload(plan.list) };
  };
  draw();
  const dialog = h('dialog', { class: 'new-case', onclose: () => dialog.remove() }, form);
  document.body.append(dialog);
  dialog.showModal();
}
