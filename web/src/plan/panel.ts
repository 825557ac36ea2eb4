// Planning: tumour, margin, shape, incision; the numbers follow while one draws.
import { api, type Plan, type Point, type PreviewHead, type Side } from '../api';
import type { App, StepView } from '../app';
import type { Bundle } from '../bundle';
import { choice, fill, h, slider, type Slider } from '../dom';
import { text } from '../text';
import type { Pick } from '../view/body';
import { posePicker, viewBar } from '../view/bar';
import { Drawing } from '../view/drawing';
import { Flat } from '../view/flat';
import * as draft from './draft';
import { History } from './history';
import { fromMarkups, isMarkups, toMarkups } from './markups';
import { Numbers } from './numbers';

const t = text.plan;
type Tool = 'none' | 'tumour' | 'outline' | 'incision';

export async function planStep(app: App): Promise<StepView> {
  const id = app.summary!.id;
  const panel = h('div', { class: 'panel' });
  if (!app.isReady('supine')) {
    fill(panel, [h('h2', {}, text.steps.plan[0]), h('p', { class: 'quiet' }, text.anatomy.waiting)]);
    return { panel };
  }
  app.body = await app.bodyOf(app.summary!);
  const answer = await api.plan(id);
  const flat = app.body ? null : Flat.ofPlan(await api.scene(id), answer.plan?.operated_side ?? answer.marked_tumour?.side ?? 'L');
  return new Planner(app, panel, answer.plan, answer.marked_tumour, flat).view();
}

class Planner {
  private history: History<Plan | null>;
  private readonly numbers = new Numbers();
  private readonly fields = h('div');
  private readonly hint = h('div', { class: 'tool-hint', role: 'status', hidden: true });
  private readonly actions = h('div', { class: 'actions' });
  private tool: Tool = 'none';
  private drawn: Pick[] = [];
  private drawing: Drawing | null = null;
  private depth = 20;
  private lastPick: Pick | null = null;
  private asked = 0;
  private running = false;
  private nextPlan: { plan: Plan; live: boolean } | null = null;
  private preview: Bundle<PreviewHead> | null = null;
  private preset: string;
  private name: HTMLInputElement;
  private seeThrough = true;
  private readonly elsewhere = h('div', { role: 'status' });
  private radius: Slider | null = null;

  constructor(private readonly app: App, private readonly panel: HTMLElement, private saved: Plan | null,
    private readonly marked: { centre_lps_mm: Point; equivalent_radius_mm: number; side: Side } | null,
    private readonly flat: Flat | null) {
    this.history = new History(saved);
    this.preset = app.summary!.parameters['heal.preset'] ?? 'vavourakis2016';
    this.name = h('input', { type: 'text', value: app.summary!.plan_name, maxLength: 60, placeholder: t.namePlaceholder, onblur: (e: FocusEvent) => this.rename(e) });
  }

  private get plan(): Plan | null { return this.history.current; }

  view(): StepView {
    const { app } = this;
    fill(this.panel, [h('h2', {}, text.steps.plan[0]),
      this.elsewhere, this.numbers.element, this.numbers.evidence, this.fields, this.actions]);
    let tools: HTMLElement | undefined;
    if (app.viewer && app.body) {
      const drawing = (this.drawing = new Drawing(app.body));
      app.body.moved = () => drawing.place();
      app.viewer.setPanes([{ title: '', bodies: [app.body], extra: [drawing.group] }]);
      app.viewer.element.append(this.hint);
      app.viewer.frame();
      app.viewer.orbit.view(this.plan?.operated_side === 'R' ? 'right-oblique' : 'left-oblique');
      app.viewer.onPick = (pick) => this.picked(pick);
      app.body.paint(null, () => [0, 0, 0]);
      app.body.showArrows(null);
      tools = h('div', { class: 'tools' }, viewBar(app.viewer, {
        label: text.view.seeThrough, value: this.seeThrough, change: (v) => { this.seeThrough = v; this.showBody(); },
      }), posePicker(app, app.body, ['prone', 'supine', 'before'], 'supine'));
    }
    setTimeout(() => app.body?.prepare(), 500);
    this.draw();
    this.ask(false);
    return {
      panel: this.panel, tools, stage: this.flat?.element, update: () => this.drawActions(), changed: () => void this.changedElsewhere(),
      key: (e) => this.key(e),
      close: () => this.close(),
    };
  }

