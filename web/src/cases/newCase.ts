// A new case: from the built-in patient, an MRI, a segmented MRI, or a surface scan alone.
import { api } from '../api';
import type { App } from '../app';
import { choice, fill, h, slider } from '../dom';
import { text } from '../text';
import { scanFiles, type Sent } from './scanFiles';
import { SeriesChoice } from './series';

const t = text.make;
type Source = 'builtin' | 'mri' | 'labels' | 'scan';
const volumes = '.nii,.gz,.nrrd,.mha,.zip', surfaces = '.obj,.mtl,.jpg,.jpeg,.png,.ply,.stl,.zip';

/** Files that a form field was given. */
class Files {
  readonly input: HTMLInputElement;
  constructor(accept: string, many = false, folder = false) {
    this.input = h('input', { type: 'file', accept, multiple: many });
    if (folder) this.input.setAttribute('webkitdirectory', '');
  }
  get list(): File[] { return [...(this.input.files ?? [])].filter((f) => !f.name.startsWith('.')); }
  get sent(): Sent[] { return this.list.map((f) => ({ name: f.name, content: f })); }
  clear(): void { this.input.value = ''; }
  field(label: string, hint = ''): HTMLElement {
    return h('label', { class: 'field' }, h('span', {}, label), this.input, hint ? h('small', { class: 'quiet' }, hint) : null);
  }
}

/** Sends files one after the other as one upload. */
async function send(files: Sent[], told: (percent: number) => void): Promise<string | undefined> {
  const all = files.reduce((sum, f) => sum + f.content.size, 0) || 1;
  let batch = '', sent = 0;
  for (const f of files) {
    told(Math.floor((100 * sent) / all));
    batch = await api.upload(f.name, f.content, batch);
    sent += f.content.size;
  }
  told(100);
  return batch || undefined;
}

export function newCaseDialog(app: App): void { new Form(app).open(); }

class Form {
  private source: Source = 'builtin';
  private density = 'scattered';
  private detail = 'paper';
  private volume = 600;
  private seed = 1;
  private readonly name = h('input', { type: 'text', value: 'patient', maxLength: 40, required: true, autocomplete: 'off', 'aria-describedby': 'name-hint' });
  private readonly fields = h('div', { class: 'fields' });
  private readonly note = h('p', { class: 'message', role: 'status' });
  private readonly go = h('button', { class: 'primary', type: 'submit' }, t.go);
  private readonly folder = new Files('', true, true);
  private readonly image = new Files(volumes);
  private readonly labels = new Files(volumes);
  private readonly labelled = new Files(volumes);
  private readonly scan = new Files(surfaces, true);
  private readonly plan = new Files('.json');
  private readonly tumour = new Files('.json,.nii,.gz,.nrrd,.mha');
  private readonly preset = h('select', {}, ...Object.entries(t.presets).map(([value, word]) => h('option', { value }, word)));
  private readonly series = new SeriesChoice();
  private mri: string | undefined; // the upload, made as soon as files are chosen
  private reading = 0; // which choice of files is being read
  private dialog: HTMLDialogElement;

  constructor(private readonly app: App) {
    const can = app.session.abilities, sources: [Source, string][] = [['builtin', t.builtin], ['labels', t.labels]];
    if (can.dicom) sources.splice(1, 0, ['mri', t.mri]);
    if (can.scan_only) sources.push(['scan', t.scan]);
    this.folder.input.addEventListener('change', () => { this.image.clear(); void this.look(this.folder); });
    this.image.input.addEventListener('change', () => { this.folder.clear(); void this.look(this.image); });
    const form = h('form', { method: 'dialog', onsubmit: (e: Event) => { e.preventDefault(); void this.create(); } },
      h('h2', {}, t.title),
      choice(t.source, sources, this.source, (v) => { this.source = v; this.draw(); }).element,
      this.fields,
      h('label', { class: 'field' }, h('span', {}, t.name), this.name, h('small', { class: 'quiet', id: 'name-hint' }, t.nameHint)),
      choice(t.detail, Object.entries(t.details), this.detail, (v) => { this.detail = v; }).element, this.note,
      h('div', { class: 'buttons' }, h('button', { type: 'button', onclick: () => this.dialog.close() }, text.cancel), this.go));
    this.dialog = h('dialog', { class: 'new-case', 'aria-label': t.title, onclose: () => { ++this.reading; this.dialog.remove(); } }, form);
    this.draw();
  }
  open(): void {
    document.body.append(this.dialog);
    this.dialog.showModal();
  }

