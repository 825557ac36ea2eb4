// The 3-D canvas: one to four panes that share a camera, drawn only when something changed.
import {
  DirectionalLight, HemisphereLight, Plane, Raycaster, Scene, Sphere, SRGBColorSpace, Vector2, Vector3,
  WebGLRenderer, type Object3D,
} from 'three';
import { h } from '../dom';
import { text } from '../text';
import type { Body, Pick } from './body';
import { listenToUser, Orbit } from './camera';

export interface Pane { scene: Scene; bodies: Body[]; words: Words }
export type Layout = 'grid' | 'wipe';

export class Viewer {
  readonly element: HTMLElement;
  readonly orbit = new Orbit(() => this.draw());
  readonly panes: Pane[] = [];
  layout: Layout = 'grid';
  wipe = 0.5;
  onWipe: ((wipe: number) => void) | null = null;
  onPick: ((pick: Pick, body: Body) => void) | null = null;
  clip: Plane | null = null;
  lastPickMs = 0;
  lastFrameMs = 0;
  private readonly renderer: WebGLRenderer;
  private readonly overlay = h('div', { class: 'view-overlay', 'aria-hidden': 'true' });
  private readonly divider = h('div', { class: 'wipe-line', hidden: true }, h('i'));
  private waiting = false;
  private unframed = false;

  /** Throws where the browser has no WebGL. */
  constructor() {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.outputColorSpace = SRGBColorSpace;
    this.renderer.localClippingEnabled = true;
    const canvas = this.renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', text.view.canvas);
    canvas.title = '';
    this.overlay.append(this.divider);
    this.dragWipe();
    this.element = h('div', { class: 'viewer' }, canvas, this.overlay);
    listenToUser(canvas, this.orbit, (x, y) => this.click(x, y));
    canvas.addEventListener('dblclick', () => this.orbit.reset());
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  setPanes(content: { title: string; bodies: Body[]; extra?: Object3D[] }[], layout: Layout = 'grid'): void {
    for (const pane of this.panes) pane.words.element.remove();
    this.panes.length = 0;
    this.layout = layout;
    for (const { title, bodies, extra } of content) {
      const scene = new Scene();
      scene.add(...lights(), ...bodies.map((b) => b.group), ...(extra ?? []));
      const words = new Words(title);
      this.overlay.append(words.element);
      this.panes.push({ scene, bodies, words });
    }
    this.resize();
  }
  /** The camera's resting place: all of the first pane's body in view. Not on the page yet: later. */
  frame(): void {
    this.unframed = this.element.clientWidth === 0 || !this.element.isConnected;
    const sphere = new Sphere();
    const body = this.panes[0]?.bodies[0];
    if (!body) return;
    const box = body.bundle.f32(`points.${body.head.poses[0]}`);
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < box.length; ++i) {
      low[i % 3] = Math.min(low[i % 3], box[i]);
      high[i % 3] = Math.max(high[i % 3], box[i]);
    }
    sphere.center.set((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2);
    sphere.radius = 0.5 * Math.hypot(high[0] - low[0], high[2] - low[2]);
    const pane = this.rectangles()[0], aspect = pane && pane.h > 0 && pane.w > 0 ? pane.w / pane.h : 1.3;
    const wide = (high[0] - low[0]) / 2 / Math.min(aspect, 1.6), tall = (high[2] - low[2]) / 2;
    this.orbit.home = { target: sphere.center.clone(), distance: 1.18 * Math.max(wide, tall) / Math.tan((11 * Math.PI) / 180) + (high[1] - low[1]) / 2 };
    this.orbit.reset();
  }
  draw(): void {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.render(); });
  }
  isAlive(): boolean { return !this.renderer.getContext().isContextLost(); }
  dispose(): void { this.renderer.dispose(); this.element.remove(); }

  private resize(): void {
    const { clientWidth: w, clientHeight: hgt } = this.element;
    if (w === 0 || hgt === 0) return;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(w, hgt);
    if (this.unframed) {
      const { azimuth, elevation } = this.orbit;
      this.frame();
      Object.assign(this.orbit, { azimuth, elevation });
      this.orbit.apply();
    }
    this.draw();
  }
  /** Where each pane is drawn, in CSS pixels from the top left. */
  private rectangles(): { x: number; y: number; w: number; h: number; clipX: number; clipW: number }[] {
    const W = this.element.clientWidth, H = this.element.clientHeight, n = this.panes.length;
    if (this.layout === 'wipe' && n === 2) {
      const cut = W * this.wipe;
      return [{ x: 0, y: 0, w: W, h: H, clipX: 0, clipW: cut }, { x: 0, y: 0, w: W, h: H, clipX: cut, clipW: W - cut }];
    }
    const columns = n === 1 ? 1 : W < 640 && n === 2 ? 1 : n <= 3 && W > 1.2 * H ? n : 2, rows = Math.ceil(n / columns);
    return this.panes.map((_, i) => {
      const w = W / columns, hh = H / rows, x = (i % columns) * w;
      return { x, y: Math.floor(i / columns) * hh, w, h: hh, clipX: x, clipW: w };
    });
  }
  private render(): void {
    const start = performance.now(), H = this.element.clientHeight;
    if (H === 0) return;
    this.renderer.setScissorTest(true);
    this.rectangles().forEach((r, i) => {
      const pane = this.panes[i];
      this.orbit.camera.aspect = r.w / r.h;
      this.orbit.camera.updateProjectionMatrix();
      this.renderer.setViewport(r.x, H - r.y - r.h, r.w, r.h);
      this.renderer.setScissor(r.clipX, H - r.y - r.h, r.clipW, r.h);
      const lamp = pane.scene.getObjectByName('lamp');
      lamp?.position.copy(this.orbit.camera.position).addScaledVector(this.orbit.camera.up, 300);
      this.renderer.render(pane.scene, this.orbit.camera);
      // A wipe shows one picture in two parts: letters once, a title at either side.
      pane.words.place(r, this.orbit.letters(), this.layout === 'wipe' ? i : null);
    });
    this.divider.hidden = this.layout !== 'wipe';
    this.divider.style.left = `${100 * this.wipe}%`;
    this.lastFrameMs = performance.now() - start;
  }
  /** The line between before and after can be taken by hand; keys have the slider below. */
  private dragWipe(): void {
    this.divider.addEventListener('pointerdown', (e) => { this.divider.setPointerCapture(e.pointerId); e.preventDefault(); });
    this.divider.addEventListener('pointermove', (e) => {
      if (!this.divider.hasPointerCapture(e.pointerId)) return;
      const box = this.element.getBoundingClientRect();
      this.wipe = Math.max(0, Math.min(1, (e.clientX - box.left) / box.width));
      this.onWipe?.(this.wipe);
      this.draw();
    });
  }
  private click(x: number, y: number): void {
    if (!this.onPick) return;
    const box = this.renderer.domElement.getBoundingClientRect();
    const px = x - box.left, py = y - box.top;
    this.rectangles().forEach((r, i) => {
      if (px < r.clipX || px > r.clipX + r.clipW || py < r.y || py > r.y + r.h) return;
      const caster = new Raycaster();
      this.orbit.camera.aspect = r.w / r.h;
      this.orbit.camera.updateProjectionMatrix();
      caster.setFromCamera(new Vector2((2 * (px - r.x)) / r.w - 1, 1 - (2 * (py - r.y)) / r.h), this.orbit.camera);
      const start = performance.now();
      for (const body of this.panes[i].bodies) {
        const hit = body.pick(caster.ray);
        this.lastPickMs = performance.now() - start;
        if (hit) { this.onPick?.(hit, body); return; }
      }
    });
  }
}