  private close(): void {
    this.hint.remove();
    this.drawing?.dispose();
    if (this.app.body) this.app.body.moved = null;
    if (!this.app.viewer) return;
    this.app.viewer.onPick = null;
    this.app.viewer.element.classList.remove('placing');
  }

  /** Applies a change; one gesture is one step of undo. */
  private change(how: (plan: Plan) => Plan, done = true, gesture = false): void {
    if (!this.plan) return;
    this.history.push(how(this.plan), gesture);
    this.drawActions();
    this.ask(!done);
  }
  private slide(how: (plan: Plan, value: number) => Plan): (value: number, done: boolean) => void {
    let dragging = false;
    return (value, done) => {
      this.change((p) => how(p, value), done, dragging);
      dragging = !done;
      if (this.plan && this.radius && how !== draft.withRadius) this.radius.set(draft.radiusOf(this.plan));
    };
  }

  private draw(): void {
    const active = document.activeElement as HTMLInputElement | null, inside = active && this.fields.contains(active);
    this.drawFields();
    // What had the focus keeps it: fields are made anew.
    if (inside) {
      const same = [...this.fields.querySelectorAll('input')].find((i) => (active.type === 'radio'
        ? i.type === 'radio' && i.value === active.value : i.getAttribute('aria-label') === active.getAttribute('aria-label')));
      same?.focus();
    }
  }
  private drawFields(): void {
    const plan = this.plan;
    this.radius = null;
    if (!plan) {
      fill(this.fields, [h('p', {}, t.nothing),
        this.marked ? h('button', { class: 'primary', onclick: () => this.start(this.marked!.centre_lps_mm, this.marked!.equivalent_radius_mm, this.marked!.side, 'prone') }, t.mark) : null,
        this.app.body ? h('button', { onclick: () => this.use('tumour') }, t.move) : null]);
      this.drawActions();
      return;
    }
    const shape = draft.shapeOf(plan), incision = draft.incisionOf(plan);
    fill(this.fields, [
      h('section', {}, h('h3', {}, t.tumour),
        slider(t.size, { min: 2, max: 80, step: 1 }, 2 * plan.tumour.equivalent_radius_mm, (v) => `${v.toFixed(0)} mm`, this.slide((p, v) => draft.withTumourRadius(p, v / 2))).element,
        this.app.body ? h('button', { 'aria-pressed': this.tool === 'tumour' ? 'true' : 'false', onclick: () => this.use('tumour') }, t.move) : null,
        this.lastPick ? slider(t.depth, { min: 3, max: 80, step: 1 }, this.depth, (v) => `${v} mm`, (v, done) => { this.depth = v; this.moveTumour(done); }).element : null),
      h('section', {}, h('h3', {}, t.excision),
        slider(t.margin, { min: 0, max: 30, step: 1 }, plan.planned_margin_mm, (v) => `${v} mm`, this.slide(draft.withMargin)).element,
        choice(t.shape, Object.entries(t.shapes).filter(([k]) => k !== 'free' || this.app.body) as [draft.Shape, string][], this.tool === 'outline' ? 'free' : shape, (s) => this.chooseShape(s)).element,
        shape === 'cylinder' ? (this.radius = slider(t.own, { min: 3, max: 60, step: 0.5 }, draft.radiusOf(plan), (v) => `${v.toFixed(1)} mm${draft.isAutomatic(this.plan!) ? ` (${t.auto})` : ''}`, this.slide(draft.withRadius))).element : null,
        ...(shape === 'segment' ? this.segmentFields(plan) : []),
        shape === 'free' ? h('button', { onclick: () => this.use('outline') }, t.draw) : null,
        slider(t.clearance, { min: 1, max: 20, step: 1 }, plan.clearance_mm ?? 5, (v) => `${v} mm`, this.slide(draft.withClearance)).element),
      h('section', {}, choice(t.incision, Object.entries(t.incisions).filter(([k]) => k !== 'free' || this.app.body) as [draft.Incision, string][],
        this.tool === 'incision' ? 'free' : incision, (k) => this.chooseIncision(k)).element),
      h('section', {}, choice(t.healing, this.app.session.healing_presets.map((p) => [p, t.presets[p] ?? p] as [string, string]), this.preset, (p) => { this.preset = p; this.drawActions(); }).element),
      h('section', {}, h('label', { class: 'field' }, h('span', {}, t.name), this.name)),
    ]);
    this.drawActions();
  }

