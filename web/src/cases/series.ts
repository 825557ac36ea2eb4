// What an uploaded MRI holds, and which of its series is taken.
import type { ImageContents, Series } from '../api';
import { fill, h } from '../dom';
import { text } from '../text';

const t = text.series;
const across = (values: number[], digits: number): string => values.map((v) => v.toFixed(digits).replace(/\.?0+$/, '')).join(' × ');

export const describe = (s: Series): string => t.line(s.series_number || s.series, s.weighting, s.plane, s.patient_position, s.size[2]);
export const grid = (s: Series): string => `${across(s.size, 0)}, ${across(s.spacing_mm, 2)} mm`;

export class SeriesChoice {
  readonly element = h('div', { class: 'series', role: 'status' });
  /** 0: as the program would choose. */
  chosen = 0;
  /** Nothing in it can be used. */
  empty = false;

  busy(percent: number): void { fill(this.element, [h('p', { class: 'quiet' }, percent < 100 ? text.make.uploading(percent) : t.looking)]); }
  clear(): void { this.chosen = 0; this.empty = false; fill(this.element, []); }

  show(contents: ImageContents): void {
    this.clear();
    if (contents.kind !== 'DICOM') {
      fill(this.element, [h('p', { class: 'quiet' }, t.volume(across(contents.size, 0), across(contents.spacing_mm, 2)))]);
      return;
    }
    const best = contents.series.find((s) => s.chosen);
    this.chosen = best?.series ?? 0;
    this.empty = contents.series.length === 0;
    const name = `series-${Math.random().toString(36).slice(2)}`;
    fill(this.element, [
      best ? null : h('p', { class: 'warning' }, `${t.none} ${contents.nothing_chosen ?? ''}`),
      this.empty ? null : h('fieldset', { class: 'series-list' }, h('legend', {}, t.legend), ...contents.series.map((s) => h('label', { class: 'check' },
        h('input', { type: 'radio', name, value: String(s.series), checked: s.series === this.chosen, onchange: () => { this.chosen = s.series; } }),
        h('span', {}, h('strong', {}, describe(s)), h('small', { class: 'quiet' }, grid(s)),
          s.not_chosen_because ? h('small', { class: 'unfit' }, t.unfit(s.not_chosen_because)) : s === best ? h('small', { class: 'quiet' }, t.best) : null,
          ...s.warnings.map((w) => h('small', { class: 'unfit' }, w)))))),
    ]);
  }
}
