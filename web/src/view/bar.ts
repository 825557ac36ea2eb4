// The strip below the 3-D view: standard views, see-through, and the pose slider.
import type { App } from '../app';
import { h } from '../dom';
import { text } from '../text';
import type { Body } from './body';
import type { StandardView } from './camera';
import { along, at, poseName } from './pose';
import type { Viewer } from './viewer';

const t = text.view;

export function viewBar(viewer: Viewer, toggle?: { label: string; value: boolean; change: (value: boolean) => void }): HTMLElement {
  const views: [StandardView, string][] = [['front', t.front], ['left-oblique', t.leftOblique], ['right-oblique', t.rightOblique],
    ['left', t.left], ['right', t.right], ['above', t.above]];
  return h('div', { class: 'view-bar', role: 'toolbar', 'aria-label': t.views },
    ...views.map(([name, label]) => h('button', { class: 'plain', onclick: () => viewer.orbit.view(name) }, label)),
    h('button', { class: 'plain', onclick: () => viewer.orbit.reset() }, t.reset),
    toggle ? h('label', { class: 'check' }, h('input', {
      type: 'checkbox', checked: toggle.value,
      onchange: (e: Event) => toggle.change((e.target as HTMLInputElement).checked),
    }), toggle.label) : null);
}

/** Moves the body along a row of poses, without asking the server. */
export function posePicker(app: App, body: Body, wanted: string[], start: string): HTMLElement {
  const poses = wanted.filter((p) => body.has(p));
  const first = Math.max(0, poses.indexOf(start));
  const stops = poses.map((pose, i) => h('button', { type: 'button', class: 'stop', onclick: () => { input.value = String(i); show(); } }, poseName(body.head, pose)));
  const input = h('input', {
    type: 'range', min: 0, max: poses.length - 1, step: 0.02, 'aria-label': t.pose,
    oninput: () => show(),
  });
  const show = (): void => {
    const position = input.valueAsNumber, near = Math.round(position), isAt = Math.abs(position - near) < 0.03;
    const pose = poses.length > 1 ? along(poses, isAt ? near : position) : at(poses[0]);
    body.setPose(pose);
    input.setAttribute('aria-valuetext', isAt ? poseName(body.head, poses[near]) : t.between(poseName(body.head, pose.from), poseName(body.head, pose.to)));
    stops.forEach((stop, i) => stop.setAttribute('aria-pressed', String(isAt && i === near)));
    app.viewer?.draw();
  };
  input.value = String(first);
  show();
  const picker = h('div', { class: 'pose-picker' }, poses.length > 1 ? input : null, h('div', { class: 'stops' }, ...stops));
  picker.style.setProperty('--stops', String(poses.length));
  return picker;
}