  private segmentFields(plan: Plan): HTMLElement[] {
    const usual = draft.usualSegment(plan), own = plan.resection!.segment!;
    const ranges = { angle_deg: { min: 10, max: 160, step: 5 }, from_mm: { min: 0, max: 120, step: 1 }, to_mm: { min: 10, max: 180, step: 1 } };
    return (['angle_deg', 'from_mm', 'to_mm'] as const).map((key) => slider(t.segment[key], ranges[key], own[key] ?? usual[key],
      (v) => (this.plan?.resection?.segment?.[key] === undefined ? t.byMargin : `${v.toFixed(0)} ${key === 'angle_deg' ? '°' : 'mm'}`),
      this.slide((p, v) => draft.withSegment(p, { [key]: v }))).element);
  }
  private drawActions(): void {
    const { app, plan } = this, busy = app.busy(app.summary!.id);
    const changed = !draft.sameSurgery(plan, this.saved) || this.preset !== (app.summary!.parameters['heal.preset'] ?? 'vavourakis2016');
    fill(this.actions, [
      h('div', { class: 'buttons' },
        h('button', { class: 'plain', disabled: !this.history.canUndo, title: 'Ctrl+Z', onclick: () => this.step('undo') }, `↶ ${t.undo}`),
        h('button', { class: 'plain', disabled: !this.history.canRedo, title: 'Ctrl+Y', onclick: () => this.step('redo') }, `↷ ${t.redo}`),
        h('button', { class: 'plain', disabled: !plan, onclick: () => this.save(this.plan, '.json') }, t.export),
        h('button', { class: 'plain', disabled: !plan, title: t.slicerHint, onclick: () => this.save(toMarkups(this.plan!), '.mrk.json') }, t.slicer),
        h('label', { class: 'plain button' }, t.import, h('input', { type: 'file', accept: '.json', class: 'hidden-file', onchange: (e: Event) => this.load(e) }))),
      changed && app.summary!.outcome ? h('p', { class: 'quiet' }, t.changed) : null,
      h('div', { class: 'row' },
        h('button', { class: 'primary', id: 'simulate', disabled: !plan || busy, onclick: () => this.simulate() }, t.simulate),
        h('button', { id: 'another', disabled: !plan || busy, onclick: () => this.saveAsAnother() }, t.another)),
    ]);
  }

  /** The name goes to this case, unless the next click makes another one for it. */
  private rename(e: FocusEvent): void {
    if ((e.relatedTarget as HTMLElement | null)?.id === 'another' || this.name.value.trim() === this.app.summary!.plan_name) return;
    void this.app.attempt(() => api.name(this.app.summary!.id, this.name.value.trim()));
  }
  private start(centre: Point, radius: number, side: Side, frame: 'prone' | 'supine'): void {
    this.history.push(draft.newPlan(side, centre, radius, frame));
    this.draw();
    this.ask(false);
  }
  private chooseShape(shape: draft.Shape): void {
    if (shape === 'free') { this.use('outline'); return; }
    this.use('none');
    this.change((p) => draft.withShape(p, shape, shape === 'segment' ? [(this.app.body ?? this.flat!.scene).head.nipple[p.operated_side][p.frame]] : undefined));
    this.draw();
  }
  private chooseIncision(kind: draft.Incision): void {
    if (kind === 'free') { this.use('incision'); return; }
    this.use('none');
    void this.placeIncision(kind);
  }
  private async placeIncision(kind: draft.Incision): Promise<void> {
    const plan = this.plan!;
    const line = kind === 'over' ? undefined : await this.app.attempt(() => api.incision(this.app.summary!.id, kind, draft.withIncision(plan, 'over')));
    if (kind === 'over' || line) this.change((p) => draft.withIncision(p, kind, line));
    this.draw();
  }

