// The live numbers of a plan, in the surgeon's terms, with what is known about such numbers.
import type { Plan, PreviewHead } from '../api';
import { fill, h } from '../dom';
import { capital, text } from '../text';

const t = text.plan;

export class Numbers {
  readonly element = h('section', { class: 'card numbers', 'aria-live': 'polite' });
  /** What such a share means; below the numbers, and it may scroll away. */
  readonly evidence = h('section', { class: 'evidence' });

  show(plan: Plan, n: PreviewHead, live: boolean, ms: number): void {
    this.element.dataset.ms = ms.toFixed(0);
    this.element.dataset.live = String(live);
    const about = live ? `${t.live} ` : '';
    const needle = h('i');
    needle.style.left = `${Math.min(100, (100 * n.excised_percent) / 30)}%`;
    fill(this.element, [
      h('p', { class: 'where' }, t.where(text.sideShort[plan.operated_side], n.quadrant, n.clock_hour, n.from_nipple_mm)),
      h('div', { class: 'big' },
        number(about + n.excised_cm3.toFixed(1), 'cm³', t.excised),
        number(about + n.excised_g.toFixed(0), 'g', t.weight),
        number(about + n.excised_percent.toFixed(1), '%', t.share)),
      h('p', { class: 'left-over' }, ...t.leaves(n.to_skin_mm, n.to_chest_mm).map((word, i) => (i % 2 ? h('strong', {}, word) : word))),
      ...n.warnings.map((w) => h('p', { class: 'warning' }, capital(w))),
    ]);
    fill(this.evidence, [
      h('div', { class: 'share', role: 'img', 'aria-label': t.shareBand(n.excised_percent) }, needle,
        h('span', { class: 'tick ten' }, '10'), h('span', { class: 'tick twenty' }, '20 %')),
      h('details', {}, h('summary', {}, t.shareBand(n.excised_percent)), h('p', { class: 'quiet' }, t.shareSource))]);
  }
  refuse(problem: { message: string; hint?: string }): void {
    fill(this.evidence, []);
    fill(this.element, [h('p', { class: 'warning' }, capital(problem.message.replace(/^plan: |^surgery: /, ''))), problem.hint ? h('p', { class: 'quiet' }, problem.hint) : null]);
  }
}

function number(value: string, unit: string, label: string): HTMLElement {
  return h('div', {}, h('strong', {}, value, h('small', {}, ` ${unit}`)), h('span', {}, label));
}
