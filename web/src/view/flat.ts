// The body without WebGL: still pictures from two sides that follow the plan. Pointing needs WebGL.
import type { PreviewHead, SceneHead, Side } from '../api';
import type { Bundle } from '../bundle';
import { h } from '../dom';
import { text } from '../text';
import * as colours from './colours';
import { poseName } from './pose';
import { draw, eyeAt, project, type Eye } from './raster';

const t = text.view, width = 560, height = 460;
const rgb = (hex: number): [number, number, number] => [hex >> 16, (hex >> 8) & 255, hex & 255];

export class Flat {
  readonly element: HTMLElement;
  private readonly canvases: { canvas: HTMLCanvasElement; eye: Eye; pose: string }[];

  /** One picture per pose and azimuth. */
  constructor(readonly scene: Bundle<SceneHead>, seen: { pose: string; azimuth: number; title: string }[]) {
    this.canvases = seen.map(({ pose, azimuth, title }) => ({
      canvas: h('canvas', { width, height, role: 'img', 'aria-label': title }), eye: this.eye(pose, azimuth), pose,
    }));
    this.element = h('div', { class: 'flat', tabIndex: 0 }, h('p', { class: 'quiet' }, t.flat), h('div', { class: 'flat-pictures' },
      ...seen.map(({ title, azimuth }, i) => {
        const sides = azimuth === 0 ? [text.side.R, text.side.L] : [];
        return h('figure', {}, this.canvases[i].canvas, ...sides.map((word, k) => h('span', { class: `side-word ${k ? 'right' : 'left'}` }, word)), h('figcaption', {}, title));
      })));
    this.show(null);
  }
  static ofPlan(scene: Bundle<SceneHead>, side: Side): Flat {
    return new Flat(scene, [{ pose: 'supine', azimuth: 0, title: `${t.poses.supine}, ${t.fromFront}` },
      { pose: 'supine', azimuth: side === 'L' ? 55 : -55, title: `${t.poses.supine}, ${t.fromSide(text.sideShort[side])}` }]);
  }
  static ofPoses(scene: Bundle<SceneHead>): Flat {
    const poses = ['prone', 'supine', 'before'].filter((p) => scene.head.poses.includes(p));
    return new Flat(scene, poses.flatMap((pose) => [0, 55].map((azimuth) => ({ pose, azimuth, title: `${poseName(scene.head, pose)}, ${azimuth ? t.fromSide(text.sideShort.L) : t.fromFront}` }))));
  }

  show(preview: Bundle<PreviewHead> | null): void {
    for (const { canvas, eye, pose } of this.canvases) {
      const context = canvas.getContext('2d')!, image = context.createImageData(width, height);
      const skin = { positions: this.scene.f32(`points.${pose}`), triangles: this.trianglesOf(), colour: rgb(colours.clay), opacity: 1 };
      draw(image, skin, eye);
      if (preview) draw(image, { positions: preview.f32(`wound.${pose}`), triangles: preview.u32('wound.triangles'), colour: rgb(colours.excision), opacity: 0.6 }, eye);
      context.putImageData(image, 0, 0);
      if (preview) this.mark(context, preview, eye, pose);
    }
  }

  private mark(context: CanvasRenderingContext2D, preview: Bundle<PreviewHead>, eye: Eye, pose: string): void {
    const { tumour } = preview.head, [x, y] = project(eye, tumour.centre[pose], 0, width, height);
    context.fillStyle = `rgb(${rgb(colours.tumour).join()})`;
    context.beginPath();
    context.arc(x, y, tumour.radius_mm * eye.pixelsPerMm, 0, 2 * Math.PI);
    context.fill();
    context.strokeStyle = `rgb(${rgb(colours.incision).join()})`;
    context.lineWidth = 3;
    const points = preview.f32(`incision.${pose}`);
    let at = 0;
    for (const length of preview.u32('incision.lengths')) {
      context.beginPath();
      for (let i = 0; i < length; ++i) context.lineTo(...(project(eye, points, 3 * (at + i), width, height).slice(0, 2) as [number, number]));
      context.stroke();
      at += length;
    }
  }
  private trianglesOf(): Uint32Array {
    const skin = this.scene.head.groups.find((g) => g.name === 'skin')!;
    return this.scene.u32('triangles').subarray(3 * skin.first, 3 * (skin.first + skin.count));
  }
  /** All of the body in the picture. */
  private eye(pose: string, azimuth: number): Eye {
    const points = this.scene.f32(`points.${pose}`), low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    points.forEach((v, i) => { low[i % 3] = Math.min(low[i % 3], v); high[i % 3] = Math.max(high[i % 3], v); });
    const widest = Math.max(high[0] - low[0], high[1] - low[1]);
    return eyeAt(azimuth, [0, 1, 2].map((c) => (low[c] + high[c]) / 2) as [number, number, number], 0.94 * Math.min(width / widest, height / (high[2] - low[2])));
  }
}