  /** Place mode; it ends by itself after a tumour was placed, as in Slicer. */
  private use(tool: Tool): void {
    this.tool = this.tool === tool ? 'none' : tool;
    this.drawn = [];
    this.app.viewer?.element.classList.toggle('placing', this.tool !== 'none');
    this.tellTool();
  }
  private tellTool(): void {
    const { tool, drawn } = this, enough = drawn.length >= (tool === 'outline' ? 3 : 2);
    this.hint.hidden = tool === 'none';
    this.drawing?.show(drawn, tool === 'outline');
    this.app.viewer?.draw();
    fill(this.hint, [
      h('span', {}, tool === 'tumour' ? t.moving : tool === 'outline' ? t.drawing(drawn.length) : t.drawIncision(drawn.length)),
      tool === 'tumour' ? null : h('button', { disabled: drawn.length === 0, onclick: () => { this.drawn.pop(); this.tellTool(); } }, t.lastPoint),
      tool === 'tumour' ? null : h('button', { class: 'primary', disabled: !enough, onclick: () => this.finishDrawing() }, t.done),
      h('button', { onclick: () => { this.use('none'); this.draw(); } }, text.cancel)]);
  }
  private picked(pick: Pick): void {
    if (this.tool === 'tumour') {
      this.lastPick = pick;
      this.use('none');
      this.moveTumour(true);
    } else if (this.tool === 'outline' || this.tool === 'incision') {
      this.drawn.push(pick);
      this.tellTool();
    }
  }
  /** Below the clicked skin along its normal, in the pose in which the plan is drawn. */
  private moveTumour(done: boolean): void {
    const body = this.app.body!, pick = this.lastPick!, frame = this.plan?.frame ?? 'supine';
    const skin = body.placeIn(pick, frame), inwards = pick.inside;
    const centre = [skin[0] + this.depth * inwards.x, skin[1] + this.depth * inwards.y, skin[2] + this.depth * inwards.z] as Point;
    const side: Side = centre[0] > body.head.midline_x_mm ? 'L' : 'R';
    if (!this.plan) this.start(centre, 7.5, side, 'supine');
    else this.change((p) => draft.withTumourAt(p, centre, side), done);
    if (done) this.draw();
  }
  private finishDrawing(): void {
    const frame = this.plan?.frame ?? 'supine', points = this.drawn.map((pick) => this.app.body!.placeIn(pick, frame));
    if (this.tool === 'outline' && points.length >= 3) this.change((p) => draft.withShape(p, 'free', points));
    if (this.tool === 'incision' && points.length >= 2) this.change((p) => draft.withIncision(p, 'free', points));
    this.use('none');
    this.draw();
  }
  private key(e: KeyboardEvent): boolean {
    if (e.key === 'Escape' && this.tool !== 'none') { this.use('none'); this.draw(); return true; }
    if (e.key === 'Enter' && (this.tool === 'outline' || this.tool === 'incision')) { this.finishDrawing(); return true; }
    if ((e.ctrlKey || e.metaKey) && e.key === 'z') { this.step(e.shiftKey ? 'redo' : 'undo'); return true; }
    if ((e.ctrlKey || e.metaKey) && e.key === 'y') { this.step('redo'); return true; }
    return false;
  }
  private step(which: 'undo' | 'redo'): void {
    this.history[which]();
    this.draw();
    this.ask(false);
  }

