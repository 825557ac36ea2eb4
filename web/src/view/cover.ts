// Nobody's body stays on a screen that nobody looks at: the page covers itself, or is covered by hand.
import { h } from '../dom';
import { text } from '../text';

const idleMinutes = 5;
let curtain: HTMLElement | null = null;

export function cover(): void {
  if (curtain) return;
  const back = document.activeElement as HTMLElement | null, page = document.getElementById('app')!;
  const show = (): void => {
    page.inert = false;
    curtain?.remove();
    curtain = null;
    back?.focus();
  };
  const button = h('button', { class: 'primary', onclick: show }, text.cover.show);
  curtain = h('div', { class: 'curtain', role: 'dialog', 'aria-label': text.cover.covered }, h('p', {}, text.cover.covered), button);
  page.inert = true;
  document.body.append(curtain);
  button.focus();
}

export function coverWhenIdle(): void {
  let last = Date.now();
  for (const kind of ['pointerdown', 'pointermove', 'keydown', 'wheel', 'touchstart']) {
    addEventListener(kind, () => { last = Date.now(); }, { passive: true, capture: true });
  }
  setInterval(() => { if (Date.now() - last > idleMinutes * 60_000) cover(); }, 10_000);
}
