// The patient as imaged, in three dimensions, with the crosshair of the slices in her.
import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments } from 'three';
import type { Point } from '../api';
import type { App } from '../app';
import { at } from '../view/pose';

const length_mm = 500; // beyond any trunk: the lines end at the edge of the picture

export class Solid {
  private readonly cross = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0x0b7a74, depthTest: false }));

  /** `picked` hears where on the skin somebody clicked, as imaged [mm]. */
  constructor(private readonly app: App, picked: (mm: Point) => void) {
    const viewer = app.viewer!, body = app.body!;
    body.setPose(at('prone'));
    body.showPlan(null);
    body.paint(null, () => [0, 0, 0]);
    body.showArrows(null);
    body.showSurgery({ tumour: body.head.tumour !== undefined, excision: false, seeThrough: true, opacity: 0.55 });
    this.cross.renderOrder = 4;
    this.cross.frustumCulled = false;
    viewer.setPanes([{ title: '', bodies: [body], extra: [this.cross] }]);
    viewer.onPick = (pick) => picked(pick.point);
    requestAnimationFrame(() => { viewer.frame(); viewer.orbit.view('left-oblique'); });
  }
  show(p: Point): void {
    const ends: number[] = [];
    for (let c = 0; c < 3; ++c) for (const sign of [-1, 1]) ends.push(...p.map((x, k) => (k === c ? x + sign * length_mm : x)));
    this.cross.geometry.dispose();
    this.cross.geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(ends), 3));
    this.app.viewer?.draw();
  }
  close(): void {
    this.cross.geometry.dispose();
    if (this.app.viewer) this.app.viewer.onPick = null;
  }
}
