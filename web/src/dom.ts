// A few lines instead of a framework: elements from a tag, attributes and children. Text is always
// set as text, so that no label of anybody becomes markup.
import { capital, text } from './text';

export type Child = Node | string | number | null | undefined | false;
type Attributes = Record<string, unknown>;

export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Attributes = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value as EventListener);
    else if (name === 'class') element.className = String(value);
    else if (name in element && !name.startsWith('aria') && name !== 'list') {
      (element as unknown as Attributes)[name] = value;
    } else element.setAttribute(name, value === true ? '' : String(value));
  }
  fill(element, children);
  return element;
}

export function fill(element: Element, children: Child[]): void {
  element.replaceChildren(...children.filter((c) => c !== null && c !== undefined && c !== false)
    .map((c) => (c instanceof Node ? c : document.createTextNode(String(c)))));
}

/** What the computation noted, for those who ask. */
export const notes = (list: string[]): HTMLElement | null => (list.length === 0 ? null
  : h('details', {}, h('summary', {}, text.notes(list.length)), ...list.map((w) => h('p', { class: 'quiet note' }, capital(w)))));

export interface Slider { element: HTMLElement; set(value: number): void; input: HTMLInputElement }

/** A labelled slider with its value and unit in words. */
export function slider(label: string, range: { min: number; max: number; step: number }, value: number,
  show: (value: number) => string, change: (value: number, done: boolean) => void): Slider {
  const output = h('output', {}, show(value));
  const input = h('input', { type: 'range', ...range, 'aria-label': label }) as HTMLInputElement;
  input.value = String(value);
  const told = (done: boolean): void => {
    output.textContent = show(input.valueAsNumber);
    input.setAttribute('aria-valuetext', output.textContent);
    change(input.valueAsNumber, done);
  };
  input.addEventListener('input', () => told(false));
  input.addEventListener('change', () => told(true));
  return {
    element: h('label', { class: 'slider' }, h('span', {}, label), output, input),
    input,
    set(next) {
      input.value = String(next);
      output.textContent = show(next);
      input.setAttribute('aria-valuetext', output.textContent);
    },
  };
}

/** Buttons of which one is chosen; arrows move, as in every radio group. */
export function choice<T extends string>(label: string, options: [T, string][], chosen: T,
  change: (value: T) => void): { element: HTMLElement; set(value: T): void } {
  const name = `choice-${Math.random().toString(36).slice(2)}`;
  const inputs = options.map(([value]) =>
    h('input', { type: 'radio', name, value, checked: value === chosen, onchange: () => change(value) }));
  return {
    element: h('fieldset', { class: 'choice' }, h('legend', {}, label), h('div', {},
      ...options.map(([, text], i) => h('label', {}, inputs[i], h('span', {}, text))))),
    set(value) { inputs.forEach((input) => { input.checked = input.value === value; }); },
  };
}