  /** Asks for the numbers; while an answer is on its way only the newest question waits. */
  private ask(live: boolean): void {
    if (!this.plan) return;
    this.nextPlan = { plan: this.plan, live };
    this.numbers.element.setAttribute('aria-busy', 'true');
    if (!this.running) void this.askNext();
  }
  private async askNext(): Promise<void> {
    this.running = true;
    while (this.nextPlan) {
      const { plan, live } = this.nextPlan, number = ++this.asked, start = performance.now();
      this.nextPlan = null;
      try {
        const preview = await api.preview(this.app.summary!.id, plan, live);
        this.preview = preview;
        this.numbers.show(plan, preview.head, live, performance.now() - start);
        this.showBody();
      } catch (problem) {
        if (number === this.asked) { this.numbers.refuse(problem as { message: string; hint?: string }); }
      }
    }
    this.running = false;
    this.numbers.element.setAttribute('aria-busy', 'false');
  }
  private showBody(): void {
    const { body, viewer } = this.app;
    this.flat?.show(this.preview);
    if (!body || !viewer) return;
    body.showPlan(this.preview);
    body.showSurgery({ tumour: this.preview !== null, excision: true, seeThrough: this.seeThrough });
    viewer.draw();
  }

  /** Another page has simulated this case with another plan: take it over, or say so. */
  private async changedElsewhere(): Promise<void> {
    const { plan } = await api.plan(this.app.summary!.id);
    if (document.activeElement !== this.name) this.name.value = this.app.summary!.plan_name;
    if (draft.sameSurgery(plan, this.saved)) return;
    const untouched = draft.sameSurgery(this.plan, this.saved), same = draft.sameSurgery(plan, this.plan);
    this.saved = plan;
    const take = (): void => {
      this.history.push(plan);
      fill(this.elsewhere, []);
      this.draw();
      this.ask(false);
    };
    if (untouched && !same) take();
    else if (!same) fill(this.elsewhere, [h('p', { class: 'warning' }, t.elsewhere, ' ', h('button', { onclick: take }, t.takeOver))]);
    this.drawActions();
  }
  private async simulate(): Promise<void> {
    const id = this.app.summary!.id;
    const started = await this.app.attempt(() => api.run(id, { plan: this.plan, set: { 'heal.preset': this.preset } }));
    if (started) location.hash = `#/case/${id}/healing`;
  }
  private async saveAsAnother(): Promise<void> {
    const from = this.app.summary!.id;
    const made = await this.app.attempt(async () => {
      const copy = await api.copy(from, `${from.replace(/-plan(-\d+)?$/, '')}-plan`);
      const name = this.name.value.trim();
      if (name && name !== this.app.summary!.plan_name) await api.name(copy.case, name);
      const { job } = await api.run(copy.case, { plan: this.plan, to: 'supine' });
      // The plan is in the case when its run has begun to compute.
      for (let state = 'queued'; state === 'queued' || state === 'running';) {
        await new Promise((resume) => setTimeout(resume, 300));
        state = (await api.jobs()).find((j) => j.id === job)?.state ?? 'done';
      }
      return copy.case;
    });
    if (made) location.hash = `#/case/${made}/plan`;
  }
  private save(content: unknown, ending: string): void {
    const link = h('a', { download: `${this.app.summary!.id}-plan${ending}`, href: URL.createObjectURL(new Blob([JSON.stringify(content, null, 1)], { type: 'application/json' })) });
    link.click();
    URL.revokeObjectURL(link.href);
  }
  private async load(event: Event): Promise<void> {
    const file = (event.target as HTMLInputElement).files?.[0];
    if (!file) return;
    await this.app.attempt(async () => {
      const read = JSON.parse(await file.text()) as unknown;
      const plan = isMarkups(read) ? fromMarkups(read, this.plan, this.app.body?.head.midline_x_mm ?? 0) : (read as Plan);
      await api.preview(this.app.summary!.id, plan, true);
      this.history.push(plan);
      this.draw();
      this.ask(false);
    });
  }
}