/** What stands over a pane: its title, the letters at its edges, and her sides in words. */
class Words {
  readonly element: HTMLElement;
  private readonly title: HTMLElement;
  private readonly letters = ['top', 'bottom', 'left', 'right'].map((edge) => h('span', { class: `letter ${edge}` }));
  private readonly sides = [h('span', { class: 'side-word left' }), h('span', { class: 'side-word right' })];

  constructor(title: string) {
    this.title = h('span', { class: 'pane-title' }, title);
    this.element = h('div', { class: 'pane' }, this.title, ...this.letters, ...this.sides);
  }
  place(r: { x: number; y: number; w: number; h: number }, l: ReturnType<Orbit['letters']>, wiped: number | null): void {
    Object.assign(this.element.style, { left: `${r.x}px`, top: `${r.y}px`, width: `${r.w}px`, height: `${r.h}px` });
    this.title.classList.toggle('at-right', wiped === 1);
    const once = wiped !== 1, word = (letter: string): string => (once && r.w > 330 ? text.side[letter] ?? '' : '');
    [l.top, l.bottom, l.left, l.right].forEach((letter, i) => { this.letters[i].textContent = once ? letter : ''; });
    this.sides[0].textContent = word(l.left);
    this.sides[1].textContent = word(l.right);
  }
}

function lights(): Object3D[] {
  const key = new DirectionalLight(0xfff6ee, 1.9);
  key.name = 'lamp';
  const rim = new DirectionalLight(0xdfe9ff, 0.55);
  rim.position.copy(new Vector3(400, -200, 600));
  return [new HemisphereLight(0xffffff, 0xa39a94, 1.7), key, rim];
}