  private draw(): void {
    const can = this.app.session.abilities, scan = can.scan ? this.scan.field(t.scanFile, t.scanHint) : null;
    const more = (...children: (HTMLElement | null)[]): HTMLElement => h('details', {}, h('summary', {}, t.more), ...children);
    const densities = (): HTMLElement => choice(t.density, Object.entries(t.densities), this.density, (v) => { this.density = v; }).element;
    const form_of: Record<Source, () => (HTMLElement | null)[]> = {
      builtin: () => [h('p', { class: 'quiet' }, t.builtinLead), slider(t.volume, { min: 150, max: 1500, step: 10 }, this.volume, (v) => `${v} cm³`, (v) => { this.volume = v; }).element,
        densities(), slider(t.seed, { min: 1, max: 50, step: 1 }, this.seed, String, (v) => { this.seed = v; }).element],
      mri: () => [h('p', { class: 'quiet' }, t.mriLead), h('div', { class: 'two' }, this.folder.field(t.dicomFiles), this.image.field(t.volumeFile, t.volumeHint)), this.series.element,
        more(can.tumour ? this.tumour.field(t.tumourFile) : null, scan, this.plan.field(t.planFile))],
      labels: () => [this.labels.field(t.labelFile, t.volumeHint), h('label', { class: 'field' }, h('span', {}, t.preset), this.preset),
        more(this.labelled.field(t.imageFile), scan, this.plan.field(t.planFile))],
      scan: () => [h('p', { class: 'quiet' }, t.scanOnly), this.scan.field(t.scanNeeded, t.scanHint), densities(), more(this.plan.field(t.planFile))],
    };
    this.note.textContent = '';
    fill(this.fields, form_of[this.source]());
  }

  /** Reads the chosen images at once and shows what they hold, so that the right series is taken. */
  private async look(files: Files): Promise<void> {
    const mine = ++this.reading;
    this.mri = undefined;
    this.series.clear();
    this.note.textContent = '';
    if (!files.list.length) return;
    this.go.disabled = true;
    try {
      const upload = await send(files.sent, (percent) => { if (mine === this.reading) this.series.busy(percent); });
      const contents = await api.series(upload!);
      if (mine !== this.reading) return;
      this.mri = upload;
      this.series.show(contents);
    } catch (problem) {
      if (mine !== this.reading) return;
      this.series.clear();
      this.note.textContent = (problem as Error).message;
    } finally {
      if (mine === this.reading) this.go.disabled = false;
    }
  }

  private async create(): Promise<void> {
    this.go.disabled = true;
    this.note.textContent = '';
    try {
      const wish = await this.wanted();
      if (wish) {
        await api.create(wish);
        this.dialog.close();
      }
    } catch (problem) {
      const { message, hint } = problem as { message: string; hint?: string };
      this.note.textContent = [message, hint].filter(Boolean).join('. ');
    }
    this.go.disabled = false;
  }
  private async wanted(): Promise<object | null> {
    const told = (percent: number): void => { this.note.textContent = percent < 100 ? t.uploading(percent) : ''; };
    const wish: Record<string, unknown> = { name: this.name.value.trim() || 'patient', set: { 'mesh.preset': this.detail } };
    if (this.source === 'builtin') return { ...wish, builtin: { seed: this.seed, volume_cm3: this.volume, density: this.density } };
    const ready = { mri: this.mri !== undefined && !this.series.empty, labels: this.labels.list.length > 0, scan: this.scan.list.length > 0 }[this.source];
    if (!ready) { this.note.textContent = t.needsFile; return null; }
    const scan = this.scan.list.length ? await scanFiles(this.scan.list) : [];
    if (this.source === 'mri') Object.assign(wish, { image: this.mri, series: this.series.chosen || undefined, tumour: await send(this.tumour.sent, told) });
    if (this.source === 'labels') Object.assign(wish, { labels: await send(this.labels.sent, told), labels_preset: this.preset.value, image: await send(this.labelled.sent, told) });
    if (this.source === 'scan') Object.assign(wish, { density: this.density });
    return { ...wish, scan: await send(scan, told), plan: await send(this.plan.sent, told) };
  }
}
