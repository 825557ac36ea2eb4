// Steps C to F: the same breast in every pose.
import { api } from '../api';
import type { App, StepView } from '../app';
import { fill, h, notes } from '../dom';
import { text } from '../text';
import { posePicker, viewBar } from './bar';
import { Flat } from './flat';

const t = text.anatomy;

export async function anatomyStep(app: App): Promise<StepView> {
  const panel = h('div', { class: 'panel' });
  app.body = await app.bodyOf(app.summary!);
  let tools: HTMLElement | undefined;
  const s = app.summary!;
  const stages = s.stages.filter((x) => ['mesh', 'unload', 'supine', 'upright'].includes(x.name));
  fill(panel, [h('h2', {}, text.steps.anatomy[0]), h('p', {}, app.isReady('mesh') ? t.lead : t.waiting),
    app.isReady('supine') ? h('a', { class: 'button primary wide', href: `#/case/${s.id}/plan` }, t.goPlan) : null,
    h('dl', {}, ...stages.flatMap((x) => [h('dt', {}, `${x.letter} ${x.title}`), h('dd', {}, text.stageWord[app.stageState(x.name)],
      x.seconds ? ` · ${x.seconds.toFixed(0)} s` : '')])),
    notes(s.stages.slice(0, 5).flatMap((x) => x.warnings))]);
  if (app.viewer && app.body) {
    app.body.showPlan(null);
    app.body.showSurgery({ tumour: false, excision: false, seeThrough: false });
    app.body.paint(null, () => [0, 0, 0]);
    app.body.showArrows(null);
    app.viewer.setPanes([{ title: '', bodies: [app.body] }]);
    app.viewer.frame();
    app.viewer.orbit.view('left-oblique');
    tools = h('div', { class: 'tools' }, viewBar(app.viewer), posePicker(app, app.body, ['prone', 'unloaded', 'supine', 'before'], app.body.has('supine') ? 'supine' : 'prone'));
  }
  const stage = !app.viewer && app.isReady('mesh') ? Flat.ofPoses(await api.scene(s.id)).element : undefined;
  return { panel, tools, stage };
}
