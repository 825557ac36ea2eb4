// The strip below the 3-D view: standard views, see-through, and the pose slider.
import type { App } from '../app';
import { h } from '../dom';
import { text } from '../text';
import type { Body } from './body';
import type { StandardView } from './camera';
import { along, at } from './pose';
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
  const output = h('output', {}, t.poses[poses[first]]);
  const input = h('input', {
    type: 'range', min: 0, max: poses.length - 1, step: 0.02, 'aria-label': t.pose,
    oninput: () => {
      const position = input.valueAsNumber, near = Math.round(position);
      const pose = along(poses, Math.abs(position - near) < 0.03 ? near : position);
      body.setPose(pose);
      output.textContent = pose.t < 0.01 ? t.poses[pose.from] : pose.t > 0.99 ? t.poses[pose.to] : t.between(t.poses[pose.from], t.poses[pose.to]);
      input.setAttribute('aria-valuetext', output.textContent);
      app.viewer?.draw();
    },
  });
  input.value = String(first);
  input.setAttribute('aria-valuetext', output.textContent ?? '');
  body.setPose(at(poses[first]));
  app.viewer?.draw();
  return h('label', { class: 'pose-picker' }, h('span', {}, t.pose), input, output);
}
