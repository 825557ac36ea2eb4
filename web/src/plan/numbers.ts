// The live numbers of a plan, in the surgeon's terms, with what is known about such numbers.
import type { Plan, PreviewHead } from '../api';
import { fill, h } from '../dom';
import { text } from '../text';

const t = text.plan;

export class Numbers {
  readonly element = h('section', { class: 'card numbers', 'aria-live': 'polite' });
  lastMs = 0;

  show(plan: Plan, n: PreviewHead, live: boolean, ms: number): void {
    this.lastMs = ms;
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
      h('div', { class: 'share', title: t.shareSource, role: 'img', 'aria-label': t.shareBand(n.excised_percent) }, needle,
        h('span', { class: 'tick ten' }, '10'), h('span', { class: 'tick twenty' }, '20 %')),
      h('p', { class: 'quiet' }, t.shareBand(n.excised_percent), ' ', h('span', { class: 'source', title: t.shareSource, tabIndex: 0 }, t.source)),
      h('div', { class: 'big small' },
        number(n.to_skin_mm.toFixed(0), 'mm', t.toSkin),
        number(n.to_chest_mm.toFixed(0), 'mm', t.toFascia)),
      ...n.warnings.map((w) => h('p', { class: 'warning' }, w)),
    ]);
  }
  refuse(problem: { message: string; hint?: string }): void {
    fill(this.element, [h('p', { class: 'warning' }, problem.message.replace(/^plan: |^surgery: /, '')), problem.hint ? h('p', { class: 'quiet' }, problem.hint) : null]);
  }
}

function number(value: string, unit: string, label: string): HTMLElement {
  return h('div', {}, h('strong', {}, value, h('small', {}, ` ${unit}`)), h('span', {}, label));
}
